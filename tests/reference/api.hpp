// The library's three arithmetics behind one set of names, so that a test is written once.
//
//     Api<T>::predict(filter.get(), process.get(), u)      T = float, double or Q31
//
// Word: a component of x, u or z.  Coefficient: an entry of a matrix.  Score: a log-likelihood.
#ifndef KALMANQ_TESTS_REFERENCE_API_HPP
#define KALMANQ_TESTS_REFERENCE_API_HPP

#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#include "kalmanq/kalmanq.h"

namespace kq
{

/// Stands for the fixed-point arithmetic, which has no number type of its own.
struct Q31 {
};

template <class T> struct Api;

/// Twice the relative error of one rounding: of a number, and in q31 of a row of the root.
template <class T> constexpr double epsilon()
{
    return static_cast<double>(std::numeric_limits<T>::epsilon());
}
template <> constexpr double epsilon<Q31>() { return 0x1p-29; }

template <> struct Api<float> {
    using Word = float;
    using Coefficient = float;
    using Score = float;
    using Process = kq_process_f32;
    using Sensor = kq_sensor_f32;
    using Filter = kq_filter_f32;
    using History = kq_history_f32;
    using Extras = kq_smooth_extras_f32;
    using Start = kq_diffuse_f32;
    static constexpr const char *name = "f32";

    static constexpr std::size_t filterLength(int n)
    {
        return static_cast<std::size_t>(KQ_FILTER_LEN_F32(n));
    }
    static constexpr std::size_t historyLength(int n, int m, std::size_t steps, std::size_t changes)
    {
        const auto width = static_cast<std::size_t>(n), depth = static_cast<std::size_t>(m);
        return KQ_HISTORY_LEN_F32(width, depth, steps, changes);
    }

    static constexpr auto processAssign = kq_process_assign_f32;
    static constexpr auto processInit = kq_process_init_f32;
    static constexpr auto processInitFactor = kq_process_init_factor_f32;
    static constexpr auto processChangeTransition = kq_process_change_transition_f32;

    static constexpr auto sensorAssign = kq_sensor_assign_f32;
    static constexpr auto sensorInit = kq_sensor_init_f32;
    static constexpr auto sensorInitDiagonal = kq_sensor_init_diagonal_f32;
    static constexpr auto sensorChangeMeasurement = kq_sensor_change_measurement_f32;

    static constexpr auto filterAssign = kq_filter_assign_f32;
    static constexpr auto filterInit = kq_filter_init_f32;
    static constexpr auto predict = kq_predict_f32;
    static constexpr auto update = kq_update_f32;
    static constexpr auto updateSubset = kq_update_subset_f32;
    static constexpr auto step = kq_step_f32;
    static constexpr auto mean = kq_mean_f32;
    static constexpr auto meanLow = kq_mean_low_f32;
    static constexpr auto sigma = kq_sigma_f32;
    static constexpr auto covariance = kq_covariance_f32;
    static constexpr auto measurement = kq_measurement_f32;
    static constexpr auto innovation = kq_innovation_f32;
    static constexpr auto gain = kq_gain_f32;
    static constexpr auto nis = kq_nis_f32;
    static constexpr auto taken = kq_taken_f32;
    static constexpr auto logLikelihoodLast = kq_log_likelihood_last_f32;
    static constexpr auto logLikelihood = kq_log_likelihood_f32;
    static constexpr auto events = kq_events_f32;
    static constexpr auto eventsClear = kq_events_clear_f32;
    static constexpr auto forecast = kq_forecast_f32;
    static constexpr auto processCheck = kq_process_check_f32;
    static constexpr auto sensorCheck = kq_sensor_check_f32;
    static constexpr auto filterCheck = kq_filter_check_f32;

    static constexpr auto historyAssign = kq_history_assign_f32;
    static constexpr auto attach = kq_attach_f32;
    static constexpr auto historySteps = kq_history_steps_f32;
    static constexpr auto smooth = kq_smooth_f32;
    static constexpr auto smoothStates = kq_smooth_states_f32;
    static constexpr auto smoothStep = kq_smooth_step_f32;
    static constexpr auto smoothedMeasurementNoise = kq_smoothed_measurement_noise_f32;
    static constexpr auto smoothed = kq_smoothed_f32;

    static std::size_t startLength(int n, std::size_t early)
    {
        const auto width = static_cast<std::size_t>(n);
        return KQ_DIFFUSE_LEN_F32(width, early);
    }
    static constexpr auto startAssign = kq_diffuse_assign_f32;
    static constexpr auto startInit = kq_diffuse_init_f32;
    static constexpr auto startCount = kq_diffuse_count_f32;
    static constexpr auto startSteps = kq_diffuse_steps_f32;
    static constexpr auto startSmooth = kq_diffuse_smooth_f32;
    static constexpr auto startSmoothed = kq_diffuse_smoothed_f32;
};

template <> struct Api<double> {
    using Word = double;
    using Coefficient = double;
    using Score = double;
    using Process = kq_process_f64;
    using Sensor = kq_sensor_f64;
    using Filter = kq_filter_f64;
    using History = kq_history_f64;
    using Extras = kq_smooth_extras_f64;
    using Start = kq_diffuse_f64;
    static constexpr const char *name = "f64";

    static constexpr std::size_t filterLength(int n)
    {
        return static_cast<std::size_t>(KQ_FILTER_LEN_F64(n));
    }
    static constexpr std::size_t historyLength(int n, int m, std::size_t steps, std::size_t changes)
    {
        const auto width = static_cast<std::size_t>(n), depth = static_cast<std::size_t>(m);
        return KQ_HISTORY_LEN_F64(width, depth, steps, changes);
    }

    static constexpr auto processAssign = kq_process_assign_f64;
    static constexpr auto processInit = kq_process_init_f64;
    static constexpr auto processInitFactor = kq_process_init_factor_f64;
    static constexpr auto processChangeTransition = kq_process_change_transition_f64;

    static constexpr auto sensorAssign = kq_sensor_assign_f64;
    static constexpr auto sensorInit = kq_sensor_init_f64;
    static constexpr auto sensorInitDiagonal = kq_sensor_init_diagonal_f64;
    static constexpr auto sensorChangeMeasurement = kq_sensor_change_measurement_f64;

    static constexpr auto filterAssign = kq_filter_assign_f64;
    static constexpr auto filterInit = kq_filter_init_f64;
    static constexpr auto predict = kq_predict_f64;
    static constexpr auto update = kq_update_f64;
    static constexpr auto updateSubset = kq_update_subset_f64;
    static constexpr auto step = kq_step_f64;
    static constexpr auto mean = kq_mean_f64;
    static constexpr auto meanLow = kq_mean_low_f64;
    static constexpr auto sigma = kq_sigma_f64;
    static constexpr auto covariance = kq_covariance_f64;
    static constexpr auto measurement = kq_measurement_f64;
    static constexpr auto innovation = kq_innovation_f64;
    static constexpr auto gain = kq_gain_f64;
    static constexpr auto nis = kq_nis_f64;
    static constexpr auto taken = kq_taken_f64;
    static constexpr auto logLikelihoodLast = kq_log_likelihood_last_f64;
    static constexpr auto logLikelihood = kq_log_likelihood_f64;
    static constexpr auto events = kq_events_f64;
    static constexpr auto eventsClear = kq_events_clear_f64;
    static constexpr auto forecast = kq_forecast_f64;
    static constexpr auto processCheck = kq_process_check_f64;
    static constexpr auto sensorCheck = kq_sensor_check_f64;
    static constexpr auto filterCheck = kq_filter_check_f64;

    static constexpr auto historyAssign = kq_history_assign_f64;
    static constexpr auto attach = kq_attach_f64;
    static constexpr auto historySteps = kq_history_steps_f64;
    static constexpr auto smooth = kq_smooth_f64;
    static constexpr auto smoothStates = kq_smooth_states_f64;
    static constexpr auto smoothStep = kq_smooth_step_f64;
    static constexpr auto smoothedMeasurementNoise = kq_smoothed_measurement_noise_f64;
    static constexpr auto smoothed = kq_smoothed_f64;

    static std::size_t startLength(int n, std::size_t early)
    {
        const auto width = static_cast<std::size_t>(n);
        return KQ_DIFFUSE_LEN_F64(width, early);
    }
    static constexpr auto startAssign = kq_diffuse_assign_f64;
    static constexpr auto startInit = kq_diffuse_init_f64;
    static constexpr auto startCount = kq_diffuse_count_f64;
    static constexpr auto startSteps = kq_diffuse_steps_f64;
    static constexpr auto startSmooth = kq_diffuse_smooth_f64;
    static constexpr auto startSmoothed = kq_diffuse_smoothed_f64;
};

template <> struct Api<Q31> {
    using Word = std::int32_t;
    using Coefficient = kq_scaled_q31;
    using Score = std::int64_t;
    using Process = kq_process_q31;
    using Sensor = kq_sensor_q31;
    using Filter = kq_filter_q31;
    using History = kq_history_q31;
    using Extras = kq_smooth_extras_q31;
    using Start = kq_diffuse_q31;
    static constexpr const char *name = "q31";

    static constexpr std::size_t filterLength(int n)
    {
        return static_cast<std::size_t>(KQ_FILTER_LEN_Q31(n));
    }
    static constexpr std::size_t historyLength(int n, int m, std::size_t steps, std::size_t changes)
    {
        const auto width = static_cast<std::size_t>(n), depth = static_cast<std::size_t>(m);
        return KQ_HISTORY_LEN_Q31(width, depth, steps, changes);
    }

    static constexpr auto processInit = kq_process_init_q31;
    static constexpr auto processChangeTransition = kq_process_change_transition_q31;

    static constexpr auto sensorInit = kq_sensor_init_q31;
    static constexpr auto sensorChangeMeasurement = kq_sensor_change_measurement_q31;

    static constexpr auto filterAssign = kq_filter_assign_q31;
    static constexpr auto filterInit = kq_filter_init_q31;
    static constexpr auto predict = kq_predict_q31;
    static constexpr auto update = kq_update_q31;
    static constexpr auto updateSubset = kq_update_subset_q31;
    static constexpr auto step = kq_step_q31;
    static constexpr auto mean = kq_mean_q31;
    static constexpr auto meanLow = kq_mean_low_q31;
    static constexpr auto sigma = kq_sigma_q31;
    static constexpr auto covariance = kq_covariance_q31;
    static constexpr auto measurement = kq_measurement_q31;
    static constexpr auto innovation = kq_innovation_q31;
    static constexpr auto gain = kq_gain_q31;
    static constexpr auto nis = kq_nis_q31;
    static constexpr auto taken = kq_taken_q31;
    static constexpr auto logLikelihoodLast = kq_log_likelihood_last_q31;
    static constexpr auto logLikelihood = kq_log_likelihood_q31;
    static constexpr auto events = kq_events_q31;
    static constexpr auto eventsClear = kq_events_clear_q31;
    static constexpr auto forecast = kq_forecast_q31;
    static constexpr auto processCheck = kq_process_check_q31;
    static constexpr auto sensorCheck = kq_sensor_check_q31;
    static constexpr auto filterCheck = kq_filter_check_q31;

    static constexpr auto historyAssign = kq_history_assign_q31;
    static constexpr auto attach = kq_attach_q31;
    static constexpr auto historySteps = kq_history_steps_q31;
    static constexpr auto smooth = kq_smooth_q31;
    static constexpr auto smoothStates = kq_smooth_states_q31;
    static constexpr auto smoothStep = kq_smooth_step_q31;
    static constexpr auto smoothedMeasurementNoise = kq_smoothed_measurement_noise_q31;
    static constexpr auto smoothed = kq_smoothed_q31;

    static std::size_t startLength(int n, std::size_t early)
    {
        const auto width = static_cast<std::size_t>(n);
        return KQ_DIFFUSE_LEN_Q31(width, early);
    }
    static constexpr auto startAssign = kq_diffuse_assign_q31;
    static constexpr auto startInit = kq_diffuse_init_q31;
    static constexpr auto startCount = kq_diffuse_count_q31;
    static constexpr auto startSteps = kq_diffuse_steps_q31;
    static constexpr auto startSmooth = kq_diffuse_smooth_q31;
    static constexpr auto startSmoothed = kq_diffuse_smoothed_q31;
};

inline void require(kq_status status, const char *what)
{
    if (status != KQ_OK) {
        throw std::runtime_error(std::string(what) + ": " + kq_status_text(status));
    }
}

} // namespace kq

#endif
