// The library's two number types behind one set of names, so that a test is written once.
//
//     Api<T>::predict(filter.get(), process.get(), u)      T = float or double
//
// The owners hold the memory that the library leaves to its caller, and throw
// std::runtime_error where the library refuses.  They are not to be copied or moved: the library
// keeps pointers into them (put them into a std::deque or behind a std::unique_ptr).
#ifndef KALMANQ_TESTS_REFERENCE_API_HPP
#define KALMANQ_TESTS_REFERENCE_API_HPP

#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "kalmanq/kalmanq.h"

namespace kq
{

template <class T> struct Api;

template <> struct Api<float> {
    using Process = kq_process_f32;
    using Sensor = kq_sensor_f32;
    using Filter = kq_filter_f32;
    using History = kq_history_f32;
    using Extras = kq_smooth_extras_f32;
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

    static constexpr auto historyAssign = kq_history_assign_f32;
    static constexpr auto historyAttach = kq_history_attach_f32;
    static constexpr auto historySteps = kq_history_steps_f32;
    static constexpr auto smooth = kq_smooth_f32;
    static constexpr auto smoothStates = kq_smooth_states_f32;
    static constexpr auto smoothStep = kq_smooth_step_f32;
    static constexpr auto smoothedMeasurementNoise = kq_smoothed_measurement_noise_f32;
    static constexpr auto smoothedMean = kq_smoothed_mean_f32;
    static constexpr auto smoothedMeanLow = kq_smoothed_mean_low_f32;
    static constexpr auto smoothedSigma = kq_smoothed_sigma_f32;
    static constexpr auto smoothedCovariance = kq_smoothed_covariance_f32;
};

template <> struct Api<double> {
    using Process = kq_process_f64;
    using Sensor = kq_sensor_f64;
    using Filter = kq_filter_f64;
    using History = kq_history_f64;
    using Extras = kq_smooth_extras_f64;
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

    static constexpr auto historyAssign = kq_history_assign_f64;
    static constexpr auto historyAttach = kq_history_attach_f64;
    static constexpr auto historySteps = kq_history_steps_f64;
    static constexpr auto smooth = kq_smooth_f64;
    static constexpr auto smoothStates = kq_smooth_states_f64;
    static constexpr auto smoothStep = kq_smooth_step_f64;
    static constexpr auto smoothedMeasurementNoise = kq_smoothed_measurement_noise_f64;
    static constexpr auto smoothedMean = kq_smoothed_mean_f64;
    static constexpr auto smoothedMeanLow = kq_smoothed_mean_low_f64;
    static constexpr auto smoothedSigma = kq_smoothed_sigma_f64;
    static constexpr auto smoothedCovariance = kq_smoothed_covariance_f64;
};

/// What a noise argument holds: a covariance, a factor F of it (F F'), or its diagonal only.
enum class Noise { covariance, factor, diagonal };

inline void require(kq_status status, const char *what)
{
    if (status != KQ_OK) {
        throw std::runtime_error(std::string(what) + ": " + kq_status_text(status));
    }
}

inline std::size_t triangle(int n) { return static_cast<std::size_t>(KQ_TRIANGLE(n)); }

/// The pointer that the library expects for an array that may be absent.
template <class T> const T *dataOrNull(const std::vector<T> &values)
{
    return values.empty() ? nullptr : values.data();
}

template <class T> class ProcessOwner
{
  public:
    using Handle = typename Api<T>::Process;

    /// A n x n, B n x l (empty if l = 0), noise Q n x n or its factor n x r; all by rows.
    ProcessOwner(int n, int l, std::vector<T> A, std::vector<T> B, const std::vector<T> &noise,
                 Noise kind = Noise::covariance)
        : transition_(std::move(A)), control_(std::move(B)), memory_(triangle(n))
    {
        require(Api<T>::processAssign(&handle_, n, l, memory_.data(), memory_.size()),
                "process assign");
        require(init(n, noise, kind), "process init");
    }
    ProcessOwner(const ProcessOwner &) = delete;
    ProcessOwner &operator=(const ProcessOwner &) = delete;

    Handle *get() { return &handle_; }
    const Handle *get() const { return &handle_; }

    /// Another A with the noise as it is.
    void changeTransition(std::vector<T> A)
    {
        transition_ = std::move(A);
        require(Api<T>::processChangeTransition(&handle_, transition_.data()),
                "process change transition");
    }

  private:
    kq_status init(int n, const std::vector<T> &noise, Noise kind)
    {
        const T *A = transition_.data();
        const T *B = dataOrNull(control_);
        if (kind == Noise::covariance) {
            return Api<T>::processInit(&handle_, A, B, noise.data());
        }
        const int columns = static_cast<int>(noise.size()) / n;
        return Api<T>::processInitFactor(&handle_, A, B, dataOrNull(noise), columns);
    }

    std::vector<T> transition_, control_, memory_;
    Handle handle_{};
};

template <class T> class SensorOwner
{
  public:
    using Handle = typename Api<T>::Sensor;

    /// H m x n, noise R m x m or its m variances; by rows.
    SensorOwner(int n, int m, std::vector<T> H, std::vector<T> noise,
                Noise kind = Noise::covariance)
        : measurement_(std::move(H)), noise_(std::move(noise)),
          memory_(kind == Noise::diagonal ? static_cast<std::size_t>(m) : triangle(m))
    {
        require(Api<T>::sensorAssign(&handle_, n, m, memory_.data(), memory_.size()),
                "sensor assign");
        const auto initialise =
            kind == Noise::diagonal ? Api<T>::sensorInitDiagonal : Api<T>::sensorInit;
        require(initialise(&handle_, measurement_.data(), noise_.data()), "sensor init");
    }
    SensorOwner(const SensorOwner &) = delete;
    SensorOwner &operator=(const SensorOwner &) = delete;

    Handle *get() { return &handle_; }
    const Handle *get() const { return &handle_; }

    /// Another H with the noise as it is.
    void changeMeasurement(std::vector<T> H)
    {
        measurement_ = std::move(H);
        require(Api<T>::sensorChangeMeasurement(&handle_, measurement_.data()),
                "sensor change measurement");
    }

  private:
    std::vector<T> measurement_, noise_, memory_;
    Handle handle_{};
};

template <class T> class FilterOwner
{
  public:
    using Handle = typename Api<T>::Filter;

    /// Memory only, not initialised: for forecasts.
    explicit FilterOwner(int n) : memory_(Api<T>::filterLength(n))
    {
        require(Api<T>::filterAssign(&handle_, n, memory_.data(), memory_.size()), "filter assign");
    }
    /// x0 n, P0 n x n.
    FilterOwner(int n, const std::vector<T> &x0, const std::vector<T> &P0) : FilterOwner(n)
    {
        require(Api<T>::filterInit(&handle_, x0.data(), P0.data()), "filter init");
    }
    FilterOwner(const FilterOwner &) = delete;
    FilterOwner &operator=(const FilterOwner &) = delete;

    Handle *get() { return &handle_; }
    const Handle *get() const { return &handle_; }
    const std::vector<T> &memory() const { return memory_; }

  private:
    std::vector<T> memory_;
    Handle handle_{};
};

template <class T> class HistoryOwner
{
  public:
    using Handle = typename Api<T>::History;

    /// Room for `steps` steps of at most m scalar measurements and `changes` changes of process.
    HistoryOwner(int n, int m, std::size_t steps, std::size_t changes)
        : memory_(Api<T>::historyLength(n, m, steps, changes))
    {
        require(Api<T>::historyAssign(&handle_, n, memory_.data(), memory_.size()),
                "history assign");
    }
    HistoryOwner(const HistoryOwner &) = delete;
    HistoryOwner &operator=(const HistoryOwner &) = delete;

    Handle *get() { return &handle_; }
    const Handle *get() const { return &handle_; }

  private:
    std::vector<T> memory_;
    Handle handle_{};
};

} // namespace kq

#endif
