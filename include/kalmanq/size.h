/*
 * kalmanq: sizes.
 *
 * n states, m measured components, l controls: each 1 .. KQ_SIZE_MAX (l may be 0).  They and their indices are `int`;
 * steps, rows, lengths and their indices are `size_t`.  Every object's memory is yours.  Its length, in words of the
 * object's number type, is a constant expression (KQ_..._LEN).  The macros KQ_FILTER_F32(name, n) and so on declare
 * an object with its memory; kq_..._assign gives it at run time.
 *
 * Words of 4 (f32, q31) or 8 (f64) bytes; the last columns are f32 bytes at (n, m):
 *
 *                          words                                                   (2, 1)  (4, 2)  (9, 3)
 *   process                n(n+1)/2 (q31: none)                                        12      40     180
 *   sensor, diagonal R     m, or m(m+1)/2 with a correlated R (q31: none)               4       8      12
 *   filter                 f32 2n, f64 n, q31 3n, each + n(n+1)/2                      28      72     252
 *   history, a step        filter (f32) + 1 + m(n+1), q31: + 1 + m(n+2)                44     116     376
 *   history, workspace     3n^2 + 4n + n(n+1), q31: 6n more                           104     336    1476
 *   a linearised predict   n^2, n(n+1)/2 more if Q has changed, a struct               60     108     368
 *   fixed lag of 10        KQ_LAG_LEN_F32(n, m, 10)                                   912    2912   12600
 *   fixed point            KQ_INSTANT_LEN_F32(n, m)                                   260     824    3492
 *   diffuse start          KQ_DIFFUSE_LEN_F32(n, 0)                                    76     244    1084
 *   adaptation             KQ_ADAPTATION_LEN_F32(n, m)                                 56     188     720
 *   sigma points, work     KQ_SIGMA_POINTS_LEN(n, m)                                   68     216     936
 *   EM, besides a history   about 15n^2 + 7mn + 5m^2; KQ_EM_LEN_F32 has both           464    1564    6760
 *
 * A, B and H stay where they are.  A q31 process table has 2n^2 + 2nl + n(n+1)/2 + n words, formats 2n + 2l.  Structs
 * on a 32-bit chip: process and sensor 44 bytes, history 44 (q31 48), filter 60 (f32), 72 (q31), 88 (f64).
 *
 * The linker does not see the stack: kq_predict needs n^2 + 2n words (q31: n^2 + 3n), n rounded up to 4, 9 or 16;
 * other functions state theirs.  Objects + memory + the worst stack + your own frames and interrupts must fit the
 * RAM.  tools/cost/README.md has the stack of whole programs;
 * `tools/cost.py --states 5 --components 2 --core m3` measures yours.
 */
#ifndef KALMANQ_SIZE_H
#define KALMANQ_SIZE_H

#include <stddef.h>
#include <stdint.h>

/** Largest n, m and l. */
#define KQ_SIZE_MAX 16

/** Most steps, rows and other counts: more, or a negative number in a size_t, is KQ_ERR_SIZE. */
#define KQ_COUNT_MAX ((size_t)(SIZE_MAX / 2 < INT32_MAX ? SIZE_MAX / 2 : INT32_MAX))

/** The type of lengths that can be large.  64 bits, so that they do not wrap where size_t has 16 or 32: an array that
 * is too long does not compile, and an assign with too little memory answers KQ_ERR_MEMORY. */
#if SIZE_MAX < UINT64_MAX
typedef uint64_t kq_length;
#else
typedef size_t kq_length;
#endif

/** Words of a triangular n x n matrix, diagonal included. */
#define KQ_TRIANGLE(n) ((n) * ((n) + 1) / 2)

/* The tables' arguments `array` or `array, (numbers)`: the array, and the numbers in braces, {0} if none */
#define KQ_PRIVATE_GIVEN(...) KQ_PRIVATE_FIRST(__VA_ARGS__, 0)
#define KQ_PRIVATE_LIST(...) KQ_PRIVATE_APPLY(KQ_PRIVATE_BRACES, KQ_PRIVATE_SECOND(__VA_ARGS__, (0), 0))
#define KQ_PRIVATE_FIRST(a, ...) a
#define KQ_PRIVATE_SECOND(a, b, ...) b
#define KQ_PRIVATE_APPLY(macro, list) macro list
#define KQ_PRIVATE_BRACES(...) {__VA_ARGS__}

#endif
