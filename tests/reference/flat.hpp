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

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "accuracy.hpp"
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
    using Index = Eigen::Index;

  public:
    Flat(const Sequence &sequence, std::uint32_t unknown)
        : sequence_(sequence), model_(sequence), n_(sequence.states())
    {
        start(unknown);
        for (std::size_t t = 0; t + 1 < sequence.steps.size(); ++t) move(t);
        for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
            for (const Reading &reading : sequence.steps[t].readings) add(t, reading);
            rowsUpTo_.push_back(static_cast<Index>(rows_.size()));
        }
        whiten();
    }

    PartBelief filtered(std::size_t t) const { return known(t, rowsUpTo_[t]); }
    PartBelief smoothed(std::size_t t) const { return known(t, rowsUpTo_.back()); }

    /// How near to not being determined what is determined is, the worst of all steps
    double weakest() const
    {
        double least = 1;
        for (const Index count : rowsUpTo_) least = std::min(least, solve(count).weakest);
        return least;
    }

    /// Of all measurements; with det Z'Z over the directions that they determine.
    Quad logLikelihood() const
    {
        const Index count = rowsUpTo_.back();
        const Solution all = solve(count);
        Quad total = Quad(static_cast<double>(count)) * logarithm(Quad(2) * pi<Quad>());
        for (Index k = 0; k < count; ++k) total += Quad(2) * logarithm(L_(k, k));
        total += all.logDeterminant + all.rest.squaredNorm();
        return -total / Quad(2);
    }

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

    void start(std::uint32_t unknown)
    {
        Mat P = convert<Quad>(sequence_.P0);
        Vec mean = convert<Quad>(sequence_.x0);
        Index count = 0;
        for (Index i = 0; i < n_; ++i) count += unknown >> i & 1;
        Mat X = Mat::Zero(n_, count);
        for (Index i = 0, j = 0; i < n_; ++i) {
            if (!(unknown >> i & 1)) continue;
            P.row(i).setZero();
            P.col(i).setZero();
            X(i, j++) = Quad(1);
        }
        mean_.push_back(mean);
        X_.push_back(X);
        C_.push_back({P});
    }

    /// C_[t][s], s <= t, is Cov(x_t, x_s) given delta.
    void move(std::size_t t)
    {
        const Step &step = sequence_.steps[t];
        const Mat &A = model_.A[step.process];
        mean_.push_back(A * mean_[t] + model_.drive(step));
        X_.push_back(A * X_[t]);
        std::vector<Mat> next;
        for (const Mat &C : C_[t]) next.push_back(A * C);
        next.push_back(A * C_[t][t] * A.transpose() + model_.Q[step.process]);
        C_.push_back(std::move(next));
    }

    void add(std::size_t t, const Reading &reading)
    {
        const Observation<Quad> seen(model_, reading);
        for (Index c = 0; c < seen.z.size(); ++c) {
            rows_.push_back({t, seen.H.row(c).transpose(), readings_.size(), c, seen.z(c)});
        }
        Mat R = seen.R;
        for (Index c = 0; c < seen.z.size(); ++c) {
            if (R(c, c) == 0) R(c, c) = Quad(1e-22);
        }
        readings_.push_back(R);
    }

    Mat covariance(std::size_t t, std::size_t s) const
    {
        return s <= t ? C_[t][s] : Mat(C_[s][t].transpose());
    }

    void whiten()
    {
        const auto count = static_cast<Index>(rows_.size());
        const auto width = n_ * static_cast<Index>(mean_.size());
        Mat V(count, count);
        G_.resize(count, width);
        Z_.resize(count, X_[0].cols());
        e_.resize(count);
        for (Index a = 0; a < count; ++a) {
            const Row &row = rows_[static_cast<std::size_t>(a)];
            Z_.row(a) = row.h.transpose() * X_[row.t];
            e_(a) = row.z - row.h.dot(mean_[row.t]);
            for (std::size_t t = 0; t < mean_.size(); ++t) {
                G_.block(a, n_ * static_cast<Index>(t), 1, n_) =
                    row.h.transpose() * covariance(row.t, t);
            }
            for (Index b = 0; b <= a; ++b) {
                const Row &other = rows_[static_cast<std::size_t>(b)];
                V(a, b) = G_.block(a, n_ * static_cast<Index>(other.t), 1, n_).row(0).dot(other.h);
                if (row.reading == other.reading) {
                    V(a, b) += readings_[row.reading](row.component, other.component);
                }
                V(b, a) = V(a, b);
            }
        }
        const Eigen::LLT<Mat> factor(V);
        if (factor.info() != Eigen::Success) throw std::runtime_error("flat: V is singular");
        L_ = factor.matrixL();
        const auto lower = L_.triangularView<Eigen::Lower>();
        G_ = lower.solve(G_).eval();
        Z_ = lower.solve(Z_).eval();
        e_ = lower.solve(e_).eval();
    }

    /// From the first `count` rows
    Solution solve(Index count) const
    {
        const Mat Z = Z_.topRows(count);
        const Index width = Z.cols();
        Solution s;
        s.logDeterminant = Quad(0);
        s.delta = Vec::Zero(width);
        s.inverse = Mat::Zero(width, width);
        s.null = Mat::Identity(width, width);
        s.rest = e_.head(count);
        s.weakest = 1;
        if (count == 0 || width == 0) return s;
        Eigen::CompleteOrthogonalDecomposition<Mat> factors(count, width);
        factors.setThreshold(Quad(1e-15));
        factors.compute(Z);
        const Mat inverse = factors.pseudoInverse();
        s.inverse = inverse * inverse.transpose();
        for (Index k = 0; k < factors.rank(); ++k) {
            s.logDeterminant += Quad(2) * logarithm(abs(factors.matrixT()(k, k)));
        }
        s.weakest = weakestOf(Z);
        if (factors.rank() == width) s.null.resize(width, 0);
        else s.null -= inverse * Z;
        s.delta = inverse * s.rest;
        s.rest -= Z * s.delta;
        return s;
    }

    /// The smallest share of a column that the others leave, of those that leave any
    static double weakestOf(const Mat &Z)
    {
        Mat columns = Z;
        for (Index j = 0; j < Z.cols(); ++j) {
            const Quad norm = Z.col(j).norm();
            if (norm > 0) columns.col(j) /= norm;
        }
        Eigen::ColPivHouseholderQR<Mat> factors(columns.rows(), columns.cols());
        factors.setThreshold(Quad(1e-15));
        factors.compute(columns);
        const Index rank = factors.rank();
        return rank == 0 ? 1 : static_cast<double>(abs(factors.matrixR()(rank - 1, rank - 1)));
    }

    PartBelief known(std::size_t t, Index count) const
    {
        const Solution s = solve(count);
        const Mat G = G_.block(0, n_ * static_cast<Index>(t), count, n_);
        const Mat W = X_[t] - G.transpose() * Z_.topRows(count);
        PartBelief part;
        part.belief.mean = mean_[t] + X_[t] * s.delta + G.transpose() * s.rest;
        part.belief.covariance = C_[t][t] - G.transpose() * G + W * s.inverse * W.transpose();
        const Mat open = X_[t] * s.null;
        for (Index i = 0; i < n_; ++i) {
            part.known.push_back(s.null.cols() == 0 ||
                                 open.row(i).norm() <= Quad(1e-11) * X_[t].row(i).norm());
        }
        return part;
    }

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
