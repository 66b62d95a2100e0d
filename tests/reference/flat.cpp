#include "flat.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "decompositions.hpp"

namespace reference
{

Flat::Flat(const Sequence &sequence, std::uint32_t unknown)
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

double Flat::weakest() const
{
    double least = 1;
    for (const Index count : rowsUpTo_) least = std::min(least, solve(count).weakest);
    return least;
}

Quad Flat::logLikelihood() const
{
    const Index count = rowsUpTo_.back();
    const Solution all = solve(count);
    Quad total = Quad(static_cast<double>(count)) * logarithm(Quad(2) * pi<Quad>());
    for (Index k = 0; k < count; ++k) total += Quad(2) * logarithm(L_(k, k));
    total += all.logDeterminant + all.rest.squaredNorm();
    return -total / Quad(2);
}

void Flat::start(std::uint32_t unknown)
{
    Matrix<Quad> P = convert<Quad>(sequence_.P0);
    Vector<Quad> mean = convert<Quad>(sequence_.x0);
    Index count = 0;
    for (Index i = 0; i < n_; ++i) count += unknown >> i & 1;
    Matrix<Quad> X = Matrix<Quad>::Zero(n_, count);
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

void Flat::move(std::size_t t)
{
    const Step &step = sequence_.steps[t];
    const Matrix<Quad> &A = model_.A[step.process];
    mean_.push_back(A * mean_[t] + model_.drive(step));
    X_.push_back(A * X_[t]);
    std::vector<Matrix<Quad>> next;
    for (const Matrix<Quad> &C : C_[t]) next.push_back(A * C);
    next.push_back(A * C_[t][t] * A.transpose() + model_.Q[step.process]);
    C_.push_back(std::move(next));
}

void Flat::add(std::size_t t, const Reading &reading)
{
    const Observation<Quad> seen(model_, reading);
    for (Index c = 0; c < seen.z.size(); ++c) {
        rows_.push_back({t, seen.H.row(c).transpose(), readings_.size(), c, seen.z(c)});
    }
    Matrix<Quad> R = seen.R;
    for (Index c = 0; c < seen.z.size(); ++c) {
        if (R(c, c) == 0) R(c, c) = Quad(1e-22);
    }
    readings_.push_back(R);
}

Matrix<Quad> Flat::covariance(std::size_t t, std::size_t s) const
{
    return s <= t ? C_[t][s] : Matrix<Quad>(C_[s][t].transpose());
}

void Flat::whiten()
{
    const auto count = static_cast<Index>(rows_.size());
    const auto width = n_ * static_cast<Index>(mean_.size());
    Matrix<Quad> V(count, count);
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
            V(a, b) = G_.row(a).segment(n_ * static_cast<Index>(other.t), n_).dot(other.h.col(0));
            if (row.reading == other.reading) {
                V(a, b) += readings_[row.reading](row.component, other.component);
            }
            V(b, a) = V(a, b);
        }
    }
    const auto root = choleskyRoot(V);
    if (!root) throw std::runtime_error("flat: V is singular");
    L_ = *root;
    G_ = solveLower(L_, G_);
    Z_ = solveLower(L_, Z_);
    e_ = solveLower(L_, e_);
}

Flat::Solution Flat::solve(Index count) const
{
    const Matrix<Quad> Z = Z_.topRows(count);
    const Index width = Z.cols();
    Solution s;
    s.logDeterminant = Quad(0);
    s.delta = Vector<Quad>::Zero(width);
    s.inverse = Matrix<Quad>::Zero(width, width);
    s.null = Matrix<Quad>::Identity(width, width);
    s.rest = e_.topRows(count);
    s.weakest = 1;
    if (count == 0 || width == 0) return s;
    const PseudoInverse<Quad> factors = pseudoInverse(Z, Quad(1e-15));
    const Matrix<Quad> &inverse = factors.inverse;
    s.inverse = inverse * inverse.transpose();
    for (Index k = 0; k < factors.rank; ++k) {
        s.logDeterminant += Quad(2) * logarithm(factors.pivots(k));
    }
    s.weakest = weakestOf(Z);
    if (factors.rank == width) s.null.resize(width, 0);
    else s.null -= inverse * Z;
    s.delta = inverse * s.rest;
    s.rest -= Z * s.delta;
    return s;
}

double Flat::weakestOf(const Matrix<Quad> &Z)
{
    Matrix<Quad> columns = Z;
    for (Index j = 0; j < Z.cols(); ++j) {
        const Quad norm = Z.col(j).norm();
        if (norm > 0) columns.col(j) /= norm;
    }
    const PivotedQr<Quad> factors = pivotedQr(columns, Quad(1e-15));
    return factors.rank == 0 ? 1 : static_cast<double>(factors.pivots(factors.rank - 1));
}

PartBelief Flat::known(std::size_t t, Index count) const
{
    const Solution s = solve(count);
    const Matrix<Quad> G = G_.block(0, n_ * static_cast<Index>(t), count, n_);
    const Matrix<Quad> W = X_[t] - G.transpose() * Z_.topRows(count);
    PartBelief part;
    part.belief.mean = mean_[t] + X_[t] * s.delta + G.transpose() * s.rest;
    part.belief.covariance = C_[t][t] - G.transpose() * G + W * s.inverse * W.transpose();
    const Matrix<Quad> open = X_[t] * s.null;
    for (Index i = 0; i < n_; ++i) {
        part.known.push_back(s.null.cols() == 0 ||
                             open.row(i).norm() <= Quad(1e-11) * X_[t].row(i).norm());
    }
    return part;
}

} // namespace reference
