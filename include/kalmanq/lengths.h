/*
 * kalmanq: sizes and lengths as functions, for languages without C macros.
 *
 * A binding allocates an object and its memory by these, gives both to kq_..._assign, and never looks inside.
 */
#ifndef KALMANQ_LENGTHS_H
#define KALMANQ_LENGTHS_H

#include "adaptation.h"
#include "consistency.h"
#include "em.h"
#include "lag.h"
#include "least_squares.h"
#include "instant.h"
#include "robust.h"
#include "diffuse.h"
#include "steady.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What has a size or a length, and the arguments of kq_length that count; pass 0 for the others. */
typedef enum {
    KQ_OBJECT_PROCESS = 0,       /* n (f32, f64) */
    KQ_OBJECT_SENSOR = 1,        /* m (f32, f64) */
    KQ_OBJECT_FILTER = 2,        /* n */
    KQ_OBJECT_HISTORY = 3,       /* n, m: scalars a step, 1..65535; k: steps; l: changes of process */
    KQ_OBJECT_LAG = 4,           /* n, m: scalar measurements a step; k: the longest lag */
    KQ_OBJECT_INSTANT = 5,       /* n, m: scalar measurements a step */
    KQ_OBJECT_DIFFUSE = 6,       /* n, k: early instants */
    KQ_OBJECT_ADAPTATION = 7,    /* n, m */
    KQ_OBJECT_CONSISTENCY = 8,   /* m, k: the window, 1..KQ_WINDOW_MAX */
    KQ_OBJECT_LEAST_SQUARES = 9, /* no length */
    KQ_OBJECT_STEADY = 10,       /* n */
    KQ_OBJECT_FREEZE = 11,       /* n */
    KQ_OBJECT_LOSS = 12,         /* no length */
    KQ_OBJECT_EM = 13,           /* n, m, k: steps (f32, f64) */
    KQ_OBJECT_STEADY_SOLVE = 14, /* n, m: the scratch of kq_steady_solve (f32, f64); no size */
    KQ_OBJECT_ROOT = 15,         /* n: the root in a table (q31); no size */
    KQ_OBJECT_CONTINUOUS = 16,   /* n, k: controls, 0..16 (f32, f64); no size */
    KQ_OBJECT_CORRELATED = 17    /* n, m, k: controls of B, k + m at most 16 (f32, f64); no size */
} kq_object;

/** Length of an object's memory in numbers: float, double, int32_t (an adaptation in q31: kq_scaled_q31).  It is the
 * macro KQ_<OBJECT>_LEN_<T>.
 *   object   KQ_OBJECT_...
 *   n        states, 1..16
 *   m        measurements, 1..16 unless the object says otherwise
 *   k        a count that the object says
 *   l        another one
 * 0 for an argument out of its range, or an object without a length in this arithmetic. */
kq_length kq_length_f32(kq_object object, int n, int m, size_t k, size_t l);
kq_length kq_length_f64(kq_object object, int n, int m, size_t k, size_t l);
kq_length kq_length_q31(kq_object object, int n, int m, size_t k, size_t l);

/** Bytes of the object itself.
 *   object   KQ_OBJECT_...; 0 if it does not exist in this arithmetic */
size_t kq_object_size_f32(kq_object object);
size_t kq_object_size_f64(kq_object object);
size_t kq_object_size_q31(kq_object object);

#ifdef __cplusplus
}
#endif
#endif
