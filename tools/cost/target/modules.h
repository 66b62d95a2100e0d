/* What modules.inc needs once, for all sizes, after library.h. */
#ifndef KALMANQ_COST_MODULES_H
#define KALMANQ_COST_MODULES_H

#include "samples.h"

enum {
    SETTLED_BITS = 8, /* of the switch */
    SETTLING = 60,    /* steps; n = 9 takes most */
    POINT_STEPS = 10, /* since the chosen instant */
    EM_STEPS = 100,   /* of the recording */
    ALL_PHASES_TO = 3 /* states: more would take the emulators long */
};

/* alone_4_2_memory: what the library's macros declare beside an object */
#define JOIN4(a, n, m, b) a##_##n##_##m##_##b
#define WITH_SIZE_AND(name, n, m, what) JOIN4(name, n, m, what)
#define BESIDE(name, what) WITH_SIZE_AND(name, N, M, what)

/* The entry of a program that has this beside the filter (use.inc) */
#define USE(what)                                                                                  \
    void SIZED(use_##what)(void)                                                                   \
    {                                                                                              \
        need_ok(SIZED(begin)());                                                                   \
        SIZED(filter_one)();                                                                       \
        SIZED(run_##what)();                                                                       \
    }

/* The usual ones (kalmanq/robust.h) */
#ifdef KQ_COST_q31
static const kq_scaled_q31 huber_k = {INT32_C(3) << 29, -30}, student_nu = {INT32_C(1) << 30, -28},
                           jump_g = {INT32_C(9) << 27, -27};
static const kq_adaptation_rule_q31 adapting = {KQ_ADAPT_BOTH,           500,
                                                {INT32_C(1) << 30, -33}, {INT32_C(1) << 30, -40},
                                                {INT32_C(1) << 30, -20}, {INT32_C(1) << 30, -40},
                                                {INT32_C(1) << 30, -20}};
#else
static const word huber_k = (word)1.5, student_nu = 4, jump_g = 9;
static const TYPED(kq_adaptation_rule) adapting = {
    KQ_ADAPT_BOTH, 500, (word)0.125, (word)0x1p-10, (word)0x1p10, (word)0x1p-10, (word)0x1p10};
#endif

static void need(int is_so)
{
    if (!is_so) cost_failed(1);
}

#endif
