// The filter that float32 is usually trusted with: P = U D U', U unit upper triangular.
// Bierman's measurement update, Thornton's modified weighted Gram-Schmidt time update, the state
// a plain vector of floats.  What the library is compared with, not a part of it.
#ifndef KALMANQ_TESTS_REFERENCE_UD_HPP
#define KALMANQ_TESTS_REFERENCE_UD_HPP

#include "matrix.hpp"

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
    void predict(const Matrix<float> &A, const Matrix<float> &G);

    /// x <- x + B u, of a predict.
    void drive(const Vector<float> &push) { x_ += push; }

    /// One scalar measurement z = h x + v of variance r.
    void update(const Vector<float> &h, float r, float z);

    Vector<double> mean() const { return x_.cast<double>(); }

    /// U D U', multiplied out in double so that nothing is added to the filter's own error.
    Matrix<double> covariance() const;

  private:
    /// W diag(weights) W' = U D U', rows from the last up.
    void orthogonalise(Matrix<float> &W, const Vector<float> &weights);

    Vector<float> x_, D_;
    Matrix<float> U_;
};

} // namespace reference

#endif
