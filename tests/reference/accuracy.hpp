// How far an estimate is from the reference, without units.
#ifndef KALMANQ_TESTS_REFERENCE_ACCURACY_HPP
#define KALMANQ_TESTS_REFERENCE_ACCURACY_HPP

#include <algorithm>
#include <limits>

#include "api.hpp"
#include "textbook.hpp"

namespace reference
{

constexpr double infinite = std::numeric_limits<double>::infinity();

/// |error| / unit; where the unit is 0 the error has to be 0 too.  Never a NaN.
double ratio(const Quad &error, const Quad &unit);

/// sqrt(P_ii), 0 where P_ii is not above 0.
Vector<Quad> sigmas(const Matrix<Quad> &P);

/// The same, but of `prior` where noise-free measurements leave less than `floor` of its variance:
/// beside the prior such a variance is 0 to the arithmetic.
Vector<Quad> sigmas(const Matrix<Quad> &P, const Matrix<Quad> &prior, double floor);

/// max |x - x_ref|_i / sigma_i
double meanError(const Vector<Quad> &x, const Vector<Quad> &exact, const Vector<Quad> &sigma);

template <class Real>
double meanError(const Vector<Real> &x, const Vector<Quad> &exact, const Vector<Quad> &sigma)
{
    return meanError(x.template cast<Quad>(), exact, sigma);
}

/// max |P - P_ref|_ij / (left_i right_j)
double covarianceError(const Matrix<Quad> &P, const Matrix<Quad> &exact, const Vector<Quad> &left,
                       const Vector<Quad> &right);

template <class Real>
double covarianceError(const Matrix<Real> &P, const Matrix<Quad> &exact, const Vector<Quad> &left,
                       const Vector<Quad> &right)
{
    return covarianceError(P.template cast<Quad>(), exact, left, right);
}

template <class Real>
double covarianceError(const Matrix<Real> &P, const Matrix<Quad> &exact, const Vector<Quad> &sigma)
{
    return covarianceError(P, exact, sigma, sigma);
}

/// The largest errors of a mean and of a covariance so far
struct Worst {
    double x = 0, P = 0;

    template <class Real>
    void add(const Belief<Real> &mine, const Belief<Quad> &exact, const Vector<Quad> &sigma)
    {
        x = std::max(x, meanError(mine.mean, exact.mean, sigma));
        P = std::max(P, covarianceError(mine.covariance, exact.covariance, sigma));
    }

    template <class Real> void add(const Belief<Real> &mine, const Belief<Quad> &exact)
    {
        add(mine, exact, sigmas(exact.covariance));
    }
};

/// The smallest eigenvalue of P in units of the variances of `unit`; -infinity where P is not
/// finite, or is not 0 where `unit` is.
double smallestEigenvalue(const Matrix<long double> &P, const Matrix<long double> &unit);

template <class Real> double smallestEigenvalue(const Matrix<Real> &P, const Matrix<Real> &unit)
{
    return smallestEigenvalue(P.template cast<long double>(), unit.template cast<long double>());
}

/// The same of the correlation matrix of P.
template <class Real> double smallestEigenvalue(const Matrix<Real> &P)
{
    return smallestEigenvalue(P, P);
}

/// What rounding alone may take from that eigenvalue where P = S S' is multiplied out in T: up to
/// (n + 1) eps / 2 of sigma_i sigma_j in each entry, so n times that in norm.
template <class T> double eigenvalueRounding(Index n)
{
    const double entry = static_cast<double>(n + 1) / 2 * kq::epsilon<T>();
    return static_cast<double>(n) * entry;
}

/// What holds of an estimate without a reference
struct Soundness {
    bool sound = true;     // no NaN, no variance below 0
    double eigenvalue = 1; // the smallest of the correlations

    template <class Real> void inspectSound(const Belief<Real> &mine)
    {
        sound = sound && mine.mean.allFinite() && mine.covariance.allFinite() &&
                mine.covariance.diagonal().minCoeff() >= 0;
    }

    template <class Real> void inspect(const Belief<Real> &mine)
    {
        inspectSound(mine);
        eigenvalue = std::min(eigenvalue, smallestEigenvalue(mine.covariance));
    }

    /// The same with the sigmas that the library tells
    template <class Real> void inspect(const Belief<Real> &mine, const Vector<Real> &sigma)
    {
        inspect(mine);
        sound = sound && sigma.allFinite() && sigma.minCoeff() >= 0;
    }
};

} // namespace reference

#endif
