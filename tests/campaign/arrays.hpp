// Matrices of __float128: products that are symmetric, roots, and what counts as 0.
#ifndef KALMANQ_TESTS_CAMPAIGN_ARRAYS_HPP
#define KALMANQ_TESTS_CAMPAIGN_ARRAYS_HPP

#include "../reference/matrix.hpp"
#include "../reference/quad.hpp"

namespace campaign
{

using reference::Index;
using reference::Matrix;
using reference::Vector;
using Real = reference::Quad;
using Vec = Vector<Real>;
using Mat = Matrix<Real>;

/// What is below this share of the terms that it is the sum of is 0: between the rounding of
/// __float128 and anything that a model can hold.
constexpr double redundant = 0x1p-80;

/// A B', where that is symmetric
inline Mat symmetricProduct(const Mat &A, const Mat &B)
{
    const Index n = A.rows();
    Mat C(n, n);
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j <= i; ++j) {
            Real sum = 0;
            for (Index k = 0; k < A.cols(); ++k) sum += A(i, k) * B(j, k);
            C(i, j) = C(j, i) = sum;
        }
    }
    return C;
}

/// A P A', P symmetric
inline Mat sandwich(const Mat &A, const Mat &P) { return symmetricProduct(A * P, A); }

/// F F'
inline Mat square(const Mat &F) { return symmetricProduct(F, F); }

/// P = L L'; a pivot that rounding explains is 0, and so is its column.
inline Mat lowerRoot(const Mat &P)
{
    const Index n = P.rows();
    Mat L = Mat::Zero(n, n);
    for (Index j = 0; j < n; ++j) {
        const auto rest = [&](Index i) {
            Real taken = 0;
            for (Index k = 0; k < j; ++k) taken += L(i, k) * L(j, k);
            return P(i, j) - taken;
        };
        const Real pivot = rest(j);
        if (!(pivot > redundant * P(j, j))) continue;
        L(j, j) = sqrt(pivot);
        for (Index i = j + 1; i < n; ++i) L(i, j) = rest(i) / L(j, j);
    }
    return L;
}

/// The standard deviation of a state; no less than 0.
inline Real sigma(const Mat &P, Index i) { return P(i, i) > 0 ? sqrt(P(i, i)) : Real(0); }

} // namespace campaign

#endif
