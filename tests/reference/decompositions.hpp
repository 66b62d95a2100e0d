// Decompositions of matrices, by Eigen, each compiled once for the number types that are named here.
#ifndef KALMANQ_TESTS_REFERENCE_DECOMPOSITIONS_HPP
#define KALMANQ_TESTS_REFERENCE_DECOMPOSITIONS_HPP

#include <optional>

#include "matrix.hpp"
#include "quad.hpp"

namespace reference
{

/// M P = Q R with R_00, R_11, ... falling in size; a pivot below `threshold` of the largest is 0.
template <class Real> struct PivotedQr {
    Vector<Real> pivots; // |R_ii|
    Index rank;
    Real threshold;
};

/// double, long double, Quad; without a threshold: the epsilon times the number of pivots.
template <class Real> PivotedQr<Real> pivotedQr(const Matrix<Real> &M);
template <class Real> PivotedQr<Real> pivotedQr(const Matrix<Real> &M, const Real &threshold);

/// From a complete orthogonal decomposition M P = Q T Z.
template <class Real> struct PseudoInverse {
    Matrix<Real> inverse;
    Vector<Real> pivots; // |T_ii|, the first `rank` of them count
    Index rank;
};

/// double, long double, Quad.
template <class Real>
PseudoInverse<Real> pseudoInverse(const Matrix<Real> &M, const Real &threshold);

/// L of M = L L', or nothing where M is not positive definite; double, long double, Quad.
template <class Real> std::optional<Matrix<Real>> choleskyRoot(const Matrix<Real> &M);

/// L^-1 B, L lower triangular; double, long double, Quad.
template <class Real> Matrix<Real> solveLower(const Matrix<Real> &L, const Matrix<Real> &B);

/// A root for sampling, of a covariance that may be singular.
Matrix<double> samplingRoot(const Matrix<double> &covariance);

/// By LU with partial pivoting; double, Quad.
template <class Real> Matrix<Real> inverse(const Matrix<Real> &M);
Matrix<Quad> solve(const Matrix<Quad> &M, const Matrix<Quad> &right);

/// The x that makes |M x - right| least, and R^-1, R'R = M'M; M of full column rank.
struct LeastSquares {
    Vector<long double> solution;
    Matrix<long double> inverseRoot;
};

LeastSquares leastSquares(const Matrix<long double> &M, const Vector<long double> &right);

/// Q of M = Q R
Matrix<double> orthogonalFactor(const Matrix<double> &M);

/// Of a symmetric matrix, rising; NaN where the iteration fails; double, long double.
template <class Real> Vector<Real> symmetricEigenvalues(const Matrix<Real> &M);

/// The largest |eigenvalue|
double spectralRadius(const Matrix<double> &A);

} // namespace reference

#endif
