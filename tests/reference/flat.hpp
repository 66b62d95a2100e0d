// An estimate without a prior for some components, as what it is: generalised least squares.  The
// states of all times are x = m + X delta + noise of covariance C, delta unknown; the measurements
// H x + v have the covariance V = H C H' + R given delta.  Whitened by the Cholesky factor of V,
//
//     delta = (Z'Z)^-1 Z'e,   x_t = m_t + X_t delta + G'(e - Z delta),   G = L^-1 H C_t
//     P_t = C_t - G'G + W (Z'Z)^-1 W',   W = X_t - G'Z
//     log L = -(N log 2 pi + log det V + log det Z'Z + |e - Z delta|^2) / 2
//
// and what is known after some of the measurements takes their rows alone.  There is no recursion
// in it.  P0 and Q may be singular; V is not, because a noise of 0 counts as one of 1e-11 sigma.
#ifndef KALMANQ_TESTS_REFERENCE_FLAT_HPP
#define KALMANQ_TESTS_REFERENCE_FLAT_HPP

#include <cstddef>
#include <cstdint>
#include <vector>

#include "textbook.hpp"

namespace reference
{

/// What is known of one state; where `known` is false mean and covariance mean nothing.
struct PartBelief {
    Belief<Quad> belief;
    std::vector<bool> known;
};

class Flat
{
    using Mat = Matrix<Quad>;
    using Vec = Vector<Quad>;

  public:
    Flat(const Sequence &sequence, std::uint32_t unknown);

    PartBelief filtered(std::size_t t) const { return known(t, rowsUpTo_[t]); }
    PartBelief smoothed(std::size_t t) const { return known(t, rowsUpTo_.back()); }

    /// How near to not being determined what is determined is, the worst of all steps
    double weakest() const;

    /// Of all measurements; with det Z'Z over the directions that they determine.
    Quad logLikelihood() const;

  private:
    struct Row {
        std::size_t t;
        Vec h;
        std::size_t reading; // of all, to find what is correlated
        Index component;
        Quad z;
    };

    struct Solution {
        Vec delta, rest;
        Mat inverse; // of Z'Z
        Mat null;    // spans what is not determined
        Quad logDeterminant;
        double weakest;
    };

    void start(std::uint32_t unknown);

    /// C_[t][s], s <= t, is Cov(x_t, x_s) given delta.
    void move(std::size_t t);

    void add(std::size_t t, const Reading &reading);

    Mat covariance(std::size_t t, std::size_t s) const;

    void whiten();

    /// From the first `count` rows
    Solution solve(Index count) const;

    /// The smallest share of a column that the others leave, of those that leave any
    static double weakestOf(const Mat &Z);

    PartBelief known(std::size_t t, Index count) const;

    const Sequence &sequence_;
    Model<Quad> model_;
    Index n_;
    std::vector<Vec> mean_;
    std::vector<Mat> X_, readings_;
    std::vector<std::vector<Mat>> C_;
    std::vector<Row> rows_;
    std::vector<Index> rowsUpTo_;
    Mat L_, G_, Z_;
    Vec e_;
};

} // namespace reference

#endif
