// The library's side of a sequence: its processes and sensors, built from the same numbers as the
// reference's, and what is read back.
#ifndef KALMANQ_TESTS_REFERENCE_LIBRARY_HPP
#define KALMANQ_TESTS_REFERENCE_LIBRARY_HPP

#include <algorithm>
#include <cstddef>
#include <deque>
#include <vector>

#include "api.hpp"
#include "library_run.hpp"
#include "textbook.hpp"

namespace reference
{

template <class T>
Matrix<double> unflattened(const std::vector<T> &values, Eigen::Index rows, Eigen::Index columns)
{
    Matrix<double> M(rows, columns);
    for (Eigen::Index i = 0; i < rows * columns; ++i) {
        M(i / columns, i % columns) = static_cast<double>(values[static_cast<std::size_t>(i)]);
    }
    return M;
}

inline bool isFloat(const Matrix<double> &M) { return M == M.cast<float>().cast<double>(); }

/// Whether models that differ in A alone share one process, which is changed before each use.
enum class Processes { separate, shared };

/// The processes and sensors of a sequence, which must outlive it.  Models that differ in H alone
/// share a sensor, which is changed before each use.  Each way to give a noise has its turn: Q or
/// its factor, R in full or, where it is diagonal, its diagonal.
template <class T> class Library
{
  public:
    using Api = kq::Api<T>;

    explicit Library(const Sequence &sequence, Processes sharing = Processes::separate)
        : sequence_(sequence), n_(static_cast<int>(sequence.states()))
    {
        for (std::size_t k = 0; k < sequence.processes.size(); ++k) addProcess(k, sharing);
        for (std::size_t k = 0; k < sequence.sensors.size(); ++k) addSensor(k);
    }

    typename Api::Process *process(std::size_t index)
    {
        kq::ProcessOwner<T> &owner = processes_[processOf_[index]];
        std::size_t &now = transitionNow_[processOf_[index]];
        if (now != index) owner.changeTransition(flattened<T>(sequence_.processes[index].A));
        now = index;
        return owner.get();
    }

    typename Api::Sensor *sensor(std::size_t index)
    {
        kq::SensorOwner<T> &owner = sensors_[sensorOf_[index]];
        std::size_t &now = measurementNow_[sensorOf_[index]];
        if (now != index) owner.changeMeasurement(flattened<T>(sequence_.sensors[index].H));
        now = index;
        return owner.get();
    }

    kq::FilterOwner<T> filter() const
    {
        return kq::FilterOwner<T>(n_, flattened<T>(sequence_.x0), flattened<T>(sequence_.P0));
    }

    void update(typename Api::Filter *filter, const Reading &reading)
    {
        const auto *sensor = this->sensor(reading.sensor);
        const std::vector<T> z = flattened<T>(reading.z);
        const auto status = reading.present == UINT32_MAX
                                ? Api::update(filter, sensor, z.data())
                                : Api::updateSubset(filter, sensor, z.data(), reading.present);
        kq::require(status, "update");
    }

    void predict(typename Api::Filter *filter, const Step &step)
    {
        const std::vector<T> u = flattened<T>(step.u);
        kq::require(Api::predict(filter, process(step.process), kq::dataOrNull(u)), "predict");
    }

  private:
    void addProcess(std::size_t k, Processes sharing)
    {
        const ProcessModel &model = sequence_.processes[k];
        for (std::size_t other = 0; sharing == Processes::shared && other < k; ++other) {
            const ProcessModel &known = sequence_.processes[other];
            if (known.F == model.F && known.B == model.B) {
                processOf_.push_back(processOf_[other]);
                return;
            }
        }
        const Matrix<double> Q = model.F * model.F.transpose();
        const bool asFactor = !isFloat(Q) || n_ % 2 == 0;
        processOf_.push_back(processes_.size());
        transitionNow_.push_back(k);
        processes_.emplace_back(n_, static_cast<int>(model.B.cols()), flattened<T>(model.A),
                                flattened<T>(model.B), flattened<T>(asFactor ? model.F : Q),
                                asFactor ? kq::Noise::factor : kq::Noise::covariance);
    }

    void addSensor(std::size_t k)
    {
        const SensorModel &model = sequence_.sensors[k];
        for (std::size_t other = 0; other < k; ++other) {
            const Matrix<double> &R = sequence_.sensors[other].R;
            if (R.rows() == model.R.rows() && R == model.R) {
                sensorOf_.push_back(sensorOf_[other]);
                return;
            }
        }
        const bool asDiagonal = model.diagonal() && n_ % 3 != 0;
        sensorOf_.push_back(sensors_.size());
        measurementNow_.push_back(k);
        sensors_.emplace_back(
            n_, static_cast<int>(model.H.rows()), flattened<T>(model.H),
            flattened<T>(asDiagonal ? Matrix<double>(model.R.diagonal()) : model.R),
            asDiagonal ? kq::Noise::diagonal : kq::Noise::covariance);
    }

    const Sequence &sequence_;
    int n_;
    std::deque<kq::ProcessOwner<T>> processes_;
    std::deque<kq::SensorOwner<T>> sensors_;
    std::vector<std::size_t> processOf_, sensorOf_;           // owner of each model
    std::vector<std::size_t> transitionNow_, measurementNow_; // model that an owner holds
};

/// Mean (the whole word) and covariance of a filter.
template <class T> Belief<double> read(const typename kq::Api<T>::Filter *filter, Eigen::Index n)
{
    Belief<double> belief{Vector<double>(n), Matrix<double>(n, n)};
    for (int i = 0; i < n; ++i) {
        belief.mean(i) = static_cast<double>(kq::Api<T>::mean(filter, i)) +
                         static_cast<double>(kq::Api<T>::meanLow(filter, i));
    }
    std::vector<T> P(static_cast<std::size_t>(n * n));
    kq::require(kq::Api<T>::covariance(filter, P.data()), "covariance");
    belief.covariance = unflattened(P, n);
    return belief;
}

/// The most scalar measurements of one step.
inline int depth(const Sequence &sequence)
{
    std::size_t most = 0;
    for (const Step &step : sequence.steps) {
        std::size_t count = 0;
        for (const Reading &reading : step.readings) count += presentComponents(reading).size();
        most = std::max(most, count);
    }
    return static_cast<int>(most);
}

/// Changes of process from one predict to the next.
inline std::size_t changes(const Sequence &sequence)
{
    std::size_t count = 0;
    for (std::size_t t = 0; t + 2 < sequence.steps.size(); ++t) {
        count += sequence.steps[t].process != sequence.steps[t + 1].process;
    }
    return count;
}

} // namespace reference

#endif
