// An EKF as PX4's ekf2 has it, around the functions that SymForce has written (peers.py).  FORM: how P is updated.
#include "model.h"
enum { SHORT, STABILISED, WHOLE };  // P - K H P; Joseph's form by rank-one steps, as in PX4; P - K H P written by SymForce, too

using Vector = Eigen::Matrix<T, N, 1>;
using Square = Eigen::Matrix<T, N, N>;
using Controls = Eigen::Matrix<T, L, 1>;
static Vector x;
static Square P;

static T wrapped(T a)
{
    const T pi = T(3.14159265358979323846);
    return -pi <= a && a < pi ? a : a - 2 * pi * std::floor((a + pi) / (2 * pi));
}

template <int DIRECT> static Vector product(const Vector &H)
{
    Vector PH;
    for (int i = 0; i < N; i++) {
        T sum = DIRECT >= 0 ? P(i, DIRECT >= 0 ? DIRECT : 0) : T(0);
        for (int j = 0; DIRECT < 0 && j < N; j++) sum += P(i, j) * H(j, 0);
        PH(i, 0) = sum;
    }
    return PH;
}

template <int DIRECT> static Vector taken(const Vector &H, T S, T R)
{
    const Vector PH = product<DIRECT>(H);
    Vector K;
    const T inverse = 1 / S;
    for (int i = 0; i < N; i++) K(i, 0) = PH(i, 0) * inverse;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < (FORM == SHORT ? i + 1 : N); j++) P(i, j) -= K(i, 0) * PH(j, 0);
    const Vector again = FORM == STABILISED ? product<DIRECT>(H) : PH;
    for (int i = 0; i < N; i++)
        for (int j = 0; j <= i; j++) {
            if (FORM == STABILISED) P(i, j) += K(i, 0) * R * K(j, 0) - again(i, 0) * K(j, 0);
            P(j, i) = P(i, j);
        }
    return K;
}

extern "C" void peer_start(void)
{
    for (int i = 0; i < N; i++) {
        x(i, 0) = T(x0_[i]);
        for (int j = 0; j < N; j++) P(i, j) = T(P0_[i * N + j]);
    }
}

extern "C" void peer_predict(const T *u)
{
    Vector x_new;
    Square P_new;
    sym::Predict<T>(x, P, reinterpret_cast<const Controls &>(*u), &x_new, &P_new);
    x = x_new, P = P_new;
    for (int i = 0; FORM != WHOLE && i < N; i++)
        for (int j = 0; j < i; j++) P(i, j) = P(j, i);
}

#define DO(j, SEEN, ALL, DIRECT, ANGLE) \
    { \
        T expected, S; \
        Vector H, K; \
        Square P_new; \
        if (FORM == WHOLE) sym::ALL<T>(x, P, reinterpret_cast<const Controls &>(*u), &expected, &K, &P_new), P = P_new; \
        else sym::SEEN<T>(x, P, reinterpret_cast<const Controls &>(*u), &expected, &S, &H), K = taken<DIRECT>(H, S, T(R_[j])); \
        const T e = ANGLE ? wrapped(z[j] - expected) : z[j] - expected; \
        for (int i = 0; i < N; i++) x(i, 0) += K(i, 0) * e; \
    }

extern "C" void peer_update(const T *z, const T *u)
{
    EACH
}

#ifdef HOST
extern "C" void run(int rows, const double *z, const double *u, double *mean, double *covariance)
{
    const int m = sizeof R_ / sizeof R_[0];
    T w[L], v[m];
    peer_start();
    for (int t = 0; t < rows; t++, z += m, u += L) {
        if (t) peer_predict(w);
        for (int k = 0; k < L; k++) w[k] = T(u[k]);
        for (int k = 0; k < m; k++) v[k] = T(z[k]);
        peer_update(v, w);
        for (int i = 0; i < N; i++) {
            *mean++ = x(i, 0);
            for (int j = 0; j < N; j++) *covariance++ = i < j ? P(i, j) : P(j, i);
        }
    }
}
#endif
