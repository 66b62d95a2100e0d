#include "decompositions.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace reference
{

// ------------------------------------------------------------------ rank

template <class Real> using EigenQr = Eigen::ColPivHouseholderQR<EigenMatrix<Real>>;

template <class Real> static PivotedQr<Real> read(const EigenQr<Real> &qr)
{
    return {qr.matrixQR().diagonal().cwiseAbs(), qr.rank(), qr.threshold()};
}

template <class Real> PivotedQr<Real> pivotedQr(const Matrix<Real> &M)
{
    return read<Real>(EigenQr<Real>(M));
}

template <class Real> static EigenQr<Real> eigenQr(const Matrix<Real> &M, const Real &threshold)
{
    EigenQr<Real> qr(M.rows(), M.cols());
    qr.setThreshold(threshold);
    qr.compute(M);
    return qr;
}

template <class Real> PivotedQr<Real> pivotedQr(const Matrix<Real> &M, const Real &threshold)
{
    return read<Real>(eigenQr(M, threshold));
}

/// X <- H X,  H = I - tau v v' over the rows from k on, v_k = 1, the rest of v as packed below R_kk
template <class Real>
static void reflect(Matrix<Real> &X, const Matrix<Real> &packed, const Real &tau, Index k)
{
    for (Index j = 0; j < X.cols(); ++j) {
        Real along = X(k, j);
        for (Index i = k + 1; i < X.rows(); ++i) along += packed(i, k) * X(i, j);
        along *= tau;
        X(k, j) -= along;
        for (Index i = k + 1; i < X.rows(); ++i) X(i, j) -= along * packed(i, k);
    }
}

/// R^-1 B, R the upper triangle
template <class Real> static Matrix<Real> solveUpper(const Matrix<Real> &R, Matrix<Real> B)
{
    for (Index j = 0; j < B.cols(); ++j) {
        for (Index i = B.rows() - 1; i >= 0; --i) {
            for (Index k = i + 1; k < B.rows(); ++k) B(i, j) -= R(i, k) * B(k, j);
            B(i, j) /= R(i, i);
        }
    }
    return B;
}

/// Of rank r: M P = Q [C; 0] with C r x n, C' P2 = Q2 T'; the inverse is P Q2 T'^-1' P2' Q'.
template <class Real>
PseudoInverse<Real> pseudoInverse(const Matrix<Real> &M, const Real &threshold)
{
    const EigenQr<Real> qr = eigenQr(M, threshold);
    const Matrix<Real> packed = qr.matrixQR();
    const Index rank = qr.rank(), n = M.cols();
    const Matrix<Real> C = packed.topRows(rank).template triangularView<Eigen::Upper>();
    const EigenQr<Real> second = eigenQr(C.transpose(), Real(0));
    const Matrix<Real> turned = second.matrixQR();

    Matrix<Real> X = Matrix<Real>::Identity(M.rows(), M.rows()); // becomes Q'
    for (Index k = 0; k < std::min(M.rows(), n); ++k) reflect(X, packed, qr.hCoeffs()(k), k);
    Matrix<Real> permuted(rank, M.rows()); // P2' of its first rows
    for (Index k = 0; k < rank; ++k) {
        permuted.row(k) = X.row(second.colsPermutation().indices()(k));
    }
    const Matrix<Real> solved = solveLower<Real>(turned.topRows(rank).transpose(), permuted);
    Matrix<Real> Y = Matrix<Real>::Zero(n, M.rows());
    if (rank > 0) Y.block(0, 0, rank, M.rows()) = solved;
    for (Index k = rank; k-- > 0;) reflect(Y, turned, second.hCoeffs()(k), k);

    Matrix<Real> inverse(n, M.rows());
    for (Index k = 0; k < n; ++k) {
        inverse.row(qr.colsPermutation().indices()(k)) = Y.row(k);
    }
    return {inverse, read<Real>(second).pivots.topRows(rank), rank};
}

// ------------------------------------------------------------------ elimination

// Written out: Eigen's root and its triangular solver, of three number types, take 20 seconds to compile.
template <class Real> std::optional<Matrix<Real>> choleskyRoot(const Matrix<Real> &M)
{
    Matrix<Real> L = Matrix<Real>::Zero(M.rows(), M.rows());
    for (Index j = 0; j < M.rows(); ++j) {
        for (Index i = j; i < M.rows(); ++i) {
            Real rest = M(i, j);
            for (Index k = 0; k < j; ++k) rest -= L(i, k) * L(j, k);
            if (i == j && !(rest > Real(0))) return std::nullopt;
            L(i, j) = i == j ? squareRoot(rest) : rest / L(j, j);
        }
    }
    return L;
}

template <class Real> Matrix<Real> solveLower(const Matrix<Real> &L, const Matrix<Real> &B)
{
    Matrix<Real> X = B;
    for (Index j = 0; j < X.cols(); ++j) {
        for (Index i = 0; i < X.rows(); ++i) {
            for (Index k = 0; k < i; ++k) X(i, j) -= L(i, k) * X(k, j);
            X(i, j) /= L(i, i);
        }
    }
    return X;
}

Matrix<Quad> solve(const Matrix<Quad> &M, const Matrix<Quad> &B)
{
    Matrix<Quad> U = M, X = B;
    for (Index k = 0; k < U.rows(); ++k) {
        Index pivot = k;
        for (Index i = k + 1; i < U.rows(); ++i) {
            if (abs(U(i, k)) > abs(U(pivot, k))) pivot = i;
        }
        U.row(k).swap(U.row(pivot));
        X.row(k).swap(X.row(pivot));
        for (Index i = k + 1; i < U.rows(); ++i) {
            const Quad factor = U(i, k) / U(k, k);
            for (Index j = k + 1; j < U.cols(); ++j) U(i, j) -= factor * U(k, j);
            for (Index j = 0; j < X.cols(); ++j) X(i, j) -= factor * X(k, j);
        }
    }
    return solveUpper(U, X);
}

Matrix<Quad> inverse(const Matrix<Quad> &M)
{
    return solve(M, Matrix<Quad>::Identity(M.rows(), M.rows()));
}

Matrix<double> inverse(const Matrix<double> &M) { return inverse(M.cast<Quad>()).cast<double>(); }

/// R over the diagonal and Householder's vectors below it in place of M, and Q' X in place of X
template <class Real> static void householder(Matrix<Real> &M, Matrix<Real> &X)
{
    for (Index k = 0; k < M.cols(); ++k) {
        Real square(0);
        for (Index i = k + 1; i < M.rows(); ++i) square += M(i, k) * M(i, k);
        if (square == Real(0)) continue;
        const Real size = squareRoot(M(k, k) * M(k, k) + square);
        const Real beta = M(k, k) >= Real(0) ? -size : size;
        const Real tau = (beta - M(k, k)) / beta, first = M(k, k) - beta;
        for (Index i = k + 1; i < M.rows(); ++i) M(i, k) /= first;
        Matrix<Real> right = M.block(0, k + 1, M.rows(), M.cols() - k - 1);
        reflect(right, M, tau, k);
        reflect(X, M, tau, k);
        M.block(0, k + 1, M.rows(), M.cols() - k - 1) = right;
        M(k, k) = beta;
    }
}

LeastSquares leastSquares(const Matrix<long double> &M, const Vector<long double> &right)
{
    const Index columns = M.cols();
    Matrix<long double> R = M, turned = right;
    householder(R, turned);
    return {solveUpper(R, Matrix<long double>(turned.topRows(columns))),
            solveUpper(R, Matrix<long double>::Identity(columns, columns))};
}

Matrix<double> orthogonalFactor(const Matrix<double> &M)
{
    Matrix<double> R = M, turned = Matrix<double>::Identity(M.rows(), M.rows());
    householder(R, turned);
    return turned.transpose();
}

Matrix<double> samplingRoot(const Matrix<double> &covariance)
{
    const Eigen::LDLT<EigenMatrix<double>> factors(covariance);
    const Matrix<double> pivots = factors.vectorD().cwiseMax(0).cwiseSqrt(), lower = factors.matrixL();
    return factors.transpositionsP().transpose() * (lower * pivots.asDiagonal());
}

// ------------------------------------------------------------------ eigenvalues

Vector<long double> symmetricEigenvalues(const Matrix<long double> &M)
{
    // in two steps: the whole, which could yield vectors, takes 5 seconds more to compile
    const Eigen::Tridiagonalization<EigenMatrix<long double>> form(M);
    Eigen::SelfAdjointEigenSolver<EigenMatrix<long double>> solver(M.rows());
    solver.computeFromTridiagonal(form.diagonal(), form.subDiagonal(), Eigen::EigenvaluesOnly);
    if (solver.info() == Eigen::Success) return solver.eigenvalues();
    return Vector<long double>::Constant(M.rows(),
                                         std::numeric_limits<long double>::quiet_NaN());
}

double spectralRadius(const Matrix<double> &A)
{
    Matrix<Quad> power = A.cast<Quad>(); // A^(2^k) over e^(2^k logarithmOfScale)
    Quad logarithmOfScale(0), share(1);
    for (int k = 0; k < 64; ++k) {
        const Quad size = power.norm();
        if (size == 0) return 0;
        power /= size;
        logarithmOfScale += share * logarithm(size);
        power = power * power;
        share /= Quad(2);
    }
    return std::exp(static_cast<double>(logarithmOfScale));
}

// ------------------------------------------------------------------ the number types

#define INSTANTIATE(Real)                                                                          \
    template PivotedQr<Real> pivotedQr(const Matrix<Real> &);                                      \
    template PivotedQr<Real> pivotedQr(const Matrix<Real> &, const Real &);                        \
    template PseudoInverse<Real> pseudoInverse(const Matrix<Real> &, const Real &);                \
    template std::optional<Matrix<Real>> choleskyRoot(const Matrix<Real> &);                       \
    template Matrix<Real> solveLower(const Matrix<Real> &, const Matrix<Real> &);

INSTANTIATE(double)
INSTANTIATE(long double)
INSTANTIATE(Quad)

} // namespace reference
