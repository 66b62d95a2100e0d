/*
 * The demo programs are one text each, compiled once for each arithmetic.  Here the neutral names
 * of run.c and estimate.c become those of the library, and what the arithmetics do not have in
 * common, how a number is written, is named; floating.c has it for f32 and f64, fixed.c for q31.
 * (Only the demo does this: a program of your own picks one arithmetic and says so in every name.)
 */
#ifndef KQ_DEMO_ARITHMETIC_H
#define KQ_DEMO_ARITHMETIC_H

#include <float.h>
#include <kalmanq/kalmanq.h>

#include "problem.h"

#if defined(KQ_DEMO_F32) + defined(KQ_DEMO_F64) + defined(KQ_DEMO_Q31) != 1
#error "define one of KQ_DEMO_F32, KQ_DEMO_F64 and KQ_DEMO_Q31"
#endif

/* NUMBER_MAX: the largest number of a problem.  PROGRAM, the name, comes from CMake. */
#if defined(KQ_DEMO_F32)
#define NUMBER_MAX FLT_MAX
#define KQ(name) kq_##name##_f32
#define FILTER_LEN(n) KQ_FILTER_LEN_F32(n)
#define HISTORY_LEN(n, m, steps) KQ_HISTORY_LEN_F32(n, m, steps, 0)
#define EM_LEN(n, m, steps) KQ_EM_LEN_F32(n, m, steps)
typedef float word;
#elif defined(KQ_DEMO_F64)
#define NUMBER_MAX DBL_MAX
#define KQ(name) kq_##name##_f64
#define FILTER_LEN(n) KQ_FILTER_LEN_F64(n)
#define HISTORY_LEN(n, m, steps) KQ_HISTORY_LEN_F64(n, m, steps, 0)
#define EM_LEN(n, m, steps) KQ_EM_LEN_F64(n, m, steps)
typedef double word;
#else
#define NUMBER_MAX DBL_MAX
#define KQ(name) kq_##name##_q31
#define FILTER_LEN(n) KQ_FILTER_LEN_Q31(n)
#define HISTORY_LEN(n, m, steps) KQ_HISTORY_LEN_Q31(n, m, steps, 0)
typedef int32_t word;
#endif

typedef KQ(process) process;
typedef KQ(sensor) sensor;
typedef KQ(filter) filter;
typedef KQ(history) history;

/* The library's objects and what they refer to, with memory from malloc. */
typedef struct {
    int n, m;
    process motion;
    sensor gauge;
    filter track, future;
    history tape;
    word *z;                           /* steps x m; anything where one is missing */
    size_t model_bytes;                /* what process and sensor refer to */
    size_t process_bytes, sensor_bytes;
#ifdef KQ_DEMO_Q31
    kq_format_q31 *state_format, *measurement_format;
#endif
} objects;

/* From doubles to the library: process, sensor, the state before the first measurement, z. */
void prepare_model(objects *o, const problem *given);

/* From the library to doubles: n means and sigmas, of a filter and of a smoothed step; m, of the
   measurement that a filter expects. */
void state_of(const objects *o, const filter *f, double *mean, double *sigma);
void smoothed_of(const objects *o, size_t t, double *mean, double *sigma);
void measurement_of(const objects *o, const filter *f, double *mean, double *sigma);
double log_likelihood_of(const filter *f);

/* The line `formats` of the results, for fixed point only. */
void write_formats(const objects *o);

#ifndef KQ_DEMO_Q31
/* A copy in the arithmetic's numbers. */
word *words(const double *values, size_t count);
#endif

#endif
