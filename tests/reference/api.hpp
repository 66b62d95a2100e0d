// The library's three arithmetics behind one set of names, so that a test is written once.
//
//     Api<T>::predict(filter.get(), process.get(), u)      T = float, double or Q31
//
// Word: a component of x, u or z.  Coefficient: an entry of a matrix.  Score: a log-likelihood.
// Functions have the library's names, without kq_ and suffix.
#ifndef KALMANQ_TESTS_REFERENCE_API_HPP
#define KALMANQ_TESTS_REFERENCE_API_HPP

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#include "kalmanq/kalmanq.h"
#include "kalmanq/prepare.h"

namespace kq
{

/// Stands for the fixed-point arithmetic, which has no number type of its own.
struct Q31 {
};

inline void require(kq_status status, const char *what)
{
    if (status != KQ_OK) {
        throw std::runtime_error(std::string(what) + ": " + kq_status_text(status));
    }
}

template <class T> struct Api;

/// Twice the relative error of one rounding: of a number, and in q31 of a row of the root.
template <class T> constexpr double epsilon()
{
    return static_cast<double>(std::numeric_limits<T>::epsilon());
}
template <> constexpr double epsilon<Q31>() { return 0x1p-29; }

/// Functions that all arithmetics have, and those of floating point alone
#define KALMANQ_FUNCTIONS(F, T) \
    F(process_init, T) F(process_change_transition, T) F(sensor_init, T) F(sensor_init_lean, T) \
    F(sensor_change_measurement, T) F(filter_assign, T) F(filter_init, T) F(predict, T) \
    F(update, T) F(update_subset, T) F(step, T) F(mean, T) F(mean_low, T) F(sigma, T) \
    F(covariance, T) F(measurement, T) F(innovation, T) F(gain, T) F(nis, T) F(taken, T) \
    F(log_likelihood_last, T) F(log_likelihood, T) F(events, T) F(events_clear, T) F(forecast, T) \
    F(process_check, T) F(sensor_check, T) F(filter_check, T) F(history_assign, T) F(attach, T) \
    F(history_steps, T) F(smooth, T) F(smooth_states, T) F(smooth_step, T) \
    F(smoothed_measurement_noise, T) F(smoothed, T) F(diffuse_assign, T) F(diffuse_init, T) \
    F(diffuse_count, T) F(diffuse_steps, T) F(diffuse_smooth, T) F(diffuse_smoothed, T) \
    F(lag_assign, T) F(delay_assign, T) F(lag_steps, T) F(lagged, T) F(lagged_states, T) F(instant_assign, T) \
    F(instant_smooth, T) F(update_robust, T) F(chi_square_limit, T) F(adaptation_init, T) \
    F(adaptation_scales, T) F(least_squares_add, T) F(least_squares_residual, T) F(forget, T) \
    F(consistency_assign, T) F(consistency_clear, T) F(consistency_watch, T) \
    F(consistency_record, T) F(consistency_count, T) F(consistency_nis, T) F(consistency_innovation, T)
#define KALMANQ_FLOAT_FUNCTIONS(F, T)                                                              \
    F(process_assign, T)                                                                           \
    F(process_init_factor, T) F(process_scale_noise, T) F(sensor_assign, T)                        \
        F(sensor_init_diagonal, T) F(smooth_reweighted, T) F(adaptation_assign, T)                 \
            F(least_squares_init, T)

#define KALMANQ_FUNCTION(stem, T) static constexpr auto stem = kq_##stem##_##T;

#define KALMANQ_API(T, word) \
    using Process = kq_process_##T; \
    using Sensor = kq_sensor_##T; \
    using Filter = kq_filter_##T; \
    using History = kq_history_##T; \
    using Extras = kq_smooth_extras_##T; \
    using Start = kq_diffuse_##T; \
    using Lag = kq_lag_##T; \
    using Instant = kq_instant_##T; \
    using Loss = kq_loss_##T; \
    using Adaptation = kq_adaptation_##T; \
    using Rule = kq_adaptation_rule_##T; \
    using LeastSquares = kq_least_squares_##T; \
    using Consistency = kq_consistency_##T; \
    using Word = word; \
    static constexpr const char *name = #T; \
    static std::size_t length(kq_object object, int n, int m = 0, std::size_t k = 0, std::size_t l = 0) \
    { \
        return static_cast<std::size_t>(kq_length_##T(object, n, m, k, l)); \
    } \
    static constexpr const auto *gate = &kq_loss_gate_##T; \
    static constexpr const auto *huber = &kq_loss_huber_##T; \
    static constexpr const auto *student = &kq_loss_student_##T; \
    static constexpr const auto *jump = &kq_loss_jump_##T; \
    KALMANQ_FUNCTIONS(KALMANQ_FUNCTION, T)

template <> struct Api<float> {
    using Coefficient = float;
    using Score = float;
    KALMANQ_API(f32, float)
    KALMANQ_FLOAT_FUNCTIONS(KALMANQ_FUNCTION, f32)
    static float number(double a) { return static_cast<float>(a); }
    static double value(float a) { return static_cast<double>(a); }
};

template <> struct Api<double> {
    using Coefficient = double;
    using Score = double;
    KALMANQ_API(f64, double)
    KALMANQ_FLOAT_FUNCTIONS(KALMANQ_FUNCTION, f64)
    static double number(double a) { return a; }
    static double value(double a) { return a; }
};

template <> struct Api<Q31> {
    using Coefficient = kq_scaled_q31;
    using Score = std::int64_t;
    KALMANQ_API(q31, std::int32_t)
    /// To the nearest of 31 bits
    static kq_scaled_q31 number(double a)
    {
        const kq_format_q31 whole = {1, 0};
        kq_scaled_q31 result;
        require(kq_matrix_prepare_q31(&result, &a, 1, 1, &whole, &whole), "number");
        return result;
    }
    static double value(kq_scaled_q31 a) { return std::ldexp(a.mantissa, a.exponent); }
};

} // namespace kq

#endif
