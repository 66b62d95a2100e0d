// The filter that float32 is usually trusted with: P = U D U', U unit upper triangular.
// Bierman's measurement update, Thornton's modified weighted Gram-Schmidt time update, the state
// a plain vector of floats.  What the library is compared with, not a part of it.
#ifndef KALMANQ_TESTS_REFERENCE_UD_HPP
#define KALMANQ_TESTS_REFERENCE_UD_HPP

#include "matrix.hpp"

namespace reference
{

/// R = U D U', U unit upper triangular: its inverse, and D.  A row that others say has none.
template <class Real> struct Decorrelation {
    Matrix<Real> inverse;
    Vector<Real> variances;

    explicit Decorrelation(Matrix<Real> R) : inverse(Matrix<Real>::Identity(R.rows(), R.rows())), variances(R.diagonal())
    {
        for (Index j = R.rows() - 1; j >= 0; --j) {
            variances(j) = R(j, j);
            for (Index i = 0; i < j && R(j, j) > Real(0); ++i) {
                const Real u = R(i, j) / R(j, j);
                inverse.row(i) -= u * inverse.row(j);
                R.row(i).head(j) -= u * R.row(j).head(j);
            }
        }
    }
};

class UdFilter
{
  public:
    /// P0 is given by its diagonal, as a vector.
    UdFilter(const Vector<float> &x0, const Vector<float> &variances);

    /// x <- A x,  P <- A P A' + G G'.
    void predict(const Matrix<float> &A, const Matrix<float> &G);

    /// x <- x + B u, of a predict.
    void drive(const Vector<float> &push) { x_ += push.col(0); }

    /// One scalar measurement z = h x + v of variance r; the row h as a vector.
    void update(const Vector<float> &row, float r, float z);

    Vector<double> mean() const { return x_.cast<double>(); }

    /// U D U', multiplied out in double so that nothing is added to the filter's own error.
    Matrix<double> covariance() const;

  private:
    void orthogonalise(Eigen::MatrixXf &W, const Eigen::VectorXf &weights);

    Eigen::VectorXf x_, D_;
    Eigen::MatrixXf U_;
};

} // namespace reference

#endif
