#include "ud.hpp"

namespace reference
{

/// a'b as vector units of four lanes add
static float dot(const Vector<float> &a, const Vector<float> &b)
{
    float lane[4] = {0, 0, 0, 0}, rest = 0;
    const Index whole = a.size() / 4 * 4;
    for (Index k = 0; k < whole; ++k) lane[k % 4] += a(k) * b(k);
    for (Index k = whole; k < a.size(); ++k) rest += a(k) * b(k);
    return (lane[0] + lane[2]) + (lane[1] + lane[3]) + rest;
}

void UdFilter::predict(const Matrix<float> &A, const Matrix<float> &G)
{
    const Index n = x_.size(), r = G.cols();
    x_ = A * x_;
    Matrix<float> W(n, n + r);
    W.block(0, 0, n, n) = A * U_;
    W.block(0, n, n, r) = G;
    Vector<float> weights = Vector<float>::Ones(n + r);
    weights.head(n) = D_;
    orthogonalise(W, weights);
}

void UdFilter::update(const Vector<float> &h, float r, float z)
{
    Vector<float> f(h.size());
    for (Index j = 0; j < f.size(); ++j) f(j) = dot(U_.col(j), h);
    Vector<float> b = D_.cwiseProduct(f);
    const float innovation = z - dot(h, x_);
    float variance = r;
    for (Index j = 0; j < x_.size(); ++j) {
        const float next = variance + f(j) * b(j);
        if (next > 0) {
            const float factor = variance > 0 ? -f(j) / variance : 0;
            D_(j) *= variance / next;
            for (Index i = 0; i < j; ++i) {
                const float old = U_(i, j);
                U_(i, j) = old + b(i) * factor;
                b(i) += old * b(j);
            }
        }
        variance = next;
    }
    if (variance > 0) x_ += b * (innovation / variance);
}

Matrix<double> UdFilter::covariance() const
{
    const Matrix<double> U = U_.cast<double>();
    return U * D_.cast<double>().asDiagonal() * U.transpose();
}

void UdFilter::orthogonalise(Matrix<float> &W, const Vector<float> &weights)
{
    for (Index j = W.rows() - 1; j >= 0; --j) {
        const Vector<float> row = W.row(j).transpose(), weighted = row.cwiseProduct(weights);
        D_(j) = row.dot(weighted);
        for (Index i = 0; i < j; ++i) {
            U_(i, j) = D_(j) > 0 ? W.row(i).dot(weighted) / D_(j) : 0;
            W.row(i) -= U_(i, j) * row;
        }
    }
}

} // namespace reference
