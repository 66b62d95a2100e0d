// The smoother on fifteen models, 400 steps with a fifth of the measurements missing, against
// an inverse-free smoother in quadruple precision.
//
// x in sigma, P and lag-one covariance without units, the largest over time.  P has to be positive
// semi-definite and never above the filtered one.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "accuracy.hpp"
#include "bryson_frazier.hpp"
#include "library_run.hpp"
#include "numerics_models.hpp"
#include "verdict.hpp"

using namespace reference;

namespace
{

constexpr std::size_t stepCount = 400;
constexpr Mode gaps = {"20 % missing", 0.2, false};
constexpr double meanGoal = 1e-4, covarianceGoal = 1e-5, doubleGoal = 1e-9;
constexpr double noiseFreeDoubleGoal = 1e-8;
constexpr double fixedGoal = 1e-5; // q31: x, P and lag one
/// Two references that share nothing but the data agree to this; where P falls by 22 decades,
/// quadruple precision is left with 12 digits.
constexpr double referenceGoal = 1e-12, illConditionedReferenceGoal = 1e-10;
/// The unit of a state that is known exactly: the library's process noise has a standard
/// deviation of at least 2^-60 in every state and step.
constexpr double knownUnit = 0x1p-40;

/// What 24 bits allow where the goals are out of reach.  A root of P that is stored in floats,
/// all arithmetic in double, is as far off where P changes slowly (IMU, seasons, regression);
/// where sigma falls by 1e7 in the smoother, one rounding of the filter's is the smoother's all.
struct FloatLimit {
    const char *model;
    double x, P;
};

constexpr FloatLimit floatLimits[] = {
    {"n9 m3 IMU bias", 5e-4, 1e-4},   {"n3 near-singular", 5e-4, 1e-4},
    {"n2 Q=0", 5e-4, 1e-4},           {"n2 P 1e6 -> 2e-9", 2, 40},
    {"n5 line+season", 5e-4, 1e-4},   {"n5 trend+season", 5e-4, 1e-4},
    {"n7 trend+season", 5e-4, 1e-4},  {"n3 regression Q=0", 5e-4, 1e-4},
    {"n2 ARMA(2,1) R=0", 5e-4, 1e-5},
};

/// What a row's 30 bits allow in q31, of seeds 1 to 6: 2.8e-5 of x where a season's P changes slowly,
/// 3.3e-2 of P where sigma falls by 2e7.
constexpr FloatLimit fixedLimits[] = {
    {"n5 line+season", 5e-5, 0}, {"n2 P 1e6 -> 2e-9", 0, 5e-2},
};

template <std::size_t count>
FloatLimit limitOf(const FloatLimit (&limits)[count], const std::string &name)
{
    for (const FloatLimit &limit : limits) {
        if (name.rfind(limit.model, 0) == 0) return limit;
    }
    return {"", 0, 0};
}

enum class Kind {
    plain,
    illConditioned, // a covariance that double cannot hold to 1e-9
    noiseFree,      // R = 0: the reference by inverses breaks down, sigma may be 0
};

struct Case {
    Kind kind;
    Sequence sequence;
};

// ------------------------------------------------------------------ models of its own

/// The third state is known from the start and stays as it is.
NumericsModel knownConstant()
{
    NumericsModel model =
        makeModel("n3 singular P-", rows({{1, 0.1, 0.005}, {0, 1, 0.1}, {0, 0, 1}}),
                  rows({{0.005}, {0.1}, {0}}), unitRow(3, 0), column({0.01}), column({100, 100, 0}),
                  column({16384, 512, 1}), column({16384}));
    model.x0(2) = 0.5;
    return model;
}

/// Observed without noise: what is not known decays with the root of the moving average.
NumericsModel arma()
{
    return makeModel("n2 ARMA(2,1) R=0", rows({{1.25, 1}, {-0.5, 0}}), rows({{1}, {0.375}}),
                     unitRow(2, 0), column({0}), column({8, 2}), column({64, 64}), column({64}));
}

/// Level, slope, and a season of `period`; noises of the level, the slope and the season.
NumericsModel trendAndSeason(Index period, double slopeNoise)
{
    const Index n = period + 1;
    Matrix<double> A = Matrix<double>::Zero(n, n), F = Matrix<double>::Zero(n, 3);
    A(0, 0) = A(0, 1) = A(1, 1) = 1;
    A.row(2).tail(period - 1).setConstant(-1);
    A.diagonal(-1).tail(period - 2).setConstant(1);
    F(0, 0) = 0.1;
    F(1, 1) = slopeNoise;
    F(2, 2) = 0.05;
    Matrix<double> H = Matrix<double>::Zero(1, n);
    H(0, 0) = H(0, 2) = 1;
    Vector<double> reach = Vector<double>::Constant(n, 512);
    reach(0) = 16384;
    return makeModel("n" + std::to_string(n) + (slopeNoise > 0 ? " trend+season" : " line+season"),
                     A, F, H, column({1}), Vector<double>::Constant(n, 100), reach,
                     column({16384}));
}

/// Constant coefficients of regressors that change at every step.
Sequence regression(std::uint64_t seed)
{
    const NumericsModel model =
        makeModel("n3 regression Q=0", Matrix<double>::Identity(3, 3), Matrix<double>(3, 0),
                  rows({{1, 0, 0}}), column({0.1}), Vector<double>::Constant(3, 100),
                  Vector<double>::Constant(3, 64), column({256}));
    Random random(seed);
    Sequence sequence{model.name, model.x0,   model.variances.asDiagonal(), {model.process}, {},
                      {},         model.reach};
    const Vector<double> x = trueStart(model, random);
    for (std::size_t t = 0; t < stepCount; ++t) {
        const double time = static_cast<double>(t) / stepCount;
        SensorModel sensor = model.sensor;
        sensor.H = rounded(rows({{1, time, std::cos(40 * time)}}));
        Reading reading = drawReading(model, gaps, sensor, x, random);
        reading.sensor = t;
        sequence.sensors.push_back(sensor);
        sequence.steps.push_back({{reading}, 0, Vector<double>()});
    }
    return sequence;
}

std::vector<Case> cases(std::uint64_t seed)
{
    const std::pair<Kind, NumericsModel> models[] = {{Kind::plain, localLevel()},
                                                     {Kind::plain, constantVelocity()},
                                                     {Kind::plain, constantAcceleration()},
                                                     {Kind::plain, planarVelocity()},
                                                     {Kind::plain, dense()},
                                                     {Kind::plain, inertialBias()},
                                                     {Kind::plain, straightLine()},
                                                     {Kind::illConditioned, nearlySingular()},
                                                     {Kind::illConditioned, fallingCovariance()},
                                                     {Kind::plain, knownConstant()},
                                                     {Kind::noiseFree, arma()},
                                                     {Kind::plain, trendAndSeason(4, 0.01)},
                                                     {Kind::plain, trendAndSeason(4, 0)},
                                                     {Kind::plain, trendAndSeason(6, 0.01)}};
    std::vector<Case> result;
    for (const auto &[kind, model] : models) {
        result.push_back({kind, simulate(model, gaps, stepCount, seed)});
    }
    result.push_back({Kind::plain, regression(seed)});
    return result;
}

// ------------------------------------------------------------------ errors

struct Figures : Worst, Soundness { // of the smoother
    Worst filter;
    double lagOne = 0;
    double reduction = 1; // smallest eigenvalue of filtered P - P
    unsigned events = 0;
};

/// What f32 calls nothing left beside the prior; q31 is measured in the same units.
template <class T> constexpr double unitEpsilon() { return kq::epsilon<T>(); }
template <> constexpr double unitEpsilon<Q31>() { return kq::epsilon<float>(); }

/// The reference and the units of its errors.
struct Exact {
    std::vector<Track<Quad>> track;
    std::vector<Smoothed<Quad>> past;

    explicit Exact(const Sequence &sequence)
    {
        const BrysonFrazier filtered(sequence);
        track = filtered.track();
        past = filtered.smooth();
    }

    /// Of a covariance P of step t.
    template <class T> Vector<Quad> sigma(const Matrix<Quad> &P, std::size_t t, Kind kind) const
    {
        const Matrix<Quad> &prior = track[t].predicted.covariance;
        const Vector<Quad> sigma =
            kind == Kind::noiseFree ? sigmas(P, prior, 16 * unitEpsilon<T>()) : sigmas(P);
        return positiveOr(sigma, Quad(knownUnit));
    }
};

template <class T> Figures runLibrary(const Case &data, const Exact &exact)
{
    Figures figures;
    const Estimates<Wide<T>> mine = estimates<T>(data.sequence);
    figures.events = mine.events;
    Vector<Quad> later; // sigma of the next step
    for (std::size_t t = mine.past.size(); t-- > 0;) {
        const Belief<Quad> &filtered = exact.track[t].filtered;
        figures.filter.add(mine.filtered[t], filtered, exact.sigma<T>(filtered.covariance, t, data.kind));
        const Belief<Wide<T>> &past = mine.past[t].belief;
        const Smoothed<Quad> &right = exact.past[t];
        const Vector<Quad> sigma = exact.sigma<T>(right.belief.covariance, t, data.kind);
        figures.add(past, right.belief, sigma);
        figures.inspect(past);
        const Matrix<Wide<T>> &before = mine.filtered[t].covariance;
        figures.reduction = std::min(figures.reduction, smallestEigenvalue(before - past.covariance, before));
        if (t + 1 < mine.past.size()) {
            figures.lagOne = std::max(figures.lagOne, covarianceError(mine.past[t].lagOne, right.lagOne, later, sigma));
        }
        later = sigma;
    }
    return figures;
}

// ------------------------------------------------------------------ checks

/// The reference beside textbook RTS in the same precision.
void checkReference(Verdict &verdict, const Case &data, const Exact &exact)
{
    const std::vector<Track<Quad>> track = filter<Quad>(data.sequence);
    const std::vector<Smoothed<Quad>> past = smooth(data.sequence, track);
    Worst worst;
    for (std::size_t t = 0; t < past.size(); ++t) {
        worst.add(exact.past[t].belief, past[t].belief, scale(past[t].belief.covariance));
    }
    verdict.expectAtMost(std::max(worst.x, worst.P),
                         data.kind == Kind::illConditioned ? illConditionedReferenceGoal
                                                           : referenceGoal,
                         data.sequence.name + ": two references differ");
}

void checkSound(Verdict &verdict, const Figures &figures, const std::string &name, double rounding)
{
    verdict.expect(figures.sound, name + ": a NaN or a negative variance");
    verdict.expect(figures.events == 0, name + ": an event was raised");
    verdict.expectAtLeast(figures.eigenvalue, -rounding, name + ": smallest eigenvalue of P");
    verdict.expectAtLeast(figures.reduction, -8 * rounding, name + ": P above the filtered one");
}

/// q31: an ill-conditioned covariance may be out of its reach too.  Then it has to be no worse than
/// f32, unless its own filter is.
void checkFixed(Verdict &verdict, const Figures &q31, const Figures &f32, Kind kind,
                const std::string &name)
{
    const bool hard = kind == Kind::illConditioned;
    const FloatLimit own = limitOf(fixedLimits, name);
    verdict.expectGoal(q31.x, fixedGoal, std::max(own.x, hard ? std::max(f32.x, q31.filter.x) : 0),
                       name + ", q31: error of x");
    verdict.expectGoal(q31.P, fixedGoal, std::max(own.P, hard ? std::max(f32.P, q31.filter.P) : 0),
                       name + ", q31: error of P");
    verdict.expectGoal(q31.lagOne, fixedGoal,
                       std::max(own.P, hard ? std::max(f32.lagOne, q31.filter.P) : 0),
                       name + ", q31: error of lag one");
}

void testCase(Verdict &verdict, const Case &data)
{
    const Exact exact(data.sequence);
    const Figures f32 = runLibrary<float>(data, exact), f64 = runLibrary<double>(data, exact),
                  q31 = runLibrary<Q31>(data, exact);
    const std::string &name = data.sequence.name;
    std::printf("%-34s %7.1e %7.1e %7.1e  %7.1e %7.1e %7.1e  %7.1e %7.1e %7.1e  %7.1e %7.1e  "
                "%8.1e %8.1e %8.1e %8.1e\n",
                name.c_str(), f32.x, f32.P, f32.lagOne, f64.x, f64.P, f64.lagOne, q31.x, q31.P,
                q31.lagOne, q31.filter.x, q31.filter.P, f32.eigenvalue, f32.reduction,
                q31.eigenvalue, q31.reduction);
    const Index n = data.sequence.states();
    checkSound(verdict, f32, name + ", f32", eigenvalueRounding<float>(n));
    checkSound(verdict, f64, name + ", f64", eigenvalueRounding<double>(n));
    checkSound(verdict, q31, name + ", q31", eigenvalueRounding<Q31>(n));
    const FloatLimit limit = limitOf(floatLimits, name);
    verdict.expectGoal(f32.x, meanGoal, limit.x, name + ", f32: error of x");
    verdict.expectGoal(f32.P, covarianceGoal, limit.P, name + ", f32: error of P");
    verdict.expectGoal(f32.lagOne, covarianceGoal, limit.P, name + ", f32: error of lag one");
    checkFixed(verdict, q31, f32, data.kind, name);
    if (data.kind != Kind::illConditioned) {
        verdict.expectAtMost(std::max({f64.x, f64.P, f64.lagOne}),
                             data.kind == Kind::noiseFree ? noiseFreeDoubleGoal : doubleGoal,
                             name + ", f64: error");
    }
    if (data.kind != Kind::noiseFree) checkReference(verdict, data, exact);
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    std::printf("%-34s %-23s  %-23s  %-23s  %-15s  %s\n", "", "f32", "f64", "q31", "q31: filter",
                "smallest eigenvalue, f32, q31");
    std::printf("%-34s %7s %7s %7s  %7s %7s %7s  %7s %7s %7s  %7s %7s  %8s %8s %8s %8s\n", "model",
                "x", "P", "lag one", "x", "P", "lag one", "x", "P", "lag one", "x", "P", "P",
                "Pf - P", "P", "Pf - P");
    Verdict verdict;
    for (const Case &data : cases(seed)) testCase(verdict, data);
    return verdict.finish();
}
