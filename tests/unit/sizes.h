/*
 * Helpers for tests over all sizes 1 .. 16: memory between guards, and dense models of 16
 * states whose results are known because they are 16 independent scalars seen through a
 * rotation.
 */
#ifndef KALMANQ_TESTS_SIZES_H
#define KALMANQ_TESTS_SIZES_H

#include "arithmetic.h"

#define GUARD_WORDS 4
#define GUARD_BYTE 0xA5

/* Room for `length` words between two guards. */
#define GUARDED(length) ((length) + 2 * GUARD_WORDS)

/* Fills a room of `size` bytes and answers where the memory inside begins, behind a guard of `edge`. */
static inline void *guarded_in(void *room, size_t size, size_t edge)
{
    memset(room, GUARD_BYTE, size);
    return (char *)room + edge;
}

/* A room of numbers */
static inline num *guard(num *room, size_t words)
{
    return guarded_in(room, words * sizeof(num), GUARD_WORDS * sizeof(num));
}

/* Of the bytes at `room` those before `inside` and after `length` more are as guard() left them. */
static inline void assert_guard_bytes(const void *room, size_t size, size_t inside, size_t length)
{
    const unsigned char *bytes = room;
    TEST_ASSERT_TRUE(inside + length < size);
    for (size_t k = 0; k < size; k++) {
        if (k == inside) k += length;
        TEST_ASSERT_EQUAL_HEX8(GUARD_BYTE, bytes[k]);
    }
}

/* Nothing outside of the `length` words inside was written; words: the whole room. */
static inline void assert_guards(const num *room, size_t length, size_t words)
{
    assert_guard_bytes(room, words * sizeof(num), GUARD_WORDS * sizeof(num), length * sizeof(num));
}

/* M = value I, n x n */
static inline void put_identity(num *M, int n, num value)
{
    for (int k = 0; k < n * n; k++) M[k] = 0;
    for (int i = 0; i < n; i++) M[i * n + i] = value;
}

/* T_ij of the 16 x 16 Hadamard rotation: +-1/4, T = T' = T^-1, exact in every arithmetic */
static inline num hadamard(int i, int j)
{
    int ones = 0;
    for (int bits = i & j; bits; bits >>= 1) ones += bits & 1;
    return ones & 1 ? N(-0.25) : N(0.25);
}

/* M = T diag(d) T, 16 x 16 */
static inline void put_rotated(num *M, const double *d)
{
    for (int i = 0; i < 16; i++) {
        for (int j = 0; j < 16; j++) {
            double sum = 0;
            for (int k = 0; k < 16; k++) {
                sum += (double)hadamard(i, k) * d[k] * (double)hadamard(k, j);
            }
            M[i * 16 + j] = N(sum);
        }
    }
}

/* (T d)_i */
static inline double rotated(const double *d, int i)
{
    double sum = 0;
    for (int k = 0; k < 16; k++) sum += (double)hadamard(i, k) * d[k];
    return sum;
}

#endif
