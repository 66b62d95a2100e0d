// The textbook filter and smoother in __float128, on plain loops: what an arithmetic is judged by.
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

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "../reference/textbook.hpp"
#include "arrays.hpp"

namespace campaign
{

using reference::Reading;
using reference::Step;
using Belief = reference::Belief<Real>;

/// What an arithmetic is given, as it holds it
struct Inputs {
    Vec x0;
    Mat P0;
    reference::Model<Real> model;
    std::vector<Vec> grain; // what an innovation of each sensor is rounded to, 0 in floating point
    std::vector<Step> steps;

    int n() const { return static_cast<int>(x0.size()); }
    /// Of the move from step t to the next
    const Mat &A(std::size_t t) const { return model.A[steps[t].process]; }
    const Mat &Q(std::size_t t) const { return model.Q[steps[t].process]; }
};

// ------------------------------------------------------------------ what comes of it

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
    Vec mean; // after it
};

/// What shows a state: the filter, a history; the means of one alone, a fixed lag, a fixed point, a lag for late measurements
enum View { ofFilter, ofHistory, ofMeans, ofLag, ofInstant, ofDelay, views };
const char *const viewNames[] = {"filter", "history", "means", "lag", "instant", "delay"};

struct Instant {
    Belief predicted, filtered, smoothed;
    std::array<Belief, views - ofMeans> others; // of an arithmetic; empty where they do not show this instant
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
    virtual void noise(Mat & /*R*/) {}
    virtual void start(Belief & /*belief*/) {}
    virtual void predicted(Belief & /*belief*/, const Belief & /*before*/, std::size_t /*t*/) {}
    virtual void innovation(Scalar & /*scalar*/, const Vec & /*x*/) {}
    /// Noise that a measurement has beside its own.
    virtual Real leastNoise(const Vec & /*h*/, Real /*r*/) { return 0; }
    /// Is a component taken, where the textbook by itself would or would not?
    virtual bool takes(bool itself) { return itself; }
    virtual void updated(Belief & /*belief*/, const Belief & /*before*/) {}
};

/// Takes what an arithmetic has taken: with sensors of one component, what is redundant to it is for its filter to say.
class AsTaken : public Rounding
{
  public:
    AsTaken(const Inputs &inputs, const Exact &found)
    {
        for (std::size_t t = 0; t < found.size(); ++t) {
            for (std::size_t k = 0; k < found[t].updates.size(); ++k) {
                if (inputs.steps[t].readings[k].present != 0) taken_.push_back(found[t].updates[k].taken != 0);
            }
        }
    }

    bool takes(bool itself) override { return taken_.at(next_++) && itself; }

  private:
    std::vector<bool> taken_;
    std::size_t next_ = 0;
};

/// Rows of U^-1 H, U^-1 (z - H x), and D, of R = U D U' over the components present.
struct Decorrelated {
    Mat H;
    Vec z, variance, grain;
};

inline Decorrelated decorrelate(const Inputs &inputs, const Reading &reading)
{
    const reference::Observation<Real> seen(inputs.model, reading);
    Decorrelated result{
        seen.H, seen.z, Vec::Zero(seen.z.size()),
        inputs.grain[reading.sensor].chooseRows(reference::presentComponents(reading))};
    Mat rest = seen.R;
    for (Index j = rest.rows() - 1; j >= 0; --j) {
        if (!(rest(j, j) > redundant * seen.R(j, j))) continue;
        result.variance(j) = rest(j, j);
        for (Index i = 0; i < j; ++i) {
            const Real u = rest(i, j) / rest(j, j);
            result.H.row(i) -= u * result.H.row(j);
            result.z(i) -= u * result.z(j);
            result.grain(i) += abs(u) * result.grain(j);
            for (Index k = 0; k <= i; ++k) rest(i, k) = rest(k, i) = rest(i, k) - u * rest(k, j);
        }
    }
    return result;
}

/// x, P by one scalar measurement.
inline void take(Belief &belief, Scalar &scalar, const Real &r, Rounding &rounding)
{
    Mat &P = belief.covariance;
    const Vec b = P * scalar.h;
    Real terms = r;
    for (Index k = 0; k < b.size(); ++k) {
        const Real part = scalar.h(k) * sigma(P, k);
        terms += part * part;
    }
    scalar.variance = scalar.h.dot(b) + r;
    scalar.taken = rounding.takes(scalar.variance > redundant * terms);
    if (!scalar.taken) return;
    scalar.variance += rounding.leastNoise(scalar.h, r);
    scalar.gain = b / scalar.variance;
    belief.mean += scalar.gain * scalar.innovation;
    for (Index i = 0; i < b.size(); ++i) {
        for (Index j = 0; j <= i; ++j) P(i, j) = P(j, i) = P(i, j) - scalar.gain(i) * b(j);
    }
}

inline Update update(Belief &belief, const Inputs &inputs, const Reading &reading,
                     Rounding &rounding)
{
    Update result;
    const Decorrelated seen = decorrelate(inputs, reading);
    const Real logTwoPi = log(Real(2) * reference::pi<Real>());
    for (Index c = 0; c < seen.z.size(); ++c) {
        const Belief before = belief;
        Scalar scalar{seen.H.row(c).transpose(), {}, 0, 0, seen.grain(c), false};
        scalar.innovation = seen.z(c) - scalar.h.dot(belief.mean);
        rounding.innovation(scalar, belief.mean);
        take(belief, scalar, seen.variance(c), rounding);
        if (scalar.taken) {
            const Real nis = scalar.innovation * scalar.innovation / scalar.variance;
            result.nis += nis;
            result.logLikelihood -= (logTwoPi + log(scalar.variance) + nis) / Real(2);
            ++result.taken;
            rounding.updated(belief, before);
        }
        result.scalars.push_back(scalar);
    }
    result.mean = belief.mean;
    return result;
}

inline void filter(Exact &exact, Inputs inputs, Rounding &rounding)
{
    for (Mat &R : inputs.model.R) rounding.noise(R);
    Belief belief{inputs.x0, inputs.P0};
    rounding.start(belief);
    for (std::size_t t = 0; t < inputs.steps.size(); ++t) {
        const Step &step = inputs.steps[t];
        Instant now;
        now.predicted = belief;
        for (const Reading &reading : step.readings) {
            now.updates.push_back(update(belief, inputs, reading, rounding));
        }
        now.filtered = belief;
        const Mat &A = inputs.A(t);
        belief = {A * belief.mean + inputs.model.drive(step), sandwich(A, belief.covariance) + inputs.Q(t)};
        rounding.predicted(belief, now.filtered, t);
        exact.push_back(now);
    }
}

// ------------------------------------------------------------------ smoother

/// What the later data say of the state.
struct Adjoint {
    Vec gradient;
    Mat information;
};

inline void backThrough(Adjoint &later, const Scalar &scalar)
{
    if (!scalar.taken) return;
    const Vec lk = later.information * scalar.gain;
    const Real klk = scalar.gain.dot(lk) + Real(1) / scalar.variance;
    const Real kg = scalar.gain.dot(later.gradient) - scalar.innovation / scalar.variance;
    const Vec &h = scalar.h;
    later.gradient -= h * kg;
    for (Index i = 0; i < h.size(); ++i) {
        for (Index j = 0; j <= i; ++j) {
            later.information(i, j) += klk * h(i) * h(j) - h(i) * lk(j) - lk(i) * h(j);
            later.information(j, i) = later.information(i, j);
        }
    }
}

inline void smooth(Exact &exact, const Inputs &inputs)
{
    const Index n = inputs.n();
    Adjoint later{Vec::Zero(n), Mat::Zero(n, n)};
    for (std::size_t t = exact.size(); t-- > 0;) {
        Instant &now = exact[t];
        const Mat &P = now.filtered.covariance;
        if (t + 1 < exact.size()) {
            const Mat &predicted = exact[t + 1].predicted.covariance, &A = inputs.A(t), back = A.transpose();
            now.lagOne = (Mat::Identity(n, n) - predicted * later.information) * (A * P);
            later = {back * later.gradient, sandwich(back, later.information)};
        }
        now.smoothed = {now.filtered.mean + P * later.gradient, P - sandwich(P, later.information)};
        for (std::size_t u = now.updates.size(); u-- > 0;) {
            const std::vector<Scalar> &scalars = now.updates[u].scalars;
            for (std::size_t c = scalars.size(); c-- > 0;) backThrough(later, scalars[c]);
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

/// look(component, the variance that it would have if nothing were measured)
template <class Look> void eachComponent(const Inputs &inputs, const Exact &exact, const Look &look)
{
    Mat open = inputs.P0;
    for (std::size_t t = 0; t < exact.size(); ++t) {
        for (const Update &update : exact[t].updates) {
            for (const Scalar &scalar : update.scalars) {
                Real terms = 0;
                for (Index k = 0; k < inputs.n(); ++k) {
                    const Real part = scalar.h(k) * sigma(open, k);
                    terms += part * part;
                }
                look(scalar, terms);
            }
        }
        open = sandwich(inputs.A(t), open) + inputs.Q(t);
    }
}

/// Does every measurement say what __float128 can tell from its own rounding, or nothing?
inline bool isResolved(const Inputs &inputs, const Exact &exact)
{
    bool all = true;
    eachComponent(inputs, exact, [&all](const Scalar &scalar, const Real &open) {
        all = all && !(scalar.taken && scalar.variance < Real(1e-20) * open);
    });
    return all;
}

/// Is a component left out that has more than this share of the variance that it would have if nothing were measured?
inline bool leavesOut(const Inputs &inputs, const Exact &exact, double share)
{
    bool any = false;
    eachComponent(inputs, exact, [&](const Scalar &scalar, const Real &open) {
        any = any || (!scalar.taken && scalar.variance > share * open);
    });
    return any;
}

} // namespace campaign

#endif
