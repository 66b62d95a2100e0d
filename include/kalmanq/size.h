/*
 * kalmanq: sizes.
 *
 * n states, m measured components and l controls: each 1 .. KQ_SIZE_MAX (l may be 0).
 * Every object's memory belongs to the caller; its length, in words of the object's number
 * type, is a constant expression of its sizes (KQ_..._LEN), and goes into static arrays.
 */
#ifndef KALMANQ_SIZE_H
#define KALMANQ_SIZE_H

#include <stddef.h>
#include <stdint.h>

/** Largest n, m and l. */
#define KQ_SIZE_MAX 16

/** Of the lengths that can be large: 64 bits, where a size_t of 16 or 32 would wrap and the array be
    too short.  So it is too long, and does not compile; and a call that is given such sizes and the
    memory that a wrapped length stands for answers KQ_ERR_MEMORY. */
#if SIZE_MAX < UINT64_MAX
typedef uint64_t kq_length;
#else
typedef size_t kq_length;
#endif

/** Words of a triangular n x n matrix, diagonal included. */
#define KQ_TRIANGLE(n) ((n) * ((n) + 1) / 2)

#endif
