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
#include <vector>

#include "textbook.hpp"

namespace reference
{

/// taken[t][k]: whether scalar measurement k of step t is taken, over the components present in
/// the order of the readings.  An empty list takes all of them.
using Taken = std::vector<std::vector<bool>>;

class BrysonFrazier
{
  public:
    explicit BrysonFrazier(const Sequence &sequence, const Taken &taken = {});

    /// Predicted and filtered, one entry a step; `updates` is not used.
    const std::vector<Track<Quad>> &track() const { return track_; }

    /// Belief and lag-one covariance; the noises are not used.
    std::vector<Smoothed<Quad>> smooth() const;

    /// The covariance of each step if nothing were ever measured.
    const std::vector<Matrix<Quad>> &unmeasured() const { return unmeasured_; }

    /// Of every scalar measurement, taken or not, in the order of `Taken`: its innovation variance
    /// as a share of the largest that it could have if nothing had been measured.
    const std::vector<std::vector<double>> &information() const { return information_; }

  private:
    /// The share below which the rounding of quadruple precision may have made it up.
    static constexpr double redundant = 1e-30;

    struct Correction {
        Vector<Quad> h, K;
        Quad e, s;
    };

    struct Adjoint {
        Vector<Quad> lambda;
        Matrix<Quad> Lambda;
    };

    void predict(Belief<Quad> &belief, const Step &step) const;

    void update(Belief<Quad> &belief, const Step &step, const std::vector<bool> &taken);

    /// s as a share of the largest that sigma allows.
    static double share(const Quad &s, const Vector<Quad> &h, const Vector<Quad> &sigma,
                        const Quad &r);

    void correct(Belief<Quad> &belief, const Vector<Quad> &h, const Quad &r, const Quad &z,
                 const Quad &s);

    static Belief<Quad> smoothed(const Belief<Quad> &filtered, const Adjoint &adjoint);

    static void undoUpdate(Adjoint &adjoint, const Correction &done);

    /// From the predicted coordinates of step t to the filtered ones of step t - 1;
    /// Cov(x[t], x[t-1] | T) = (I - P- Lambda) A P.
    Matrix<Quad> undoPredict(Adjoint &adjoint, std::size_t t) const;

    const Sequence &sequence_;
    Model<Quad> model_;
    std::vector<Track<Quad>> track_;
    std::vector<Matrix<Quad>> unmeasured_;
    std::vector<std::vector<Correction>> corrections_;
    std::vector<std::vector<double>> information_;
};

} // namespace reference

#endif
