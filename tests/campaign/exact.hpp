// The textbook filter and smoother in __float128, on plain arrays: what an arithmetic is judged by.
//
//     Exact exact = run(inputs);                  predict, update: the covariance form
//     run(inputs, &rounding)                      the same with roundings of a stated size
//
// The update takes decorrelated scalar measurements one after the other, in the library's order,
// so that where noise-free components say the same both leave out the same one.  The smoother is
// that of Bryson and Frazier, which inverts no covariance: a singular one is nothing special.
//
//     back through an update    l <- (I - K h)' l + h' e / s,  L <- (I - K h)' L (I - K h) + h'h/s
//     back through a predict    l <- A' l,  L <- A' L A
//     x_t|T = x + P l     P_t|T = P - P L P     Cov(x_t+1, x_t | T) = (I - P- L) A P
#ifndef KALMANQ_TESTS_CAMPAIGN_EXACT_HPP
#define KALMANQ_TESTS_CAMPAIGN_EXACT_HPP

#include <quadmath.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "arrays.hpp"

namespace campaign
{

// ------------------------------------------------------------------ what an arithmetic is given

struct Process {
    Mat A, Q;
};

/// z = H x + v; H by rows.
struct Sensor {
    int components;
    Mat H, R;
    Vec grain; // what an innovation is rounded to, 0 in floating point
};

/// One call of an update.
struct Reading {
    std::size_t sensor;
    std::uint32_t present;
    Vec z;
};

struct Moment {
    std::vector<Reading> readings;
    Vec drive; // B u of the move to the next step
};

struct Inputs {
    int n;
    Vec x0;
    Mat P0;
    Process process;
    std::vector<Sensor> sensors;
    std::vector<Moment> moments;
};

// ------------------------------------------------------------------ what comes of it

struct Belief {
    Vec mean;
    Mat covariance;
};

/// One decorrelated component.
struct Scalar {
    Vec h, gain;
    Real variance, innovation, grain;
    bool taken;
};

struct Update {
    std::vector<Scalar> scalars;
    Real nis = 0, logLikelihood = 0;
    int taken = 0;
    Vec mean{}; // after it
};

/// Those that show means alone or work on line: of all states, of a fixed lag, of a fixed point.
constexpr int smoothers = 3;

struct Instant {
    Belief predicted, filtered, smoothed;
    std::array<Vec, smoothers> alone; // where `told` has its bit, of an arithmetic
    unsigned told = 0;
    Mat lagOne; // Cov(x[t+1], x[t] | T)
    std::vector<Update> updates;
};

using Exact = std::vector<Instant>;

// ------------------------------------------------------------------ filter

/// What disturbs a run where an arithmetic rounds.  Does nothing by itself.
class Rounding
{
  public:
    virtual ~Rounding() = default;
    virtual void noise(Mat & /*R*/, int /*m*/) {}
    virtual void start(Belief & /*belief*/) {}
    virtual void predicted(Belief & /*belief*/, const Belief & /*before*/, const Moment & /*move*/)
    {
    }
    virtual void innovation(Scalar & /*scalar*/, const Vec & /*x*/) {}
    /// Noise that a measurement has beside its own.
    virtual Real leastNoise(const Vec & /*h*/, Real /*r*/) { return 0; }
    virtual void updated(Belief & /*belief*/, const Belief & /*before*/) {}
};

/// Rows of U^-1 H, U^-1 (z - H x), and D, of R = U D U' over the components present.
struct Decorrelated {
    int m = 0;
    Mat H{};
    Vec z{}, variance{}, grain{};
};

inline Decorrelated decorrelate(const Sensor &sensor, const Reading &reading, int n)
{
    Decorrelated result;
    std::array<int, maxComponents> chosen{};
    for (int c = 0; c < sensor.components; ++c) {
        if (reading.present >> c & 1) chosen[result.m++] = c;
    }
    Mat rest{};
    for (int a = 0; a < result.m; ++a) {
        result.H[a] = sensor.H[chosen[a]];
        result.z[a] = reading.z[chosen[a]];
        result.grain[a] = sensor.grain[chosen[a]];
        for (int b = 0; b < result.m; ++b) rest[a][b] = sensor.R[chosen[a]][chosen[b]];
    }
    for (int j = result.m - 1; j >= 0; --j) {
        const bool open = rest[j][j] > redundant * sensor.R[chosen[j]][chosen[j]];
        result.variance[j] = open ? rest[j][j] : Real(0);
        for (int i = 0; i < j && open; ++i) {
            const Real u = rest[i][j] / rest[j][j];
            for (int k = 0; k < n; ++k) result.H[i][k] -= u * result.H[j][k];
            result.z[i] -= u * result.z[j];
            result.grain[i] += fabsq(u) * result.grain[j];
            for (int k = 0; k <= i; ++k) rest[i][k] = rest[k][i] = rest[i][k] - u * rest[k][j];
        }
    }
    return result;
}

/// x, P by one scalar measurement.
inline void take(Belief &belief, Scalar &scalar, Real r, int n, Rounding &rounding)
{
    const Vec b = times(belief.covariance, scalar.h, n);
    Real terms = r;
    for (int k = 0; k < n; ++k) {
        const Real part = fabsq(scalar.h[k]) * sigma(belief.covariance, k);
        terms += part * part;
    }
    scalar.variance = dot(scalar.h, b, n) + r;
    scalar.taken = scalar.variance > redundant * terms;
    if (!scalar.taken) return;
    scalar.variance += rounding.leastNoise(scalar.h, r);
    for (int i = 0; i < n; ++i) scalar.gain[i] = b[i] / scalar.variance;
    for (int i = 0; i < n; ++i) {
        belief.mean[i] += scalar.gain[i] * scalar.innovation;
        for (int j = 0; j <= i; ++j) {
            belief.covariance[i][j] -= scalar.gain[i] * b[j];
            belief.covariance[j][i] = belief.covariance[i][j];
        }
    }
}

inline Update update(Belief &belief, const Sensor &sensor, const Reading &reading, int n,
                     Rounding &rounding)
{
    Update result;
    const Decorrelated seen = decorrelate(sensor, reading, n);
    const Real logTwoPi = logq(2 * acosq(-1));
    for (int c = 0; c < seen.m; ++c) {
        const Belief before = belief;
        Scalar scalar{seen.H[c], {}, 0, 0, seen.grain[c], false};
        scalar.innovation = seen.z[c] - dot(scalar.h, belief.mean, n);
        rounding.innovation(scalar, belief.mean);
        take(belief, scalar, seen.variance[c], n, rounding);
        if (scalar.taken) {
            const Real nis = scalar.innovation * scalar.innovation / scalar.variance;
            result.nis += nis;
            result.logLikelihood -= (logTwoPi + logq(scalar.variance) + nis) / 2;
            ++result.taken;
            rounding.updated(belief, before);
        }
        result.scalars.push_back(scalar);
    }
    result.mean = belief.mean;
    return result;
}

inline void filter(Exact &exact, const Inputs &inputs, Rounding &rounding)
{
    const int n = inputs.n;
    std::vector<Sensor> sensors = inputs.sensors;
    for (Sensor &sensor : sensors) rounding.noise(sensor.R, sensor.components);
    Belief belief{inputs.x0, inputs.P0};
    rounding.start(belief);
    for (const Moment &moment : inputs.moments) {
        Instant now;
        now.predicted = belief;
        for (const Reading &reading : moment.readings) {
            now.updates.push_back(update(belief, sensors[reading.sensor], reading, n, rounding));
        }
        now.filtered = belief;
        exact.push_back(now);
        belief.mean = times(inputs.process.A, now.filtered.mean, n);
        belief.covariance = plus(sandwich(inputs.process.A, now.filtered.covariance, n),
                                 inputs.process.Q, n);
        for (int i = 0; i < n; ++i) belief.mean[i] += moment.drive[i];
        rounding.predicted(belief, now.filtered, moment);
    }
}

// ------------------------------------------------------------------ smoother

/// What the later data say of the state.
struct Adjoint {
    Vec gradient{};
    Mat information{};
};

inline void backThrough(Adjoint &later, const Scalar &scalar, int n)
{
    if (!scalar.taken) return;
    const Vec lk = times(later.information, scalar.gain, n);
    const Real klk = dot(scalar.gain, lk, n) + 1 / scalar.variance;
    const Real kg = dot(scalar.gain, later.gradient, n) - scalar.innovation / scalar.variance;
    for (int i = 0; i < n; ++i) {
        later.gradient[i] -= scalar.h[i] * kg;
        for (int j = 0; j <= i; ++j) {
            later.information[i][j] += klk * scalar.h[i] * scalar.h[j] - scalar.h[i] * lk[j] -
                                       lk[i] * scalar.h[j];
            later.information[j][i] = later.information[i][j];
        }
    }
}

/// (I - P- L) A P, `later` as seen from after the predict.
inline Mat lagOne(const Instant &now, const Mat &predicted, const Adjoint &later, const Mat &A,
                  int n)
{
    Mat rest = times(predicted, later.information, n);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) rest[i][j] = (i == j ? Real(1) : Real(0)) - rest[i][j];
    }
    return times(rest, times(A, now.filtered.covariance, n), n);
}

inline void smooth(Exact &exact, const Inputs &inputs)
{
    const int n = inputs.n;
    const Mat &A = inputs.process.A;
    const Mat back = transposed(A, n);
    Adjoint later;
    for (std::size_t t = exact.size(); t-- > 0;) {
        Instant &now = exact[t];
        if (t + 1 < exact.size()) {
            now.lagOne = lagOne(now, exact[t + 1].predicted.covariance, later, A, n);
            later.gradient = transposedTimes(A, later.gradient, n);
            later.information = sandwich(back, later.information, n);
        }
        const Mat &P = now.filtered.covariance;
        const Vec moved = times(P, later.gradient, n);
        const Mat gained = sandwich(P, later.information, n);
        for (int i = 0; i < n; ++i) {
            now.smoothed.mean[i] = now.filtered.mean[i] + moved[i];
            for (int j = 0; j < n; ++j) now.smoothed.covariance[i][j] = P[i][j] - gained[i][j];
        }
        for (std::size_t u = now.updates.size(); u-- > 0;) {
            const std::vector<Scalar> &scalars = now.updates[u].scalars;
            for (std::size_t c = scalars.size(); c-- > 0;) backThrough(later, scalars[c], n);
        }
    }
}

inline Exact run(const Inputs &inputs, Rounding &rounding)
{
    Exact exact;
    filter(exact, inputs, rounding);
    smooth(exact, inputs);
    return exact;
}

inline Exact run(const Inputs &inputs)
{
    Rounding none;
    return run(inputs, none);
}

} // namespace campaign

#endif
