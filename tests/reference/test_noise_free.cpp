// Sensors without noise: measurements that are exact, said twice, implied by others, or of
// something that is known already.  The filter and the smoother take the pseudo-inverse, that is
// they leave out what is redundant, and here it is known beforehand what is.
//
// Errors in sigma, as in the other tests.  Where nothing is left of it (below 16 eps of its
// variance), in the sigma that the state would have if nothing had been measured.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "accuracy.hpp"
#include "bryson_frazier.hpp"
#include "decompositions.hpp"
#include "library_run.hpp"
#include "numerics_models.hpp"
#include "verdict.hpp"

using namespace reference;

namespace
{

constexpr double floatGoal = 1e-4, doubleGoal = 1e-8;
/// Two models where 24 bits do not reach the goal: one forgets nothing (a moving average with a
/// unit root adds up the rounding of all steps), in the other sigma falls by 1e3 in the smoother.
constexpr double floatLimit = 2e-3;
/// The unit of a state that is known from the start: the library's process noise has a standard
/// deviation of at least 2^-60 in every state and step.
constexpr double knownUnit = 0x1p-40;

/// Measurements and the rank that goes with them.
struct Case {
    Sequence sequence;
    Taken taken;
    bool sharp = true; // the library can tell what is redundant, and has to say so
};

/// What a step sees, and which of that says something
struct Seen {
    std::vector<Reading> readings;
    std::vector<bool> taken;
};

// ------------------------------------------------------------------ building sequences

Sequence model(std::string name, const Matrix<double> &A, const Matrix<double> &F,
               const Vector<double> &x0, const Matrix<double> &P0)
{
    const Matrix<double> none(A.rows(), 0);
    return {std::move(name), x0, P0, {{rounded(A), none, rounded(F)}}, {}, {}};
}

/// A sensor of independent components; its number.
std::size_t addSensor(Sequence &sequence, const Matrix<double> &H, const Vector<double> &r)
{
    sequence.sensors.push_back({H, r.asDiagonal()});
    return sequence.sensors.size() - 1;
}

Matrix<double> none(Index n) { return Matrix<double>(n, 0); }
Matrix<double> identity(Index n) { return Matrix<double>::Identity(n, n); }
Vector<double> noNoise(Index m) { return Vector<double>::Zero(m); }

/// Multiples of 2^-12 and below 2^11: sums of two are floats.
double onGrid(double z) { return std::rint(z * 4096) / 4096; }

/// A run of the truth that a sequence describes, step by step.
class Truth
{
  public:
    Truth(const Sequence &sequence, Vector<double> x, std::uint64_t seed)
        : process_(sequence.processes[0]), x_(std::move(x)), random_(seed)
    {
    }

    /// h x, on the grid.
    double see(const Matrix<double> &h) const { return onGrid((h * x_)(0)); }
    double seeWithNoise(const Matrix<double> &h, double sigma)
    {
        return onGrid((h * x_)(0) + sigma * random_.normal());
    }

    void advance() { x_ = process_.A * x_ + process_.F * normals(random_, process_.F.cols(), 1); }

  private:
    ProcessModel process_;
    Vector<double> x_;
    Random random_;
};

Reading reading(std::size_t sensor, const Vector<double> &z)
{
    return {sensor, z, (1U << z.size()) - 1};
}

/// A run of a case whose sensors are there: `look`(truth, step) answers what is seen.
template <class Look> Case measured(Case data, Truth truth, int steps, const Look &look)
{
    for (int t = 0; t < steps; ++t) {
        const Seen seen = look(truth, t);
        data.sequence.steps.push_back({seen.readings, 0, Vector<double>()});
        data.taken.push_back(seen.taken);
        truth.advance();
    }
    return data;
}

/// Position and velocity, each with a noise of its own.
Sequence movingTarget(const std::string &name)
{
    return model(name, rows({{1, 0.125}, {0, 1}}), rows({{0.03125, 0}, {0, 0.125}}),
                 column({10, -3}), rows({{4, 0}, {0, 9}}));
}

/// The same with a random acceleration only.  Exact positions pin the velocity down in the end,
/// but no error is ever forgotten on the way: the moving average has its root on the unit circle.
Sequence acceleratedTarget(const std::string &name)
{
    Sequence sequence = movingTarget(name);
    sequence.processes[0].F = rows({{0.0078125}, {0.125}});
    return sequence;
}

// ------------------------------------------------------------------ no redundancy

Case arma(double missing, std::uint64_t seed)
{
    Case data{model(missing > 0 ? "ARMA(2,1), gaps" : "ARMA(2,1)", rows({{1.25, 1}, {-0.5, 0}}),
                    rows({{1}, {0.375}}), column({0, 0}), rows({{8, 0}, {0, 2}})),
              {}};
    const Matrix<double> h = unitRow(2, 0);
    const std::size_t sensor = addSensor(data.sequence, h, noNoise(1));
    Random random(seed + 1);
    return measured(data, Truth(data.sequence, column({1, 1}), seed), 200, [&](Truth &truth, int) {
        if (random.chance(missing)) return Seen{};
        return Seen{{reading(sensor, column({truth.see(h)}))}, {true}};
    });
}

// ------------------------------------------------------------------ redundant at one instant

/// The same row twice, in one call or in two.
Case twins(Sequence sequence, bool separate, std::uint64_t seed)
{
    sequence.name += separate ? ", in two calls" : ", in one call";
    const Matrix<double> h = unitRow(sequence.states(), 0);
    const std::size_t one = addSensor(sequence, h, noNoise(1));
    const std::size_t two = addSensor(sequence, h.chooseRows({0, 0}), noNoise(2));
    return measured({sequence, {}}, Truth(sequence, sequence.x0, seed), 60, [&](Truth &truth, int) {
        const double z = truth.see(h);
        const Reading single = reading(one, column({z})), both = reading(two, column({z, z}));
        return Seen{separate ? std::vector<Reading>{single, single} : std::vector<Reading>{both},
                    {true, false}};
    });
}

Sequence level(const std::string &name)
{
    return model(name, rows({{1}}), rows({{0.5}}), column({7}), rows({{25}}));
}

/// An exact sensor and a noisy one that see the same; the noisy one says nothing, or nothing new.
Case exactAndNoisyTwin(bool exactFirst, std::uint64_t seed)
{
    Sequence sequence = movingTarget(exactFirst ? "exact sensor, then its noisy twin"
                                                : "noisy sensor, then its exact twin");
    const Matrix<double> h = unitRow(2, 0);
    const std::size_t noisy = addSensor(sequence, h, column({0.25}));
    const std::size_t sure = addSensor(sequence, h, noNoise(1));
    return measured(
        {sequence, {}}, Truth(sequence, column({10, -3}), seed), 60, [&](Truth &truth, int) {
            const Reading a = reading(sure, column({truth.see(h)}));
            const Reading b = reading(noisy, column({truth.seeWithNoise(h, 0.5)}));
            return Seen{exactFirst ? std::vector<Reading>{a, b} : std::vector<Reading>{b, a},
                        {true, true}};
        });
}

/// Three dense rows of which one is the sum of the others; `order` says which comes when.  With two
/// noises the two exact measurements a step determine all of them in the end: the smoother's sigma
/// falls to a thousandth of the filter's.
Case sums(const std::vector<Index> &order, bool separate, Index noises, std::uint64_t seed)
{
    Random random(seed + 2);
    const Matrix<double> A = 0.9 * orthogonalFactor(normals(random, 4, 4));
    Sequence sequence =
        model(std::string("h3 = h1 + h2, ") + (order[0] == 2 ? "h3 first, " : "") +
                  (separate ? "in three calls" : "in one call") + (noises < 4 ? ", 2 noises" : ""),
              A, normals(random, 4, noises), noNoise(4), 16 * identity(4));
    Matrix<double> H = rows({{1.5, -0.25, 0.75, 2}, {-0.5, 1.25, 3, -1.75}, {0, 0, 0, 0}});
    H.row(2) = H.row(0) + H.row(1);
    const Matrix<double> ordered = H.chooseRows(order);
    for (Index k = 0; k < 3; ++k) addSensor(sequence, ordered.row(k), noNoise(1));
    const std::size_t all = addSensor(sequence, ordered, noNoise(3));
    return measured({sequence, {}}, Truth(sequence, column({3, -5, 2, 1}), seed), 60,
                    [&](Truth &truth, int) {
                        Vector<double> z = column({truth.see(H.row(0)), truth.see(H.row(1)), 0});
                        z(2) = z(0) + z(1);
                        const Vector<double> seen = z.chooseRows(order);
                        std::vector<Reading> readings;
                        if (!separate) readings.push_back(reading(all, seen));
                        for (std::size_t k = 0; k < 3 && separate; ++k) {
                            readings.push_back(reading(k, seen.row(static_cast<Index>(k))));
                        }
                        return Seen{readings, {true, true, false}};
                    });
}

// ------------------------------------------------------------------ known already

/// One exact sensor of h; `isTaken`(step): whether it says something
template <class IsTaken>
Case exactSensor(Sequence sequence, const Matrix<double> &h, bool sharp, Vector<double> start,
                 int steps, std::uint64_t seed, const IsTaken &isTaken)
{
    const std::size_t sensor = addSensor(sequence, h, noNoise(1));
    return measured({sequence, {}, sharp}, Truth(sequence, std::move(start), seed), steps,
                    [&](Truth &truth, int t) {
                        return Seen{{reading(sensor, column({truth.see(h)}))}, {isTaken(t)}};
                    });
}

/// P0 = 0: the first measurement has S = 0, later ones do not.
Case knownStart(std::uint64_t seed)
{
    Sequence sequence = movingTarget("P0 = 0");
    sequence.P0.setZero();
    return exactSensor(sequence, unitRow(2, 0), true, sequence.x0, 60, seed,
                       [](int t) { return t > 0; });
}

/// Nothing is ever uncertain, and nothing is ever taken.
Case knownForever()
{
    const Sequence sequence = model("P0 = 0 and Q = 0", rows({{1, 0.125}, {0, 1}}), none(2),
                                    column({10, -3}), Matrix<double>::Zero(2, 2));
    return exactSensor(sequence, rows({{1, 0.5}}), true, sequence.x0, 40, 0,
                       [](int) { return false; });
}

/// A sensor that sees nothing, beside one that does.
Case blindSensor(bool separate, std::uint64_t seed)
{
    Sequence sequence = movingTarget(separate ? "H = 0, in two calls" : "H = 0, in one call");
    const Matrix<double> h = unitRow(2, 0), blind = Matrix<double>::Zero(1, 2);
    const std::size_t dark = addSensor(sequence, blind, noNoise(1));
    const std::size_t light = addSensor(sequence, h, column({0.25}));
    const std::size_t both = addSensor(sequence, rows({{0, 0}, {1, 0}}), column({0, 0.25}));
    return measured(
        {sequence, {}}, Truth(sequence, column({11, -1}), seed), 60, [&](Truth &truth, int) {
            const double z = truth.seeWithNoise(h, 0.5);
            const std::vector<Reading> two{reading(dark, column({0})), reading(light, column({z}))};
            const std::vector<Reading> one{reading(both, column({0, z}))};
            return Seen{separate ? two : one, {false, true}};
        });
}

/// A constant state of which some combinations are measured, over and over; `noisy` adds another
/// combination with noise.
Case constantState(const std::string &name, const Matrix<double> &H, bool noisy, bool sharp,
                   std::uint64_t seed)
{
    Sequence sequence = model(name, identity(3), none(3), column({100, 0, -50}),
                              rows({{4, 1, 0}, {1, 9, -2}, {0, -2, 25}}));
    for (Index k = 0; k < H.rows(); ++k) addSensor(sequence, H.row(k), noNoise(1));
    const Matrix<double> extra = rows({{1, 1, -0.5}});
    const std::size_t extraSensor = addSensor(sequence, extra, column({0.25}));
    Truth start(sequence, column({101.5, -2.25, -46.75}), seed);
    return measured({sequence, {}, sharp}, start, 40, [&](Truth &truth, int t) {
        const Index k = t % H.rows();
        Seen seen{{reading(static_cast<std::size_t>(k), column({truth.see(H.row(k))}))},
                  {t < std::min<Index>(H.rows(), 3)}};
        if (noisy) {
            seen.readings.push_back(reading(extraSensor, column({truth.seeWithNoise(extra, 0.5)})));
            seen.taken.push_back(true);
        }
        return seen;
    });
}

/// A straight line: two exact points say all.
Case straightLineOfPoints(std::uint64_t seed)
{
    const Sequence sequence = model("straight line, exact points", rows({{1, 0.125}, {0, 1}}),
                                    none(2), column({0, 0}), rows({{100, 0}, {0, 4}}));
    return exactSensor(sequence, unitRow(2, 0), false, column({12.5, -1.75}), 40, seed,
                       [](int t) { return t < 2; });
}

/// P0 of rank one: the first exact measurement says all.
Case singularPrior(std::uint64_t seed)
{
    const Vector<double> v = column({2, -1, 0.5});
    const Sequence sequence =
        model("P0 of rank 1", identity(3), none(3), column({1, 2, 3}), v * v.transpose());
    return exactSensor(sequence, rows({{1, 0.5, 2}}), false, sequence.x0 + 1.5 * v, 40, seed,
                       [](int t) { return t == 0; });
}

std::vector<Case> cases(std::uint64_t seed)
{
    const Matrix<double> H =
        rows({{1.25, -0.5, 0.75}, {0.5, 2, -1}, {-1.5, 0.25, 1}, {2.75, 0.25, 1.5}});
    return {arma(0, seed),
            arma(0.2, seed),
            twins(level("level, twin"), false, seed),
            twins(level("level, twin"), true, seed),
            twins(movingTarget("moving target, twin"), false, seed),
            twins(movingTarget("moving target, twin"), true, seed),
            exactAndNoisyTwin(true, seed),
            exactAndNoisyTwin(false, seed),
            twins(acceleratedTarget("accelerated target, twin"), false, seed),
            sums({0, 1, 2}, false, 4, seed),
            sums({0, 1, 2}, true, 4, seed),
            sums({2, 0, 1}, false, 4, seed),
            sums({2, 0, 1}, true, 4, seed),
            sums({0, 1, 2}, false, 2, seed),
            knownStart(seed),
            knownForever(),
            blindSensor(false, seed),
            blindSensor(true, seed),
            constantState("constant, one combination", H.topRows(1), false, true, seed),
            constantState("constant, one and a noisy one", H.topRows(1), true, true, seed),
            constantState("constant, two combinations", H.topRows(2), false, true, seed),
            constantState("constant, two and a noisy one", H.topRows(2), true, true, seed),
            constantState("constant, three combinations", H.topRows(3), false, false, seed),
            constantState("constant, four combinations", H, false, false, seed),
            straightLineOfPoints(seed),
            singularPrior(seed)};
}

// ------------------------------------------------------------------ errors

struct Figures : Soundness {
    Worst filtered, smoothed;
    bool rankIsRight = true; // as many taken in every step as there should be
    unsigned events = 0;
};

template <class T> Vector<Quad> units(const Matrix<Quad> &P, const Matrix<Quad> &unmeasured)
{
    constexpr double floor = 16 * static_cast<double>(std::numeric_limits<T>::epsilon());
    const Vector<Quad> sigma = sigmas(P, unmeasured, floor);
    return positiveOr(sigma, Quad(knownUnit));
}

template <class T> Figures runLibrary(const Case &data, const BrysonFrazier &reference)
{
    Figures figures;
    const Estimates<double> mine = estimates<T>(data.sequence);
    const std::vector<Smoothed<Quad>> past = reference.smooth();
    figures.events = mine.events;
    for (std::size_t t = 0; t < past.size(); ++t) {
        const auto expected = std::count(data.taken[t].begin(), data.taken[t].end(), true);
        const int taken = std::accumulate(mine.taken[t].begin(), mine.taken[t].end(), 0);
        figures.rankIsRight = figures.rankIsRight && taken == static_cast<int>(expected);
        const auto compare = [&](Worst &worst, const Belief<double> &belief, const Belief<Quad> &exact) {
            worst.add(belief, exact, units<T>(exact.covariance, reference.unmeasured()[t]));
            figures.inspectSound(belief);
        };
        compare(figures.filtered, mine.filtered[t], reference.track()[t].filtered);
        compare(figures.smoothed, mine.past[t].belief, past[t].belief);
    }
    return figures;
}

// ------------------------------------------------------------------ checks

bool hasRedundancy(const Case &data)
{
    return std::any_of(data.taken.begin(), data.taken.end(), [](const std::vector<bool> &taken) {
        return std::find(taken.begin(), taken.end(), false) != taken.end();
    });
}

bool isLimitedByFloat(const Case &data)
{
    return data.sequence.name == "accelerated target, twin, in one call" ||
           data.sequence.name == "h3 = h1 + h2, in one call, 2 noises";
}

void check(Verdict &verdict, const Case &data, const Figures &figures, const std::string &name,
           double goal, double limit)
{
    verdict.expect(figures.sound, name + ": a NaN or a negative variance");
    verdict.expectGoal(figures.filtered.x, goal, limit, name + ": filtered x");
    verdict.expectAtMost(figures.filtered.P, goal, name + ": filtered P");
    verdict.expectGoal(figures.smoothed.x, goal, limit, name + ": smoothed x");
    verdict.expectAtMost(figures.smoothed.P, goal, name + ": smoothed P");
    verdict.expect((figures.events & ~unsigned{KQ_EVENT_REDUNDANT}) == 0, name + ": a wrong event");
    if (!data.sharp) return;
    const bool floor = (figures.events & KQ_EVENT_REDUNDANT) != 0;
    verdict.expect(floor == hasRedundancy(data), name + ": KQ_EVENT_REDUNDANT is wrong");
    verdict.expect(figures.rankIsRight, name + ": not as many taken as there should be");
}

void testCase(Verdict &verdict, const Case &data)
{
    const BrysonFrazier reference(data.sequence, data.taken);
    const Figures f32 = runLibrary<float>(data, reference);
    const Figures f64 = runLibrary<double>(data, reference);
    std::printf("%-38s %7.1e %7.1e  %7.1e %7.1e   %7.1e %7.1e  %7.1e %7.1e\n",
                data.sequence.name.c_str(), f32.filtered.x, f32.filtered.P, f32.smoothed.x,
                f32.smoothed.P, f64.filtered.x, f64.filtered.P, f64.smoothed.x, f64.smoothed.P);
    check(verdict, data, f32, data.sequence.name + ", f32", floatGoal,
          isLimitedByFloat(data) ? floatLimit : 0);
    check(verdict, data, f64, data.sequence.name + ", f64", doubleGoal, 0);
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    std::printf("%-38s %-34s  %s\n", "", "f32: filter, smoother", "f64: filter, smoother");
    std::printf("%-38s %7s %7s  %7s %7s   %7s %7s  %7s %7s\n", "R = 0", "x", "P", "x", "P", "x",
                "P", "x", "P");
    Verdict verdict;
    for (const Case &data : cases(seed)) testCase(verdict, data);
    return verdict.finish();
}
