// Matrices of any number type.  They are Eigen's, but sums and products of whole matrices, and what yields
// a matrix of their size, are done where they stand and compiled once, in matrix.cpp: Eigen's templates of
// expressions would cost each program half a minute.  Parts of matrices (row(), block() and so on) are Eigen's.
// A vector is a matrix of one column.  Entries begin as 0; sizes that do not fit throw.
#ifndef KALMANQ_TESTS_REFERENCE_MATRIX_HPP
#define KALMANQ_TESTS_REFERENCE_MATRIX_HPP

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "quad.hpp"

#define eigen_assert(condition) \
    ((condition) ? static_cast<void>(0) : throw std::logic_error("matrices whose sizes do not fit"))
#include <Eigen/Core>

namespace Eigen
{

template <> struct NumTraits<reference::Quad> : GenericNumTraits<reference::Quad> {
    using Quad = reference::Quad;
    using Real = Quad;
    using NonInteger = Quad;
    using Nested = Quad;
    using Literal = Quad;
    enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 0 };
    enum { ReadCost = 2, AddCost = 40, MulCost = 40 };
    static Quad epsilon() { return Quad::of(ldexpq(1, -112)); }
    static Quad dummy_precision() { return Quad::of(ldexpq(1, -100)); }
    static Quad lowest() { return -highest(); }
    static Quad highest() { return Quad::of(ldexpq(2 - ldexpq(1, -112), 16383)); }
    static Quad infinity() { return Quad(std::numeric_limits<double>::infinity()); }
    static Quad quiet_NaN() { return Quad(std::numeric_limits<double>::quiet_NaN()); }
    static int digits10() { return 33; }
};

} // namespace Eigen

namespace reference
{

using Index = std::ptrdiff_t;

template <class Real> using EigenMatrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

template <class Real> class Matrix : public EigenMatrix<Real>
{
    using Base = EigenMatrix<Real>;

  public:
    Matrix() : Base(0, 1) {}
    explicit Matrix(Index rows, Index cols = 1);
    template <class Expression> Matrix(const Eigen::EigenBase<Expression> &e) : Base(e) {}

    static Matrix Constant(Index rows, Index cols, const Real &x);
    static Matrix Constant(Index count, const Real &x) { return Constant(count, 1, x); }
    static Matrix Zero(Index rows, Index cols = 1) { return Matrix(rows, cols); }
    static Matrix Ones(Index rows, Index cols = 1) { return Constant(rows, cols, Real(1)); }
    static Matrix Identity(Index rows, Index cols);

    /// What was in it is lost.
    void resize(Index rows, Index cols = 1) { *this = Matrix(rows, cols); }

    Matrix transpose() const;
    Matrix asDiagonal() const;
    Matrix upperTriangle() const;

    /// The entries where a chosen row and a chosen column cross
    Matrix choose(const std::vector<Index> &rows, const std::vector<Index> &cols) const;
    Matrix chooseRows(const std::vector<Index> &rows) const;

    template <class Other> Matrix<Other> cast() const;
    Matrix cwiseAbs() const;
    Matrix cwiseSqrt() const;
    Matrix cwiseInverse() const;
    Matrix cwiseMax(const Real &least) const;
    Matrix cwiseMax(const Matrix &other) const;
    Matrix cwiseProduct(const Matrix &other) const;
    Matrix cwiseQuotient(const Matrix &other) const;

    Matrix &operator+=(const Matrix &other);
    Matrix &operator-=(const Matrix &other);
    Matrix &operator*=(const Real &s);
    Matrix &operator/=(const Real &s);

    Real dot(const Matrix &other) const;
    bool isDiagonal() const;
};

template <class Real> using Vector = Matrix<Real>;

// ------------------------------------------------------------------ operators

template <class Real> Matrix<Real> operator+(const Matrix<Real> &a, const Matrix<Real> &b);
template <class Real> Matrix<Real> operator-(const Matrix<Real> &a, const Matrix<Real> &b);
template <class Real> Matrix<Real> operator-(const Matrix<Real> &a);

/// Sums in the order of the inner index
template <class Real> Matrix<Real> operator*(const Matrix<Real> &a, const Matrix<Real> &b);

template <class Real, class Part>
Matrix<Real> operator*(const Matrix<Real> &a, const Eigen::MatrixBase<Part> &b)
{
    return a * Matrix<Real>(b);
}
template <class Real, class Part>
Matrix<Real> operator*(const Eigen::MatrixBase<Part> &a, const Matrix<Real> &b)
{
    return Matrix<Real>(a) * b;
}

template <class Real, class Number>
using ScaledBy = std::enable_if_t<std::is_convertible<Number, Real>::value, Matrix<Real>>;

template <class Real, class Number> ScaledBy<Real, Number> operator*(Matrix<Real> a, const Number &s)
{
    return a *= Real(s);
}
template <class Real, class Number> ScaledBy<Real, Number> operator*(const Number &s, Matrix<Real> a)
{
    return a *= Real(s);
}
template <class Real, class Number> ScaledBy<Real, Number> operator/(Matrix<Real> a, const Number &s)
{
    return a /= Real(s);
}

/// Of one size, and the same in every entry
template <class Real> bool operator==(const Matrix<Real> &a, const Matrix<Real> &b);
template <class Real> bool operator!=(const Matrix<Real> &a, const Matrix<Real> &b) { return !(a == b); }

/// sigma, or the unit that takes its place where there is none
template <class Real> Vector<Real> positiveOr(const Vector<Real> &sigma, const Real &unit)
{
    return sigma.unaryExpr([&](const Real &x) { return x > Real(0) ? x : unit; });
}

/// Of what a function yields, by columns
template <class Function> Matrix<double> generated(Index rows, Index cols, Function next)
{
    Matrix<double> M(rows, cols);
    std::generate(M.data(), M.data() + M.size(), next);
    return M;
}

// ------------------------------------------------------------------ written out

inline Vector<double> column(std::initializer_list<double> entries)
{
    Vector<double> v(static_cast<Index>(entries.size()));
    std::copy(entries.begin(), entries.end(), v.data());
    return v;
}

inline Matrix<double> rows(std::initializer_list<std::initializer_list<double>> entries)
{
    Matrix<double> M(static_cast<Index>(entries.size()),
                     static_cast<Index>(entries.begin()->size()));
    Index i = 0;
    for (const auto &row : entries) M.row(i++) = column(row).transpose();
    return M;
}

/// Row c of an identity: the sensor that sees state c.
inline Matrix<double> unitRow(Index n, Index c) { return Matrix<double>::Identity(n, n).row(c); }

/// To floats
inline Matrix<double> rounded(const Matrix<double> &M) { return M.cast<float>().cast<double>(); }

} // namespace reference

#endif
