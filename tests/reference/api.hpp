// The library's three arithmetics behind one set of names, so that a test is written once.
//
//     Api<T>::predict(filter.get(), process.get(), u)      T = float, double or Q31
//
// Word: a component of x, u or z.  Coefficient: an entry of a matrix.  Score: a log-likelihood.
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

/// What all arithmetics have; lengths are of sizes that are not negative.
#define KALMANQ_API(suffix, SUFFIX, word)                                                          \
    using Word = word;                                                                             \
    using Process = kq_process_##suffix;                                                           \
    using Sensor = kq_sensor_##suffix;                                                             \
    using Filter = kq_filter_##suffix;                                                             \
    using History = kq_history_##suffix;                                                           \
    using Extras = kq_smooth_extras_##suffix;                                                      \
    using Start = kq_diffuse_##suffix;                                                             \
    using Lag = kq_lag_##suffix;                                                                   \
    using Instant = kq_instant_##suffix;                                                           \
    using Loss = kq_loss_##suffix;                                                                 \
    using Adaptation = kq_adaptation_##suffix;                                                     \
    using Rule = kq_adaptation_rule_##suffix;                                                      \
    using LeastSquares = kq_least_squares_##suffix;                                                \
    using Consistency = kq_consistency_##suffix;                                                   \
    static constexpr const char *name = #suffix;                                                   \
    static constexpr std::size_t filterLength(int n)                                               \
    {                                                                                              \
        return static_cast<std::size_t>(KQ_FILTER_LEN_##SUFFIX(n));                                \
    }                                                                                              \
    static constexpr std::size_t historyLength(std::size_t n, std::size_t m, std::size_t steps,    \
                                               std::size_t changes)                                \
    {                                                                                              \
        return static_cast<std::size_t>(KQ_HISTORY_LEN_##SUFFIX(n, m, steps, changes));            \
    }                                                                                              \
    static constexpr std::size_t startLength(std::size_t n, std::size_t early)                     \
    {                                                                                              \
        return static_cast<std::size_t>(KQ_DIFFUSE_LEN_##SUFFIX(n, early));                        \
    }                                                                                              \
    static constexpr std::size_t lagLength(std::size_t n, std::size_t m, std::size_t L)            \
    {                                                                                              \
        return static_cast<std::size_t>(KQ_LAG_LEN_##SUFFIX(n, m, L));                             \
    }                                                                                              \
    static constexpr std::size_t instantLength(std::size_t n, std::size_t m)                       \
    {                                                                                              \
        return static_cast<std::size_t>(KQ_INSTANT_LEN_##SUFFIX(n, m));                            \
    }                                                                                              \
    static constexpr std::size_t adaptationLength(std::size_t n, std::size_t m)                    \
    {                                                                                              \
        return static_cast<std::size_t>(KQ_ADAPTATION_LEN_##SUFFIX(n, m));                         \
    }                                                                                              \
    static constexpr std::size_t consistencyLength(std::size_t m, std::size_t window)              \
    {                                                                                              \
        return static_cast<std::size_t>(KQ_CONSISTENCY_LEN_##SUFFIX(m, window));                   \
    }                                                                                              \
    static constexpr auto processInit = kq_process_init_##suffix;                                  \
    static constexpr auto processChangeTransition = kq_process_change_transition_##suffix;         \
    static constexpr auto sensorInit = kq_sensor_init_##suffix;                                    \
    static constexpr auto sensorChangeMeasurement = kq_sensor_change_measurement_##suffix;         \
    static constexpr auto filterAssign = kq_filter_assign_##suffix;                                \
    static constexpr auto filterInit = kq_filter_init_##suffix;                                    \
    static constexpr auto predict = kq_predict_##suffix;                                           \
    static constexpr auto update = kq_update_##suffix;                                             \
    static constexpr auto updateSubset = kq_update_subset_##suffix;                                \
    static constexpr auto step = kq_step_##suffix;                                                 \
    static constexpr auto mean = kq_mean_##suffix;                                                 \
    static constexpr auto meanLow = kq_mean_low_##suffix;                                          \
    static constexpr auto sigma = kq_sigma_##suffix;                                               \
    static constexpr auto covariance = kq_covariance_##suffix;                                     \
    static constexpr auto measurement = kq_measurement_##suffix;                                   \
    static constexpr auto innovation = kq_innovation_##suffix;                                     \
    static constexpr auto gain = kq_gain_##suffix;                                                 \
    static constexpr auto nis = kq_nis_##suffix;                                                   \
    static constexpr auto taken = kq_taken_##suffix;                                               \
    static constexpr auto logLikelihoodLast = kq_log_likelihood_last_##suffix;                     \
    static constexpr auto logLikelihood = kq_log_likelihood_##suffix;                              \
    static constexpr auto events = kq_events_##suffix;                                             \
    static constexpr auto eventsClear = kq_events_clear_##suffix;                                  \
    static constexpr auto forecast = kq_forecast_##suffix;                                         \
    static constexpr auto processCheck = kq_process_check_##suffix;                                \
    static constexpr auto sensorCheck = kq_sensor_check_##suffix;                                  \
    static constexpr auto filterCheck = kq_filter_check_##suffix;                                  \
    static constexpr auto historyAssign = kq_history_assign_##suffix;                              \
    static constexpr auto attach = kq_attach_##suffix;                                             \
    static constexpr auto historySteps = kq_history_steps_##suffix;                                \
    static constexpr auto smooth = kq_smooth_##suffix;                                             \
    static constexpr auto smoothStates = kq_smooth_states_##suffix;                                \
    static constexpr auto smoothStep = kq_smooth_step_##suffix;                                    \
    static constexpr auto smoothedMeasurementNoise = kq_smoothed_measurement_noise_##suffix;       \
    static constexpr auto smoothed = kq_smoothed_##suffix;                                         \
    static constexpr auto startAssign = kq_diffuse_assign_##suffix;                                \
    static constexpr auto startInit = kq_diffuse_init_##suffix;                                    \
    static constexpr auto startCount = kq_diffuse_count_##suffix;                                  \
    static constexpr auto startSteps = kq_diffuse_steps_##suffix;                                  \
    static constexpr auto startSmooth = kq_diffuse_smooth_##suffix;                                \
    static constexpr auto startSmoothed = kq_diffuse_smoothed_##suffix;                            \
    static constexpr auto lagAssign = kq_lag_assign_##suffix;                                      \
    static constexpr auto lagSteps = kq_lag_steps_##suffix;                                        \
    static constexpr auto lagged = kq_lagged_##suffix;                                             \
    static constexpr auto laggedStates = kq_lagged_states_##suffix;                                \
    static constexpr auto instantAssign = kq_instant_assign_##suffix;                              \
    static constexpr auto instantSmooth = kq_instant_smooth_##suffix;                              \
    static constexpr auto updateRobust = kq_update_robust_##suffix;                                \
    static constexpr auto chiSquareLimit = kq_chi_square_limit_##suffix;                           \
    static constexpr auto adaptationInit = kq_adaptation_init_##suffix;                            \
    static constexpr auto adaptationScales = kq_adaptation_scales_##suffix;                        \
    static constexpr auto leastSquaresAdd = kq_least_squares_add_##suffix;                         \
    static constexpr auto leastSquaresResidual = kq_least_squares_residual_##suffix;               \
    static constexpr auto forget = kq_forget_##suffix;                                             \
    static constexpr auto consistencyAssign = kq_consistency_assign_##suffix;                      \
    static constexpr auto consistencyClear = kq_consistency_clear_##suffix;                        \
    static constexpr auto consistencyWatch = kq_consistency_watch_##suffix;                        \
    static constexpr auto consistencyRecord = kq_consistency_record_##suffix;                      \
    static constexpr auto consistencyNis = kq_consistency_nis_##suffix;                            \
    static constexpr auto consistencyInnovation = kq_consistency_innovation_##suffix;              \
    static constexpr const auto *gate = &kq_loss_gate_##suffix;                                    \
    static constexpr const auto *huber = &kq_loss_huber_##suffix;                                  \
    static constexpr const auto *student = &kq_loss_student_##suffix;                              \
    static constexpr const auto *jump = &kq_loss_jump_##suffix;

/// What floating point alone has
#define KALMANQ_FLOAT_API(suffix)                                                                  \
    static constexpr auto processAssign = kq_process_assign_##suffix;                              \
    static constexpr auto processInitFactor = kq_process_init_factor_##suffix;                     \
    static constexpr auto sensorAssign = kq_sensor_assign_##suffix;                                \
    static constexpr auto sensorInitDiagonal = kq_sensor_init_diagonal_##suffix;

template <> struct Api<float> {
    using Coefficient = float;
    using Score = float;
    KALMANQ_API(f32, F32, float)
    KALMANQ_FLOAT_API(f32)
    static float number(double a) { return static_cast<float>(a); }
    static double value(float a) { return static_cast<double>(a); }
};

template <> struct Api<double> {
    using Coefficient = double;
    using Score = double;
    KALMANQ_API(f64, F64, double)
    KALMANQ_FLOAT_API(f64)
    static double number(double a) { return a; }
    static double value(double a) { return a; }
};

template <> struct Api<Q31> {
    using Coefficient = kq_scaled_q31;
    using Score = std::int64_t;
    KALMANQ_API(q31, Q31, std::int32_t)
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
