// In Eigen's own order of sums: the errors of this filter, in floats, are what others are compared with.
#include "ud.hpp"

namespace reference
{

UdFilter::UdFilter(const Vector<float> &x0, const Vector<float> &variances)
    : x_(x0), D_(variances), U_(Eigen::MatrixXf::Identity(x0.size(), x0.size()))
{
}

void UdFilter::predict(const Matrix<float> &A, const Matrix<float> &G)
{
    const Index n = x_.size(), r = G.cols();
    x_ = A * x_;
    Eigen::MatrixXf W(n, n + r);
    W << A * U_, G;
    Eigen::VectorXf weights(n + r);
    weights << D_, Eigen::VectorXf::Ones(r);
    orthogonalise(W, weights);
}

void UdFilter::update(const Vector<float> &row, float r, float z)
{
    const Eigen::VectorXf h = row, f = U_.transpose() * h;
    Eigen::VectorXf b = D_.cwiseProduct(f);
    const float innovation = z - h.dot(x_);
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
    const Matrix<double> U = U_.cast<double>(), D = D_.cast<double>().asDiagonal();
    return U * D * U.transpose();
}

/// W diag(weights) W' = U D U', rows from the last up.
void UdFilter::orthogonalise(Eigen::MatrixXf &W, const Eigen::VectorXf &weights)
{
    for (Index j = W.rows() - 1; j >= 0; --j) {
        const Eigen::VectorXf weighted = W.row(j).transpose().cwiseProduct(weights);
        D_(j) = W.row(j) * weighted;
        for (Index i = 0; i < j; ++i) {
            const float along = W.row(i) * weighted;
            U_(i, j) = D_(j) > 0 ? along / D_(j) : 0;
            W.row(i) -= U_(i, j) * W.row(j);
        }
    }
}

} // namespace reference
