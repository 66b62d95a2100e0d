/* Models (models.h) beside the functions for compile-time sizes, which bring all of src/ along, and these as tables:
   one row for every n and m of the tests. */
#ifndef KALMANQ_TESTS_FIXED_H
#define KALMANQ_TESTS_FIXED_H

/* src/ has these, too */
#define score_of score_of_number
#define score_number number_of_score
#include "models.h"
#undef score_of
#undef score_number
#define num src_num
#define reading src_reading
#if defined(KQ_TEST_F32)
#include "fixed_size/kq_fixed_f32.h"
#elif defined(KQ_TEST_Q31)
#include "fixed_size/kq_fixed_q31.h"
#else
#include "fixed_size/kq_fixed_f64.h"
#endif
#undef num
#undef reading

/* FIXED_SIZES(options, suffix): three functions for each of the sizes, one control */
#define FIXED_SIZE(n, m, options, suffix)                                                          \
    static kq_status predict_##n##_##m##_##suffix(S(filter) *f, const S(process) *p, const word *u) \
    {                                                                                              \
        return S(fixed_predict)(f, p, u, n, 1, options);                                           \
    }                                                                                              \
    static kq_status update_##n##_##m##_##suffix(S(filter) *f, const S(sensor) *s, const word *z)  \
    {                                                                                              \
        return S(fixed_update)(f, s, z, n, m, options);                                            \
    }                                                                                              \
    static kq_status step_##n##_##m##_##suffix(S(filter) *f, const S(process) *p, const word *u,   \
                                               const S(sensor) *s, const word *z)                  \
    {                                                                                              \
        return S(fixed_step)(f, p, u, s, z, n, m, 1, options);                                     \
    }

#define FIXED_SIZES(options, suffix)                                                               \
    FIXED_SIZE(1, 1, options, suffix)                                                              \
    FIXED_SIZE(2, 1, options, suffix)                                                              \
    FIXED_SIZE(3, 2, options, suffix)                                                              \
    FIXED_SIZE(4, 2, options, suffix)

/* The steady-state filter's step, with a dense or an upper triangular A */
#define FIXED_STEADY(n, m, options, suffix)                                                        \
    static kq_status steady_##n##_##m##_##suffix(S(steady) *st, const word *u, const word *z)      \
    {                                                                                              \
        return S(fixed_steady_step)(st, u, z, n, m, 1, options);                                   \
    }

#define FIXED_ROW(n, m, suffix)                                                                    \
    {                                                                                              \
        n, m, predict_##n##_##m##_##suffix, update_##n##_##m##_##suffix, step_##n##_##m##_##suffix \
    }
#define FIXED_ROWS(suffix)                                                                         \
    FIXED_ROW(1, 1, suffix), FIXED_ROW(2, 1, suffix), FIXED_ROW(3, 2, suffix),                     \
        FIXED_ROW(4, 2, suffix)

#endif
