// What an arithmetic made of a model, step by step, in the terms of exact.hpp.
#ifndef KALMANQ_TESTS_CAMPAIGN_OUTCOME_HPP
#define KALMANQ_TESTS_CAMPAIGN_OUTCOME_HPP

#include <algorithm>
#include <array>
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

/// The event that does not say that a result may be off
constexpr unsigned harmless = KQ_EVENT_REDUNDANT;

struct Outcome {
    Exact instants;
    std::vector<unsigned> events; // of each step: its updates, and the predict that led to it
    std::array<unsigned, views> viewEvents{};
    unsigned followedEvents = 0; // of the filters that smoothers on line have followed, but for what is redundant
    double indefinite = 0; // smoothed P, over what rounding makes of it where it is handed over
    std::string refused; // the call that answered an error, with its status

    const Belief &shown(View view, std::size_t t) const
    {
        const Instant &now = instants[t];
        return view == ofFilter ? now.filtered : view == ofHistory ? now.smoothed : now.others[view - ofMeans];
    }

    /// Of a history, its means alone, and of the filters that the others have followed
    unsigned ofSmoothers() const { return viewEvents[ofHistory] | viewEvents[ofMeans] | followedEvents; }
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

    /// A history, smoothed step by step; means alone, a lag, and an instant
    Outcome run()
    {
        return tried([this](Outcome &outcome) {
            filter(outcome);
            smoothInSteps(outcome);
            smoothMeans(outcome);
            followLag(outcome, ofLag, shortLag, false);
            followInstant(outcome);
        });
    }

    /// A history, smoothed at once; lags that hold all of the run, and an instant
    Outcome runOfAllViews()
    {
        return tried([this](Outcome &outcome) {
            filter(outcome);
            smoothAtOnce(outcome);
            const int most = static_cast<int>(sequence_.steps.size()) - 1;
            followLag(outcome, ofLag, most, true);
            followLag(outcome, ofDelay, most, true);
            followInstant(outcome);
        });
    }

  private:
    static constexpr int shortLag = 6;

    template <class Run> Outcome tried(const Run &run)
    {
        Outcome outcome;
        try {
            run(outcome);
        } catch (const std::exception &error) {
            outcome.refused = error.what();
        }
        return outcome;
    }

    void filter(Outcome &outcome)
    {
        library_.init(filter_);
        kq::require(Api::attach(filter_.get(), &history_.get()->attached), "history attach");
        for (const Step &step : sequence_.steps) filter(outcome, step);
        for (const unsigned events : outcome.events) outcome.viewEvents[ofFilter] |= events;
    }

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

    void smoothInSteps(Outcome &outcome)
    {
        for (std::size_t t = outcome.instants.size(); t-- > 0;) {
            const auto now = reference::smoothStep<T>(history_, nullptr, t);
            Instant &instant = outcome.instants[t];
            instant.smoothed = toBelief(now.belief);
            outcome.indefinite = std::max(outcome.indefinite, reference::indefinite<T>(now.belief));
            if (t + 1 == outcome.instants.size()) continue;
            instant.lagOne = now.lagOne.template cast<Real>();
        }
        const auto view = reference::viewSmoothed(history_, 0);
        outcome.viewEvents[ofHistory] = Api::events(filter_.get()) | Api::events(&view);
    }

    void smoothAtOnce(Outcome &outcome)
    {
        kq::require(Api::smooth(history_.get()), "smooth");
        for (std::size_t t = 0; t < outcome.instants.size(); ++t) {
            const auto view = reference::viewSmoothed(history_, t);
            outcome.instants[t].smoothed = toBelief(reference::readView(library_.states(), view));
            outcome.viewEvents[ofHistory] |= Api::events(&view);
        }
    }

    void update(const Step &step)
    {
        for (const Reading &reading : step.readings) library_.update(filter_.get(), reading);
    }

    /// The run once more, for what is attached to the filter before or behind its first updates.
    template <class Attach> void follow(bool isBefore, const Attach &attach)
    {
        library_.init(filter_);
        if (isBefore) attach();
        update(sequence_.steps[0]);
        if (!isBefore) attach();
        for (std::size_t t = 1; t < sequence_.steps.size(); ++t) {
            library_.predict(filter_.get(), sequence_.steps[t - 1]);
            update(sequence_.steps[t]);
        }
    }

    void smoothMeans(Outcome &outcome)
    {
        follow(false, [this] { kq::require(Api::attach(filter_.get(), &history_.get()->attached), "history attach"); });
        kq::require(Api::smooth_states(history_.get()), "smooth states");
        for (std::size_t t = 0; t < outcome.instants.size(); ++t) {
            outcome.instants[t].others[0].mean = reference::readSmoothedMean(history_, t).template cast<Real>();
        }
        const auto view = reference::viewSmoothed(history_, 0);
        outcome.viewEvents[ofMeans] = Api::events(&view);
    }

    /// What a lag holds at the end of the run, where it knows what the textbook does
    void followLag(Outcome &outcome, View kind, int length, bool isBefore)
    {
        reference::LagOwner<T> lag(library_.states(), components_, length, kind == ofDelay);
        follow(isBefore, [&] { lag.attach(filter_); });
        for (int k = 0; k <= length; ++k) {
            const auto view = lag.view(k);
            Instant &instant = outcome.instants[outcome.instants.size() - 1 - static_cast<std::size_t>(k)];
            instant.others[kind - ofMeans] = toBelief(reference::readView(library_.states(), view));
            outcome.viewEvents[kind] |= Api::events(&view);
        }
        outcome.followedEvents |= Api::events(filter_.get()) & ~harmless;
    }

    void followInstant(Outcome &outcome)
    {
        reference::InstantOwner<T> instant(library_.states(), components_);
        follow(false, [&] { instant.attach(filter_); });
        outcome.followedEvents |= Api::events(filter_.get()) & ~harmless;
        Api::events_clear(filter_.get());
        outcome.instants[0].others[ofInstant - ofMeans] = toBelief(instant.smooth());
        outcome.viewEvents[ofInstant] = Api::events(filter_.get());
        outcome.followedEvents |= outcome.viewEvents[ofInstant] & ~harmless;
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
