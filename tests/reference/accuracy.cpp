#include "accuracy.hpp"

#include <algorithm>
#include <cmath>

#include "decompositions.hpp"

namespace reference
{

double ratio(const Quad &error, const Quad &unit)
{
    const Quad size = abs(error);
    if (!isfinite(size)) return infinite;
    if (size == 0) return 0;
    return unit > 0 ? static_cast<double>(size / unit) : infinite;
}

Vector<Quad> sigmas(const Matrix<Quad> &P)
{
    return P.diagonal().unaryExpr([](const Quad &v) { return v > 0 ? sqrt(v) : Quad(0); });
}

Vector<Quad> sigmas(const Matrix<Quad> &P, const Matrix<Quad> &prior, double floor)
{
    Vector<Quad> result = sigmas(P);
    for (Index i = 0; i < P.rows(); ++i) {
        if (P(i, i) < Quad(floor) * prior(i, i)) result(i) = sqrt(prior(i, i));
    }
    return result;
}

double meanError(const Vector<Quad> &x, const Vector<Quad> &exact, const Vector<Quad> &sigma)
{
    double worst = 0;
    for (Index i = 0; i < x.size(); ++i) {
        worst = std::max(worst, ratio(x(i) - exact(i), sigma(i)));
    }
    return worst;
}

double covarianceError(const Matrix<Quad> &P, const Matrix<Quad> &exact, const Vector<Quad> &left,
                       const Vector<Quad> &right)
{
    double worst = 0;
    for (Index i = 0; i < P.rows(); ++i) {
        for (Index j = 0; j < P.cols(); ++j) {
            worst = std::max(worst, ratio(P(i, j) - exact(i, j), left(i) * right(j)));
        }
    }
    return worst;
}

/// D^-1 P D^-1 with D_ii = sqrt(unit_ii), in long double.  Where unit_ii is 0, row and column i
/// of P must be 0; if they are not, -infinity is put on the diagonal.
static Matrix<long double> dimensionless(const Matrix<long double> &P,
                                         const Matrix<long double> &unit)
{
    Matrix<long double> C = P;
    for (Index i = 0; i < P.rows(); ++i) {
        if (unit(i, i) > 0) {
            const long double sigma = std::sqrt(unit(i, i));
            C.row(i) /= sigma;
            C.col(i) /= sigma;
        } else if (!P.row(i).isZero(0) || !P.col(i).isZero(0)) {
            C(i, i) = -std::numeric_limits<long double>::infinity();
        }
    }
    return C;
}

double smallestEigenvalue(const Matrix<long double> &P, const Matrix<long double> &unit)
{
    const Matrix<long double> C = dimensionless(P, unit);
    if (!P.allFinite() || !C.allFinite()) return -infinite;
    const long double smallest = symmetricEigenvalues(C)(0);
    return std::isnan(smallest) ? -infinite : static_cast<double>(smallest);
}

} // namespace reference
