#include "decompositions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace reference
{

template <class Real> static void swapRows(Matrix<Real> &M, Index a, Index b)
{
    for (Index j = 0; j < M.cols(); ++j) std::swap(M(a, j), M(b, j));
}

// ------------------------------------------------------------------ reflections, and rank

/// X <- H X from column `first` on,  H = I - tau v v' over the rows from k on, v_k = 1, the rest of v as packed below R_kk
template <class Real>
static void reflect(Matrix<Real> &X, const Matrix<Real> &packed, const Real &tau, Index k, Index first = 0)
{
    for (Index j = first; j < X.cols(); ++j) {
        Real along = X(k, j);
        for (Index i = k + 1; i < X.rows(); ++i) along += packed(i, k) * X(i, j);
        along *= tau;
        X(k, j) -= along;
        for (Index i = k + 1; i < X.rows(); ++i) X(i, j) -= along * packed(i, k);
    }
}

/// M P = Q R by Householder's reflections: R over the diagonal, their vectors below it
template <class Real> struct Qr {
    Matrix<Real> packed;
    std::vector<Real> tau;
    std::vector<Index> column; // of M, in the order of P

    /// X <- Q'X
    void turn(Matrix<Real> &X) const
    {
        for (std::size_t k = 0; k < tau.size(); ++k) reflect(X, packed, tau[k], static_cast<Index>(k));
    }
    Vector<Real> pivots() const { return packed.diagonal().cwiseAbs(); }
    Index rank(const Real &threshold) const
    {
        const Vector<Real> all = pivots();
        const Real least = all.size() > 0 ? threshold * all.maxCoeff() : threshold;
        return std::count_if(all.begin(), all.end(), [&](const Real &x) { return x > least; });
    }
};

/// Brings the largest of the columns that are left to the front.
template <class Real> static void choosePivot(Qr<Real> &qr, Index k)
{
    Matrix<Real> &M = qr.packed;
    Index best = k;
    Real most(-1);
    for (Index j = k; j < M.cols(); ++j) {
        Real square(0);
        for (Index i = k; i < M.rows(); ++i) square += M(i, j) * M(i, j);
        if (square > most) best = j, most = square;
    }
    for (Index i = 0; i < M.rows(); ++i) std::swap(M(i, k), M(i, best));
    std::swap(qr.column[static_cast<std::size_t>(k)], qr.column[static_cast<std::size_t>(best)]);
}

template <class Real> static Qr<Real> factored(const Matrix<Real> &given, bool isPivoted)
{
    Qr<Real> qr{given, {}, std::vector<Index>(static_cast<std::size_t>(given.cols()))};
    std::iota(qr.column.begin(), qr.column.end(), Index(0));
    Matrix<Real> &M = qr.packed;
    for (Index k = 0; k < std::min(M.rows(), M.cols()); ++k) {
        if (isPivoted) choosePivot(qr, k);
        Real square(0);
        for (Index i = k + 1; i < M.rows(); ++i) square += M(i, k) * M(i, k);
        qr.tau.push_back(Real(0));
        if (square == Real(0)) continue;
        const Real size = squareRoot(M(k, k) * M(k, k) + square);
        const Real beta = M(k, k) >= Real(0) ? -size : size, first = M(k, k) - beta;
        for (Index i = k + 1; i < M.rows(); ++i) M(i, k) /= first;
        qr.tau.back() = -first / beta;
        M(k, k) = beta;
        reflect(M, M, qr.tau.back(), k, k + 1);
    }
    return qr;
}

template <class Real> PivotedQr<Real> pivotedQr(const Matrix<Real> &M)
{
    const Index count = std::min(M.rows(), M.cols());
    return pivotedQr(M, std::numeric_limits<Real>::epsilon() * static_cast<Real>(static_cast<double>(count)));
}

template <class Real> PivotedQr<Real> pivotedQr(const Matrix<Real> &M, const Real &threshold)
{
    const Qr<Real> qr = factored(M, true);
    return {qr.pivots(), qr.rank(threshold), threshold};
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
    const Qr<Real> qr = factored(M, true);
    const Index rank = qr.rank(threshold), n = M.cols();
    const Qr<Real> second = factored(Matrix<Real>(qr.packed.upperTriangle().topRows(rank).transpose()), true);

    Matrix<Real> X = Matrix<Real>::Identity(M.rows(), M.rows()); // becomes Q'
    qr.turn(X);
    const Matrix<Real> permuted = X.chooseRows(second.column); // P2' of its first rows
    const Matrix<Real> lower = second.packed.topRows(rank).transpose();
    Matrix<Real> Y = Matrix<Real>::Zero(n, M.rows());
    if (rank > 0) Y.block(0, 0, rank, M.rows()) = solveLower(lower, permuted);
    for (Index k = rank; k-- > 0;) reflect(Y, second.packed, second.tau[static_cast<std::size_t>(k)], k);

    Matrix<Real> inverse(n, M.rows());
    for (Index k = 0; k < n; ++k) inverse.row(qr.column[static_cast<std::size_t>(k)]) = Y.row(k).eval();
    return {inverse, second.pivots().head(rank), rank};
}

// ------------------------------------------------------------------ elimination

template <class Real> std::optional<Matrix<Real>> choleskyRoot(const Matrix<Real> &M)
{
    Matrix<Real> L = Matrix<Real>::Zero(M.rows(), M.rows());
    for (Index j = 0; j < M.rows(); ++j) {
        for (Index i = j; i < M.rows(); ++i) {
            Real sum = M(i, j);
            for (Index k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
            if (i == j && !(sum > Real(0))) return std::nullopt;
            L(i, j) = i == j ? squareRoot(sum) : sum / L(j, j);
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

template <class Real> Matrix<Real> solve(const Matrix<Real> &M, const Matrix<Real> &B)
{
    Matrix<Real> U = M, X = B;
    for (Index k = 0; k < U.rows(); ++k) {
        Index pivot = k;
        for (Index i = k + 1; i < U.rows(); ++i) {
            if (magnitude(U(i, k)) > magnitude(U(pivot, k))) pivot = i;
        }
        swapRows(U, k, pivot);
        swapRows(X, k, pivot);
        for (Index i = k + 1; i < U.rows(); ++i) {
            const Real factor = U(i, k) / U(k, k);
            for (Index j = k + 1; j < U.cols(); ++j) U(i, j) -= factor * U(k, j);
            for (Index j = 0; j < X.cols(); ++j) X(i, j) -= factor * X(k, j);
        }
    }
    return solveUpper(U, X);
}

template <class Real> Matrix<Real> inverse(const Matrix<Real> &M)
{
    return solve(M, Matrix<Real>(Matrix<Real>::Identity(M.rows(), M.rows())));
}

LeastSquares leastSquares(const Matrix<long double> &M, const Vector<long double> &right)
{
    const Qr<long double> qr = factored(M, false);
    Matrix<long double> turned = right;
    qr.turn(turned);
    return {solveUpper(qr.packed, Matrix<long double>(turned.topRows(M.cols()))),
            solveUpper(qr.packed, Matrix<long double>::Identity(M.cols(), M.cols()))};
}

Matrix<double> orthogonalFactor(const Matrix<double> &M)
{
    Matrix<double> turned = Matrix<double>::Identity(M.rows(), M.rows());
    factored(M, false).turn(turned);
    return turned.transpose();
}

/// A column from the largest variance that is left, until none is
Matrix<double> samplingRoot(const Matrix<double> &covariance)
{
    Matrix<double> left = covariance, root = Matrix<double>::Zero(left.rows(), left.rows());
    for (Index k = 0; k < left.rows(); ++k) {
        const Vector<double> variances = left.diagonal();
        const Index i = std::max_element(variances.begin(), variances.end()) - variances.begin();
        if (!(variances(i) > 0)) break;
        root.col(k) = left.col(i).eval() / std::sqrt(variances(i));
        left -= root.col(k).eval() * root.col(k).transpose();
        left.row(i).setZero();
        left.col(i).setZero();
    }
    return root;
}

// ------------------------------------------------------------------ eigenvalues

/// A rotation that makes M_ij 0 (Jacobi)
static void rotate(Matrix<long double> &M, Index i, Index j)
{
    const long double theta = (M(j, j) - M(i, i)) / (2 * M(i, j));
    const long double t = (theta < 0 ? -1 : 1) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
    const long double c = 1 / std::sqrt(t * t + 1), s = t * c;
    for (Index k = 0; k < M.rows(); ++k) {
        const long double a = M(k, i), b = M(k, j);
        M(k, i) = c * a - s * b, M(k, j) = s * a + c * b;
    }
    for (Index k = 0; k < M.rows(); ++k) {
        const long double a = M(i, k), b = M(j, k);
        M(i, k) = c * a - s * b, M(j, k) = s * a + c * b;
    }
    M(i, j) = M(j, i) = 0;
}

Vector<long double> symmetricEigenvalues(const Matrix<long double> &M)
{
    if (!M.allFinite()) return Vector<long double>::Constant(M.rows(), std::numeric_limits<long double>::quiet_NaN());
    Matrix<long double> D = M;
    const long double least = 1e-22L * M.norm();
    for (bool rests = false; !rests;) {
        rests = true;
        for (Index i = 0; i < D.rows(); ++i) {
            for (Index j = i + 1; j < D.rows(); ++j) {
                if (std::fabs(D(i, j)) <= least) continue;
                rotate(D, i, j);
                rests = false;
            }
        }
    }
    Vector<long double> values = D.diagonal();
    std::sort(values.begin(), values.end());
    return values;
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
    template Matrix<Real> solveLower(const Matrix<Real> &, const Matrix<Real> &);                  \
    template Matrix<Real> solve(const Matrix<Real> &, const Matrix<Real> &);                       \
    template Matrix<Real> inverse(const Matrix<Real> &);

INSTANTIATE(double)
INSTANTIATE(long double)
INSTANTIATE(Quad)

} // namespace reference
