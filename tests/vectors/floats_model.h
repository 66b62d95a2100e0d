/* Models of any size, made with + * / of the arithmetic itself: the same bits on every machine.  Which arithmetic it is,
   VECTOR_F32 or VECTOR_F64 says. */
#ifndef KALMANQ_FLOATS_MODEL_H
#define KALMANQ_FLOATS_MODEL_H

#include <stddef.h>
#include <stdint.h>

#include <kalmanq/kalmanq.h>

/* One text for f32 and f64 */
#if defined(VECTOR_F32)
typedef float num;
#define K(name) kq_##name##_f32
#define LEN(object) KQ_##object##_LEN_F32
#define SMALL 0x1p-42f /* variances at the lower end of those that count */
#define TINY 0x1p-118f /* no variances; means whose low parts are subnormal */
#define LARGE 0x1p+57f /* variances at the upper end of all numbers */
#elif defined(VECTOR_F64)
typedef double num;
#define K(name) kq_##name##_f64
#define LEN(object) KQ_##object##_LEN_F64
#define SMALL 0x1p-170
#define TINY 0x1p-1018
#define LARGE 0x1p+497
#else
#error "compile with one of -DVECTOR_F32 and -DVECTOR_F64"
#endif

enum { MOST_STATES = 16, MOST_COMPONENTS = 4 };
enum { BEYOND_STATES = 9, BEYOND_COMPONENTS = 3 }; /* of all runs but the filter's */

/* What is special about a case */
enum {
    CORRELATED = 1, /* R is full */
    EXACT = 2,      /* R = 0, and the last row of H is the first one again */
    SHARP = 4       /* R is 2^-40 of what it would be */
};

typedef struct {
    int n, m, l;
    int kinds;
    num scale; /* of states and measurements */
} model_case;

typedef struct {
    int n, m, l;
    num A[MOST_STATES * MOST_STATES], B[MOST_STATES], Q[MOST_STATES * MOST_STATES];
    num H[MOST_COMPONENTS * MOST_STATES], R[MOST_COMPONENTS * MOST_COMPONENTS];
    num x0[MOST_STATES], P0[MOST_STATES * MOST_STATES];
} model;

/** n, m, l, kinds and which scale, as a case has them; returns 0 where they are none. */
int model_case_of(model_case *c, const int32_t *in, size_t count);

/** The model of a case, and the sequence of draws from its beginning */
void model_make(model *M, const model_case *c);

/** A signed number below 1 of 24 bits, from a fixed sequence */
num model_draw(void);

#endif
