// The library's objects with the memory that it leaves to its caller, made from the matrices of a
// sequence.  The library keeps pointers into them, so they are not to be copied or moved (put them
// into a std::deque or behind a std::unique_ptr).  They throw std::runtime_error where the library
// refuses.
#ifndef KALMANQ_TESTS_REFERENCE_OWNERS_HPP
#define KALMANQ_TESTS_REFERENCE_OWNERS_HPP

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "api.hpp"
#include "formats.hpp"
#include "textbook.hpp"

namespace reference
{

/// How a noise is given to the library: as a covariance, a factor F of it (F F'), its diagonal, or that of a lean sensor.
enum class Noise { covariance, factor, diagonal, lean };

inline std::size_t triangle(int n) { return static_cast<std::size_t>(KQ_TRIANGLE(n)); }

/// The pointer that the library expects for an array that may be absent.
template <class T> const T *dataOrNull(const std::vector<T> &values)
{
    return values.empty() ? nullptr : values.data();
}

class NotCopied
{
  public:
    NotCopied() = default;
    NotCopied(const NotCopied &) = delete;
    NotCopied &operator=(const NotCopied &) = delete;
};

// ------------------------------------------------------------------ process

template <class T> class ProcessOwner : NotCopied
{
    using Api = kq::Api<T>;

  public:
    ProcessOwner(const Formats<T> &states, const ProcessModel &model, Noise kind)
        : controls_(model.B.cols(), model.range), transition_(flattened<T>(model.A)),
          control_(flattened<T>(model.B)), memory_(triangle(states.count()))
    {
        kq::require(Api::process_assign(&handle_, states.count(), controls_.count(), memory_.data(),
                                       memory_.size()),
                    "process assign");
        kq::require(init(model.F, kind), "process init");
    }

    typename Api::Process *get() { return &handle_; }
    const Formats<T> &controls() const { return controls_; }

    /// Another A with the noise as it is.
    void changeTransition(const Matrix<double> &A)
    {
        transition_ = flattened<T>(A);
        kq::require(Api::process_change_transition(&handle_, transition_.data()),
                    "process change transition");
    }

  private:
    kq_status init(const Matrix<double> &F, Noise kind)
    {
        const T *A = transition_.data(), *B = dataOrNull(control_);
        if (kind == Noise::covariance) {
            return Api::process_init(&handle_, A, B, flattened<T>(F * F.transpose()).data());
        }
        const std::vector<T> factor = flattened<T>(F);
        return Api::process_init_factor(&handle_, A, B, dataOrNull(factor),
                                      static_cast<int>(F.cols()));
    }

    Formats<T> controls_;
    std::vector<T> transition_, control_, memory_;
    typename Api::Process handle_{};
};

// ------------------------------------------------------------------ sensor

template <class T> class SensorOwner : NotCopied
{
    using Api = kq::Api<T>;

  public:
    SensorOwner(const Formats<T> &states, const SensorModel &model, Noise kind)
        : components_(model.components(), model.range), measurement_(flattened<T>(model.H)),
          noise_(flattened<T>(kind == Noise::covariance ? model.R : Matrix<double>(model.R.diagonal()))),
          memory_(kind == Noise::covariance ? triangle(components_.count())
                                            : static_cast<std::size_t>(model.components()))
    {
        kq::require(Api::sensor_assign(&handle_, states.count(), components_.count(), memory_.data(),
                                      memory_.size()),
                    "sensor assign");
        const auto initialise = kind == Noise::lean       ? Api::sensor_init_lean
                                : kind == Noise::diagonal ? Api::sensor_init_diagonal
                                                          : Api::sensor_init;
        kq::require(initialise(&handle_, measurement_.data(), noise_.data()), "sensor init");
    }

    typename Api::Sensor *get() { return &handle_; }
    const Formats<T> &components() const { return components_; }

    /// Another H with the noise as it is.
    void changeMeasurement(const Matrix<double> &H)
    {
        measurement_ = flattened<T>(H);
        kq::require(Api::sensor_change_measurement(&handle_, measurement_.data()),
                    "sensor change measurement");
    }

  private:
    Formats<T> components_;
    std::vector<T> measurement_, noise_, memory_;
    typename Api::Sensor handle_{};
};

// ------------------------------------------------------------------ filter and history

/// The memory only; init() gives it a state, forecasts do without.
template <class T> class FilterOwner : NotCopied
{
    using Api = kq::Api<T>;
    using Word = typename Api::Word;

  public:
    explicit FilterOwner(const Formats<T> &states)
        : states_(states), memory_(Api::length(KQ_OBJECT_FILTER, states.count()))
    {
        kq::require(Api::filter_assign(&handle_, states.count(), memory_.data(), memory_.size()),
                    "filter assign");
    }

    kq_status init(const Vector<double> &x0, const Matrix<double> &P0);

    typename Api::Filter *get() { return &handle_; }
    const typename Api::Filter *get() const { return &handle_; }
    const Formats<T> &states() const { return states_; }
    const std::vector<Word> &memory() const { return memory_; }

  private:
    const Formats<T> &states_;
    std::vector<Word> memory_;
    typename Api::Filter handle_{};
};

template <class T>
kq_status FilterOwner<T>::init(const Vector<double> &x0, const Matrix<double> &P0)
{
    return Api::filter_init(&handle_, flattened<T>(x0).data(), flattened<T>(P0).data());
}

template <class T> class HistoryOwner : NotCopied
{
    using Api = kq::Api<T>;

  public:
    /// Room for `steps` steps of at most m scalar measurements and `changes` changes of process.
    HistoryOwner(const Formats<T> &states, int m, std::size_t steps, std::size_t changes)
        : states_(states), memory_(Api::length(KQ_OBJECT_HISTORY, states.count(), m, steps, changes))
    {
        kq::require(Api::history_assign(&handle_, states.count(), memory_.data(), memory_.size()),
                    "history assign");
    }

    typename Api::History *get() { return &handle_; }
    const typename Api::History *get() const { return &handle_; }
    const Formats<T> &states() const { return states_; }

  private:
    const Formats<T> &states_;
    std::vector<typename Api::Word> memory_;
    typename Api::History handle_{};
};

// ------------------------------------------------------------------ q31

/// Says whose range does not fit.
inline void requireFit(kq_status status, const kq_range_error_q31 &range_error, const char *what)
{
    if (status != KQ_ERR_RANGE) return kq::require(status, what);
    char text[80];
    kq_range_error_text_q31(&range_error, text, sizeof text);
    throw std::runtime_error(std::string(what) + ": " + text);
}

/// The table of M, which makes `rows` of `columns`.
inline std::vector<kq_scaled_q31> prepared(const Matrix<double> &M, const Formats<Q31> &rows,
                                           const Formats<Q31> &columns)
{
    std::vector<kq_scaled_q31> table(static_cast<std::size_t>(M.size()));
    if (table.empty()) return table;
    kq::require(kq_matrix_prepare_q31(table.data(), flattened<double>(M).data(), rows.count(),
                                      columns.count(), rows.data(), columns.data()),
                "matrix prepare");
    return table;
}

inline std::size_t rootLength(int n) { return static_cast<std::size_t>(KQ_ROOT_LEN_Q31(n)); }

template <> class ProcessOwner<Q31> : NotCopied
{
  public:
    ProcessOwner(const Formats<Q31> &states, const ProcessModel &model, Noise kind)
        : states_(states), controls_(model.B.cols(), model.range),
          transition_(prepared(model.A, states, states)),
          control_(prepared(model.B, states, controls_)), root_(rootLength(states.count()))
    {
        kq::require(prepareNoise(model.F, kind), "noise root prepare");
        const kq_process_table_q31 table = {
            states.count(),     controls_.count(),    states.data(), controls_.dataOrNull(),
            transition_.data(), dataOrNull(control_), root_.data()};
        kq_range_error_q31 range_error{};
        requireFit(kq_process_init_q31(&handle_, &table, &range_error), range_error, "process init");
    }

    kq_process_q31 *get() { return &handle_; }
    const Formats<Q31> &controls() const { return controls_; }

    void changeTransition(const Matrix<double> &A)
    {
        transition_ = prepared(A, states_, states_);
        kq::require(kq_process_change_transition_q31(&handle_, transition_.data(), nullptr),
                    "process change transition");
    }

  private:
    kq_status prepareNoise(const Matrix<double> &F, Noise kind)
    {
        const int n = states_.count();
        if (kind == Noise::covariance) {
            return kq_root_prepare_q31(root_.data(), flattened<double>(F * F.transpose()).data(), n,
                                       states_.data());
        }
        const std::vector<double> factor = flattened<double>(F);
        return kq_root_prepare_factor_q31(root_.data(), dataOrNull(factor), n,
                                          static_cast<int>(F.cols()), states_.data());
    }

    const Formats<Q31> &states_;
    Formats<Q31> controls_;
    std::vector<kq_scaled_q31> transition_, control_;
    std::vector<std::int32_t> root_;
    kq_process_q31 handle_{};
};

template <> class SensorOwner<Q31> : NotCopied
{
  public:
    SensorOwner(const Formats<Q31> &states, const SensorModel &model, Noise kind)
        : states_(states), components_(model.components(), model.range),
          measurement_(prepared(model.H, components_, states))
    {
        kq::require(prepareNoise(model.R, kind), "noise prepare");
        const kq_sensor_table_q31 table = {
            states.count(), components_.count(), kind == Noise::covariance ? 1 : 0,
            states.data(),  components_.data(),  measurement_.data(),
            noise_.data()};
        kq_range_error_q31 range_error{};
        const auto initialise = kind == Noise::lean ? kq_sensor_init_lean_q31 : kq_sensor_init_q31;
        requireFit(initialise(&handle_, &table, &range_error), range_error, "sensor init");
    }

    kq_sensor_q31 *get() { return &handle_; }
    const Formats<Q31> &components() const { return components_; }

    void changeMeasurement(const Matrix<double> &H)
    {
        measurement_ = prepared(H, components_, states_);
        kq::require(kq_sensor_change_measurement_q31(&handle_, measurement_.data(), nullptr),
                    "sensor change measurement");
    }

  private:
    kq_status prepareNoise(const Matrix<double> &R, Noise kind)
    {
        const int m = components_.count();
        if (kind != Noise::covariance) {
            noise_.resize(static_cast<std::size_t>(m));
            return kq_noise_prepare_diagonal_q31(
                noise_.data(), flattened<double>(R.diagonal()).data(), m, components_.data());
        }
        noise_.resize(triangle(m));
        return kq_noise_prepare_q31(noise_.data(), flattened<double>(R).data(), m,
                                    components_.data());
    }

    const Formats<Q31> &states_;
    Formats<Q31> components_;
    std::vector<kq_scaled_q31> measurement_, noise_;
    kq_sensor_q31 handle_{};
};

/// The table of a prior, and what it points to
struct Prior : NotCopied {
    std::vector<std::int32_t> mean, root;
    kq_prior_table_q31 table;
    kq_status status; // of its preparation

    Prior(const Formats<Q31> &states, const Vector<double> &x0, const Matrix<double> &P0)
        : mean(states.words(x0)),
          root(rootLength(states.count())), table{states.count(), states.data(), mean.data(),
                                                  root.data()},
          status(kq_root_prepare_q31(root.data(), flattened<double>(P0).data(), states.count(),
                                     states.data()))
    {
    }
};

template <>
inline kq_status FilterOwner<Q31>::init(const Vector<double> &x0, const Matrix<double> &P0)
{
    const Prior prior(states_, x0, P0);
    return prior.status != KQ_OK ? prior.status
                                 : kq_filter_init_q31(&handle_, &prior.table, nullptr);
}

} // namespace reference

#endif
