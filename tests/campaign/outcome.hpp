// What an arithmetic made of a model, step by step, in the terms of exact.hpp.
#ifndef KALMANQ_TESTS_CAMPAIGN_OUTCOME_HPP
#define KALMANQ_TESTS_CAMPAIGN_OUTCOME_HPP

#include <algorithm>
#include <cstddef>
#include <exception>
#include <string>
#include <vector>

#include "../reference/on_line.hpp"
#include "../reference/readings.hpp"
#include "../reference/smoother_checks.hpp"
#include "../reference/ud.hpp"
#include "held.hpp"

namespace campaign
{

struct Outcome {
    Exact instants;
    std::vector<unsigned> events; // of each step: its updates, and the predict that led to it
    unsigned smootherEvents = 0;
    unsigned onLineEvents = 0; // of the smoothers that show means alone or work on line, and of the filters that they follow
    double indefinite = 0; // smoothed P, over what rounding makes of it where it is handed over
    std::string refused; // the call that answered an error, with its status
};

template <class Wide> Belief toBelief(const reference::Belief<Wide> &from)
{
    return {from.mean.template cast<Real>(), from.covariance.template cast<Real>()};
}

/// All that the sensors of a sequence measure
inline int componentsOf(const Sequence &sequence)
{
    Index count = 0;
    for (const reference::SensorModel &sensor : sequence.sensors) count += sensor.components();
    return static_cast<int>(count);
}

/// A filter with a tape, and the objects that it takes.
template <class T> class Campaigner
{
    using Api = kq::Api<T>;

  public:
    Campaigner(const Sequence &sequence, reference::Library<T> &library)
        : sequence_(sequence), library_(library), components_(componentsOf(sequence)), filter_(library.states()),
          history_(library.states(), components_, sequence.steps.size(), 1)
    {
    }

    Outcome run()
    {
        Outcome outcome;
        try {
            library_.init(filter_);
            kq::require(Api::attach(filter_.get(), &history_.get()->attached), "history attach");
            for (const Step &step : sequence_.steps) filter(outcome, step);
            smooth(outcome);
            smoothAlone(outcome);
            smoothOnLine(outcome);
        } catch (const std::exception &error) {
            outcome.refused = error.what();
        }
        return outcome;
    }

  private:
    void filter(Outcome &outcome, const Step &step)
    {
        Instant now{};
        for (const Reading &reading : step.readings) {
            library_.update(filter_.get(), reading);
            Update update;
            update.taken = Api::taken(filter_.get());
            update.nis = reference::Formats<T>::score(Api::nis(filter_.get()));
            update.logLikelihood =
                reference::Formats<T>::score(Api::log_likelihood_last(filter_.get()));
            now.updates.push_back(update);
        }
        now.filtered = toBelief(reference::read(filter_));
        outcome.events.push_back(takeEvents());
        outcome.instants.push_back(now);
        if (outcome.instants.size() == sequence_.steps.size()) return;
        library_.predict(filter_.get(), step);
        pending_ = takeEvents();
    }

    unsigned takeEvents()
    {
        const unsigned events = Api::events(filter_.get()) | pending_;
        pending_ = 0;
        Api::events_clear(filter_.get());
        return events;
    }

    void smooth(Outcome &outcome)
    {
        for (std::size_t t = outcome.instants.size(); t-- > 0;) {
            const auto now = reference::smoothStep<T>(history_, nullptr, t);
            Instant &instant = outcome.instants[t];
            instant.smoothed = toBelief(now.belief);
            outcome.indefinite = std::max(outcome.indefinite, reference::indefinite<T>(now.belief));
            if (t + 1 == outcome.instants.size()) continue;
            instant.lagOne = now.lagOne.template cast<Real>();
        }
        typename Api::Filter view;
        (void)Api::smoothed(history_.get(), 0, &view);
        outcome.smootherEvents = Api::events(filter_.get()) | Api::events(&view);
    }

    void update(const Step &step)
    {
        for (const Reading &reading : step.readings) library_.update(filter_.get(), reading);
    }

    /// The run once more, for what is attached to the filter behind its first updates.
    template <class Attach> void follow(const Attach &attach)
    {
        library_.init(filter_);
        update(sequence_.steps[0]);
        attach();
        for (std::size_t t = 1; t < sequence_.steps.size(); ++t) {
            library_.predict(filter_.get(), sequence_.steps[t - 1]);
            update(sequence_.steps[t]);
        }
    }

    void tell(Outcome &outcome, std::size_t t, int smoother, const Vector<reference::Wide<T>> &mean)
    {
        outcome.instants[t].alone[static_cast<std::size_t>(smoother)] = mean.template cast<Real>();
        outcome.instants[t].told |= 1u << smoother;
    }

    void smoothAlone(Outcome &outcome)
    {
        follow([this] { kq::require(Api::attach(filter_.get(), &history_.get()->attached), "history attach"); });
        kq::require(Api::smooth_states(history_.get()), "smooth states");
        for (std::size_t t = 0; t < outcome.instants.size(); ++t) tell(outcome, t, 0, reference::readSmoothedMean(history_, t));
        typename Api::Filter view;
        (void)Api::smoothed(history_.get(), 0, &view);
        outcome.onLineEvents |= Api::events(&view);
    }

    /// At the end of the run, where they know what the textbook does: the last steps, and the first one
    void smoothOnLine(Outcome &outcome)
    {
        constexpr int lags = 6;
        reference::LagOwner<T> lag(library_.states(), components_, lags);
        reference::InstantOwner<T> point(library_.states(), components_);
        follow([&] { lag.attach(filter_); });
        const std::size_t last = outcome.instants.size() - 1;
        for (int k = 0; k <= lags; ++k) tell(outcome, last - static_cast<std::size_t>(k), 1, lag.smooth(k).mean);
        outcome.onLineEvents |= Api::events(filter_.get()) & ~static_cast<unsigned>(KQ_EVENT_REDUNDANT);
        follow([&] { point.attach(filter_); });
        tell(outcome, 0, 2, point.smooth().mean);
        outcome.onLineEvents |= Api::events(filter_.get()) & ~static_cast<unsigned>(KQ_EVENT_REDUNDANT);
    }

    const Sequence &sequence_;
    reference::Library<T> &library_;
    const int components_;
    reference::FilterOwner<T> filter_;
    reference::HistoryOwner<T> history_;
    unsigned pending_ = 0;
};

// ------------------------------------------------------------------ the float UD filter

inline void updateUd(reference::UdFilter &filter, const reference::SensorModel &sensor,
                     const Reading &reading)
{
    const std::vector<Index> chosen = reference::presentComponents(reading);
    if (chosen.empty()) return;
    const Matrix<double> H = sensor.H.chooseRows(chosen), R = sensor.R.choose(chosen, chosen);
    const Vector<double> z = reading.z.chooseRows(chosen);
    const reference::Decorrelation<float> noise(R.cast<float>());
    const Matrix<float> rows = noise.inverse * H.cast<float>();
    const Vector<float> parts = noise.inverse * z.cast<float>();
    for (Index c = 0; c < parts.size(); ++c) {
        filter.update(rows.row(c).transpose(), noise.variances(c), parts(c));
    }
}

/// Filtered states only.
inline Outcome runUd(const Model &model)
{
    const Sequence &sequence = model.sequence;
    const reference::ProcessModel &process = sequence.processes[0];
    const Index n = sequence.states();
    const Matrix<float> identity = Matrix<float>::Identity(n, n);
    reference::UdFilter filter(sequence.x0.cast<float>(), Vector<float>::Zero(n));
    filter.predict(identity, model.F.cast<float>()); // P0 = F F'
    Outcome outcome;
    for (const Step &step : sequence.steps) {
        for (const Reading &reading : step.readings) {
            updateUd(filter, sequence.sensors[reading.sensor], reading);
        }
        Instant now{};
        now.filtered = toBelief<double>({filter.mean(), filter.covariance()});
        outcome.instants.push_back(now);
        outcome.events.push_back(0);
        filter.predict(process.A.cast<float>(), process.F.cast<float>());
        if (step.u.size() > 0) filter.drive(process.B.cast<float>() * step.u.cast<float>());
    }
    return outcome;
}

} // namespace campaign

#endif
