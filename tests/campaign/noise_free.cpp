// Smoothers behind sensors without noise: random models of small whole numbers (their data every other time), with components that have no noise,
// say a thing twice, say a sum or a difference, and processes that have little noise or none.  Each step is judged
// against the textbook in __float128 (exact.hpp).
//
//     campaign_noise_free [--ordinary] [models [seed [first]]]      2000, 1, 0
//
// It counts models whose filter is right at every step and whose smoothed mean or covariance is not, with no event:
// beyond 0.05 sigma in f32, 1e-3 in q31 and 1e-6 in f64, and a few roundings of the filtered sigma.  And it counts how
// often KQ_EVENT_PRECISION of a history is told for nothing, there and, --ordinary, where every component has noise.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

#include "judge.hpp"

using namespace campaign;

namespace
{

constexpr int runLength = 30;

/// A signed permutation, a chain, a part of it that forgets, or whole numbers below a diagonal.
Matrix<double> transition(Random &random, Index n)
{
    Matrix<double> A = Matrix<double>::Zero(n, n);
    const int kind = random.integer(0, 3);
    for (Index i = 0; i < n; ++i) {
        if (kind == 0) A(i, (i + 1) % n) = random.chance(0.5) ? 1 : -1;
        if (kind == 1) A(i, i) = 1;
        if (kind == 1 && i + 1 < n) A(i, i + 1) = 1;
        if (kind == 2) A(i, i) = random.chance(0.5) ? 1 : 0.5;
        if (kind == 3) A(i, i) = random.integer(-1, 1);
        for (Index j = i + 1; j < n && kind >= 2; ++j) A(i, j) = random.chance(0.4) ? random.integer(-1, 1) : 0;
    }
    if (random.chance(0.15)) A.row(random.integer(0, static_cast<int>(n) - 1)).setZero();
    return A;
}

Matrix<double> wholeNumbers(Random &random, Index height, Index width, double share)
{
    Matrix<double> M(height, width);
    for (Index i = 0; i < height; ++i) {
        for (Index j = 0; j < width; ++j) M(i, j) = random.chance(share) ? random.integer(-2, 2) : 0;
    }
    return M;
}

/// Components of small whole numbers, some of them what the ones before have said.
reference::SensorModel sensor(Random &random, Index m, Index n, double noiseFree)
{
    reference::SensorModel s;
    s.H = wholeNumbers(random, m, n, 0.7);
    s.R = Matrix<double>::Zero(m, m);
    for (Index c = 0; c < m; ++c) {
        if (c > 0 && random.chance(0.2)) s.H.row(c) = Matrix<double>(2 * s.H.row(c - 1));
        if (c > 1 && random.chance(0.2)) s.H.row(c) = Matrix<double>(s.H.row(0) + s.H.row(1));
        s.R(c, c) = random.chance(noiseFree) ? 0 : std::ldexp(1, random.integer(-12, 2));
    }
    return s;
}

/// Small whole numbers, or normal ones
Matrix<double> drawn(Random &random, bool whole, Index count)
{
    return whole ? wholeNumbers(random, count, 1, 1)
                 : Matrix<double>(reference::normals(random, count));
}

Model wholeModel(std::uint64_t seed, std::uint64_t number, double noiseFree)
{
    Random random(seed * 1000003U + number);
    Model model;
    Sequence &sequence = model.sequence;
    const Index n = random.integer(2, 6), rank = random.integer(0, static_cast<int>(n));
    const double quiet = std::ldexp(1, random.integer(-6, 1));
    model.units = Vector<double>::Ones(n);
    model.F = wholeNumbers(random, n, n, 0.6) * std::ldexp(1, random.integer(-1, 4));
    sequence.P0 = model.F * model.F.transpose();
    sequence.x0 = wholeNumbers(random, n, 1, 1);
    Matrix<double> A = transition(random, n);
    sequence.processes.push_back({A, Matrix<double>(n, 0), Matrix<double>(wholeNumbers(random, n, rank, 0.5) * quiet)});
    for (int k = random.integer(1, 2); k > 0; --k) {
        sequence.sensors.push_back(sensor(random, random.integer(1, 3), n, noiseFree));
        model.repeated.push_back(false);
    }
    const reference::ProcessModel &process = sequence.processes[0];
    const bool whole = random.chance(0.5);
    Vector<double> x = sequence.x0 + model.F * drawn(random, whole, n);
    model.largest = x.cwiseAbs();
    for (int t = 0; t < runLength; ++t) {
        reference::Step step{{}, 0, Vector<double>()};
        model.largest = model.largest.cwiseMax(x.cwiseAbs());
        for (std::size_t k = 0; k < sequence.sensors.size(); ++k) {
            const reference::SensorModel &s = sequence.sensors[k];
            if (random.chance(0.2)) continue;
            Vector<double> z = s.H * x;
            z += s.R.diagonal().cwiseSqrt().cwiseProduct(Vector<double>(drawn(random, whole, z.size())));
            const bool all = random.chance(0.8);
            const auto some = static_cast<std::uint32_t>(random.integer(1, 7));
            step.readings.push_back({k, rounded(z), all ? UINT32_MAX : some});
        }
        sequence.steps.push_back(step);
        x = process.A * x + process.F * drawn(random, whole, process.F.cols());
    }
    model.text = "n" + std::to_string(n) + " Q rank " + std::to_string(rank);
    return model;
}

struct Goal {
    double filter, smoother;
};

template <class T> Goal goalOf();
template <> Goal goalOf<float>() { return {0.005, 0.05}; }
template <> Goal goalOf<double>() { return {1e-7, 1e-6}; }
template <> Goal goalOf<Q31>() { return {1e-4, 1e-3}; }

/// Does every measurement say what __float128 can tell from its own rounding, or nothing?
bool isResolved(const Inputs &inputs, const Exact &exact)
{
    Mat open = inputs.P0;
    for (const Instant &now : exact) {
        for (const Update &update : now.updates) {
            for (const Scalar &scalar : update.scalars) {
                Real terms = 0;
                for (Index k = 0; k < inputs.n(); ++k) {
                    const Real part = scalar.h(k) * sigma(open, k);
                    terms += part * part;
                }
                if (scalar.taken && scalar.variance < Real(1e-20) * terms) return false;
            }
        }
        open = sandwich(inputs.A(), open) + inputs.Q();
    }
    return true;
}

/// What one arithmetic made of one model.
struct Found {
    bool filterIsRight = true, isTold = false, isToldOfPrecision = false;
    double worst = 0; // of the smoother, 1 being the goal
    std::size_t at = 0;
    bool isMean = true;
};

template <class T>
Found find(const Sequence &sequence, reference::Library<T> &library, const Inputs &inputs, const Exact &exact,
           const Vec &words, Outcome &outcome)
{
    const Goal goal = goalOf<T>();
    const Accuracy accuracy = accuracyOf<T>(inputs.n());
    const Units units(accuracy, inputs, words);
    outcome = Campaigner<T>(sequence, library).run();
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

template <class T>
void judge(Tally &tally, const std::string &id, const Sequence &sequence, reference::Library<T> &library,
           const Inputs &inputs, const Exact &exact, const Vec &words)
{
    Outcome outcome;
    const std::string name = kq::Api<T>::name;
    if (!isResolved(inputs, exact)) {
        ++tally.counts[name + " no reference"];
        return;
    }
    const Found found = find<T>(sequence, library, inputs, exact, words, outcome);
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

void study(Tally &tally, std::uint64_t seed, std::uint64_t number, double noiseFree)
{
    const Model model = wholeModel(seed, number, noiseFree);
    const std::string id = std::to_string(seed) + ":" + std::to_string(number);
    const Inputs inputs = heldByFloats(model.sequence);
    const Exact exact = run(inputs);
    reference::Library<float> single(model.sequence);
    reference::Library<double> wide(model.sequence);
    judge<double>(tally, id, model.sequence, wide, inputs, exact, Vec());
    judge<float>(tally, id, model.sequence, single, inputs, exact, Vec());
    if (!hasFormats(declaredRange(model, exact))) return;
    const Sequence sequence = withRanges(model, exact);
    reference::Library<Q31> library(sequence);
    const Inputs held = heldByWords(sequence, library);
    judge<Q31>(tally, id, sequence, library, held, run(held), wordsOf(library));
}

} // namespace

int main(int argc, char **argv)
{
    std::uint64_t numbers[] = {2000, 1, 0};
    int given = 0;
    double noiseFree = 0.7;
    Tally tally;
    for (int k = 1; k < argc; ++k) {
        if (std::strcmp(argv[k], "--ordinary") == 0) noiseFree = 0;
        else if (given < 3) numbers[given++] = std::strtoull(argv[k], nullptr, 10);
    }
    for (std::uint64_t k = 0; k < numbers[0]; ++k) {
        try {
            study(tally, numbers[1], numbers[2] + k, noiseFree);
        } catch (const std::exception &error) {
            ++tally.counts[std::string("not run: ") + error.what()];
        }
    }
    for (const auto &[what, count] : tally.counts) std::printf("%6d  %s\n", count, what.c_str());
    const int judged = tally.counts["f32 judged"], silent = tally.counts["f32 wrong, SILENT"];
    const int needless = tally.counts["f32 precision told for nothing"] + tally.counts["f64 precision told for nothing"];
    const bool good = noiseFree > 0 ? 250 * silent <= judged : needless == 0;
    std::printf("%s\n", good ? "passed" : "FAILED: at most 1 of 250 may be silent, none be told of where all have noise");
    return good ? 0 : 1;
}
