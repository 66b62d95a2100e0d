// Eigen, its numbers and its view of our matrices.  For source files of the reference library only:
// whoever includes it compiles Eigen anew.
#ifndef KALMANQ_TESTS_REFERENCE_EIGEN_HPP
#define KALMANQ_TESTS_REFERENCE_EIGEN_HPP

#include <Eigen/Dense>

#include "matrix.hpp"
#include "quad.hpp"

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

template <class Real> using EigenMatrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
template <class Real> using EigenVector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

template <class Real> EigenMatrix<Real> toEigen(const Matrix<Real> &M)
{
    return Eigen::Map<const EigenMatrix<Real>>(M.data(), M.rows(), M.cols());
}

template <class Real> Matrix<Real> fromEigen(const EigenMatrix<Real> &M)
{
    Matrix<Real> result(M.rows(), M.cols());
    std::copy(M.data(), M.data() + M.size(), result.begin());
    return result;
}

} // namespace reference

#endif
