// Smoothers behind sensors without noise, on the models of whole.hpp.  Each step is judged against the textbook in
// __float128 (exact.hpp).
//
//     campaign_noise_free [--ordinary] [models [seed [first]]]      2000, 1, 0
//
// It counts models whose filter is right at every step and whose smoothed mean or covariance is not, with no event:
// beyond 0.05 sigma in f32, 1e-3 in q31 and 1e-6 in f64, and a few roundings of the filtered sigma.  And it counts how
// often KQ_EVENT_PRECISION of a history is told for nothing, there and, --ordinary, where every component has noise.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
#include <string>

#include "arithmetics.hpp"
#include "whole.hpp"

using namespace campaign;

namespace
{

struct Goal {
    double filter, smoother;
};

template <class T> Goal goalOf();
template <> Goal goalOf<float>() { return {0.005, 0.05}; }
template <> Goal goalOf<double>() { return {1e-7, 1e-6}; }
template <> Goal goalOf<Q31>() { return {1e-4, 1e-3}; }

/// What one arithmetic made of one model.
struct Found {
    bool filterIsRight = true, isTold = false, isToldOfPrecision = false;
    double worst = 0; // of the smoother, 1 being the goal
    std::size_t at = 0;
    bool isMean = true;
};

template <class T> Found find(const Held &held)
{
    const auto &[sequence, inputs, exact, words] = held;
    reference::Library<T> library(sequence);
    const Goal goal = goalOf<T>();
    const Accuracy accuracy = accuracyOf<T>(inputs.n());
    const Units units(accuracy, inputs, words);
    const Outcome outcome = Campaigner<T>(sequence, library).run();
    Found found;
    if (!outcome.refused.empty()) {
        found.isTold = true;
        return found;
    }
    const Series errors = compare(outcome.instants, exact, units, false);
    for (std::size_t t = 0; t < errors.size(); ++t) {
        found.filterIsRight &= errors[t][filterMean] <= goal.filter && errors[t][filterCovariance] <= goal.filter &&
                               std::isfinite(errors[t][score]);
        const Belief &mine = outcome.instants[t].smoothed, &right = exact[t].smoothed;
        Vec unit = units.of(right.covariance, t);
        for (Index i = 0; i < inputs.n(); ++i) {
            const Real rounding = accuracy.smoother * sigma(exact[t].filtered.covariance, i);
            unit(i) = std::max(unit(i), few * rounding / goal.smoother);
        }
        const double ofMean = meanError(mine.mean, right.mean, unit) / goal.smoother;
        const double ofP = covarianceError(mine.covariance, right.covariance, unit) / goal.smoother;
        if (std::max(ofMean, ofP) <= found.worst) continue;
        found.worst = std::max(ofMean, ofP);
        found.at = t;
        found.isMean = ofMean > ofP;
        found.isTold |= (outcome.events[t] & ~static_cast<unsigned>(KQ_EVENT_REDUNDANT)) != 0;
    }
    found.isToldOfPrecision = outcome.smootherEvents & KQ_EVENT_PRECISION;
    found.isTold |= outcome.smootherEvents != 0;
    return found;
}

struct Tally {
    std::map<std::string, int> counts;
};

template <class T> void judge(Tally &tally, const std::string &id, const Held &held)
{
    const std::string name = kq::Api<T>::name;
    if (!isResolved(held.inputs, held.exact)) {
        ++tally.counts[name + " no reference"];
        return;
    }
    const Found found = find<T>(held);
    const bool wrong = found.worst > 1;
    if (!found.filterIsRight) {
        ++tally.counts[name + " filter off"];
        return;
    }
    ++tally.counts[name + " judged"];
    if (found.isToldOfPrecision) ++tally.counts[name + " precision told" + (wrong ? ", rightly" : " for nothing")];
    if (!wrong) return;
    ++tally.counts[name + (found.isTold ? " wrong, told" : " wrong, SILENT")];
    std::printf("%s %s %s off %.1e times the goal at step %zu%s\n", id.c_str(), name.c_str(),
                found.isMean ? "mean" : "covariance", found.worst, found.at, found.isTold ? ", told" : "");
}

void study(Tally &tally, const std::string &id, const Model &model)
{
    const auto each = [&](auto arithmetic, const Held &held) { judge<decltype(arithmetic)>(tally, id, held); };
    const Inputs inputs = heldByFloats(model.sequence);
    const Exact exact = run(inputs);
    judgeFloats(model.sequence, inputs, exact, each);
    judgeWords(model, exact, each);
}

} // namespace

int main(int argc, char **argv)
{
    const Options options(argc, argv, 2000);
    const double noiseFree = options.option == "--ordinary" ? 0 : 0.7;
    Tally tally;
    options.forEach([&](std::uint64_t number, const std::string &id) {
        try {
            study(tally, id, wholeModel(options.seed, number, noiseFree));
        } catch (const std::exception &error) {
            ++tally.counts[std::string("not run: ") + error.what()];
        }
    });
    for (const auto &[what, count] : tally.counts) std::printf("%6d  %s\n", count, what.c_str());
    const int judged = tally.counts["f32 judged"], silent = tally.counts["f32 wrong, SILENT"];
    const int needless = tally.counts["f32 precision told for nothing"] + tally.counts["f64 precision told for nothing"];
    const bool good = noiseFree > 0 ? 250 * silent <= judged : needless == 0;
    std::printf("%s\n", good ? "passed" : "FAILED: at most 1 of 250 may be silent, none be told of where all have noise");
    return good ? 0 : 1;
}
