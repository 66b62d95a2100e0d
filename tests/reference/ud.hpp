// The filter that float32 is usually trusted with: P = U D U', U unit upper triangular.
// Bierman's measurement update, Thornton's modified weighted Gram-Schmidt time update, the state
// a plain vector of floats.  What the library is compared with, not a part of it.
#ifndef KALMANQ_TESTS_REFERENCE_UD_HPP
#define KALMANQ_TESTS_REFERENCE_UD_HPP

#include <Eigen/Dense>

#include "textbook.hpp"

namespace reference
{

class UdFilter
{
  public:
    /// P0 is given by its diagonal, as a vector.
    UdFilter(const Vector<float> &x0, const Vector<float> &variances)
        : x_(x0), D_(variances), U_(Matrix<float>::Identity(x0.size(), x0.size()))
    {
    }

    /// x <- A x,  P <- A P A' + G G'.
    void predict(const Matrix<float> &A, const Matrix<float> &G)
    {
        const Eigen::Index n = x_.size(), r = G.cols();
        x_ = (A * x_).eval();
        Matrix<float> W(n, n + r);
        W << A * U_, G;
        Vector<float> weights(n + r);
        weights << D_, Vector<float>::Ones(r);
        orthogonalise(W, weights);
    }

    /// x <- x + B u, of a predict.
    void drive(const Vector<float> &push) { x_ += push; }

    /// One scalar measurement z = h x + v of variance r.
    void update(const Vector<float> &h, float r, float z)
    {
        const Vector<float> f = U_.transpose() * h;
        Vector<float> b = D_.cwiseProduct(f);
        const float innovation = z - h.dot(x_);
        float variance = r;
        for (Eigen::Index j = 0; j < x_.size(); ++j) {
            const float next = variance + f(j) * b(j);
            if (next > 0) {
                const float factor = variance > 0 ? -f(j) / variance : 0;
                D_(j) *= variance / next;
                for (Eigen::Index i = 0; i < j; ++i) {
                    const float old = U_(i, j);
                    U_(i, j) = old + b(i) * factor;
                    b(i) += old * b(j);
                }
            }
            variance = next;
        }
        if (variance > 0) {
            x_ += b * (innovation / variance);
        }
    }

    Vector<double> mean() const { return x_.cast<double>(); }

    /// U D U', multiplied out in double so that nothing is added to the filter's own error.
    Matrix<double> covariance() const
    {
        const Matrix<double> U = U_.cast<double>();
        return U * D_.cast<double>().asDiagonal() * U.transpose();
    }

  private:
    /// W diag(weights) W' = U D U', rows from the last up.
    void orthogonalise(Matrix<float> &W, const Vector<float> &weights)
    {
        for (Eigen::Index j = W.rows() - 1; j >= 0; --j) {
            const Vector<float> weighted = W.row(j).transpose().cwiseProduct(weights);
            D_(j) = W.row(j) * weighted;
            for (Eigen::Index i = 0; i < j; ++i) {
                const float along = W.row(i) * weighted;
                U_(i, j) = D_(j) > 0 ? along / D_(j) : 0;
                W.row(i) -= U_(i, j) * W.row(j);
            }
        }
    }

    Vector<float> x_, D_;
    Matrix<float> U_;
};

} // namespace reference

#endif
