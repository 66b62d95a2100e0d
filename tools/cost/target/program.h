/*
 * What every program for a target begins with: what it tells the emulator, what it is about, that
 * is kalmanq in one arithmetic (KQ_COST_f32, ..._f64, ..._q31) or a textbook filter
 * (KQ_COST_TEXTBOOK, of floats or of KQ_COST_q16), and how names are made.
 */
#ifndef KALMANQ_COST_PROGRAM_H
#define KALMANQ_COST_PROGRAM_H

/* ------------------------------------------------------------------ marks (marks.c) */

/** What is measured; also the order of the columns that ask for it. */
enum {
    COST_PREDICT, COST_UPDATE, COST_STEP, COST_LEAN, COST_SMOOTH, COST_STEADY, COST_SETTLING,
    COST_GATED, COST_HUBER, COST_STUDENT, COST_JUMP, COST_LAG, COST_LAG_STATES, COST_POINT,
    COST_DELAYED, COST_ADAPTED, COST_CONTINUOUS, COST_CORRELATED, COST_CHANGED,
    COST_EXTENDED, COST_EXTENDED_PREDICT, COST_EXTENDED_UPDATE, COST_POINTS, COST_DEAREST, COST_HARD_PREDICT, COST_HARD_UPDATE, COST_HARD_STEP,
    COST_HARD_SMOOTH, COST_HARD_LEAN,
    COST_FILTER_CALLS, COST_ROOT_CALLS, COST_LEAN_CALLS, COST_SMOOTHER_CALLS, COST_KINDS
};

/** The next call of the function for this region is to be measured, or for ..._CALLS all that
 *  follows until the next mark; of several, the most counts.
 *    region   COST_KINDS * (number of the size in the program) + COST_... */
void cost_region(unsigned region);

/** A call answered an error: nothing of this program counts. */
void cost_failed(int status);

/** All regions are done. */
void cost_end(void);

/* ------------------------------------------------------------------ the subject */

#if defined(KQ_COST_TEXTBOOK)
#include <string.h>
#else
#include <kalmanq/kalmanq.h>
#endif

#if defined(KQ_COST_q16)
#include "q16_filter.h"
#define TEXTBOOK(name) q16_##name
typedef int32_t word;
#elif defined(KQ_COST_TEXTBOOK)
#include "textbook_filter.h"
#define TEXTBOOK(name) textbook_##name
typedef float word;
#elif defined(KQ_COST_f32)
#define TYPE f32
#define OBJECT_TYPE F32
typedef float word;
#elif defined(KQ_COST_f64)
#define TYPE f64
#define OBJECT_TYPE F64
typedef double word;
#elif defined(KQ_COST_q31)
#define TYPE q31
#define OBJECT_TYPE Q31
typedef int32_t word;
#endif

#if !defined(KQ_COST_TEXTBOOK) && !defined(KQ_COST_MODULES) && !defined(KQ_COST_NONLINEAR) && !defined(KQ_COST_EVEN)
#define HAS_SMOOTHER
#endif

/* ------------------------------------------------------------------ names */

/* N and M are the size that is being compiled. */
#define JOIN2(a, b) a##_##b
#define JOIN3(a, b, c) a##_##b##_##c
#define WITH_TYPE(name, type) JOIN2(name, type)
#define WITH_SIZE(name, n, m) JOIN3(name, n, m)

#define T(name) WITH_TYPE(name, TYPE)     /* kq_predict: kq_predict_f32 */
#define SIZED(name) WITH_SIZE(name, N, M) /* A: A_4_2 */

/* A macro whose arguments are themselves macros; DECLARE(KQ_FILTER, ...) is KQ_FILTER_F32(...). */
#define EXPANDED(macro, ...) macro(__VA_ARGS__)
#define DECLARE(object, ...) EXPANDED(WITH_TYPE(object, OBJECT_TYPE), __VA_ARGS__)

/* What a user calls: the library, or functions of his own that are compiled for one size (user.c).
   Among the modules these are the steady-state filter's alone. */
#ifdef KQ_COST_FIXED
#define CALLED(user, library) SIZED(user)
#else
#define CALLED(user, library) T(library)
#endif
#ifdef KQ_COST_MODULES
#define FILTER_CALLED(user, library) T(library)
#else
#define FILTER_CALLED(user, library) CALLED(user, library)
#endif

/* B and u of a user's own number of controls */
#if CONTROLS
#define OF_CONTROLS(name) SIZED(name)
#else
#define OF_CONTROLS(name) NULL
#endif

/* ------------------------------------------------------------------ what all do */

enum { STEADY = 20 }; /* the step that is measured */

#define TAPE_STEPS 30 /* of the smoother; the one in the middle is measured */

/* Of a user's program: no frame but the caller's lies between the mark and the library. */
#define ALWAYS_INLINE __attribute__((always_inline, unused)) static inline

__attribute__((unused)) static void need_ok(int status)
{
    if (status) cost_failed(status);
}

#endif
