// Matrices of any number type, on plain memory: what the tests and the interface of the reference
// are written in.  A header of its own because Eigen's templates cost each program that includes
// them many times what it takes to compile this; what needs a decomposition asks for it by name
// (decompositions.hpp), and is compiled once.
//
// The names are Eigen's, but every operation is done where it stands and yields a matrix.  A vector
// is a matrix of one column.  row(), col(), block() and so on of a matrix that may be changed are
// views, which can be assigned to; of a constant one they are copies.
#ifndef KALMANQ_TESTS_REFERENCE_MATRIX_HPP
#define KALMANQ_TESTS_REFERENCE_MATRIX_HPP

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <vector>

#include "matrix_view.hpp"

namespace reference
{

/// By columns, as Eigen has it.
template <class Real> class Matrix : public Algebra<Real>
{
  public:
    Matrix() : rows_(0), cols_(1) {}
    explicit Matrix(Index count) : Matrix(count, 1) {}
    Matrix(Index rows, Index cols)
        : rows_(rows), cols_(cols), entries_(static_cast<std::size_t>(rows * cols))
    {
    }

    static Matrix Constant(Index rows, Index cols, const Real &x)
    {
        Matrix M(rows, cols);
        std::fill(M.begin(), M.end(), x);
        return M;
    }
    static Matrix Constant(Index count, const Real &x) { return Constant(count, 1, x); }
    static Matrix Zero(Index rows, Index cols = 1) { return Constant(rows, cols, Real(0)); }
    static Matrix Ones(Index rows, Index cols = 1) { return Constant(rows, cols, Real(1)); }
    static Matrix Identity(Index rows, Index cols)
    {
        Matrix M = Zero(rows, cols);
        for (Index i = 0; i < std::min(rows, cols); ++i) M(i, i) = Real(1);
        return M;
    }

    Index rows() const { return rows_; }
    Index cols() const { return cols_; }
    Index size() const { return rows_ * cols_; }
    Real &operator()(Index i, Index j) { return *(data() + i + j * rows_); }
    const Real &operator()(Index i, Index j) const { return *(data() + i + j * rows_); }
    Real &operator()(Index k) { return *(data() + k); }
    const Real &operator()(Index k) const { return *(data() + k); }
    Real *data() { return entries_.data(); }
    const Real *data() const { return entries_.data(); }
    auto begin() { return entries_.begin(); }
    auto begin() const { return entries_.begin(); }
    auto end() { return entries_.end(); }
    auto end() const { return entries_.end(); }

    /// What was in it is lost.
    void resize(Index rows, Index cols = 1) { *this = Matrix(rows, cols); }
    void setConstant(const Real &x) { std::fill(begin(), end(), x); }
    void setZero() { setConstant(Real(0)); }

    // ---- parts

    View<Real> block(Index i, Index j, Index rows, Index cols)
    {
        return View<Real>(data() + i + j * rows_, rows, cols, 1, rows_);
    }
    Matrix block(Index i, Index j, Index rows, Index cols) const
    {
        Matrix M(rows, cols);
        for (Index l = 0; l < cols; ++l) {
            for (Index k = 0; k < rows; ++k) M(k, l) = (*this)(i + k, j + l);
        }
        return M;
    }
    View<Real> all() { return block(0, 0, rows_, cols_); }
    View<Real> row(Index i) { return block(i, 0, 1, cols_); }
    Matrix row(Index i) const { return block(i, 0, 1, cols_); }
    View<Real> col(Index j) { return block(0, j, rows_, 1); }
    Matrix col(Index j) const { return block(0, j, rows_, 1); }
    View<Real> diagonal(Index k = 0) { return all().diagonal(k); }
    Matrix diagonal() const
    {
        Matrix d(std::min(rows_, cols_));
        for (Index i = 0; i < d.size(); ++i) d(i) = (*this)(i, i);
        return d;
    }
    View<Real> segment(Index k, Index count) { return all().segment(k, count); }
    Matrix segment(Index k, Index count) const
    {
        return cols_ == 1 ? block(k, 0, count, 1) : block(0, k, 1, count);
    }
    View<Real> head(Index count) { return segment(0, count); }
    Matrix head(Index count) const { return segment(0, count); }
    View<Real> tail(Index count) { return segment(size() - count, count); }
    Matrix tail(Index count) const { return segment(size() - count, count); }
    Matrix topRows(Index count) const { return block(0, 0, count, cols_); }
    Matrix middleRows(Index i, Index count) const { return block(i, 0, count, cols_); }

    /// The entries where a chosen row and a chosen column cross
    Matrix choose(const std::vector<Index> &rows, const std::vector<Index> &cols) const
    {
        Matrix M(static_cast<Index>(rows.size()), static_cast<Index>(cols.size()));
        auto at = M.begin();
        for (const Index j : cols) {
            for (const Index i : rows) *at++ = (*this)(i, j);
        }
        return M;
    }
    Matrix chooseRows(const std::vector<Index> &rows) const
    {
        std::vector<Index> cols(static_cast<std::size_t>(cols_));
        for (std::size_t j = 0; j < cols.size(); ++j) cols[j] = static_cast<Index>(j);
        return choose(rows, cols);
    }

    Matrix upperTriangle() const
    {
        Matrix M = *this;
        for (Index j = 0; j < cols_; ++j) {
            for (Index i = j + 1; i < rows_; ++i) M(i, j) = Real(0);
        }
        return M;
    }

    // ---- entry by entry

    Matrix &operator+=(const Matrix &other)
    {
        requireSize(rows_ == other.rows_ && cols_ == other.cols_);
        for (Index k = 0; k < size(); ++k) (*this)(k) += other(k);
        return *this;
    }
    Matrix &operator-=(const Matrix &other)
    {
        requireSize(rows_ == other.rows_ && cols_ == other.cols_);
        for (Index k = 0; k < size(); ++k) (*this)(k) -= other(k);
        return *this;
    }
    Matrix &operator*=(const Real &s)
    {
        for (Real &x : entries_) x *= s;
        return *this;
    }
    Matrix &operator/=(const Real &s)
    {
        for (Real &x : entries_) x /= s;
        return *this;
    }

    template <class Other> Matrix<Other> cast() const
    {
        Matrix<Other> M(rows_, cols_);
        std::transform(begin(), end(), M.begin(),
                       [](const Real &x) { return static_cast<Other>(x); });
        return M;
    }
    template <class Function> Matrix unaryExpr(Function f) const
    {
        Matrix M(rows_, cols_);
        std::transform(begin(), end(), M.begin(), f);
        return M;
    }
    template <class Function> Matrix binaryExpr(const Matrix &other, Function f) const
    {
        requireSize(rows_ == other.rows_ && cols_ == other.cols_);
        Matrix M(rows_, cols_);
        std::transform(begin(), end(), other.begin(), M.begin(), f);
        return M;
    }
    Matrix cwiseAbs() const
    {
        return unaryExpr([](const Real &x) {
            using std::abs;
            return abs(x);
        });
    }
    Matrix cwiseSqrt() const
    {
        return unaryExpr([](const Real &x) {
            using std::sqrt;
            return sqrt(x);
        });
    }
    Matrix cwiseInverse() const
    {
        return unaryExpr([](const Real &x) { return Real(1) / x; });
    }
    Matrix cwiseMax(const Real &least) const
    {
        return unaryExpr([&](const Real &x) { return x < least ? least : x; });
    }
    Matrix cwiseMax(const Matrix &other) const
    {
        return binaryExpr(other, [](const Real &a, const Real &b) { return a < b ? b : a; });
    }
    Matrix cwiseProduct(const Matrix &other) const
    {
        return binaryExpr(other, [](const Real &a, const Real &b) { return a * b; });
    }
    Matrix cwiseQuotient(const Matrix &other) const
    {
        return binaryExpr(other, [](const Real &a, const Real &b) { return a / b; });
    }

    Matrix transpose() const
    {
        Matrix M(cols_, rows_);
        for (Index j = 0; j < cols_; ++j) {
            for (Index i = 0; i < rows_; ++i) M(j, i) = (*this)(i, j);
        }
        return M;
    }
    Matrix asDiagonal() const
    {
        Matrix M = Zero(size(), size());
        M.diagonal() = *this;
        return M;
    }

    // ---- one number

    Real dot(const Matrix &other) const
    {
        requireSize(size() == other.size());
        if (size() == 0) return Real(0);
        Real sum = (*this)(0) * other(0);
        for (Index k = 1; k < size(); ++k) sum += (*this)(k) * other(k);
        return sum;
    }
    Real squaredNorm() const { return dot(*this); }
    Real norm() const
    {
        using std::sqrt;
        return sqrt(squaredNorm());
    }
    Real maxCoeff() const { return *std::max_element(begin(), end()); }
    Real minCoeff() const { return *std::min_element(begin(), end()); }
    bool allFinite() const
    {
        using std::isfinite;
        return std::all_of(begin(), end(), [](const Real &x) { return isfinite(x); });
    }
    bool isZero() const { return *this == Zero(rows_, cols_); }
    bool isDiagonal() const
    {
        for (Index j = 0; j < cols_; ++j) {
            for (Index i = 0; i < rows_; ++i) {
                if (i != j && (*this)(i, j) != Real(0)) return false;
            }
        }
        return true;
    }

  private:
    Index rows_, cols_;
    std::vector<Real> entries_;
};

/// sigma, or the unit that takes its place where there is none
template <class Real> Vector<Real> positiveOr(const Vector<Real> &sigma, const Real &unit)
{
    return sigma.unaryExpr([&](const Real &x) { return x > Real(0) ? x : unit; });
}

/// Of what a function yields, by columns
template <class Function> Matrix<double> generated(Index rows, Index cols, Function next)
{
    Matrix<double> M(rows, cols);
    std::generate(M.begin(), M.end(), next);
    return M;
}

// ------------------------------------------------------------------ written out

inline Vector<double> column(std::initializer_list<double> entries)
{
    Vector<double> v(static_cast<Index>(entries.size()));
    std::copy(entries.begin(), entries.end(), v.begin());
    return v;
}

inline Matrix<double> rows(std::initializer_list<std::initializer_list<double>> entries)
{
    Matrix<double> M(static_cast<Index>(entries.size()),
                     static_cast<Index>(entries.begin()->size()));
    Index i = 0;
    for (const auto &row : entries) M.row(i++) = column(row);
    return M;
}

/// Row c of an identity: the sensor that sees state c.
inline Matrix<double> unitRow(Index n, Index c) { return Matrix<double>::Identity(n, n).row(c); }

/// To floats
inline Matrix<double> rounded(const Matrix<double> &M) { return M.cast<float>().cast<double>(); }

} // namespace reference

#endif
