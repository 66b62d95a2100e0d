// Lean sensors beside full ones and the textbook in __float128 (exact.hpp): random models of low noise, P0 / R from 1e2 to
// 1e15 by a uniform exponent.  n = 1..16, m = 1..4, up to 3 sensors, rows that are 1e-4 apart, chains of integrators, and
// models that grow, with outages of 20 steps.
//
//     lean [models [seed [first]]]      300, 1, 0; -v names the models that are wrong or have events
//
// A model is wrong where, at some step, a mean is off by more than 0.1 sigma or an entry of a covariance by more than 0.1
// of sigma_i sigma_j; sigma as judge.hpp has it.  It is silent where no event says so.  Of an arithmetic, lean sensors may
// have so many more wrong models than full ones as 1 % of all: filtered, smoothed, and of the other smoothers' means.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "arithmetics.hpp"

using namespace campaign;

namespace
{

constexpr int runLength = 60, outageFrom = 20, outageTo = 40;
constexpr double most = 0.1, mostOfScore = 0.01;
const double classes[] = {6, 10, 15}; // of log10 P0 / R
const double sure[] = {6, 15, 10};    // of each arithmetic: up to it no model is wrong

// ------------------------------------------------------------------ models

/// A chain of integrators of which the last one walks, or dense and stable; growing: by 2 % a step, or by the chain
reference::ProcessModel processOf(Random &random, Index n, bool isChain, bool grows)
{
    Matrix<double> A = Matrix<double>::Identity(n, n), F = Matrix<double>::Zero(n, n);
    if (!isChain) A = 0.3 / static_cast<double>(n + 2) * reference::normals(random, n, n);
    for (Index i = 0; i < n && !isChain; ++i) A(i, i) += grows ? 0.816 : 0.8;
    for (Index i = 0; i + 1 < n && isChain; ++i) A(i, i + 1) = 0.1;
    if (isChain) F(n - 1, n - 1) = 0.1;
    else F = 0.1 / std::sqrt(n) * reference::normals(random, n, n);
    return {rounded(A), Matrix<double>(n, 0), rounded(F)};
}

void addLowNoiseSensor(Random &random, Model &model, double ratio, bool isNear)
{
    const Index n = model.F.rows(), m = random.integer(1, 4);
    reference::SensorModel sensor{reference::normals(random, m, n), Matrix<double>::Zero(m, m)};
    std::vector<reference::SensorModel> &all = model.sequence.sensors;
    for (Index c = 0; c < m; ++c) {
        sensor.R(c, c) = static_cast<float>(random.uniform(1, 2) / ratio);
        if (!isNear || (c == 0 && all.empty())) continue;
        const Matrix<double> other = all.empty() ? sensor.H : all[0].H;
        for (Index k = 0; k < n; ++k) sensor.H(c, k) = other(0, k) * (1 + 1e-4 * random.normal());
    }
    sensor.H = rounded(sensor.H);
    model.N.push_back(Matrix<double>(sensor.R.cwiseSqrt()));
    all.push_back(sensor);
    model.repeated.push_back(false);
}

/// The other sensors speak at every third step.
Model leanModel(std::uint64_t seed, std::uint64_t number, double &exponent)
{
    Random random(seed * 1000003U + number);
    Model model;
    const Index n = random.integer(1, random.chance(0.2) ? 16 : 6);
    const bool isChain = random.chance(0.25), hasOutage = random.chance(0.33), isNear = random.chance(0.15);
    exponent = random.uniform(2, 15);
    model.F = random.chance(0.5) ? Matrix<double>::Identity(n, n)
                                 : reference::generator::randomFactor(random, n, n, Vector<double>::Ones(n));
    model.sequence.P0 = model.F * model.F.transpose();
    model.sequence.x0 = Vector<double>::Zero(n);
    model.sequence.processes.push_back(processOf(random, n, isChain, hasOutage));
    for (int k = random.chance(0.3) ? random.integer(2, 3) : 1; k > 0; --k) {
        addLowNoiseSensor(random, model, std::pow(10, exponent), isNear);
    }
    for (int t = 0; t < runLength; ++t) {
        Step step{{}, 0, Vector<double>()};
        const bool isSilent = hasOutage && t >= outageFrom && t < outageTo;
        for (std::size_t k = 0; k < model.N.size() && !isSilent; ++k) {
            if (k == 0 || t % 3 == 0) step.readings.push_back({k, Vector<double>(), UINT32_MAX});
        }
        model.sequence.steps.push_back(step);
    }
    simulate(random, model, 1);
    for (Step &step : model.sequence.steps) {
        for (Reading &reading : step.readings) reading.z = rounded(reading.z);
    }
    model.text = "n" + std::to_string(n) + " sensors " + std::to_string(model.N.size()) + (isChain ? " chain" : "") +
                 (hasOutage ? " outage" : "") + (isNear ? " near" : "");
    return model;
}

// ------------------------------------------------------------------ what comes of them

struct Tally {
    int models = 0, refused = 0, wrong = 0, silent = 0, smoothedWrong = 0, smoothedSilent = 0, meansWrong = 0, scoresOff = 0,
        indefinite = 0, saturated = 0, falsePrecision = 0;
};

using Table = Tally[3][2][std::size(classes)]; // by arithmetic, full or lean, class

const char *const forms[] = {"full", "lean"};

/// What is wrong of a model, and its events
struct Found {
    std::array<bool, quantities> off{};
    unsigned filter = 0, all = 0;

    Found(const Series &errors, const Outcome &outcome)
    {
        for (std::size_t t = 0; t < errors.size(); ++t) {
            for (std::size_t q = 0; q < quantities; ++q) off[q] |= !(errors[t][q] <= (q == score ? mostOfScore : most));
            filter |= outcome.events[t] & ~static_cast<unsigned>(KQ_EVENT_REDUNDANT);
        }
        all = filter | outcome.smootherEvents;
    }

    bool isWrong() const { return off[filterMean] || off[filterCovariance]; }
    bool isWrongSmoothed() const { return off[smootherMean] || off[smootherCovariance]; }
};

void count(Tally &tally, const Found &found, const Outcome &outcome)
{
    const bool isRight = !found.isWrong() && !found.isWrongSmoothed();
    tally.wrong += found.isWrong();
    tally.silent += found.isWrong() && !found.filter;
    tally.smoothedWrong += found.isWrongSmoothed();
    tally.smoothedSilent += found.isWrongSmoothed() && !found.all;
    tally.meansWrong += found.off[means] || found.off[means + 1] || found.off[means + 2];
    tally.scoresOff += found.off[score];
    tally.indefinite += !(outcome.indefinite <= 1);
    tally.saturated += (found.all & KQ_EVENT_SATURATED) != 0;
    tally.falsePrecision += isRight && (found.all & KQ_EVENT_PRECISION);
}

/// level: its class; name: or NULL
template <class T> void judge(Tally (&tallies)[2][std::size(classes)], const Held &held, std::size_t level, const char *name)
{
    const Accuracy accuracy = accuracyOf<T>(held.inputs.n());
    const Units units(accuracy, held.inputs, held.words);
    for (int isLean = 0; isLean < 2; ++isLean) {
        Tally &tally = tallies[isLean][level];
        reference::Library<T> library(held.sequence, reference::Processes::separate, isLean);
        const Outcome outcome = Campaigner<T>(held.sequence, library).run();
        ++tally.models;
        if (!outcome.refused.empty()) {
            ++tally.refused, ++tally.wrong, ++tally.smoothedWrong;
            std::printf("%s: %s\n", kq::Api<T>::name, outcome.refused.c_str());
            continue;
        }
        const Found found(compare(outcome.instants, held.exact, units, true), outcome);
        count(tally, found, outcome);
        if (!name || (!found.isWrong() && !found.isWrongSmoothed() && !found.all)) continue;
        std::printf("%s %s %s:%s%s events %x %x\n", name, kq::Api<T>::name, forms[isLean], found.isWrong() ? " wrong" : "",
                    found.isWrongSmoothed() ? " smoothed wrong" : "", found.filter, found.all);
    }
}

template <class T> constexpr int rowOf = std::is_same_v<T, float> ? 0 : std::is_same_v<T, double> ? 1 : 2; // of a table

void study(Table &table, const Options &options, std::uint64_t number, const std::string &id)
{
    double exponent = 0;
    const Model model = leanModel(options.seed, number, exponent);
    const auto level = static_cast<std::size_t>(std::lower_bound(classes, std::end(classes), exponent) - classes);
    const std::string text = id + " " + model.text + " 1e" + std::to_string(exponent);
    const auto each = [&](auto arithmetic, const Held &held) {
        using T = decltype(arithmetic);
        judge<T>(table[rowOf<T>], held, level, options.isVerbose ? text.c_str() : nullptr);
    };
    const Inputs inputs = heldByFloats(model.sequence);
    const Exact exact = run(inputs);
    judgeFloats(model.sequence, inputs, exact, each);
    judgeWords(model, exact, each);
}

} // namespace

int main(int argc, char **argv)
{
    static const char *const names[] = {"f32", "f64", "q31"};
    const Options options(argc, argv, 300);
    bool good = true;
    Table table{};
    options.forEach([&](std::uint64_t number, const std::string &id) { study(table, options, number, id); });
    std::printf("          P0/R to  models  wrong (silent)  smoothed (silent)  other means  scores  not PSD  saturated  "
                "false precision\n");
    for (int a = 0; a < 3; ++a) {
        int wrong[2] = {}, smoothed[2] = {}, other[2] = {};
        for (int form = 0; form < 2; ++form) {
            for (std::size_t c = 0; c < std::size(classes); ++c) {
                const Tally &t = table[a][form][c];
                std::printf("%s %s    1e%-4g %7d %6d (%4d)   %8d (%4d)     %8d %7d %8d %9d %9d\n", names[a], forms[form],
                            classes[c], t.models, t.wrong, t.silent, t.smoothedWrong, t.smoothedSilent, t.meansWrong,
                            t.scoresOff, t.indefinite, t.saturated, t.falsePrecision);
                good &= classes[c] > sure[a] || t.wrong + t.smoothedWrong + t.meansWrong == 0;
                wrong[form] += t.wrong, smoothed[form] += t.smoothedWrong, other[form] += t.meansWrong;
            }
        }
        const auto least = static_cast<int>(options.models / 100);
        good &= wrong[1] <= wrong[0] + least && smoothed[1] <= smoothed[0] + least && other[1] <= other[0] + least;
    }
    std::printf("%s\n", good ? "passed" : "FAILED");
    return good ? 0 : 1;
}
