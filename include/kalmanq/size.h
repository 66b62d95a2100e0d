/*
 * kalmanq: sizes.
 *
 * n states, m measured components and l controls: each 1 .. KQ_SIZE_MAX (l may be 0).  They, and what
 * numbers one of them, are `int`; steps, rows, lengths and what numbers those are `size_t`.
 * Every object's memory belongs to the caller; its length, in words of the object's number
 * type, is a constant expression of its sizes (KQ_..._LEN), and goes into static arrays.  The macros
 * KQ_FILTER_F32(name, n), KQ_HISTORY_F32(name, n, m, steps, changes), ... declare an object with its
 * memory; kq_..._assign gives it sizes and memory that are known at run time.
 *
 * Words of 4 (f32, q31) or 8 (f64) bytes:
 *
 *                              words                                    f32 bytes at n, m =  2, 1    4, 2    9, 3
 *   process                    n(n+1)/2 (q31: none)                                            12      40     180
 *   sensor, diagonal R         m, or m(m+1)/2 with a correlated R (q31: none)                   4       8      12
 *   filter                     f32 2n, f64 n, q31 3n, each + n(n+1)/2                          28      72     252
 *   history, a step            filter (f32) + 1 + m(n+1), q31: + 1 + m(n+2)                    44     116     376
 *   history, workspace         3n^2 + 4n + n(n+1), q31: 6n more                               104     336    1476
 *   a linearised predict       n^2, n(n+1)/2 more where Q has changed, a struct (extended.h)       60     108     368
 *   fixed lag of 10            KQ_LAG_LEN_F32(n, m, 10)                                       912    2912   12600
 *   fixed point                KQ_INSTANT_LEN_F32(n, m)                                       260     824    3492
 *   unknown start              KQ_DIFFUSE_LEN_F32(n, 0)                                          76     244    1084
 *   adaptation                 KQ_ADAPTATION_LEN_F32(n, m)                                     56     188     720
 *   sigma points, work         KQ_SIGMA_POINTS_LEN(n, m)                                              68     216     936
 *   EM, beside a history as    about 15n^2 + 7mn + 5m^2; all of it:                           464    1564    6760
 *   long as the longest recording                              KQ_EM_LEN_F32(n, m, steps)
 *
 * A, B and H stay where they are; a q31 table of a process is 2n^2 + 2nl + n(n+1)/2 + n words, its formats
 * 2n + 2l.  An object itself takes on a 32-bit chip, beside its memory: process, sensor and history 44
 * bytes; filter 60 (f32), 72 (q31), 88 (f64).
 *
 * Stack is not seen by the linker: kq_predict needs n^2 + 2n words (q31: n^2 + 3n), n rounded up to 4, 9
 * or 16, other functions say theirs.  Budget: objects + memory + the worst stack + the frames of your own
 * functions and interrupts <= RAM.  tools/cost/README.md has the worst stack of whole programs;
 * `tools/cost.py --states 5 --components 2 --core m3` measures yours.
 */
#ifndef KALMANQ_SIZE_H
#define KALMANQ_SIZE_H

#include <stddef.h>
#include <stdint.h>

/** Largest n, m and l. */
#define KQ_SIZE_MAX 16

/** Most steps, rows and the like: a call that is given more, or a negative number that became a
    size_t on its way, answers KQ_ERR_SIZE. */
#define KQ_COUNT_MAX ((size_t)(SIZE_MAX / 2 < INT32_MAX ? SIZE_MAX / 2 : INT32_MAX))

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

/* Of the tables' arguments `array` or `array, (numbers)`: the array, and the numbers in braces, {0} if none. */
#define KQ_PRIVATE_GIVEN(...) KQ_PRIVATE_FIRST(__VA_ARGS__, 0)
#define KQ_PRIVATE_LIST(...) KQ_PRIVATE_APPLY(KQ_PRIVATE_BRACES, KQ_PRIVATE_SECOND(__VA_ARGS__, (0), 0))
#define KQ_PRIVATE_FIRST(a, ...) a
#define KQ_PRIVATE_SECOND(a, b, ...) b
#define KQ_PRIVATE_APPLY(macro, list) macro list
#define KQ_PRIVATE_BRACES(...) {__VA_ARGS__}

#endif
