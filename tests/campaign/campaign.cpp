// The campaign: random models of the hard kind through every arithmetic, each step judged against
// the textbook filter and smoother in __float128 on the inputs as that arithmetic holds them.
//
//     campaign [hard] [models [seed [first]]]      models first .. first + models - 1; 100, 1, 0
//     campaign narrow ...                          true states far closer to x0 than the prior says; q31 alone
//     campaign --model SEED:NUMBER -v              one of them, step by step where something is wrong
//
// It counts silent errors: beyond the tolerance of the arithmetic (sigmas of the exact result:
// 1e-2 in f32, 1e-3 in q31, 1e-6 in f64) plus what its documented roundings make on this model
// (allowance.hpp), with no event and no error status.  In q31 and f64 there must be none, in f32 no
// more than one in 100 models.  In q31 and f64 the smoothed P is positive semi-definite.  An
// event that is right does not excuse an error: KQ_EVENT_REDUNDANT where the textbook leaves the same
// component out.  A step where the documented roundings alone come to a quarter of a sigma is
// beyond the arithmetic; it is counted and not judged.  q31's ranges are 1.5 times the largest
// exact state: it must not saturate either, as long as the roundings come to less than that.
//
//     kinds.hpp      the random models          exact.hpp      the textbook
//     held.hpp       inputs as held             outcome.hpp    the library, and a float UD filter
//     allowance.hpp  documented roundings       judge.hpp      errors and their units
//     arithmetics.hpp  a model through every arithmetic, and the command line
#include <cstdio>
#include <map>
#include <string>

#include "arithmetics.hpp"

using namespace campaign;

namespace
{

/// Over all models.
struct Tally {
    std::map<std::string, int> counts;
    bool verbose = false;

    void add(const std::string &what, int count = 1) { counts[what] += count; }
    int of(const std::string &what) const
    {
        const auto found = counts.find(what);
        return found == counts.end() ? 0 : found->second;
    }
};

struct Case {
    std::string id; // SEED:NUMBER
    const Model &model;
    Tally &tally;

    void report(const std::string &what, const char *detail) const
    {
        std::printf("%-34s %-9s %s; %s\n", what.c_str(), id.c_str(), detail, model.text.c_str());
        tally.add(what);
    }
};

/// The first step from which an event says that something is not as it should be.
std::size_t firstFlag(const Outcome &outcome, const Exact &exact)
{
    for (std::size_t t = 0; t < outcome.instants.size(); ++t) {
        bool same = true;
        for (std::size_t k = 0; k < exact[t].updates.size(); ++k) {
            same = same && outcome.instants[t].updates[k].taken == exact[t].updates[k].taken;
        }
        const unsigned events = outcome.events[t];
        if ((events & ~harmless) || (events && !same)) return t;
    }
    return outcome.ofSmoothers() ? outcome.instants.size() : SIZE_MAX;
}

/// The worst excess of one quantity.
struct Excess {
    double ratio = 0, error = 0, allowed = 0;
    std::size_t at = 0;
    int beyondSteps = 0;
    double beyondError = 0; // of the steps that are not judged
};

Excess worstOf(const Series &errors, const Series &allowed, const Accuracy &accuracy, int q,
               std::size_t end)
{
    Excess worst;
    for (std::size_t t = 0; t < std::min(end, errors.size()); ++t) {
        if (!(allowed[t][q] <= beyond)) {
            ++worst.beyondSteps;
            worst.beyondError = std::max(worst.beyondError, errors[t][q]);
            continue;
        }
        const double limit = accuracy.tolerance + allowed[t][q];
        if (errors[t][q] / limit <= worst.ratio) continue;
        worst.ratio = errors[t][q] / limit;
        worst.error = errors[t][q];
        worst.allowed = limit;
        worst.at = t;
    }
    return worst;
}

void judgeQuantity(const Case &now, const char *name, int q, const Excess &silent,
                   const Excess &all)
{
    const std::string what = std::string(name) + " " + nameOf(static_cast<Quantity>(q));
    char detail[160];
    if (q < means) {
        now.tally.add(std::string(name) + " steps judged", steps - all.beyondSteps);
        now.tally.add(std::string(name) + " steps beyond the arithmetic", all.beyondSteps);
    }
    if (silent.beyondError > beyond) {
        std::snprintf(detail, sizeof detail, "off by %.1e, where beyond", silent.beyondError);
        if (now.tally.verbose) std::printf("%s %s %s\n", now.id.c_str(), what.c_str(), detail);
        now.tally.add(what + " off with no event where beyond the arithmetic");
    }
    if (all.ratio <= 1) return;
    const bool quiet = silent.ratio > 1;
    const Excess &worst = quiet ? silent : all;
    std::snprintf(detail, sizeof detail, "%.1e, limit %.1e, step %zu", worst.error, worst.allowed,
                  worst.at);
    now.report(what + (quiet ? " SILENT" : " flagged"), detail);
    if (quiet) now.tally.add(std::string(name) + " silent errors");
}

/// The first one, as long as the filter's own state is within the arithmetic.
void reportSaturation(const Case &now, const char *name, const Outcome &outcome,
                      const Series &allowed)
{
    for (std::size_t t = 0; t < outcome.events.size(); ++t) {
        if (!(allowed[t][filterMean] <= beyond)) return;
        if (!(outcome.events[t] & KQ_EVENT_SATURATED)) continue;
        char detail[32];
        std::snprintf(detail, sizeof detail, "step %zu", t);
        now.report(std::string(name) + " saturated inside its range", detail);
        return;
    }
    for (const auto &step : allowed) {
        if (!(step[smootherMean] <= beyond)) return;
    }
    if (outcome.ofSmoothers() & KQ_EVENT_SATURATED) {
        now.report(std::string(name) + " saturated inside its range", "smoothers");
    }
}

void printSteps(const char *name, const Series &errors, const Series &allowed,
                const Outcome &outcome)
{
    std::printf("%s: error (allowed) of each quantity, by step\n", name);
    for (std::size_t t = 0; t < errors.size(); ++t) {
        std::printf("  %3zu events %2x", t, outcome.events[t]);
        for (int q = 0; q < quantities; ++q) {
            std::printf("  %.0e (%.0e)", errors[t][q], allowed[t][q]);
        }
        std::printf("\n");
    }
}

/// What an arithmetic was off by, and what it was allowed to.
struct Judged {
    Series errors, allowed;
};

template <class T> Judged judge(const Case &now, const Held &held)
{
    const auto &[id, model, sequence, inputs, exact, words, areFloatsResolved] = held;
    reference::Library<T> library(sequence);
    const char *name = kq::Api<T>::name;
    const Accuracy accuracy = accuracyOf<T>(inputs.n());
    const Units units(accuracy, inputs, words);
    const Outcome outcome = Campaigner<T>(sequence, library).run();
    const bool done = outcome.refused.empty();
    if (!done) now.report(std::string(name) + " refused", outcome.refused.c_str());
    const Series errors = compare(outcome.instants, exact, units, done);
    if (!done) return {errors, errors};
    const Series allowed = allowance(inputs, exact, units, accuracy, words);
    const std::size_t flag = firstFlag(outcome, exact);
    for (int q = 0; q < quantities; ++q) {
        const bool past = q >= smootherMean;
        const std::size_t end = past ? (flag == SIZE_MAX ? exact.size() : 0) : flag;
        judgeQuantity(now, name, q, worstOf(errors, allowed, accuracy, q, end),
                      worstOf(errors, allowed, accuracy, q, exact.size()));
    }
    reportSaturation(now, name, outcome, allowed);
    if (!(outcome.indefinite <= 1)) now.report(std::string(name) + " smoothed P indefinite", "by more than it is rounded where it is handed over");
    if (now.tally.verbose) printSteps(name, errors, allowed, outcome);
    return {errors, allowed};
}

/// Over the steps that are judged.
double worst(const Series &series, const Series &allowed, int q)
{
    double most = 0;
    for (std::size_t t = 0; t < series.size(); ++t) {
        if (allowed[t][q] <= beyond) most = std::max(most, series[t][q]);
    }
    return most;
}

/// f32 beside UD, where the error is one that shows.
void judgeBesideUd(const Case &now, const Judged &library, const Series &ud)
{
    for (const Quantity q : {filterMean, filterCovariance}) {
        const double mine = worst(library.errors, library.allowed, q);
        const double other = worst(ud, library.allowed, q);
        if (mine < 1e-4 || mine <= 2 * other) continue;
        char detail[64];
        std::snprintf(detail, sizeof detail, "%.1e, UD %.1e", mine, other);
        now.report(std::string("f32 ") + nameOf(q) + (mine > 5 * other ? " > 5 UD" : " > 2 UD"),
                   detail);
    }
}

/// The filter that f32 is beside
Series errorsOfUd(const Held &held)
{
    const Accuracy accuracy = accuracyOf<float>(held.inputs.n());
    return compare(runUd(held.model).instants, held.exact, Units(accuracy, held.inputs, held.words), false);
}

} // namespace

int main(int argc, char **argv)
{
    const Options options(argc, argv, 100);
    const std::string kind = options.what.empty() ? "hard" : options.what;
    Tally tally;
    tally.verbose = options.isVerbose;
    const auto each = [&tally](auto arithmetic, const Held &held) {
        using T = decltype(arithmetic);
        const Case now{held.id, held.model, tally};
        const Judged judged = judge<T>(now, held);
        if constexpr (std::is_same_v<T, float>) judgeBesideUd(now, judged, errorsOfUd(held));
    };
    const Through all = options.through(kind, each, kind != "narrow");
    tally.add("models", all.models);
    if (all.notRun > 0) tally.add("not run", all.notRun);
    if (all.withoutFormat > 0) tally.add("q31 has no format for the exact states", all.withoutFormat);
    for (const auto &[what, count] : tally.counts) std::printf("%6d  %s\n", count, what.c_str());
    const int silent = tally.of("f64 silent errors") + tally.of("q31 silent errors");
    const bool good = silent == 0 && all.notRun == 0 && tally.of("q31 saturated inside its range") == 0 &&
                      tally.of("f64 smoothed P indefinite") == 0 && tally.of("q31 smoothed P indefinite") == 0 &&
                      100 * tally.of("f32 silent errors") <= static_cast<int>(options.models);
    std::printf("%s: %d silent errors in f64 and q31\n", good ? "passed" : "FAILED", silent);
    return good ? 0 : 1;
}
