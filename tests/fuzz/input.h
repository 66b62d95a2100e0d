/* Bytes as numbers, sizes and memory; and the end of a program in which something does not hold. */
#ifndef KALMANQ_FUZZ_INPUT_H
#define KALMANQ_FUZZ_INPUT_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kalmanq/kalmanq.h"

#if defined KQ_FUZZ_Q31
typedef double num; /* what tables are made of */
typedef int32_t word;
typedef kq_scaled_q31 entry;
typedef int64_t score; /* Q39.24 */
#define K(name) kq_##name##_q31
#define LENGTH(name) KQ_##name##_LEN_Q31
#define ROUNDING 0x1p-29 /* of a correlation: from a covariance that is rounded */
#define WORD_ROUNDING 0x1p-18 /* of what two ways of calls that mean the same make, in sigmas */
#define IS_WHOLE 1 /* a mean is rounded to it */
#define GROWTH 0x1p-16 /* of a smoothed variance beside the filtered one, by hundreds of operations */
#elif defined KQ_FUZZ_F64
typedef double num, word, entry, score;
#define K(name) kq_##name##_f64
#define LENGTH(name) KQ_##name##_LEN_F64
#define ROUNDING 0x1p-40
#define WORD_ROUNDING 0x1p-30
#define IS_WHOLE 0
#define GROWTH 0x1p-30
#define TINY 0x1p-200 /* a sigma below it is noise to the arithmetic (process.h) */
#else
typedef float num, word, entry, score;
#define K(name) kq_##name##_f32
#define LENGTH(name) KQ_##name##_LEN_F32
#define ROUNDING 0x1p-16
#define WORD_ROUNDING 0x1p-9
#define IS_WHOLE 0
#define GROWTH 0x1p-10
#define TINY 0x1p-60
#endif

enum { MOST = KQ_SIZE_MAX, SQUARE = MOST * MOST, SENSORS = 4 };

static const uint8_t *at, *end;
static uint32_t spun; /* not 0: bytes come of it, not of the input, which has too few for 16 states */

static unsigned byte(void)
{
    if (!spun) return at < end ? *at++ : 0;
    spun = spun * 1664525u + 1013904223u;
    return spun >> 24;
}

static unsigned below(unsigned count) { return byte() % count; }

/* Small ones mostly: they are cheap */
static int size_drawn(void)
{
    const unsigned kind = byte();
    return (int)(kind < 216 ? kind % 4 : kind % MOST) + 1;
}

static void spin(void)
{
    const unsigned low = byte();
    spun = (low | byte() << 8) * 2654435761u | 1;
}

static void spin_if_many(int count)
{
    if (count > 4) spin();
}

static void spin_ends(void) { spun = 0; }

static num number(void)
{
    static const num absurd[] = {0, 1, -1, (num)1e-30, (num)1e30, (num)-1e-18, (num)1e18, (num)1e-6, 1000, (num)0x1p-100, (num)0x1p60, (num)-0x1p60};
    const unsigned kind = byte();
    if (kind == 255) return (num)(byte() & 1 ? NAN : INFINITY);
    if (kind >= 240) return absurd[below(sizeof absurd / sizeof *absurd)];
    if (kind >= 220) return 0;
    return (num)ldexp((double)kind - 110, -(int)below(12));
}

/* Of a size, some of them 0; then up to three of any kind */
static void spin_numbers(num *to, int count)
{
    const int size = (int)below(24) - 19;
    const unsigned share = byte();
    spin();
    for (int k = 0; k < count; k++) to[k] = byte() > share ? 0 : (num)ldexp((double)byte() - 127.5, size);
    spin_ends();
    for (unsigned k = below(4); k > 0; k--) to[below((unsigned)count)] = number();
}

static void numbers(num *to, int count)
{
    if (count > 4 && byte() < 200) {
        spin_numbers(to, count);
        return;
    }
    for (int k = 0; k < count; k++) to[k] = number();
}

static void square_of(num *P, const num *F, int n, int rank)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            num sum = 0;
            for (int k = 0; k < rank; k++) sum += F[i * rank + k] * F[j * rank + k];
            P[i * n + j] = P[j * n + i] = sum;
        }
}

/* A covariance F F' of n, of some rank; or anything, which is refused */
static void covariance(num *P, int n)
{
    num F[SQUARE];
    const int rank = (int)below((unsigned)n + 1);
    if (byte() > 250) {
        numbers(P, n * n);
        return;
    }
    numbers(F, n * rank);
    square_of(P, F, n, rank);
}

/* Memory of exactly so many bytes, gone after the input */
static void *kept[320];
static int count_kept;

static void *keep(size_t count, size_t size)
{
    void *made = calloc(count ? count : 1, size);
    if (!made || count_kept == sizeof kept / sizeof *kept) abort();
    return kept[count_kept++] = made;
}

#define KEEP(type, count) ((type *)keep((size_t)(count), sizeof(type)))

static word *words(size_t count) { return KEEP(word, count); }

static int states; /* of the models, for a fault's last words */

static void fail(const char *what, const char *file, int line)
{
    fprintf(stderr, "%s:%d: %s (n = %d)\n", file, line, what, states);
    abort();
}

#define DEMAND(good) ((good) ? (void)0 : fail(#good, __FILE__, __LINE__))

#endif
