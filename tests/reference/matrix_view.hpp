// Operators and parts of a matrix: see matrix.hpp, which includes it.
#ifndef KALMANQ_TESTS_REFERENCE_MATRIX_VIEW_HPP
#define KALMANQ_TESTS_REFERENCE_MATRIX_VIEW_HPP

#include <algorithm>
#include <cstddef>
#include <stdexcept>

namespace reference
{

using Index = std::ptrdiff_t;

template <class Real> class Matrix;
template <class Real> using Vector = Matrix<Real>;

inline void requireSize(bool fits)
{
    if (!fits) throw std::logic_error("matrices whose sizes do not fit");
}

/// The operators of matrices and views: found for either, because both derive from it.
template <class Real> struct Algebra {
    using M = Matrix<Real>;

    friend M operator+(M a, const M &b) { return a += b; }
    friend M operator-(M a, const M &b) { return a -= b; }
    friend M operator-(const M &a)
    {
        return a.unaryExpr([](const Real &x) { return -x; });
    }
    friend M operator*(const Real &s, M a) { return a *= s; }
    friend M operator*(M a, const Real &s) { return a *= s; }
    friend M operator/(M a, const Real &s) { return a /= s; }

    /// Sums in the order of the inner index
    friend M operator*(const M &a, const M &b)
    {
        requireSize(a.cols() == b.rows());
        M c(a.rows(), b.cols());
        for (Index j = 0; j < b.cols() && a.cols() > 0; ++j) {
            for (Index i = 0; i < a.rows(); ++i) {
                Real sum = a(i, 0) * b(0, j);
                for (Index k = 1; k < a.cols(); ++k) sum += a(i, k) * b(k, j);
                c(i, j) = sum;
            }
        }
        return c;
    }

    friend bool operator==(const M &a, const M &b)
    {
        return a.rows() == b.rows() && a.cols() == b.cols() &&
               std::equal(a.begin(), a.end(), b.begin());
    }
    friend bool operator!=(const M &a, const M &b) { return !(a == b); }
};

// ------------------------------------------------------------------ a part of a matrix

template <class Real> class View : public Algebra<Real>
{
  public:
    View(Real *at, Index rows, Index cols, Index down, Index right)
        : at_(at), rows_(rows), cols_(cols), down_(down), right_(right)
    {
    }
    View(const View &) = default;

    Index rows() const { return rows_; }
    Index cols() const { return cols_; }
    Index size() const { return rows_ * cols_; }
    Real &operator()(Index i, Index j) const { return at_[i * down_ + j * right_]; }
    Real &operator()(Index k) const { return cols_ == 1 ? (*this)(k, 0) : (*this)(0, k); }
    operator Matrix<Real>() const { return eval(); }

    Matrix<Real> eval() const
    {
        Matrix<Real> M(rows_, cols_);
        for (Index j = 0; j < cols_; ++j) {
            for (Index i = 0; i < rows_; ++i) M(i, j) = (*this)(i, j);
        }
        return M;
    }

    View operator=(const View &other) const { return *this = other.eval(); }
    View operator=(const Matrix<Real> &other) const
    {
        return with(other, [](const Real &, const Real &x) { return x; });
    }
    View operator+=(const Matrix<Real> &other) const
    {
        return with(other, [](const Real &a, const Real &b) { return a + b; });
    }
    View operator-=(const Matrix<Real> &other) const
    {
        return with(other, [](const Real &a, const Real &b) { return a - b; });
    }
    View operator/=(const Real &s) const
    {
        for (Index j = 0; j < cols_; ++j) {
            for (Index i = 0; i < rows_; ++i) (*this)(i, j) /= s;
        }
        return *this;
    }
    View setConstant(const Real &x) const
    {
        return *this = Matrix<Real>::Constant(rows_, cols_, x);
    }
    View setZero() const { return setConstant(Real(0)); }

    View block(Index i, Index j, Index rows, Index cols) const
    {
        return View(at_ + i * down_ + j * right_, rows, cols, down_, right_);
    }
    View segment(Index k, Index count) const
    {
        return cols_ == 1 ? block(k, 0, count, 1) : block(0, k, 1, count);
    }
    View head(Index count) const { return segment(0, count); }
    View tail(Index count) const { return segment(size() - count, count); }

    /// The k-th diagonal, above the main one where k > 0
    View diagonal(Index k = 0) const
    {
        const Index i = std::max<Index>(-k, 0), j = std::max<Index>(k, 0);
        const Index count = std::max<Index>(std::min(rows_ - i, cols_ - j), 0);
        return View(&(*this)(i, j), count, 1, down_ + right_, 0);
    }

    Matrix<Real> transpose() const { return eval().transpose(); }
    Real dot(const Matrix<Real> &other) const { return eval().dot(other); }

  private:
    template <class Function> View with(const Matrix<Real> &other, Function f) const
    {
        requireSize(other.size() == size() && (other.rows() == rows_ || cols_ == 1 || rows_ == 1));
        const bool along = other.rows() == rows_; // else a row is given as a column, or the reverse
        for (Index j = 0; j < cols_; ++j) {
            for (Index i = 0; i < rows_; ++i) {
                (*this)(i, j) = f((*this)(i, j), along ? other(i, j) : other(j, i));
            }
        }
        return *this;
    }

    Real *at_;
    Index rows_, cols_, down_, right_;
};

} // namespace reference

#endif
