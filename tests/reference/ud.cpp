#include "ud.hpp"

#include "eigen.hpp"

namespace reference
{

class UdFilter::Factors
{
  public:
    Factors(const EigenVector<float> &x0, const EigenVector<float> &variances)
        : x_(x0), D_(variances), U_(EigenMatrix<float>::Identity(x0.size(), x0.size()))
    {
    }

    void predict(const EigenMatrix<float> &A, const EigenMatrix<float> &G)
    {
        const Index n = x_.size(), r = G.cols();
        x_ = (A * x_).eval();
        EigenMatrix<float> W(n, n + r);
        W << A * U_, G;
        EigenVector<float> weights(n + r);
        weights << D_, EigenVector<float>::Ones(r);
        orthogonalise(W, weights);
    }

    void drive(const EigenVector<float> &push) { x_ += push; }

    void update(const EigenVector<float> &h, float r, float z)
    {
        const EigenVector<float> f = U_.transpose() * h;
        EigenVector<float> b = D_.cwiseProduct(f);
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
        if (variance > 0) {
            x_ += b * (innovation / variance);
        }
    }

    EigenVector<double> mean() const { return x_.cast<double>(); }

    /// U D U', multiplied out in double so that nothing is added to the filter's own error.
    EigenMatrix<double> covariance() const
    {
        const EigenMatrix<double> U = U_.cast<double>();
        return U * D_.cast<double>().asDiagonal() * U.transpose();
    }

  private:
    /// W diag(weights) W' = U D U', rows from the last up.
    void orthogonalise(EigenMatrix<float> &W, const EigenVector<float> &weights)
    {
        for (Index j = W.rows() - 1; j >= 0; --j) {
            const EigenVector<float> weighted = W.row(j).transpose().cwiseProduct(weights);
            D_(j) = W.row(j) * weighted;
            for (Index i = 0; i < j; ++i) {
                const float along = W.row(i) * weighted;
                U_(i, j) = D_(j) > 0 ? along / D_(j) : 0;
                W.row(i) -= U_(i, j) * W.row(j);
            }
        }
    }

    EigenVector<float> x_, D_;
    EigenMatrix<float> U_;
};

UdFilter::UdFilter(const Vector<float> &x0, const Vector<float> &variances)
    : factors_(std::make_unique<Factors>(toEigen(x0), toEigen(variances)))
{
}

UdFilter::~UdFilter() = default;

void UdFilter::predict(const Matrix<float> &A, const Matrix<float> &G)
{
    factors_->predict(toEigen(A), toEigen(G));
}

void UdFilter::drive(const Vector<float> &push) { factors_->drive(toEigen(push)); }

void UdFilter::update(const Vector<float> &h, float r, float z)
{
    factors_->update(toEigen(h), r, z);
}

Vector<double> UdFilter::mean() const { return fromEigen<double>(factors_->mean()); }

Matrix<double> UdFilter::covariance() const { return fromEigen<double>(factors_->covariance()); }

} // namespace reference
