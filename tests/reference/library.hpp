// The library's side of a sequence: its processes and sensors, built from the same numbers as the
// reference's, and what is read back.  After each call the objects' checks are asked: none may find anything.
#ifndef KALMANQ_TESTS_REFERENCE_LIBRARY_HPP
#define KALMANQ_TESTS_REFERENCE_LIBRARY_HPP

#include <algorithm>
#include <cstddef>
#include <deque>
#include <vector>

#include "api.hpp"
#include "formats.hpp"
#include "library_run.hpp"
#include "owners.hpp"
#include "textbook.hpp"

namespace reference
{

inline bool isFloat(const Matrix<double> &M) { return M == M.cast<float>().cast<double>(); }

/// Whether models that differ in A alone share one process, which is changed before each use.
enum class Processes { separate, shared };

/// The processes and sensors of a sequence, which must outlive it.  Models that differ in H alone
/// share a sensor, which is changed before each use.  Each way to give a noise has its turn: Q or
/// its factor, R in full or, where it is diagonal, its diagonal; or lean sensors throughout.
template <class T> class Library
{
  public:
    using Api = kq::Api<T>;

    explicit Library(const Sequence &sequence, Processes sharing = Processes::separate, bool isLean = false)
        : sequence_(sequence), states_(sequence.states(), sequence.range), isLean_(isLean)
    {
        for (std::size_t k = 0; k < sequence.processes.size(); ++k) addProcess(k, sharing);
        for (std::size_t k = 0; k < sequence.sensors.size(); ++k) addSensor(k);
    }

    typename Api::Process *process(std::size_t index)
    {
        ProcessOwner<T> &owner = processes_[processOf_[index]];
        std::size_t &now = transitionNow_[processOf_[index]];
        if (now != index) owner.changeTransition(sequence_.processes[index].A);
        now = index;
        return owner.get();
    }

    typename Api::Sensor *sensor(std::size_t index)
    {
        SensorOwner<T> &owner = sensors_[sensorOf_[index]];
        std::size_t &now = measurementNow_[sensorOf_[index]];
        if (now != index) owner.changeMeasurement(sequence_.sensors[index].H);
        now = index;
        return owner.get();
    }

    const Formats<T> &states() const { return states_; }
    const Formats<T> &components(std::size_t sensor) const
    {
        return sensors_[sensorOf_[sensor]].components();
    }
    const Formats<T> &controls(std::size_t process) const
    {
        return processes_[processOf_[process]].controls();
    }

    void init(FilterOwner<T> &filter) const
    {
        kq::require(filter.init(sequence_.x0, sequence_.P0), "filter init");
    }

    void update(typename Api::Filter *filter, const Reading &reading)
    {
        auto *sensor = this->sensor(reading.sensor);
        const auto z = components(reading.sensor).words(reading.z);
        const auto status = reading.present == UINT32_MAX
                                ? Api::update(filter, sensor, z.data())
                                : Api::update_subset(filter, sensor, z.data(), reading.present);
        kq::require(status, "update");
        kq::require(Api::sensor_check(sensor), "sensor check");
        kq::require(Api::filter_check(filter), "filter check");
    }

    void predict(typename Api::Filter *filter, const Step &step)
    {
        auto *process = this->process(step.process);
        const auto u = controls(step.process).words(step.u);
        kq::require(Api::predict(filter, process, dataOrNull(u)), "predict");
        kq::require(Api::process_check(process), "process check");
        kq::require(Api::filter_check(filter), "filter check");
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
        const bool asFactor = !isFloat(Q) || states_.count() % 2 == 0;
        processOf_.push_back(processes_.size());
        transitionNow_.push_back(k);
        processes_.emplace_back(states_, model, asFactor ? Noise::factor : Noise::covariance);
    }

    void addSensor(std::size_t k)
    {
        const SensorModel &model = sequence_.sensors[k];
        for (std::size_t other = 0; other < k; ++other) {
            const SensorModel &known = sequence_.sensors[other];
            if (known.R.rows() == model.R.rows() && known.R == model.R) {
                sensorOf_.push_back(sensorOf_[other]);
                return;
            }
        }
        const bool asDiagonal = model.diagonal() && states_.count() % 3 != 0;
        sensorOf_.push_back(sensors_.size());
        measurementNow_.push_back(k);
        const Noise kind = isLean_ ? Noise::lean : asDiagonal ? Noise::diagonal : Noise::covariance;
        sensors_.emplace_back(states_, model, kind);
    }

    const Sequence &sequence_;
    Formats<T> states_;
    bool isLean_;
    std::deque<ProcessOwner<T>> processes_;
    std::deque<SensorOwner<T>> sensors_;
    std::vector<std::size_t> processOf_, sensorOf_;           // owner of each model
    std::vector<std::size_t> transitionNow_, measurementNow_; // model that an owner holds
};

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
