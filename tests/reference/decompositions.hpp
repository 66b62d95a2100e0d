// Decompositions of matrices, most of them Eigen's, each compiled once for the number types that
// are named here.
#ifndef KALMANQ_TESTS_REFERENCE_DECOMPOSITIONS_HPP
#define KALMANQ_TESTS_REFERENCE_DECOMPOSITIONS_HPP

#include <optional>

#include "matrix.hpp"
#include "quad.hpp"

namespace reference
{

// ------------------------------------------------------------------ rank, in double and wider

/// M P = Q R with R_00, R_11, ... falling in size; a pivot below `threshold` of the largest is 0.
template <class Real> struct PivotedQr {
    Vector<Real> pivots; // |R_ii|
    Index rank;
    Real threshold;
};

/// Without a threshold: the epsilon times the number of pivots.
template <class Real> PivotedQr<Real> pivotedQr(const Matrix<Real> &M);
template <class Real> PivotedQr<Real> pivotedQr(const Matrix<Real> &M, const Real &threshold);

/// From the complete orthogonal decomposition M P = Q T Z.
template <class Real> struct PseudoInverse {
    Matrix<Real> inverse;
    Vector<Real> pivots; // |T_ii|, as many as the rank
    Index rank;
};

template <class Real>
PseudoInverse<Real> pseudoInverse(const Matrix<Real> &M, const Real &threshold);

// ------------------------------------------------------------------ elimination

/// L of M = L L', or nothing where M is not positive definite; double, long double, Quad.
template <class Real> std::optional<Matrix<Real>> choleskyRoot(const Matrix<Real> &M);

/// L^-1 B, L lower triangular; double, long double, Quad.
template <class Real> Matrix<Real> solveLower(const Matrix<Real> &L, const Matrix<Real> &B);

/// M^-1 B by elimination with row pivots.
Matrix<Quad> solve(const Matrix<Quad> &M, const Matrix<Quad> &B);
Matrix<Quad> inverse(const Matrix<Quad> &M);

/// By Eigen: the random models are made with it, to the last bit.
Matrix<double> inverse(const Matrix<double> &M);

/// The x that makes |M x - right| least, and R^-1, R'R = M'M; M of full column rank.
struct LeastSquares {
    Vector<long double> solution;
    Matrix<long double> inverseRoot;
};

LeastSquares leastSquares(const Matrix<long double> &M, const Vector<long double> &right);

/// Q of M = Q R, M square
Matrix<double> orthogonalFactor(const Matrix<double> &M);

/// A root for sampling, of a covariance that may be singular.
Matrix<double> samplingRoot(const Matrix<double> &covariance);

// ------------------------------------------------------------------ eigenvalues

/// Of a symmetric matrix, rising; NaN where the iteration fails.
Vector<long double> symmetricEigenvalues(const Matrix<long double> &M);

/// The largest |eigenvalue|, as the limit of |A^k|^(1/k).
double spectralRadius(const Matrix<double> &A);

} // namespace reference

#endif
