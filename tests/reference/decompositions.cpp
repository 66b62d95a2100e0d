#include "decompositions.hpp"

#include "eigen.hpp"

namespace reference
{

template <class Real> static PivotedQr<Real> read(const Eigen::ColPivHouseholderQR<EigenMatrix<Real>> &qr)
{
    const EigenMatrix<Real> pivots = qr.matrixR().diagonal().cwiseAbs();
    return {fromEigen<Real>(pivots), qr.rank(), qr.threshold()};
}

template <class Real> PivotedQr<Real> pivotedQr(const Matrix<Real> &M)
{
    return read<Real>(Eigen::ColPivHouseholderQR<EigenMatrix<Real>>(toEigen(M)));
}

template <class Real> PivotedQr<Real> pivotedQr(const Matrix<Real> &M, const Real &threshold)
{
    Eigen::ColPivHouseholderQR<EigenMatrix<Real>> qr(M.rows(), M.cols());
    qr.setThreshold(threshold);
    qr.compute(toEigen(M));
    return read<Real>(qr);
}

template <class Real>
PseudoInverse<Real> pseudoInverse(const Matrix<Real> &M, const Real &threshold)
{
    Eigen::CompleteOrthogonalDecomposition<EigenMatrix<Real>> factors(M.rows(), M.cols());
    factors.setThreshold(threshold);
    factors.compute(toEigen(M));
    const EigenMatrix<Real> inverse = factors.pseudoInverse();
    const EigenMatrix<Real> pivots = factors.matrixT().diagonal().cwiseAbs();
    return {fromEigen<Real>(inverse), fromEigen<Real>(pivots), factors.rank()};
}

template <class Real> std::optional<Matrix<Real>> choleskyRoot(const Matrix<Real> &M)
{
    const Eigen::LLT<EigenMatrix<Real>> factors(toEigen(M));
    if (factors.info() != Eigen::Success) return std::nullopt;
    return fromEigen<Real>(factors.matrixL());
}

template <class Real> Matrix<Real> solveLower(const Matrix<Real> &L, const Matrix<Real> &B)
{
    const EigenMatrix<Real> lower = toEigen(L);
    return fromEigen<Real>(lower.template triangularView<Eigen::Lower>().solve(toEigen(B)));
}

Matrix<double> samplingRoot(const Matrix<double> &covariance)
{
    const Eigen::LDLT<EigenMatrix<double>> factors(toEigen(covariance));
    const EigenVector<double> pivots = factors.vectorD().cwiseMax(0).cwiseSqrt();
    const EigenMatrix<double> lower = factors.matrixL();
    const EigenMatrix<double> scaled = lower * pivots.asDiagonal();
    return fromEigen<double>(factors.transpositionsP().transpose() * scaled);
}

template <class Real> Matrix<Real> inverse(const Matrix<Real> &M)
{
    return fromEigen<Real>(toEigen(M).inverse());
}

Matrix<Quad> solve(const Matrix<Quad> &M, const Matrix<Quad> &right)
{
    return fromEigen<Quad>(toEigen(M).partialPivLu().solve(toEigen(right)));
}

LeastSquares leastSquares(const Matrix<long double> &M, const Vector<long double> &right)
{
    const Index columns = M.cols();
    const Eigen::HouseholderQR<EigenMatrix<long double>> factors(toEigen(M));
    const EigenMatrix<long double> R = factors.matrixQR().topRows(columns);
    const EigenMatrix<long double> turned = factors.householderQ().adjoint() * toEigen(right);
    const auto upper = R.triangularView<Eigen::Upper>();
    const EigenMatrix<long double> top = turned.topRows(columns);
    return {fromEigen<long double>(upper.solve(top)),
            fromEigen<long double>(
                upper.solve(EigenMatrix<long double>::Identity(columns, columns)))};
}

Matrix<double> orthogonalFactor(const Matrix<double> &M)
{
    const Eigen::HouseholderQR<EigenMatrix<double>> factors(toEigen(M));
    return fromEigen<double>(factors.householderQ() *
                             EigenMatrix<double>::Identity(M.rows(), M.rows()));
}

template <class Real> Vector<Real> symmetricEigenvalues(const Matrix<Real> &M)
{
    const Eigen::SelfAdjointEigenSolver<EigenMatrix<Real>> solver(toEigen(M),
                                                                  Eigen::EigenvaluesOnly);
    if (solver.info() == Eigen::Success) return fromEigen<Real>(solver.eigenvalues());
    return Vector<Real>::Constant(M.rows(), std::numeric_limits<Real>::quiet_NaN());
}

double spectralRadius(const Matrix<double> &A)
{
    const Eigen::EigenSolver<EigenMatrix<double>> solver(toEigen(A), false);
    return solver.eigenvalues().cwiseAbs().maxCoeff();
}

#define INSTANTIATE(Real)                                                                          \
    template PivotedQr<Real> pivotedQr(const Matrix<Real> &);                                      \
    template PivotedQr<Real> pivotedQr(const Matrix<Real> &, const Real &);                        \
    template PseudoInverse<Real> pseudoInverse(const Matrix<Real> &, const Real &);                \
    template std::optional<Matrix<Real>> choleskyRoot(const Matrix<Real> &);                       \
    template Matrix<Real> solveLower(const Matrix<Real> &, const Matrix<Real> &);

INSTANTIATE(double)
INSTANTIATE(long double)
INSTANTIATE(Quad)
template Matrix<double> inverse(const Matrix<double> &);
template Matrix<Quad> inverse(const Matrix<Quad> &);
template Vector<double> symmetricEigenvalues(const Matrix<double> &);
template Vector<long double> symmetricEigenvalues(const Matrix<long double> &);

} // namespace reference
