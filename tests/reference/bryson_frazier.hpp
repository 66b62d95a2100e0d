// The smoother without an inverse (modified Bryson and Frazier; Bierman 1977): the adjoint of the
// filter run backwards.  The reference where P- may be singular: noise-free sensors, a singular
// Q, P0 or A.
//
//     filtered   x_s = x + P lambda                 P_s = P - P Lambda P
//     update     lambda <- h e / s + J' lambda      Lambda <- h h'/ s + J' Lambda J,  J = I - K h'
//     predict    lambda <- A' lambda                Lambda <- A' Lambda A
//
// It takes one scalar measurement after the other, so R has to be diagonal.  Which of them are
// redundant (no noise, and known already) is for the caller to say: that is a matter of rank, and
// the pseudo-inverse skips them.  One that is redundant in this arithmetic too is skipped anyway.
#ifndef KALMANQ_TESTS_REFERENCE_BRYSON_FRAZIER_HPP
#define KALMANQ_TESTS_REFERENCE_BRYSON_FRAZIER_HPP

#include <cstddef>
#include <utility>
#include <vector>

#include "textbook.hpp"

namespace reference
{

/// taken[t][k]: whether scalar measurement k of step t is taken, over the components present in
/// the order of the readings.  An empty list takes all of them.
using Taken = std::vector<std::vector<bool>>;

template <class Real> class BrysonFrazier
{
  public:
    BrysonFrazier(const Sequence &sequence, const Taken &taken = {})
        : sequence_(sequence), model_(sequence)
    {
        Belief<Real> belief{convert<Real>(sequence.x0), convert<Real>(sequence.P0)};
        Belief<Real> unmeasured = belief;
        for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
            const Step &step = sequence.steps[t];
            Track<Real> now;
            now.predicted = belief;
            corrections_.emplace_back();
            unmeasured_.push_back(unmeasured.covariance);
            update(belief, step, taken.empty() ? std::vector<bool>() : taken[t]);
            now.filtered = belief;
            track_.push_back(now);
            predict(belief, step);
            predict(unmeasured, step);
        }
    }

    /// Predicted and filtered, one entry a step; `updates` is not used.
    const std::vector<Track<Real>> &track() const { return track_; }

    /// Belief and lag-one covariance; the noises are not used.
    std::vector<Smoothed<Real>> smooth() const
    {
        const Eigen::Index n = sequence_.states();
        Adjoint adjoint{Vector<Real>::Zero(n), Matrix<Real>::Zero(n, n)};
        std::vector<Smoothed<Real>> past(track_.size());
        for (std::size_t t = track_.size(); t-- > 0;) {
            past[t].belief = smoothed(track_[t].filtered, adjoint);
            for (std::size_t k = corrections_[t].size(); k-- > 0;) {
                undoUpdate(adjoint, corrections_[t][k]);
            }
            if (t > 0) past[t - 1].lagOne = undoPredict(adjoint, t);
        }
        return past;
    }

    /// The covariance of each step if nothing were ever measured.
    const std::vector<Matrix<Real>> &unmeasured() const { return unmeasured_; }

    /// Of every scalar measurement, taken or not, in the order of `Taken`: its innovation variance
    /// as a share of the largest that it could have if nothing had been measured.
    const std::vector<std::vector<double>> &information() const { return information_; }

  private:
    /// The share below which the rounding of quadruple precision may have made it up.
    static constexpr double redundant = 1e-30;

    struct Correction {
        Vector<Real> h, K;
        Real e, s;
    };

    struct Adjoint {
        Vector<Real> lambda;
        Matrix<Real> Lambda;
    };

    void predict(Belief<Real> &belief, const Step &step) const
    {
        reference::predict(belief, model_.A[step.process], model_.Q[step.process],
                           model_.drive(step));
    }

    void update(Belief<Real> &belief, const Step &step, const std::vector<bool> &taken)
    {
        const Vector<Real> reach = unmeasured_.back().diagonal().cwiseSqrt();
        information_.emplace_back();
        std::size_t k = 0;
        for (const Reading &reading : step.readings) {
            for (const Eigen::Index c : presentComponents(reading)) {
                const Vector<Real> h = model_.H[reading.sensor].row(c).transpose();
                const Real r = model_.R[reading.sensor](c, c);
                const Real s = h.dot(belief.covariance * h) + r;
                information_.back().push_back(share(s, h, reach, r));
                const bool isRedundant = r == Real(0) && information_.back().back() <= redundant;
                const bool isTaken = taken.empty() || taken[k++];
                if (isTaken && !isRedundant) correct(belief, h, r, Real(reading.z(c)), s);
            }
        }
    }

    /// s as a share of the largest that sigma allows.
    static double share(const Real &s, const Vector<Real> &h, const Vector<Real> &sigma,
                        const Real &r)
    {
        const Real span = h.cwiseAbs().dot(sigma);
        const Real most = span * span + r;
        return most > Real(0) ? static_cast<double>(s / most) : 0;
    }

    void correct(Belief<Real> &belief, const Vector<Real> &h, const Real &r, const Real &z,
                 const Real &s)
    {
        const Eigen::Index n = belief.mean.size();
        const Vector<Real> K = belief.covariance * h / s;
        const Real e = z - h.dot(belief.mean);
        const Matrix<Real> J = Matrix<Real>::Identity(n, n) - K * h.transpose();
        belief.mean += K * e;
        belief.covariance =
            symmetric<Real>(J * belief.covariance * J.transpose() + r * K * K.transpose());
        corrections_.back().push_back({h, K, e, s});
    }

    static Belief<Real> smoothed(const Belief<Real> &filtered, const Adjoint &adjoint)
    {
        const Matrix<Real> &P = filtered.covariance;
        return {filtered.mean + P * adjoint.lambda, symmetric<Real>(P - P * adjoint.Lambda * P)};
    }

    static void undoUpdate(Adjoint &adjoint, const Correction &done)
    {
        const Vector<Real> &h = done.h;
        const Eigen::Index n = h.size();
        const Matrix<Real> J = Matrix<Real>::Identity(n, n) - done.K * h.transpose();
        adjoint.lambda = (h * (done.e / done.s) + J.transpose() * adjoint.lambda).eval();
        adjoint.Lambda =
            symmetric<Real>(h * h.transpose() / done.s + J.transpose() * adjoint.Lambda * J);
    }

    /// From the predicted coordinates of step t to the filtered ones of step t - 1;
    /// Cov(x[t], x[t-1] | T) = (I - P- Lambda) A P.
    Matrix<Real> undoPredict(Adjoint &adjoint, std::size_t t) const
    {
        const Eigen::Index n = sequence_.states();
        const Matrix<Real> &A = model_.A[sequence_.steps[t - 1].process];
        const Matrix<Real> rest =
            Matrix<Real>::Identity(n, n) - track_[t].predicted.covariance * adjoint.Lambda;
        const Matrix<Real> lagOne = rest * A * track_[t - 1].filtered.covariance;
        adjoint.lambda = (A.transpose() * adjoint.lambda).eval();
        adjoint.Lambda = symmetric<Real>(A.transpose() * adjoint.Lambda * A);
        return lagOne;
    }

    const Sequence &sequence_;
    Model<Real> model_;
    std::vector<Track<Real>> track_;
    std::vector<Matrix<Real>> unmeasured_;
    std::vector<std::vector<Correction>> corrections_;
    std::vector<std::vector<double>> information_;
};

} // namespace reference

#endif
