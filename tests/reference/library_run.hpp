// A sequence run through the library in arithmetic T, read back in a type that holds it exactly.
//
//     LibraryRun<float> run(sequence);
//     run.record();                              only if it is to be smoothed
//     for (const Step &step : sequence.steps) {
//         run.update(step);                      run.belief() is the filtered one here
//         run.predict(step);
//     }
//     std::vector<Smoothed<double>> past = run.smooth();
//
//     Estimates<double> all = estimates<float>(sequence);        all of that at once
#ifndef KALMANQ_TESTS_REFERENCE_LIBRARY_RUN_HPP
#define KALMANQ_TESTS_REFERENCE_LIBRARY_RUN_HPP

#include <algorithm>
#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "api.hpp"
#include "formats.hpp"
#include "owners.hpp"
#include "readings.hpp"
#include "textbook.hpp"

namespace reference
{

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

template <class T> class LibraryRun
{
    using Api = kq::Api<T>;

  public:
    explicit LibraryRun(const Sequence &sequence)
        : sequence_(sequence), states_(sequence.states(), sequence.range), filter_(states_)
    {
        kq::require(filter_.init(sequence.x0, sequence.P0), "filter init");
        for (const ProcessModel &process : sequence.processes) {
            processes_.emplace_back(states_, process, Noise::factor);
        }
        for (const SensorModel &sensor : sequence.sensors) {
            sensors_.emplace_back(states_, sensor, Noise::diagonal);
        }
    }

    /// From here on, for smooth().
    void record()
    {
        const std::size_t steps = sequence_.steps.size();
        history_ = std::make_unique<HistoryOwner<T>>(states_, depth(sequence_), steps, steps);
        kq::require(Api::attach(filter_.get(), &history_->get()->attached), "history attach");
    }

    /// The readings of a step, one call each; how many scalar measurements each call took.
    std::vector<int> update(const Step &step)
    {
        std::vector<int> taken;
        for (const Reading &reading : step.readings) {
            SensorOwner<T> &sensor = sensors_[reading.sensor];
            const auto z = sensor.components().words(reading.z);
            kq::require(Api::update_subset(filter_.get(), sensor.get(), z.data(), reading.present),
                        "update");
            taken.push_back(Api::taken(filter_.get()));
        }
        return taken;
    }

    void predict(const Step &step)
    {
        kq::require(Api::predict(filter_.get(), processes_[step.process].get(), nullptr),
                    "predict");
    }

    Belief<Wide<T>> belief() const { return read(filter_); }
    Vector<Wide<T>> sigma() const { return readSigma(filter_); }
    unsigned events() const { return Api::events(filter_.get()); }

    /// The recorded run backwards.
    std::vector<Smoothed<Wide<T>>> smooth()
    {
        std::vector<Smoothed<Wide<T>>> past(Api::history_steps(history_->get()));
        for (std::size_t t = past.size(); t-- > 0;) {
            past[t] = smoothStep<T>(*history_, nullptr, t);
        }
        return past;
    }

  private:
    const Sequence &sequence_;
    Formats<T> states_;
    FilterOwner<T> filter_;
    std::deque<ProcessOwner<T>> processes_;
    std::deque<SensorOwner<T>> sensors_;
    std::unique_ptr<HistoryOwner<T>> history_;
};

/// What the library says of a sequence: at each step filtered, how many scalar measurements each reading gave, and
/// smoothed; the events are of the filter.
template <class Real> struct Estimates {
    std::vector<Belief<Real>> filtered;
    std::vector<std::vector<int>> taken;
    std::vector<Smoothed<Real>> past;
    unsigned events = 0;
};

template <class T> Estimates<Wide<T>> estimates(const Sequence &sequence)
{
    Estimates<Wide<T>> result;
    LibraryRun<T> run(sequence);
    run.record();
    for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
        result.taken.push_back(run.update(sequence.steps[t]));
        result.filtered.push_back(run.belief());
        if (t + 1 < sequence.steps.size()) run.predict(sequence.steps[t]);
    }
    result.events = run.events();
    result.past = run.smooth();
    return result;
}

} // namespace reference

#endif
