// The smoothers on line against the textbook: every lag up to L = 1, 5 and 20, and fixed points.
//
//     test_lag [seed]
//
// Short sequences beside one dense least-squares solve of the measurements so far (batch.hpp), long
// ones, with singular noise too, beside the recursion without an inverse in quadruple precision.
// Models that change with time, several sensors a step, components and whole steps missing.
//
// Units: an error of the mean counts in sigma of the smoothed state at that time, of a covariance
// in sigma_i sigma_j: bounds and units are those of the fixed-interval smoother
// (comparison.hpp).
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "batch.hpp"
#include "comparison.hpp"
#include "library.hpp"
#include "on_line.hpp"
#include "smoother_checks.hpp"

using namespace reference;

namespace
{

constexpr int randomModels = 72;
constexpr int randomSteps = 60;
constexpr int shortModels = 54;
constexpr int shortSteps = 24; // of a dense solve
constexpr int longest = 20;
constexpr int lags[] = {1, 5, longest};

/// What is right at one time: of steps first .. first + past.size() - 1, the last being the time.
struct Window {
    std::size_t first;
    std::vector<Belief<Quad>> past;
};

/// A sequence with some of its times; what is right at each is known to the lag `longest`.
struct Case : Study {
    std::vector<Window> windows;
    explicit Case(const Sequence &data) : Study(data) {}

    double refinement(double floor) const
    {
        double worst = 1;
        for (const Window &window : windows) {
            for (std::size_t k = 0; k < window.past.size(); ++k) {
                refine(worst, *this, window.first + k, window.past[k].covariance, floor);
            }
        }
        return worst;
    }
};

/// Steps first .. last alone, with no more models than they use.
Sequence part(const Sequence &whole, std::size_t first, std::size_t last)
{
    Sequence result;
    result.x0 = whole.x0;
    result.P0 = whole.P0;
    result.range = whole.range;
    for (std::size_t t = first; t <= last; ++t) {
        Step step = whole.steps[t];
        result.processes.push_back(whole.processes[step.process]);
        step.process = result.processes.size() - 1;
        for (Reading &reading : step.readings) {
            result.sensors.push_back(whole.sensors[reading.sensor]);
            reading.sensor = result.sensors.size() - 1;
        }
        result.steps.push_back(step);
    }
    return result;
}

/// Given all up to step `last`, by recursion from there; the filter has seen what is before.
Window windowByRecursion(const Case &model, std::size_t last)
{
    const std::size_t most = longest, first = last > most ? last - most : 0;
    const std::vector<Track<Quad>> track(model.track.begin() + static_cast<std::ptrdiff_t>(first),
                                         model.track.begin() + static_cast<std::ptrdiff_t>(last) +
                                             1);
    Window window{first, {}};
    for (Smoothed<Quad> &now : smoothWithoutInverse(part(model.sequence, first, last), track)) {
        window.past.push_back(now.belief);
    }
    return window;
}

/// The same as one least-squares problem from step 0 on.
Window windowByBatch(const Case &model, std::size_t last)
{
    Window window{0, {}};
    for (const auto &now : smoothByLeastSquares(part(model.sequence, 0, last))) {
        window.past.push_back(
            {now.belief.mean.template cast<Quad>(), now.belief.covariance.template cast<Quad>()});
    }
    return window;
}

const Window *windowAt(const Case &model, std::size_t last)
{
    for (const Window &window : model.windows) {
        if (window.first + window.past.size() == last + 1) return &window;
    }
    return nullptr;
}

// ------------------------------------------------------------------ one sequence

template <class T>
void compare(Figures &figures, const Case &model, const Belief<Wide<T>> &now,
             const Belief<Quad> &exact)
{
    const Vector<Quad> unit = units(model, exact.covariance, floorOf<T>());
    figures.add("x", meanError(now.mean, exact.mean, unit));
    figures.add("P", covarianceError(now.covariance, exact.covariance, unit));
    figures.add("not PSD", indefinite<T>(now));
}

/// All that can be asked of the lag at one time.
template <class T>
void compareLags(Figures &figures, const Case &model, LagOwner<T> &lag, std::size_t t,
                 const std::vector<Belief<Wide<T>>> &filtered)
{
    const Window *window = windowAt(model, t);
    figures.add("lag 0", difference(lag.smooth(0), filtered[t]));
    if (!window) return;
    for (int k = lag.steps(); k >= 0; --k) {
        const std::size_t then = t - static_cast<std::size_t>(k);
        const Belief<Wide<T>> now = lag.smooth(k);
        compare<T>(figures, model, now, window->past[then - window->first]);
        figures.add("above filter", aboveFilter<T>(filtered[then], now));
        figures.add("means alone", lag.smoothStates(k) == now.mean ? 0 : 1);
    }
}

template <class T> void runLag(Figures &figures, const Case &model, int L)
{
    const Sequence &sequence = model.sequence;
    Library<T> library(sequence, Processes::shared);
    FilterOwner<T> filter(library.states()), twin(library.states());
    LagOwner<T> lag(library.states(), std::max(depth(sequence), 1), L);
    std::vector<Belief<Wide<T>>> filtered;
    library.init(filter);
    library.init(twin);
    lag.attach(filter);
    for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
        for (const Reading &reading : sequence.steps[t].readings) {
            library.update(filter.get(), reading);
            library.update(twin.get(), reading);
        }
        filtered.push_back(read(filter));
        figures.add("filter", filter.memory() == twin.memory() ? 0 : 1);
        compareLags(figures, model, lag, t, filtered);
        if (t + 1 == sequence.steps.size()) break;
        library.predict(filter.get(), sequence.steps[t]);
        library.predict(twin.get(), sequence.steps[t]);
    }
}

/// The instant `at`, refined up to each of the times.
template <class T> void runPoint(Figures &figures, const Case &model, std::size_t at)
{
    const Sequence &sequence = model.sequence;
    Library<T> library(sequence, Processes::shared);
    FilterOwner<T> filter(library.states());
    InstantOwner<T> point(library.states(), std::max(depth(sequence), 1));
    library.init(filter);
    for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
        const Step &step = sequence.steps[t];
        if (t == at) point.attach(filter);
        for (const Reading &reading : step.readings) library.update(filter.get(), reading);
        const Window *window = t >= at ? windowAt(model, t) : nullptr;
        if (window && window->first <= at) {
            compare<T>(figures, model, point.smooth(), window->past[at - window->first]);
        }
        if (t + 1 == sequence.steps.size()) break;
        library.predict(filter.get(), step);
    }
}

// ------------------------------------------------------------------ groups

const Claims claims = {
    {"x"}, {"P"}, {}, {{"above filter", 8}, {"not PSD", 1}, {"lag 0", 0}, {"filter", 0}, {"means alone", 0}}};

template <class T> void compareLibrary(Report &report, const std::string &group, const Case &model)
{
    const auto add = [&](const std::string &title, const Figures &figures) {
        judge<T>(report, title + group, group == "named models", model, figures, claims, {1e-9, 1e-10},
                 model.refinement(floorOf<T>()));
    };
    for (int L : lags) {
        Figures figures;
        runLag<T>(figures, model, L);
        add(", L = " + std::to_string(L) + ", ", figures);
    }
    Figures figures;
    const std::size_t last = model.sequence.steps.size() - 1;
    for (std::size_t at : {std::size_t(0), last / 3, last - longest / 2}) {
        runPoint<T>(figures, model, at);
    }
    add(", fixed point, ", figures);
}

void compareAll(Report &report, const std::string &group, const Case &model)
{
    compareLibrary<double>(report, group, model);
    compareLibrary<float>(report, group, model);
    compareLibrary<Q31>(report, group, model);
}

void compareRecursion(Report &report, const std::string &group, const Sequence &sequence)
{
    Case model(sequence);
    const std::size_t count = sequence.steps.size(), apart = std::max<std::size_t>(count / 9, 1);
    for (std::size_t t = apart / 2; t < count; t += apart) {
        model.windows.push_back(windowByRecursion(model, t));
    }
    compareAll(report, group, model);
}

void compareBatch(Report &report, Random &random, int number, bool isCompared)
{
    generator::Options options;
    options.steps = shortSteps;
    options.invertible = true;
    const Sequence sequence = generator::randomSequence(random, number, options);
    if (!isCompared) return;
    Case model(sequence);
    for (std::size_t t : {0, 3, 11, shortSteps - 1}) {
        model.windows.push_back(windowByBatch(model, t));
    }
    compareAll(report, "dense solve", model);
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv, generator::defaultSeed);
    const int compared = static_cast<int>(amountOf(argc, argv, randomModels)); // all are drawn
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    Random random(seed);
    Report report;
    for (int number = 0; number < shortModels; ++number) compareBatch(report, random, number, number < compared);
    generator::Options options;
    options.steps = randomSteps;
    for (int number = 0; number < randomModels; ++number) {
        const Sequence sequence = generator::randomSequence(random, number, options);
        if (number < compared) compareRecursion(report, "random models", sequence);
    }
    for (const Sequence &sequence : generator::namedSequences(random)) {
        compareRecursion(report, "named models", sequence);
    }
    report.print();
    return report.verdict.finish();
}
