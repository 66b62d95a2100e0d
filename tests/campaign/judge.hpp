// The errors of an outcome in units of the exact result, what the documented accuracy allows, and
// what of it nobody was told.
#ifndef KALMANQ_TESTS_CAMPAIGN_JUDGE_HPP
#define KALMANQ_TESTS_CAMPAIGN_JUDGE_HPP

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "allowance.hpp"
#include "outcome.hpp"

namespace campaign
{

enum Quantity {
    filterMean,
    filterCovariance,
    score,
    smootherMean,
    smootherCovariance,
    lagOneCovariance,
    means, // of the other smoothers: states alone, lag, instant
    smoothers = 3,
    quantities = means + smoothers
};

inline const char *nameOf(Quantity quantity)
{
    static const char *const names[] = {"filter x",   "filter P",   "likelihood",
                                        "smoother x", "smoother P", "lag one",
                                        "states alone", "fixed lag",  "fixed point"};
    return names[quantity];
}

using reference::covarianceError;
using reference::meanError;
using reference::ratio;

using Series = std::vector<std::array<double, quantities>>;

/// The documented roundings are drawn at random, and "a few" of them is what the library promises.
constexpr double few = 8;
/// Roundings that make that much of a sigma: the model is beyond the arithmetic at that step.
constexpr double beyond = 0.25;
/// Steps around one over which the response is taken: a random one may be small by chance.
constexpr std::size_t around = 10;

/// The units of one step: sigma, or what the arithmetic can tell where measurements without noise
/// leave nothing of it: there a few roundings of what the sigma would be without any measurement
/// are the tolerance.  Nor is a sigma less than what the least noise of the arithmetic makes of it.
class Units
{
  public:
    /// words: of q31; elsewhere any
    Units(const Accuracy &accuracy, const Inputs &inputs, const Vec &words)
        : accuracy_(accuracy),
          words_(accuracy.fixedPoint ? words : Vec::Zero(inputs.n())), least_{floor()}
    {
        open_.push_back(inputs.P0);
        for (std::size_t t = 1; t < inputs.steps.size(); ++t) {
            open_.push_back(sandwich(inputs.A(t - 1), open_.back()) + inputs.Q(t - 1));
            least_.push_back(sandwich(inputs.A(t - 1), least_.back()) + floor());
        }
    }

    /// Of a covariance of step t.
    Vec of(const Mat &P, std::size_t t) const
    {
        Vec units(P.rows());
        for (Index i = 0; i < P.rows(); ++i) {
            const Real unmeasured = sigma(open_[t], i), left = sigma(P, i);
            units(i) = std::max(left, sigma(least_[t], i));
            if (left > 0x1p-40 * unmeasured) continue;
            const Real rounding = accuracy_.rows * unmeasured + accuracy_.mean * words_(i);
            units(i) = std::max(units(i), rounding * few / accuracy_.tolerance);
        }
        return units;
    }

  private:
    Mat floor() const
    {
        const Vec least =
            accuracy_.least * (accuracy_.fixedPoint ? words_ : Vec::Ones(words_.size()));
        return least.cwiseProduct(least).asDiagonal();
    }

    const Accuracy &accuracy_;
    Vec words_;
    std::vector<Mat> open_;  // covariances if nothing were measured
    std::vector<Mat> least_; // and if nothing but the least noise moved the states
};

/// NIS and log-likelihood of one update, relative where they are large.
inline double scoreError(const Update &update, const Update &exact)
{
    if (update.taken != exact.taken) return std::numeric_limits<double>::infinity();
    const Real unit = 1 + exact.nis;
    return std::max(ratio(update.nis - exact.nis, unit),
                    ratio(update.logLikelihood - exact.logLikelihood, unit));
}

inline Series compare(const Exact &found, const Exact &exact, const Units &units, bool smoothed)
{
    Series series(exact.size());
    for (std::size_t t = 0; t < found.size(); ++t) {
        const Instant &now = found[t], &right = exact[t];
        auto &errors = series[t];
        const Vec unit = units.of(right.filtered.covariance, t);
        errors[filterMean] = meanError(now.filtered.mean, right.filtered.mean, unit);
        errors[filterCovariance] =
            covarianceError(now.filtered.covariance, right.filtered.covariance, unit);
        for (std::size_t k = 0; k < now.updates.size(); ++k) {
            errors[score] = std::max(errors[score], scoreError(now.updates[k], right.updates[k]));
        }
        if (!smoothed) continue;
        const Vec past = units.of(right.smoothed.covariance, t);
        errors[smootherMean] = meanError(now.smoothed.mean, right.smoothed.mean, past);
        errors[smootherCovariance] =
            covarianceError(now.smoothed.covariance, right.smoothed.covariance, past);
        for (int k = 0; k < smoothers; ++k) {
            const Vec &mean = now.others[k].mean;
            if (mean.size() > 0) errors[means + k] = meanError(mean, right.smoothed.mean, past);
        }
        if (t + 1 == exact.size()) continue;
        const Vec later = units.of(exact[t + 1].smoothed.covariance, t + 1);
        errors[lagOneCovariance] = covarianceError(now.lagOne, right.lagOne, later, past);
    }
    return series;
}

/// The largest errors of what a view shows, the step of the largest, and its events
struct Found {
    double mean = 0, covariance = 0;
    std::size_t at = 0;
    unsigned events = 0;
    unsigned eventsOnTheWay = 0; // of the filter, at the steps whose error was the largest so far
};

/// unitOf(what is right, step)
template <class Unit> Found worstOf(const Outcome &outcome, const Exact &exact, View view, const Unit &unitOf)
{
    Found found;
    found.events = outcome.viewEvents[view];
    for (std::size_t t = 0; t < exact.size(); ++t) {
        const Belief &mine = outcome.shown(view, t), &right = view == ofFilter ? exact[t].filtered : exact[t].smoothed;
        if (mine.mean.size() == 0) continue;
        const Vec unit = unitOf(right, t);
        const double mean = meanError(mine.mean, right.mean, unit);
        const double covariance = mine.covariance.size() > 0 ? covarianceError(mine.covariance, right.covariance, unit) : 0;
        if (std::max(mean, covariance) > std::max(found.mean, found.covariance)) {
            found.at = t;
            found.eventsOnTheWay |= outcome.events[t];
        }
        found.mean = std::max(found.mean, mean);
        found.covariance = std::max(found.covariance, covariance);
    }
    return found;
}

inline double worstScore(const Outcome &outcome, const Exact &exact)
{
    double worst = 0;
    for (std::size_t t = 0; t < exact.size(); ++t) {
        const std::vector<Update> &updates = outcome.instants[t].updates;
        for (std::size_t k = 0; k < updates.size(); ++k) worst = std::max(worst, scoreError(updates[k], exact[t].updates[k]));
    }
    return worst;
}

/// The largest filtered sigma over the smoothed one, and the rounding of the mean over it.
inline void addSmoother(Series &allowed, const Exact &exact, const Units &units,
                        const Accuracy &accuracy, const Vec &words)
{
    for (std::size_t t = 0; t < exact.size(); ++t) {
        const Vec unit = units.of(exact[t].smoothed.covariance, t);
        double share = 0, mean = 0;
        for (Index i = 0; i < unit.size(); ++i) {
            const Real grain = accuracy.fixedPoint ? words(i) : abs(exact[t].smoothed.mean(i));
            share = std::max(share, ratio(sigma(exact[t].filtered.covariance, i), unit(i)));
            if (!accuracy.pair) mean = std::max(mean, ratio(accuracy.mean * grain, unit(i)));
        }
        allowed[t][smootherMean] += accuracy.smoother * share + mean;
        allowed[t][smootherCovariance] += 2 * accuracy.smoother * share;
        allowed[t][lagOneCovariance] += 2 * accuracy.smoother * share;
    }
}

/// The worst over the steps around each one.
inline Series widened(const Series &series)
{
    Series result = series;
    for (std::size_t t = 0; t < series.size(); ++t) {
        const std::size_t from = t > around ? t - around : 0;
        for (std::size_t s = from; s < std::min(series.size(), t + around + 1); ++s) {
            for (int q = 0; q < quantities; ++q) {
                result[t][q] = std::max(result[t][q], series[s][q]);
            }
        }
    }
    return result;
}

/// How far a variance moves by full roundings, in units, from its change by those drawn at `scale`.
/// Where its root moves by d it moves by 2 sigma d + d^2: the second term is all where sigma is 0.
inline double varianceResponse(Real change, Real variance, Real unit, double scale)
{
    if (variance + change <= 0) return ratio(change, unit * unit) / scale;
    const Real d = change / (sqrt(variance + change) + sqrt(variance)) / scale;
    return ratio(Real(2) * sqrt(variance) * abs(d) + d * d, unit * unit);
}

inline double varianceResponse(const Mat &found, const Mat &exact, const Vec &units, double scale)
{
    double worst = 0;
    for (Index i = 0; i < units.size(); ++i) {
        const Real variance = std::max(exact(i, i), Real(0));
        worst =
            std::max(worst, varianceResponse(found(i, i) - variance, variance, units(i), scale));
    }
    return worst;
}

inline void raise(double &value, double other) { value = std::max(value, other); }

/// A run with roundings drawn at the accuracy's scale, as what roundings of full size would make.
inline void addRun(Series &allowed, const Exact &found, const Exact &exact, const Units &units,
                   const Accuracy &accuracy)
{
    const Series series = compare(found, exact, units, true);
    for (std::size_t t = 0; t < series.size(); ++t) {
        for (int q = 0; q < quantities; ++q) raise(allowed[t][q], series[t][q] / accuracy.scale);
        const Mat &filtered = exact[t].filtered.covariance, &past = exact[t].smoothed.covariance;
        raise(allowed[t][filterCovariance],
              varianceResponse(found[t].filtered.covariance, filtered, units.of(filtered, t),
                               accuracy.scale));
        raise(allowed[t][smootherCovariance], varianceResponse(found[t].smoothed.covariance, past,
                                                               units.of(past, t), accuracy.scale));
    }
}

/// The covariance of two steps is off by no less than those of either.
inline void addLagOne(Series &allowed)
{
    for (std::size_t t = 0; t < allowed.size(); ++t) {
        const std::size_t next = std::min(t + 1, allowed.size() - 1);
        raise(allowed[t][lagOneCovariance], allowed[t][smootherCovariance]);
        raise(allowed[t][lagOneCovariance], allowed[next][smootherCovariance]);
    }
}

/// How far the documented roundings may move each result.
inline Series allowance(const Inputs &inputs, const Exact &exact, const Units &units,
                        const Accuracy &accuracy, const Vec &words)
{
    Series worst(exact.size());
    for (std::uint64_t draw = 1; draw <= 2; ++draw) {
        Documented rounding(accuracy, inputs, words, draw);
        addRun(worst, run(inputs, rounding), exact, units, accuracy);
    }
    addSmoother(worst, exact, units, accuracy, words);
    addLagOne(worst);
    for (auto &step : worst) {
        std::fill(step.begin() + means, step.end(), step[smootherMean]);
        for (double &value : step) value *= few;
    }
    return widened(worst);
}

} // namespace campaign

#endif
