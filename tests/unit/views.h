/* Views to be read at once: K(mean)(SMOOTHED(&tape, t), i).  Where nothing can be shown they read NaN. */
#ifndef KALMANQ_TESTS_VIEWS_H
#define KALMANQ_TESTS_VIEWS_H

#include "kalmanq/kalmanq.h"

#define DEFINE_VIEWS(T)                                                                            \
    static inline kq_filter_##T smoothed_view_##T(const kq_history_##T *h, size_t t)               \
    {                                                                                              \
        kq_filter_##T view;                                                                        \
        const kq_status status = kq_smoothed_##T(h, t, &view);                                     \
        (void)status;                                                                              \
        return view;                                                                               \
    }                                                                                              \
    static inline kq_filter_##T start_smoothed_view_##T(const kq_diffuse_##T *s, size_t t)           \
    {                                                                                              \
        kq_filter_##T view;                                                                        \
        const kq_status status = kq_diffuse_smoothed_##T(s, t, &view);                               \
        (void)status;                                                                              \
        return view;                                                                               \
    }

DEFINE_VIEWS(f32)
DEFINE_VIEWS(f64)
DEFINE_VIEWS(q31)

#define SMOOTHED_F32(h, t) ((kq_filter_f32[]){smoothed_view_f32(h, t)})
#define SMOOTHED_F64(h, t) ((kq_filter_f64[]){smoothed_view_f64(h, t)})
#define SMOOTHED_Q31(h, t) ((kq_filter_q31[]){smoothed_view_q31(h, t)})
#define START_SMOOTHED_F32(s, t) ((kq_filter_f32[]){start_smoothed_view_f32(s, t)})
#define START_SMOOTHED_F64(s, t) ((kq_filter_f64[]){start_smoothed_view_f64(s, t)})
#define START_SMOOTHED_Q31(s, t) ((kq_filter_q31[]){start_smoothed_view_q31(s, t)})

#endif
