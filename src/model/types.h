/*
 * The objects, and the seal of one that is prepared: a remainder of its sizes and addresses, in which every bit
 * counts.  A bit that is turned turns one bit of the word, which is +-2^k, and no power of 2 is a multiple of 127.
 */
#ifndef KQ_SRC_MODEL_TYPES_H
#define KQ_SRC_MODEL_TYPES_H

#include "../arithmetic/arithmetic.h"

typedef T(kq_process) process;
typedef T(kq_sensor) sensor;
typedef T(kq_filter) filter;
typedef T(kq_history) history;

static inline uint32_t seal_join(uint32_t seal, uint32_t word)
{
    return (seal << 5 | seal >> 27) ^ word;
}

static inline uint32_t seal_address(uint32_t seal, const void *at)
{
    const uint64_t address = (uintptr_t)at;
    return seal_join(seal, (uint32_t)(address ^ address >> 32));
}

/* An object <- 0.  Not by assignment: for that a compiler calls memset, which may be larger than all else is. */
KQ_COLD KQ_NOINLINE static void clear_bytes(void *object, size_t count)
{
    unsigned char *byte = object;
    for (; count > 0; count--) *byte++ = 0;
}

/* 129 .. 255: neither 0, which is none, nor one bit from it */
KQ_SHARED uint8_t seal_close(uint32_t seal)
{
    while (seal > 127) seal = (seal & 127) + (seal >> 7);
    return (uint8_t)(128 + (seal == 0 ? 127 : seal));
}

/* Of numbers */
KQ_SHARED uint8_t seal_of(const scaled *numbers, int count)
{
    const num *word = (const num *)numbers;
    uint32_t seal = 0;
    for (count *= SCALED_WORDS; count > 0; count--) seal = seal_join(seal, num_folded(*word++));
    return seal_close(seal);
}

#endif
