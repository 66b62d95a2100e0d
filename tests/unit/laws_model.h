/*
 * The model of the laws (laws.h) in numbers, a run's measurements, and garbage before each call.
 */
#ifndef KALMANQ_TESTS_LAWS_MODEL_H
#define KALMANQ_TESTS_LAWS_MODEL_H

#include "reading.h"

#define STEPS 8

typedef struct {
    num A[4], B[2], Q[4];
    num H[4], R[4]; /* two correlated components */
    num h[2], r[1]; /* and one of its own */
    num x0[2], P0[4];
    num z[STEPS][3], u[STEPS];
    num range[2], measured_range[3]; /* declared, for those arithmetics that ask for it */
} numbers;

static void make_numbers(numbers *s, uint32_t seed)
{
    static const numbers constant = {
        .A = {1, 0.5, -0.25, 0.75},
        .B = {0.125, 0.5},
        .Q = {0.25, 0.125, 0.125, 0.5},
        .H = {1, 0, 0.5, 1},
        .R = {0.5, 0.25, 0.25, 1},
        .h = {-1, 0.25},
        .r = {0.125},
        .x0 = {1, -2},
        .P0 = {2, 0.5, 0.5, 1},
        .range = {30, 30},
        .measured_range = {15, 15, 15},
    };
    *s = constant;
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < 3; c++) s->z[t][c] = noise(&seed);
        s->u[t] = noise(&seed);
    }
}

/* What a test of garbage does before each call; nothing, mostly. */
static void do_nothing(void) {}
static void (*volatile before_call)(void) = do_nothing;

#define CALL(call)                                                                                 \
    do {                                                                                           \
        before_call();                                                                             \
        ASSERT_OK(call);                                                                           \
    } while (0)

#define PAINTED_BYTES 2048

static int paint_byte;

/* through a pointer that the compiler cannot see through, or it would leave it out */
static void *(*volatile fill)(void *, int, size_t) = memset;

static void paint_the_stack(void)
{
    unsigned char below[PAINTED_BYTES];
    fill(below, paint_byte, sizeof below);
}

#endif
