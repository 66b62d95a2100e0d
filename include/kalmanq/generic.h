/*
 * kalmanq: names without a suffix.  Optional: kalmanq.h does not include this header.
 *
 *     #include <kalmanq/kalmanq.h>
 *     #include <kalmanq/generic.h>
 *
 *     kq_step(&cart, &motion, NULL, &ranger, z);        kq_step_f32, if cart is a kq_filter_f32
 *
 * The type of the first argument says which arithmetic it is: by _Generic in C11, by overloads in C++.  There is no
 * other code: a call is the call of the function with the suffix, whose header is its manual.  The other functions
 * have their names with the suffix alone.
 */
#ifndef KALMANQ_GENERIC_H
#define KALMANQ_GENERIC_H

#include "filter.h"
#include "process.h"
#include "sensor.h"
#include "smoother.h"

#ifdef __cplusplus

#define KQ_PRIVATE_OVERLOADS(T, word, number, score)                                               \
    KQ_NODISCARD inline kq_status kq_predict(kq_filter_##T *f, const kq_process_##T *p, const word *u)          \
    { return kq_predict_##T(f, p, u); }                                                            \
    KQ_NODISCARD inline kq_status kq_update(kq_filter_##T *f, const kq_sensor_##T *s, const word *z)            \
    { return kq_update_##T(f, s, z); }                                                             \
    KQ_NODISCARD inline kq_status kq_update_subset(kq_filter_##T *f, const kq_sensor_##T *s, const word *z,     \
                                      uint32_t present)                                            \
    { return kq_update_subset_##T(f, s, z, present); }                                             \
    KQ_NODISCARD inline kq_status kq_step(kq_filter_##T *f, const kq_process_##T *p, const word *u,             \
                             const kq_sensor_##T *s, const word *z)                                \
    { return kq_step_##T(f, p, u, s, z); }                                                         \
    KQ_NODISCARD inline kq_status kq_forecast(const kq_filter_##T *f, const kq_process_##T *p, const word *u,   \
                                 size_t steps, kq_filter_##T *ahead)                               \
    { return kq_forecast_##T(f, p, u, steps, ahead); }                                             \
    KQ_NODISCARD inline kq_status kq_innovation(const kq_filter_##T *f, const kq_sensor_##T *s, const word *z,  \
                                   word *e)                                                        \
    { return kq_innovation_##T(f, s, z, e); }                                                      \
    KQ_NODISCARD inline kq_status kq_covariance(const kq_filter_##T *f, number *P)                              \
    { return kq_covariance_##T(f, P); }                                                            \
    inline word kq_mean(const kq_filter_##T *f, int i) { return kq_mean_##T(f, i); }               \
    inline word kq_sigma(const kq_filter_##T *f, int i) { return kq_sigma_##T(f, i); }             \
    inline score kq_nis(const kq_filter_##T *f) { return kq_nis_##T(f); }                          \
    inline unsigned kq_events(const kq_filter_##T *f) { return kq_events_##T(f); }                 \
    KQ_NODISCARD inline kq_status kq_attach(kq_filter_##T *f, struct kq_attached_##T *object)                   \
    { return kq_attach_##T(f, object); }                                                           \
    KQ_NODISCARD inline kq_status kq_detach(struct kq_attached_##T *object) { return kq_detach_##T(object); }   \
    KQ_NODISCARD inline kq_status kq_smooth(kq_history_##T *h) { return kq_smooth_##T(h); }

#define KQ_PRIVATE_FLOATING_OVERLOADS(T, word)                                                     \
    KQ_PRIVATE_OVERLOADS(T, word, word, word)                                                      \
    KQ_NODISCARD inline kq_status kq_process_init(kq_process_##T *p, const word *A, const word *B, const word *Q) \
    { return kq_process_init_##T(p, A, B, Q); }                                                    \
    KQ_NODISCARD inline kq_status kq_sensor_init(kq_sensor_##T *s, const word *H, const word *R)                \
    { return kq_sensor_init_##T(s, H, R); }                                                        \
    KQ_NODISCARD inline kq_status kq_filter_init(kq_filter_##T *f, const word *x0, const word *P0)              \
    { return kq_filter_init_##T(f, x0, P0); }

#define KQ_PRIVATE_FIXED_OVERLOADS(T)                                                              \
    KQ_PRIVATE_OVERLOADS(T, int32_t, kq_scaled_##T, int64_t)                                       \
    KQ_NODISCARD inline kq_status kq_process_init(kq_process_##T *p, const kq_process_table_##T *table,         \
                                     kq_range_error_##T *range_error)                                        \
    { return kq_process_init_##T(p, table, range_error); }                                              \
    KQ_NODISCARD inline kq_status kq_sensor_init(kq_sensor_##T *s, const kq_sensor_table_##T *table,            \
                                    kq_range_error_##T *range_error)                                         \
    { return kq_sensor_init_##T(s, table, range_error); }                                               \
    KQ_NODISCARD inline kq_status kq_filter_init(kq_filter_##T *f, const kq_prior_table_##T *prior,             \
                                    kq_range_error_##T *range_error)                                         \
    { return kq_filter_init_##T(f, prior, range_error); }

extern "C++" {
KQ_PRIVATE_FLOATING_OVERLOADS(f32, float)
KQ_PRIVATE_FLOATING_OVERLOADS(f64, double)
KQ_PRIVATE_FIXED_OVERLOADS(q31)
}

#else

/* The function of the arithmetic of `object`, a pointer to a TYPE, const or not */
#define KQ_PRIVATE_OF(TYPE, object, name)                                                          \
    _Generic((object),                                                                             \
        TYPE##_f32 *: kq_##name##_f32, const TYPE##_f32 *: kq_##name##_f32,                        \
        TYPE##_f64 *: kq_##name##_f64, const TYPE##_f64 *: kq_##name##_f64,                        \
        TYPE##_q31 *: kq_##name##_q31, const TYPE##_q31 *: kq_##name##_q31)

#define kq_process_init(p, ...) KQ_PRIVATE_OF(kq_process, p, process_init)(p, __VA_ARGS__)
#define kq_sensor_init(s, ...) KQ_PRIVATE_OF(kq_sensor, s, sensor_init)(s, __VA_ARGS__)
#define kq_filter_init(f, ...) KQ_PRIVATE_OF(kq_filter, f, filter_init)(f, __VA_ARGS__)
#define kq_predict(f, p, u) KQ_PRIVATE_OF(kq_filter, f, predict)(f, p, u)
#define kq_update(f, s, z) KQ_PRIVATE_OF(kq_filter, f, update)(f, s, z)
#define kq_update_subset(f, s, z, present) KQ_PRIVATE_OF(kq_filter, f, update_subset)(f, s, z, present)
#define kq_step(f, p, u, s, z) KQ_PRIVATE_OF(kq_filter, f, step)(f, p, u, s, z)
#define kq_forecast(f, p, u, steps, ahead) KQ_PRIVATE_OF(kq_filter, f, forecast)(f, p, u, steps, ahead)
#define kq_innovation(f, s, z, e) KQ_PRIVATE_OF(kq_filter, f, innovation)(f, s, z, e)
#define kq_covariance(f, P) KQ_PRIVATE_OF(kq_filter, f, covariance)(f, P)
#define kq_mean(f, i) KQ_PRIVATE_OF(kq_filter, f, mean)(f, i)
#define kq_sigma(f, i) KQ_PRIVATE_OF(kq_filter, f, sigma)(f, i)
#define kq_nis(f) KQ_PRIVATE_OF(kq_filter, f, nis)(f)
#define kq_events(f) KQ_PRIVATE_OF(kq_filter, f, events)(f)
#define kq_attach(f, object) KQ_PRIVATE_OF(kq_filter, f, attach)(f, object)
#define kq_detach(object) KQ_PRIVATE_OF(struct kq_attached, object, detach)(object)
#define kq_smooth(h) KQ_PRIVATE_OF(kq_history, h, smooth)(h)

#endif
#endif
