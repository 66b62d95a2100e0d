// How far an estimate is from the reference, without units.
#ifndef KALMANQ_TESTS_REFERENCE_ACCURACY_HPP
#define KALMANQ_TESTS_REFERENCE_ACCURACY_HPP

#include <algorithm>
#include <cmath>
#include <limits>

#include "api.hpp"
#include "textbook.hpp"

namespace reference
{

constexpr double infinite = std::numeric_limits<double>::infinity();

/// |error| / unit; where the unit is 0 the error has to be 0 too.  Never a NaN.
inline double ratio(const Quad &error, const Quad &unit)
{
    const Quad size = abs(error);
    if (!isfinite(size)) return infinite;
    if (size == 0) return 0;
    return unit > 0 ? static_cast<double>(size / unit) : infinite;
}

/// sqrt(P_ii), 0 where P_ii is not above 0.
inline Vector<Quad> sigmas(const Matrix<Quad> &P)
{
    return P.diagonal().unaryExpr([](const Quad &v) { return v > 0 ? sqrt(v) : Quad(0); });
}

/// The same, but of `prior` where noise-free measurements leave less than `floor` of its variance:
/// beside the prior such a variance is 0 to the arithmetic.
inline Vector<Quad> sigmas(const Matrix<Quad> &P, const Matrix<Quad> &prior, double floor)
{
    Vector<Quad> result = sigmas(P);
    for (Eigen::Index i = 0; i < P.rows(); ++i) {
        if (P(i, i) < Quad(floor) * prior(i, i)) result(i) = sqrt(prior(i, i));
    }
    return result;
}

/// max |x - x_ref|_i / sigma_i
template <class Mean>
double meanError(const Eigen::MatrixBase<Mean> &x, const Vector<Quad> &exact,
                 const Vector<Quad> &sigma)
{
    double worst = 0;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
        worst = std::max(worst, ratio(Quad(x(i)) - exact(i), sigma(i)));
    }
    return worst;
}

/// max |P - P_ref|_ij / (left_i right_j)
template <class Covariance>
double covarianceError(const Eigen::MatrixBase<Covariance> &P, const Matrix<Quad> &exact,
                       const Vector<Quad> &left, const Vector<Quad> &right)
{
    double worst = 0;
    for (Eigen::Index i = 0; i < P.rows(); ++i) {
        for (Eigen::Index j = 0; j < P.cols(); ++j) {
            worst = std::max(worst, ratio(Quad(P(i, j)) - exact(i, j), left(i) * right(j)));
        }
    }
    return worst;
}

template <class Covariance>
double covarianceError(const Eigen::MatrixBase<Covariance> &P, const Matrix<Quad> &exact,
                       const Vector<Quad> &sigma)
{
    return covarianceError(P, exact, sigma, sigma);
}

/// D^-1 P D^-1 with D_ii = sqrt(unit_ii), in long double.  Where unit_ii is 0, row and column i
/// of P must be 0; if they are not, -infinity is put on the diagonal.
template <class Covariance, class Unit>
Matrix<long double> dimensionless(const Eigen::MatrixBase<Covariance> &P,
                                  const Eigen::MatrixBase<Unit> &unit)
{
    Matrix<long double> C = P.template cast<long double>();
    for (Eigen::Index i = 0; i < P.rows(); ++i) {
        if (unit(i, i) > 0) {
            const long double sigma = std::sqrt(static_cast<long double>(unit(i, i)));
            C.row(i) /= sigma;
            C.col(i) /= sigma;
        } else if (!P.row(i).isZero(0) || !P.col(i).isZero(0)) {
            C(i, i) = -std::numeric_limits<long double>::infinity();
        }
    }
    return C;
}

/// The smallest eigenvalue of P in units of the variances of `unit`; -infinity where P is not
/// finite.
template <class Covariance, class Unit>
double smallestEigenvalue(const Eigen::MatrixBase<Covariance> &P,
                          const Eigen::MatrixBase<Unit> &unit)
{
    const Matrix<long double> C = dimensionless(P, unit);
    if (!P.allFinite() || !C.allFinite()) return -infinite;
    const Eigen::SelfAdjointEigenSolver<Matrix<long double>> solver(C, Eigen::EigenvaluesOnly);
    return static_cast<double>(solver.eigenvalues()(0));
}

/// The same of the correlation matrix of P.
template <class Covariance> double smallestEigenvalue(const Eigen::MatrixBase<Covariance> &P)
{
    return smallestEigenvalue(P, P);
}

/// What rounding alone may take from that eigenvalue where P = S S' is multiplied out in T: up to
/// (n + 1) eps / 2 of sigma_i sigma_j in each entry, so n times that in norm.
template <class T> double eigenvalueRounding(Eigen::Index n)
{
    const double entry = static_cast<double>(n + 1) / 2 * kq::epsilon<T>();
    return static_cast<double>(n) * entry;
}

} // namespace reference

#endif
