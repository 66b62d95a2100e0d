/*
 * The demo program is one text, compiled once for each arithmetic.  Here the neutral names of
 * run.c become those of the library.  (Only the demo does this: a program of your own picks
 * one arithmetic and says so in every name.)
 */
#ifndef KQ_DEMO_ARITHMETIC_H
#define KQ_DEMO_ARITHMETIC_H

#include <float.h>
#include <kalmanq/kalmanq.h>

#if defined(KQ_DEMO_F32) == defined(KQ_DEMO_F64)
#error "define one of KQ_DEMO_F32 and KQ_DEMO_F64"
#endif

#ifdef KQ_DEMO_F32
#define PROGRAM "kq_demo_f32"
#define REAL_MAX FLT_MAX
#define KQ(name) kq_##name##_f32
#define FILTER_LEN(n) KQ_FILTER_LEN_F32(n)
#define HISTORY_LEN(n, m, steps) KQ_HISTORY_LEN_F32(n, m, steps, 0)
typedef float real;
#else
#define PROGRAM "kq_demo_f64"
#define REAL_MAX DBL_MAX
#define KQ(name) kq_##name##_f64
#define FILTER_LEN(n) KQ_FILTER_LEN_F64(n)
#define HISTORY_LEN(n, m, steps) KQ_HISTORY_LEN_F64(n, m, steps, 0)
typedef double real;
#endif

typedef KQ(process) process;
typedef KQ(sensor) sensor;
typedef KQ(filter) filter;
typedef KQ(history) history;

#endif
