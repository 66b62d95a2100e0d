/*
 * kalmanq: names without a suffix.  Optional: kalmanq.h does not include this header.
 *
 *     #include <kalmanq/kalmanq.h>
 *     #include <kalmanq/generic.h>
 *
 *     kq_step(&cart, &motion, NULL, &ranger, z);        kq_step_f32 if cart is a kq_filter_f32
 *
 * The type of the first argument selects the arithmetic: _Generic in C11, overloads in C++.  The
 * manual is the header of the function with the suffix.  There are
 *     kq_process_init, kq_sensor_init, _init_diagonal, _init_lean, kq_filter_init, kq_filter_copy
 *     kq_predict, kq_update, kq_update_subset, kq_step, kq_forecast, kq_innovation
 *     kq_mean, kq_sigma, kq_covariance, kq_nis, kq_log_likelihood, kq_events, kq_events_clear
 *     kq_attach, kq_detach, kq_smooth, kq_smoothed
 * Other functions have the suffix only.
 */
#ifndef KALMANQ_GENERIC_H
#define KALMANQ_GENERIC_H

#include "filter.h"
#include "process.h"
#include "sensor.h"
#include "smoother.h"

#ifdef __cplusplus

/* An inline function `name` of (parameters) that passes (arguments) on */
#define KQ_PRIVATE_INLINE(T, result, name, parameters, arguments) \
    inline result kq_##name parameters { return kq_##name##_##T arguments; }
#define KQ_PRIVATE_STATUS(T, name, parameters, arguments) \
    KQ_NODISCARD KQ_PRIVATE_INLINE(T, kq_status, name, parameters, arguments)

#define KQ_PRIVATE_OVERLOADS(T, word, number, score) \
    KQ_PRIVATE_STATUS(T, predict, (kq_filter_##T *f, const kq_process_##T *p, const word *u), (f, p, u)) \
    KQ_PRIVATE_STATUS(T, update, (kq_filter_##T *f, const kq_sensor_##T *s, const word *z), (f, s, z)) \
    KQ_PRIVATE_STATUS(T, update_subset, (kq_filter_##T *f, const kq_sensor_##T *s, const word *z, \
        uint32_t present), (f, s, z, present)) \
    KQ_PRIVATE_STATUS(T, step, (kq_filter_##T *f, const kq_process_##T *p, const word *u, \
        const kq_sensor_##T *s, const word *z), (f, p, u, s, z)) \
    KQ_PRIVATE_STATUS(T, forecast, (const kq_filter_##T *f, const kq_process_##T *p, const word *u, \
        size_t steps, kq_filter_##T *ahead), (f, p, u, steps, ahead)) \
    KQ_PRIVATE_STATUS(T, innovation, (const kq_filter_##T *f, const kq_sensor_##T *s, const word *z, \
        word *e), (f, s, z, e)) \
    KQ_PRIVATE_STATUS(T, covariance, (const kq_filter_##T *f, number *P), (f, P)) \
    KQ_PRIVATE_INLINE(T, word, mean, (const kq_filter_##T *f, int i), (f, i)) \
    KQ_PRIVATE_INLINE(T, word, sigma, (const kq_filter_##T *f, int i), (f, i)) \
    KQ_PRIVATE_INLINE(T, score, nis, (const kq_filter_##T *f), (f)) \
    KQ_PRIVATE_INLINE(T, score, log_likelihood, (const kq_filter_##T *f), (f)) \
    KQ_PRIVATE_INLINE(T, unsigned, events, (const kq_filter_##T *f), (f)) \
    KQ_PRIVATE_INLINE(T, void, events_clear, (kq_filter_##T *f), (f)) \
    KQ_PRIVATE_STATUS(T, filter_copy, (kq_filter_##T *to, const kq_filter_##T *from), (to, from)) \
    KQ_PRIVATE_STATUS(T, attach, (kq_filter_##T *f, struct kq_attached_##T *object), (f, object)) \
    KQ_PRIVATE_STATUS(T, detach, (struct kq_attached_##T *object), (object)) \
    KQ_PRIVATE_STATUS(T, smooth, (kq_history_##T *h), (h)) \
    KQ_PRIVATE_STATUS(T, smoothed, (const kq_history_##T *h, size_t t, kq_filter_##T *view), (h, t, view))

#define KQ_PRIVATE_FLOATING_OVERLOADS(T, word) \
    KQ_PRIVATE_OVERLOADS(T, word, word, word) \
    KQ_PRIVATE_STATUS(T, process_init, (kq_process_##T *p, const word *A, const word *B, const word *Q), \
        (p, A, B, Q)) \
    KQ_PRIVATE_STATUS(T, sensor_init, (kq_sensor_##T *s, const word *H, const word *R), (s, H, R)) \
    KQ_PRIVATE_STATUS(T, sensor_init_diagonal, (kq_sensor_##T *s, const word *H, const word *r), (s, H, r)) \
    KQ_PRIVATE_STATUS(T, sensor_init_lean, (kq_sensor_##T *s, const word *H, const word *r), (s, H, r)) \
    KQ_PRIVATE_STATUS(T, filter_init, (kq_filter_##T *f, const word *x0, const word *P0), (f, x0, P0))

#define KQ_PRIVATE_FIXED_OVERLOADS(T) \
    KQ_PRIVATE_OVERLOADS(T, int32_t, kq_scaled_##T, int64_t) \
    KQ_PRIVATE_STATUS(T, process_init, (kq_process_##T *p, const kq_process_table_##T *table, \
        kq_range_error_##T *range_error), (p, table, range_error)) \
    KQ_PRIVATE_STATUS(T, sensor_init, (kq_sensor_##T *s, const kq_sensor_table_##T *table, \
        kq_range_error_##T *range_error), (s, table, range_error)) \
    KQ_PRIVATE_STATUS(T, sensor_init_diagonal, (kq_sensor_##T *s, const kq_sensor_table_##T *table, \
        kq_range_error_##T *range_error), (s, table, range_error)) \
    KQ_PRIVATE_STATUS(T, sensor_init_lean, (kq_sensor_##T *s, const kq_sensor_table_##T *table, \
        kq_range_error_##T *range_error), (s, table, range_error)) \
    KQ_PRIVATE_STATUS(T, filter_init, (kq_filter_##T *f, const kq_prior_table_##T *prior, \
        kq_range_error_##T *range_error), (f, prior, range_error))

extern "C++" {
KQ_PRIVATE_FLOATING_OVERLOADS(f32, float)
KQ_PRIVATE_FLOATING_OVERLOADS(f64, double)
KQ_PRIVATE_FIXED_OVERLOADS(q31)
}

#else

/* The function of the arithmetic of `object`, a pointer to a TYPE, const or not */
#define KQ_PRIVATE_OF(TYPE, object, name) \
    _Generic((object), TYPE##_f32 *: kq_##name##_f32, const TYPE##_f32 *: kq_##name##_f32, \
        TYPE##_f64 *: kq_##name##_f64, const TYPE##_f64 *: kq_##name##_f64, \
        TYPE##_q31 *: kq_##name##_q31, const TYPE##_q31 *: kq_##name##_q31)

#define kq_process_init(p, ...) KQ_PRIVATE_OF(kq_process, p, process_init)(p, __VA_ARGS__)
#define kq_sensor_init(s, ...) KQ_PRIVATE_OF(kq_sensor, s, sensor_init)(s, __VA_ARGS__)
#define kq_sensor_init_diagonal(s, ...) KQ_PRIVATE_OF(kq_sensor, s, sensor_init_diagonal)(s, __VA_ARGS__)
#define kq_sensor_init_lean(s, ...) KQ_PRIVATE_OF(kq_sensor, s, sensor_init_lean)(s, __VA_ARGS__)
#define kq_filter_init(f, ...) KQ_PRIVATE_OF(kq_filter, f, filter_init)(f, __VA_ARGS__)
#define kq_filter_copy(to, from) KQ_PRIVATE_OF(kq_filter, to, filter_copy)(to, from)
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
#define kq_log_likelihood(f) KQ_PRIVATE_OF(kq_filter, f, log_likelihood)(f)
#define kq_events(f) KQ_PRIVATE_OF(kq_filter, f, events)(f)
#define kq_events_clear(f) KQ_PRIVATE_OF(kq_filter, f, events_clear)(f)
#define kq_attach(f, object) KQ_PRIVATE_OF(kq_filter, f, attach)(f, object)
#define kq_detach(object) KQ_PRIVATE_OF(struct kq_attached, object, detach)(object)
#define kq_smooth(h) KQ_PRIVATE_OF(kq_history, h, smooth)(h)
#define kq_smoothed(h, t, view) KQ_PRIVATE_OF(kq_history, h, smoothed)(h, t, view)

#endif
#endif
