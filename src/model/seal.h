/*
 * The seal of a prepared object: a remainder of its sizes and addresses, in which every bit counts.  A bit
 * that is turned turns one bit of the word, which is +-2^k, and no power of 2 is a multiple of 127.
 */
#ifndef KQ_SRC_MODEL_SEAL_H
#define KQ_SRC_MODEL_SEAL_H

#include <stdint.h>

static inline uint32_t seal_join(uint32_t seal, uint32_t word)
{
    return (seal << 5 | seal >> 27) ^ word;
}

static inline uint32_t seal_address(uint32_t seal, const void *at)
{
    const uint64_t address = (uintptr_t)at;
    return seal_join(seal, (uint32_t)(address ^ address >> 32));
}

/* 129 .. 255: neither 0, which is none, nor one bit from it */
static inline uint8_t seal_close(uint32_t seal)
{
    while (seal > 127) seal = (seal & 127) + (seal >> 7);
    return (uint8_t)(128 + (seal == 0 ? 127 : seal));
}

#endif
