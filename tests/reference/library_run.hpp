// A sequence run through the library in number type T, read back in double.
//
//     LibraryRun<float> run(sequence);
//     run.record();                              only if it is to be smoothed
//     for (const Step &step : sequence.steps) {
//         run.update(step);                      run.belief() is the filtered one here
//         run.predict(step);
//     }
//     std::vector<Smoothed<double>> past = run.smooth();
#ifndef KALMANQ_TESTS_REFERENCE_LIBRARY_RUN_HPP
#define KALMANQ_TESTS_REFERENCE_LIBRARY_RUN_HPP

#include <algorithm>
#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "api.hpp"
#include "textbook.hpp"

namespace reference
{

/// By rows, as the library takes it; exact, because every number of a sequence is a float.
template <class T> std::vector<T> flattened(const Matrix<double> &M)
{
    std::vector<T> values;
    for (Eigen::Index i = 0; i < M.rows(); ++i) {
        for (Eigen::Index j = 0; j < M.cols(); ++j) {
            values.push_back(static_cast<T>(M(i, j)));
        }
    }
    return values;
}

template <class T> Matrix<double> unflattened(const std::vector<T> &values, Eigen::Index n)
{
    Matrix<double> M(n, n);
    for (Eigen::Index k = 0; k < n * n; ++k) {
        M(k / n, k % n) = static_cast<double>(values[static_cast<std::size_t>(k)]);
    }
    return M;
}

template <class T> class LibraryRun
{
    using Api = kq::Api<T>;

  public:
    explicit LibraryRun(const Sequence &sequence)
        : sequence_(sequence), n_(static_cast<int>(sequence.states())),
          filter_(n_, flattened<T>(sequence.x0), flattened<T>(sequence.P0)),
          square_(static_cast<std::size_t>(n_ * n_)), sensorMemory_(KQ_SIZE_MAX)
    {
        for (const ProcessModel &process : sequence.processes) {
            processes_.emplace_back(n_, 0, flattened<T>(process.A), std::vector<T>(),
                                    flattened<T>(process.F), kq::Noise::factor);
        }
        for (const SensorModel &sensor : sequence.sensors) {
            rows_.push_back(flattened<T>(sensor.H));
        }
    }

    /// From here on, for smooth().
    void record()
    {
        std::size_t most = 0;
        for (const Step &step : sequence_.steps) {
            std::size_t count = 0;
            for (const Reading &reading : step.readings) {
                count += presentComponents(reading).size();
            }
            most = std::max(most, count);
        }
        const std::size_t steps = sequence_.steps.size();
        history_ = std::make_unique<kq::HistoryOwner<T>>(n_, static_cast<int>(most), steps, steps);
        kq::require(Api::historyAttach(history_->get(), filter_.get()), "history attach");
    }

    /// The readings of a step, one call each; how many scalar measurements each call took.
    std::vector<int> update(const Step &step)
    {
        std::vector<int> taken;
        for (const Reading &reading : step.readings) {
            read(reading);
            taken.push_back(Api::taken(filter_.get()));
        }
        return taken;
    }

    void predict(const Step &step)
    {
        kq::require(Api::predict(filter_.get(), processes_[step.process].get(), nullptr),
                    "predict");
    }

    Belief<double> belief()
    {
        kq::require(Api::covariance(filter_.get(), square_.data()), "covariance");
        Belief<double> result{Vector<double>(n_), unflattened(square_, n_)};
        for (int i = 0; i < n_; ++i) {
            result.mean(i) = static_cast<double>(Api::mean(filter_.get(), i)) +
                             static_cast<double>(Api::meanLow(filter_.get(), i));
        }
        return result;
    }

    /// The standard deviations as the library reports them.
    Vector<double> sigma() const
    {
        Vector<double> result(n_);
        for (int i = 0; i < n_; ++i) {
            result(i) = static_cast<double>(Api::sigma(filter_.get(), i));
        }
        return result;
    }

    unsigned events() const { return Api::events(filter_.get()); }

    /// The recorded run backwards.  Of the extras, the lag-one covariance only.
    std::vector<Smoothed<double>> smooth()
    {
        const std::size_t steps = Api::historySteps(history_->get());
        std::vector<Smoothed<double>> past(steps);
        std::vector<T> lag(square_.size());
        typename Api::Extras extras{lag.data(), nullptr, nullptr};
        for (std::size_t t = steps; t-- > 0;) {
            kq::require(Api::smoothStep(history_->get(), nullptr, &extras), "smooth step");
            past[t].belief = smoothedBelief(t);
            if (t + 1 < steps) {
                past[t].lagOne = unflattened(lag, n_);
            }
        }
        return past;
    }

  private:
    /// One sensor object for all of them, initialised anew at every reading.
    void read(const Reading &reading)
    {
        const SensorModel &model = sequence_.sensors[reading.sensor];
        const int m = static_cast<int>(model.components());
        kq::require(Api::sensorAssign(&sensor_, n_, m, sensorMemory_.data(), sensorMemory_.size()),
                    "sensor assign");
        const std::vector<T> variances = flattened<T>(model.R.diagonal());
        kq::require(
            Api::sensorInitDiagonal(&sensor_, rows_[reading.sensor].data(), variances.data()),
            "sensor init");
        const std::vector<T> z = flattened<T>(reading.z);
        kq::require(Api::updateSubset(filter_.get(), &sensor_, z.data(), reading.present),
                    "update");
    }

    Belief<double> smoothedBelief(std::size_t t)
    {
        const auto *history = history_->get();
        kq::require(Api::smoothedCovariance(history, t, square_.data()), "smoothed covariance");
        Belief<double> result{Vector<double>(n_), unflattened(square_, n_)};
        for (int i = 0; i < n_; ++i) {
            result.mean(i) = static_cast<double>(Api::smoothedMean(history, t, i)) +
                             static_cast<double>(Api::smoothedMeanLow(history, t, i));
        }
        return result;
    }

    const Sequence &sequence_;
    int n_;
    kq::FilterOwner<T> filter_;
    std::vector<T> square_, sensorMemory_;
    std::deque<kq::ProcessOwner<T>> processes_;
    std::vector<std::vector<T>> rows_;
    typename Api::Sensor sensor_{};
    std::unique_ptr<kq::HistoryOwner<T>> history_;
};

} // namespace reference

#endif
