/* Seeded random numbers, the same on every machine; memory that is exactly as long as it says. */
#ifndef KALMANQ_FUZZ_RANDOM_H
#define KALMANQ_FUZZ_RANDOM_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static uint64_t random_state;

/* splitmix64 */
static inline uint64_t random_bits(void)
{
    uint64_t z = random_state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

/* 0 <= u < 1 */
static inline double uniform(void) { return (double)(random_bits() >> 11) * 0x1p-53; }

static inline int chance(double p) { return uniform() < p; }

/* from .. to */
static inline int between(int from, int to)
{
    return from + (int)(random_bits() % (uint64_t)(to - from + 1));
}

/* About N(0, 1) */
static inline double normal(void)
{
    double sum = -6;
    for (int k = 0; k < 12; k++) sum += uniform();
    return sum;
}

/* Decades 10^-d/2 .. 10^d/2 */
static inline double decades(double d) { return pow(10, d * (uniform() - 0.5)); }

/* A word of |word| <= most: of any size, small, or at the very end */
static inline int32_t random_word(int32_t most)
{
    const double u = 2 * uniform() - 1;
    if (chance(0.1)) return u < 0 ? -most : most;
    return (int32_t)(u * most * (chance(0.5) ? pow(2, -31 * uniform()) : 1));
}

/* Blocks of one model, freed together.  Exact lengths: the address sanitizer sees what is read or
   written beyond. */
#define BLOCKS 512

static void *blocks[BLOCKS];
static int block_count;

static inline void *take(size_t count, size_t size)
{
    if (block_count == BLOCKS) abort();
    void *block = calloc(count ? count : 1, size);
    if (!block) abort();
    return blocks[block_count++] = block;
}

static inline void give_back(void)
{
    while (block_count > 0) free(blocks[--block_count]);
}

#define TAKE(type, count) ((type *)take((size_t)(count), sizeof(type)))

#endif
