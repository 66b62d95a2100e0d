// Vectors and matrices of __float128 on plain arrays, for up to 8 states.
#ifndef KALMANQ_TESTS_CAMPAIGN_ARRAYS_HPP
#define KALMANQ_TESTS_CAMPAIGN_ARRAYS_HPP

#include <quadmath.h>

#include <array>

namespace campaign
{

using Real = __float128;

constexpr int maxStates = 8, maxComponents = 3;

using Vec = std::array<Real, maxStates>;
using Mat = std::array<Vec, maxStates>;

/// What is below this share of the terms that it is the sum of is 0: between the rounding of
/// __float128 and anything that a model can hold.
constexpr double redundant = 0x1p-80;

inline Real dot(const Vec &a, const Vec &b, int n)
{
    Real sum = 0;
    for (int k = 0; k < n; ++k) sum += a[k] * b[k];
    return sum;
}

inline Vec times(const Mat &M, const Vec &x, int n)
{
    Vec y{};
    for (int i = 0; i < n; ++i) y[i] = dot(M[i], x, n);
    return y;
}

/// M' x
inline Vec transposedTimes(const Mat &M, const Vec &x, int n)
{
    Vec y{};
    for (int k = 0; k < n; ++k) {
        for (int i = 0; i < n; ++i) y[i] += M[k][i] * x[k];
    }
    return y;
}

inline Mat times(const Mat &A, const Mat &B, int n)
{
    Mat C{};
    for (int i = 0; i < n; ++i) {
        for (int k = 0; k < n; ++k) {
            if (A[i][k] == 0) continue;
            for (int j = 0; j < n; ++j) C[i][j] += A[i][k] * B[k][j];
        }
    }
    return C;
}

inline Mat transposed(const Mat &M, int n)
{
    Mat T{};
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) T[i][j] = M[j][i];
    }
    return T;
}

inline Mat plus(const Mat &A, const Mat &B, int n)
{
    Mat C{};
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) C[i][j] = A[i][j] + B[i][j];
    }
    return C;
}

/// A P A', P symmetric
inline Mat sandwich(const Mat &A, const Mat &P, int n)
{
    const Mat AP = times(A, P, n);
    Mat C{};
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j <= i; ++j) C[i][j] = C[j][i] = dot(AP[i], A[j], n);
    }
    return C;
}

/// F F', `width` columns
inline Mat square(const Mat &F, int n, int width)
{
    Mat C{};
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j <= i; ++j) C[i][j] = C[j][i] = dot(F[i], F[j], width);
    }
    return C;
}

/// P = L L'; a pivot that rounding explains is 0, and so is its column.
inline Mat lowerRoot(const Mat &P, int n)
{
    Mat L{};
    for (int j = 0; j < n; ++j) {
        const Real rest = P[j][j] - dot(L[j], L[j], j);
        if (!(rest > redundant * P[j][j])) continue;
        L[j][j] = sqrtq(rest);
        for (int i = j + 1; i < n; ++i) L[i][j] = (P[i][j] - dot(L[i], L[j], j)) / L[j][j];
    }
    return L;
}

/// The standard deviation of a state; no less than 0.
inline Real sigma(const Mat &P, int i) { return P[i][i] > 0 ? sqrtq(P[i][i]) : Real(0); }

} // namespace campaign

#endif
