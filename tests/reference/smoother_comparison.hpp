// The smoother against the textbook formulas in quadruple precision.  The reference has to stand singular predicted
// covariances, so it is that of Bryson and Frazier; it is itself compared with Rauch, Tung and Striebel, and with one
// dense least-squares solve.
//
// Units: an error of the mean counts in sigma of the smoothed state at that time, of a covariance in sigma_i sigma_j, of
// the process noise in sqrt(Q_ii), of the measurement noise, which is standardised, in 1.
#ifndef KALMANQ_TESTS_REFERENCE_SMOOTHER_COMPARISON_HPP
#define KALMANQ_TESTS_REFERENCE_SMOOTHER_COMPARISON_HPP

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "comparison.hpp"
#include "library.hpp"
#include "smoother_checks.hpp"
#include "ud.hpp"

namespace reference
{

/// A covariance that is handed over and what says yes or no have limits of their own.
inline const Claims smootherClaims = {
    {"x", "x alone", "x alone - x", "w", "v"},
    {"P", "lag one", "cov w", "var v"},
    {},
    {{"above filter", 8}, {"not PSD", 1}, {"last step", 0}, {"one by one", 0}, {"count of v", 0}}};

/// A sequence, and what is right for it.
struct Case : Study {
    std::vector<Smoothed<Quad>> past;

    explicit Case(const Sequence &data) : Study(data), past(smoothWithoutInverse(data, track)) {}

    double refinement(double floor) const
    {
        double worst = 1;
        for (std::size_t t = 0; t < past.size(); ++t) refine(worst, *this, t, past[t].belief.covariance, floor);
        return worst;
    }
};

/// sqrt(Q_ii); a state without noise has to have none beside its own sigma.
inline Vector<Quad> noiseUnits(const Case &model, std::size_t t)
{
    const Matrix<Quad> F =
        convert<Quad>(model.sequence.processes[model.sequence.steps[t].process].F);
    return sigmas(Matrix<Quad>(F * F.transpose())).cwiseMax(Quad(1e-6) * model.largest);
}

/// All that is known of step t, beside the reference.
template <class Real>
void compareStep(Figures &figures, const Case &model, std::size_t t, const Smoothed<Real> &now,
                 double floor)
{
    const Smoothed<Quad> &exact = model.past[t];
    const Vector<Quad> unit = units(model, exact.belief.covariance, floor);
    figures.add("x", meanError(now.belief.mean, exact.belief.mean, unit));
    figures.add("P", covarianceError(now.belief.covariance, exact.belief.covariance, unit));
    if (t + 1 == model.past.size()) return;
    const Vector<Quad> later = units(model, model.past[t + 1].belief.covariance, floor);
    const Vector<Quad> noise = noiseUnits(model, t);
    figures.add("lag one", covarianceError(now.lagOne, exact.lagOne, later, unit));
    figures.add("w", meanError(now.noiseMean, exact.noiseMean, noise));
    figures.add("cov w", covarianceError(now.noiseCovariance, exact.noiseCovariance, noise));
}

// ------------------------------------------------------------------ measurement noise

/// What the library says of the k-th measurement of the step that was smoothed last.
template <class T>
void compareMeasurementNoise(Figures &figures, const Case &model, std::size_t t,
                             const HistoryOwner<T> &history)
{
    using Api = kq::Api<T>;
    const Model<Quad> matrices(model.sequence);
    const Belief<Quad> &exact = model.past[t].belief;
    int k = 0;
    for (const Reading &reading : model.sequence.steps[t].readings) {
        const Observation<Quad> seen(matrices, reading);
        const Decorrelation<Quad> noise(seen.R);
        const Matrix<Quad> H = noise.inverse * seen.H;
        const Vector<Quad> v = noise.inverse * seen.z - H * exact.mean;
        const Matrix<Quad> variance = H * exact.covariance * H.transpose();
        for (Index c = 0; c < v.size(); ++c, ++k) {
            typename Api::Coefficient mean{}, square{};
            kq::require(Api::smoothed_measurement_noise(history.get(), k, &mean, &square),
                        "smoothed measurement noise");
            if (noise.variances(c) == 0) continue;
            const Quad root = sqrt(noise.variances(c));
            const Quad noiseMean(Formats<T>::number(mean));
            const Quad noiseSquare(Formats<T>::number(square));
            figures.add("v", ratio(noiseMean - v(c) / root, 1));
            figures.add("var v", ratio(noiseSquare - variance(c, c) / noise.variances(c), 1));
        }
    }
    typename Api::Coefficient mean, square;
    const bool over =
        Api::smoothed_measurement_noise(history.get(), k, &mean, &square) == KQ_ERR_SIZE;
    figures.add("count of v", over ? 0 : 1);
}

// ------------------------------------------------------------------ one sequence

/// A recorded run of the library, not smoothed yet.
template <class T> struct Recording {
    Library<T> library;
    FilterOwner<T> filter;
    HistoryOwner<T> history;
    std::vector<Belief<Wide<T>>> filtered;

    /// The history has exactly the room that its length constant promises to be enough.
    Recording(const Sequence &sequence, Processes sharing)
        : library(sequence, sharing), filter(library.states()),
          history(library.states(), depth(sequence), sequence.steps.size(),
                  sharing == Processes::shared ? 0 : changes(sequence))
    {
        library.init(filter);
        kq::require(kq::Api<T>::attach(filter.get(), &history.get()->attached), "history attach");
        for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
            const Step &step = sequence.steps[t];
            for (const Reading &reading : step.readings) library.update(filter.get(), reading);
            filtered.push_back(read(filter));
            if (t + 1 < sequence.steps.size()) library.predict(filter.get(), step);
        }
    }
};

/// The whole history at once.
template <class T> std::vector<Belief<Wide<T>>> smoothAll(Figures &figures, const Case &model)
{
    Recording<T> recording(model.sequence, Processes::separate);
    kq::require(kq::Api<T>::smooth(recording.history.get()), "smooth");
    std::vector<Belief<Wide<T>>> beliefs;
    for (std::size_t t = 0; t < model.past.size(); ++t) {
        beliefs.push_back(readSmoothed(recording.history, t));
        figures.add("above filter", aboveFilter<T>(recording.filtered[t], beliefs[t]));
        figures.add("not PSD", indefinite<T>(beliefs[t]));
    }
    figures.add("last step", difference(beliefs.back(), recording.filtered.back()));
    return beliefs;
}

/// Step by step, with everything that a step can give; a process that has changed is passed in.
template <class T>
void smoothInSteps(Figures &figures, const Case &model, const std::vector<Belief<Wide<T>>> &beliefs)
{
    const Sequence &sequence = model.sequence;
    Recording<T> recording(sequence, Processes::shared);
    for (std::size_t t = sequence.steps.size(); t-- > 0;) {
        const bool changed = sequence.processes.size() > 1;
        const auto *process =
            changed ? recording.library.process(sequence.steps[t].process) : nullptr;
        const Smoothed<Wide<T>> now = smoothStep(recording.history, process, t);
        figures.add("one by one", difference(now.belief, beliefs[t]));
        compareStep(figures, model, t, now, floorOf<T>());
        compareMeasurementNoise(figures, model, t, recording.history);
    }
}

/// The means alone, beside those of the full pass and the reference.
template <class T>
void smoothStates(Figures &figures, const Case &model, const std::vector<Belief<Wide<T>>> &beliefs)
{
    Recording<T> recording(model.sequence, Processes::separate);
    kq::require(kq::Api<T>::smooth_states(recording.history.get()), "smooth states");
    for (std::size_t t = 0; t < model.past.size(); ++t) {
        const Belief<Quad> &exact = model.past[t].belief;
        const Vector<Quad> unit = units(model, exact.covariance, floorOf<T>());
        const Vector<Wide<T>> now = readSmoothedMean(recording.history, t);
        const Vector<Quad> other = beliefs[t].mean.template cast<Quad>();
        figures.add("x alone", meanError(now, exact.mean, unit));
        figures.add("x alone - x", meanError(now, other, unit));
    }
}

template <class T> Figures smootherFigures(const Case &model)
{
    Figures figures;
    const std::vector<Belief<Wide<T>>> beliefs = smoothAll<T>(figures, model);
    smoothInSteps<T>(figures, model, beliefs);
    smoothStates<T>(figures, model, beliefs);
    return figures;
}

// ------------------------------------------------------------------ the reference itself

/// Handed over in double, a mean has an error of its own beside sigma: hence the floor.
template <class Real>
Figures compareReference(const Case &model, const std::vector<Smoothed<Real>> &past)
{
    Figures figures;
    for (std::size_t t = 0; t < past.size(); ++t) {
        const Smoothed<Real> &now = past[t];
        compareStep<double>(figures, model, t,
                            {{now.belief.mean.template cast<double>(),
                              now.belief.covariance.template cast<double>()},
                             now.lagOne.template cast<double>(),
                             now.noiseMean.template cast<double>(),
                             now.noiseCovariance.template cast<double>()},
                            floorOf<float>());
    }
    return figures;
}

/// The gain of Rauch, Tung and Striebel needs the inverse of P-: a tolerance decides on its rank,
/// and only where nothing is near that tolerance the result is a reference.
inline void compareGain(Report &report, const std::string &group, const Case &model)
{
    double condition = 1;
    for (const Track<Quad> &now : model.track) {
        condition = std::max(condition, conditionOf(now.predicted.covariance));
    }
    const bool regular = condition <= conditionLimit;
    const std::string title = "RTS, " + group + (regular ? "" : ", P- nearly singular");
    const Quad tolerance(1e-17);
    report.add(title, model.sequence.name,
               compareReference(model, smooth(model.sequence, model.track, tolerance)),
               regular ? boundsOf(smootherClaims, {1e-10, 1e-13}) : Bounds{});
}

} // namespace reference

#endif
