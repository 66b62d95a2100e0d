/*
 * The demo programs are one text each, compiled once for each arithmetic.  Here is what they share:
 * what a program is given, in doubles whatever it computes in, how it gives up or ends, and what
 * the arithmetics do not have in common, how a number is written; floating.c has it for f32 and
 * f64, fixed.c for q31.  (Only the demo does this: a program of your own picks one arithmetic and
 * says so in every name.)
 */
#ifndef KQ_DEMO_H
#define KQ_DEMO_H

#include <float.h>
#include <kalmanq/kalmanq.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#if defined(KQ_DEMO_F32) + defined(KQ_DEMO_F64) + defined(KQ_DEMO_Q31) != 1
#error "define one of KQ_DEMO_F32, KQ_DEMO_F64 and KQ_DEMO_Q31"
#endif

/* T(kq_predict) is kq_predict_f32, LENGTH(KQ_FILTER_LEN) is KQ_FILTER_LEN_F32.
   NUMBER_MAX: the largest number of a problem.  PROGRAM, the name, comes from CMake. */
#if defined(KQ_DEMO_F32)
#define T(name) name##_f32
#define LENGTH(name) name##_F32
#define NUMBER_MAX FLT_MAX
typedef float word;
#elif defined(KQ_DEMO_F64)
#define T(name) name##_f64
#define LENGTH(name) name##_F64
#define NUMBER_MAX DBL_MAX
typedef double word;
#else
#define T(name) name##_q31
#define LENGTH(name) name##_Q31
#define NUMBER_MAX DBL_MAX
typedef int32_t word;
#endif

/* ---- what is given (problem.c) ----------------------------------------------------------- */

typedef struct {
    int n, m, ahead;
    size_t steps;
    double *A, *Q, *H, *R, *x0, *P0;
    double *x_range, *z_range; /* for fixed point only */
    double *z;                 /* steps x m, NaN: not measured */
    uint32_t *present;         /* steps: bit c: component c was measured */
} problem;

/* Reads the text that run.c documents, or fails. */
problem read_problem(FILE *stream);

/* One line on stderr, exit status 1. */
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2), noreturn))
#endif
void fail(const char *format, ...);

/* Fails unless the library is content; `what` says with which part of the problem. */
void check(kq_status status, const char *what);

/* The line `end` on stdout, after which all of it is written, or the program fails. */
void finish_output(void);

/* Zeroed memory, or the program fails. */
void *allocate(size_t count, size_t size);

/* ---- how it is written (floating.c, fixed.c) --------------------------------------------- */

typedef T(kq_process) process;
typedef T(kq_sensor) sensor;
typedef T(kq_filter) filter;
typedef T(kq_history) history;

/* The library's objects and what they refer to, with memory from malloc. */
typedef struct {
    int n, m;
    process motion;
    sensor gauge;
    filter track, future;
    history tape;
    word *z;            /* steps x m; anything where one is missing */
    size_t model_bytes; /* what process and sensor refer to */
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
