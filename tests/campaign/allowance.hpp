// What the documented accuracy of an arithmetic allows on a model: the textbook is run again with
// roundings of the documented size at the documented places, drawn at random, and what they make of
// the results is measured.  The model's own conditioning is all in that; nothing is fitted to what
// the library does.
//
//   where                        f32                 f64                 q31
//   rows of S, of their norm     n 2^-23             n 2^-52             (2n + 4) 2^-29
//   correlated R, of its sigmas  the same
//   x at a predict               2^-23 of what is    2^-52 of all terms  2^-24 word
//                                added to x
//   x at an update               2^-23 of K e        2^-52 of x          2^-24 word
//   innovation                   2^-23 of h_k x_k    2^-52 of z, h_k x_k 2^-24 word of z
//   smoother, of filtered sigma  2^-23               2^-52               2^-25
//   measurement without noise                                            one of 2^-24 word in
//                                                                        every state
//
// A measurement shortens a row of S; where it does by more than the documented loss of one stage
// (2^8, 2^24, 2^4: beyond it a measurement is taken in stages) the rows are rounded at that loss.
//
// The least sigma that counts: 2^-50 (f32) and 2^-177 (f64), so that the least process noise, 2^-60
// and 2^-200, is within the tolerance; 2^-17.5 word in q31, so that a few of what a noise-free
// measurement counts as, 2^-24 word in every state, are.
//
// The roundings of f32 and q31 are drawn 2^30 times smaller and the response is scaled up, so that
// it is the linear one: what is singular stays so.
#ifndef KALMANQ_TESTS_CAMPAIGN_ALLOWANCE_HPP
#define KALMANQ_TESTS_CAMPAIGN_ALLOWANCE_HPP

#include <algorithm>
#include <cmath>

#include "held.hpp"

namespace campaign
{

/// The documented figures of an arithmetic.
struct Accuracy {
    double rows, mean, stage, smoother;
    double scale;     // of the roundings that are drawn
    double tolerance; // what counts as right on any model, in sigmas and the like
    double least;     // a sigma far below it is noise to the arithmetic; q31: in words
    bool fixedPoint, pair;
};

template <class T> Accuracy accuracyOf(int n); // of so many states

template <> inline Accuracy accuracyOf<float>(int n)
{
    return {n * 0x1p-23, 0x1p-23, 0x1p8, 0x1p-23, 0x1p-30, 1e-2, 0x1p-50, false, true};
}
template <> inline Accuracy accuracyOf<double>(int n)
{
    return {n * 0x1p-52, 0x1p-52, 0x1p24, 0x1p-52, 1, 1e-6, 0x1p-177, false, false};
}
template <> inline Accuracy accuracyOf<Q31>(int n)
{
    return {(2 * n + 4) * 0x1p-29, 0x1p-24, 0x1p4, 0x1p-25, 0x1p-30, 1e-3, 0x1.6p-18, true, false};
}

class Documented : public Rounding
{
  public:
    Documented(const Accuracy &accuracy, const Inputs &inputs, const Vec &words,
               std::uint64_t seed)
        : accuracy_(accuracy), inputs_(inputs), words_(words), random_(seed)
    {
    }

    void noise(Mat &R) override
    {
        if (R.isDiagonal()) return;
        const Mat root = lowerRoot(R);
        Mat L = root;
        for (Index i = 0; i < R.rows(); ++i) {
            for (Index j = 0; j < R.rows(); ++j) {
                if (root(j, j) > 0) L(i, j) += draw(accuracy_.rows * sigma(R, i));
            }
        }
        R = square(L);
    }

    void start(Belief &belief) override { disturb(belief.covariance, belief.covariance); }

    void predicted(Belief &belief, const Belief &before, std::size_t t) override
    {
        disturb(belief.covariance, belief.covariance);
        const Vec drive = inputs_.model.drive(inputs_.steps[t]);
        for (Index i = 0; i < drive.size(); ++i) {
            Real terms = abs(drive(i));
            for (Index k = 0; k < drive.size(); ++k) terms += abs(addedFrom(t, i, k) * before.mean(k));
            round(belief, i, terms);
        }
    }

    void innovation(Scalar &scalar, const Vec &x) override
    {
        Real terms = 0;
        int count = 0;
        for (Index k = 0; k < x.size(); ++k) {
            const Real &h = scalar.h(k);
            terms += abs(h * x(k));
            count += h != 0 && h != 1 ? 2 : h != 0;
        }
        if (accuracy_.pair && count == 1) terms = 0; // a state as it is: the high parts cancel
        scalar.innovation += draw(accuracy_.fixedPoint ? scalar.grain : accuracy_.mean * terms);
    }

    /// q31: no measurement is sharper than the last bits of the mean that it sees.
    Real leastNoise(const Vec &h, Real r) override
    {
        if (!accuracy_.fixedPoint) return 0;
        const Real least = (accuracy_.mean * h.cwiseProduct(words_)).squaredNorm();
        return r < least ? accuracy_.scale * least : Real(0);
    }

    void updated(Belief &belief, const Belief &before) override
    {
        disturb(belief.covariance, before.covariance);
        for (Index i = 0; i < belief.mean.size(); ++i) {
            const Real moved = belief.mean(i) - before.mean(i);
            round(belief, i, abs(accuracy_.pair ? moved : belief.mean(i)));
        }
    }

  private:
    /// A_ik, but for what a pair has already: A_ii - 1 where 1/2 <= A_ii <= 2
    Real addedFrom(std::size_t t, Index i, Index k) const
    {
        const Real a = inputs_.A(t)(i, k);
        return accuracy_.pair && i == k && a >= 0.5 && a <= 2 ? a - 1 : a;
    }

    Real draw(const Real &size) { return size * accuracy_.scale * random_.uniform(-1, 1); }

    void round(Belief &belief, Index i, const Real &terms)
    {
        belief.mean(i) += draw(accuracy_.mean * (accuracy_.fixedPoint ? words_(i) : terms));
    }

    void disturb(Mat &P, const Mat &before)
    {
        Mat L = lowerRoot(P);
        const Index n = P.rows();
        const double share = std::sqrt(3.0 / static_cast<double>(n)); // n draws are as long as one
        for (Index i = 0; i < n; ++i) {
            const Real most = accuracy_.stage * sigma(P, i), was = sigma(before, i);
            const Real size = accuracy_.rows * share * (was < most ? was : most);
            for (Index j = 0; j < n; ++j) L(i, j) += draw(size);
        }
        P = square(L);
    }

    const Accuracy &accuracy_;
    const Inputs &inputs_;
    const Vec words_;
    Random random_;
};

} // namespace campaign

#endif
