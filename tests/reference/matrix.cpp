#include "matrix.hpp"

namespace reference
{

template <class Real> Matrix<Real>::Matrix(Index rows, Index cols) : Base(rows, cols) { this->setZero(); }

template <class Real> Matrix<Real> Matrix<Real>::Constant(Index rows, Index cols, const Real &x)
{
    return Base::Constant(rows, cols, x);
}

template <class Real> Matrix<Real> Matrix<Real>::Identity(Index rows, Index cols) { return Base::Identity(rows, cols); }

template <class Real> Matrix<Real> Matrix<Real>::transpose() const { return Base::transpose(); }

template <class Real> Matrix<Real> Matrix<Real>::asDiagonal() const
{
    Matrix M(this->size(), this->size());
    M.diagonal() = *this;
    return M;
}

template <class Real> Matrix<Real> Matrix<Real>::upperTriangle() const
{
    return this->template triangularView<Eigen::Upper>();
}

template <class Real>
Matrix<Real> Matrix<Real>::choose(const std::vector<Index> &rows, const std::vector<Index> &cols) const
{
    return (*this)(rows, cols);
}

template <class Real> Matrix<Real> Matrix<Real>::chooseRows(const std::vector<Index> &rows) const
{
    return (*this)(rows, Eigen::all);
}

template <class Real> template <class Other> Matrix<Other> Matrix<Real>::cast() const
{
    return Base::template cast<Other>();
}

template <class Real> Matrix<Real> Matrix<Real>::cwiseAbs() const { return Base::cwiseAbs(); }
template <class Real> Matrix<Real> Matrix<Real>::cwiseSqrt() const { return Base::cwiseSqrt(); }
template <class Real> Matrix<Real> Matrix<Real>::cwiseInverse() const { return Base::cwiseInverse(); }

template <class Real> Matrix<Real> Matrix<Real>::cwiseMax(const Real &least) const { return Base::cwiseMax(least); }
template <class Real> Matrix<Real> Matrix<Real>::cwiseMax(const Matrix &other) const { return Base::cwiseMax(other); }
template <class Real> Matrix<Real> Matrix<Real>::cwiseProduct(const Matrix &other) const
{
    return Base::cwiseProduct(other);
}
template <class Real> Matrix<Real> Matrix<Real>::cwiseQuotient(const Matrix &other) const
{
    return Base::cwiseQuotient(other);
}

template <class Real> Matrix<Real> &Matrix<Real>::operator+=(const Matrix &other)
{
    Base::operator+=(other);
    return *this;
}
template <class Real> Matrix<Real> &Matrix<Real>::operator-=(const Matrix &other)
{
    Base::operator-=(other);
    return *this;
}
template <class Real> Matrix<Real> &Matrix<Real>::operator*=(const Real &s)
{
    Base::operator*=(s);
    return *this;
}
template <class Real> Matrix<Real> &Matrix<Real>::operator/=(const Real &s)
{
    Base::operator/=(s);
    return *this;
}

template <class Real> Real Matrix<Real>::dot(const Matrix &other) const { return (transpose() * other)(0); }

template <class Real> bool Matrix<Real>::isDiagonal() const { return Base::isDiagonal(Real(0)); }

template <class Real> Matrix<Real> operator+(const Matrix<Real> &a, const Matrix<Real> &b)
{
    Matrix<Real> sum = a;
    return sum += b;
}
template <class Real> Matrix<Real> operator-(const Matrix<Real> &a, const Matrix<Real> &b)
{
    Matrix<Real> rest = a;
    return rest -= b;
}
template <class Real> Matrix<Real> operator-(const Matrix<Real> &a) { return a * Real(-1); }

// Models have many zeros, and a product of quadruple precision takes a hundred times as long as a look at its factor.
template <class Real> Matrix<Real> operator*(const Matrix<Real> &a, const Matrix<Real> &b)
{
    eigen_assert(a.cols() == b.rows());
    Matrix<Real> product(a.rows(), b.cols());
    for (Index j = 0; j < b.cols(); ++j) {
        for (Index k = 0; k < a.cols(); ++k) {
            const Real factor = b(k, j), *from = a.data() + k * a.rows();
            Real *to = product.data() + j * a.rows();
            for (Index i = 0; factor != Real(0) && i < a.rows(); ++i) {
                if (from[i] != Real(0)) to[i] += from[i] * factor;
            }
        }
    }
    return product;
}

template <class Real> bool operator==(const Matrix<Real> &a, const Matrix<Real> &b)
{
    return a.rows() == b.rows() && a.cols() == b.cols() && a.cwiseEqual(b).all();
}

// ------------------------------------------------------------------ the number types

#define INSTANTIATE(Real) \
    template class Matrix<Real>; \
    template Matrix<float> Matrix<Real>::cast<float>() const; \
    template Matrix<double> Matrix<Real>::cast<double>() const; \
    template Matrix<long double> Matrix<Real>::cast<long double>() const; \
    template Matrix<Quad> Matrix<Real>::cast<Quad>() const; \
    template Matrix<Real> operator+(const Matrix<Real> &, const Matrix<Real> &); \
    template Matrix<Real> operator-(const Matrix<Real> &, const Matrix<Real> &); \
    template Matrix<Real> operator-(const Matrix<Real> &); \
    template Matrix<Real> operator*(const Matrix<Real> &, const Matrix<Real> &); \
    template bool operator==(const Matrix<Real> &, const Matrix<Real> &);

INSTANTIATE(float)
INSTANTIATE(double)
INSTANTIATE(long double)
INSTANTIATE(Quad)

} // namespace reference
