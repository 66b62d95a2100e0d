// The square-root smoother that the literature has, in float: Rauch, Tung and Striebel with a gain
// C = Y (S-)^+ from the filter's own arrays.  What the library is compared with, not a part of it.
//
//     predict    [A S, G; S, 0] Theta = [S-, 0; Y, Z]
//     smooth     C = Y (S-)^+,  x_s = x + C (x_s+ - x-),  S_s = tria [C S_s+, Z]
//
// The mean is held in double, so that only the covariance arithmetic is compared.
#ifndef KALMANQ_TESTS_REFERENCE_GAIN_SMOOTHER_HPP
#define KALMANQ_TESTS_REFERENCE_GAIN_SMOOTHER_HPP

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "bryson_frazier.hpp"
#include "textbook.hpp"

namespace reference
{

/// W Theta = [L, 0] in its first n rows, L upper triangular; rows below are carried along.
/// Householder, rows from n - 1 up, over columns 0..i and n.. of W.
inline void triangularise(Matrix<float> &W, Eigen::Index n)
{
    const Eigen::Index width = W.cols();
    for (Eigen::Index i = n - 1; i >= 0; --i) {
        Vector<float> v = W.row(i).transpose();
        v.segment(i + 1, n - 1 - i).setZero();
        const float norm = v.stableNorm();
        if (norm == std::abs(v(i))) continue;
        v /= norm;
        const float kappa = 1 / (1 + std::abs(v(i)));
        v(i) += v(i) < 0 ? -1.0F : 1.0F;
        for (Eigen::Index k = 0; k < W.rows(); ++k) {
            if (k > i && k < n) continue;
            const float along = kappa * W.row(k).dot(v);
            W.row(k) -= along * v.transpose();
        }
        W.row(i).head(i).setZero();
        W.row(i).tail(width - n).setZero();
    }
}

class GainSmoother
{
  public:
    explicit GainSmoother(const Sequence &sequence)
        : x_(sequence.x0), S_(Matrix<float>::Zero(sequence.states(), sequence.states()))
    {
        for (const Step &step : sequence.steps) {
            const Matrix<float> before = S_;
            taken_.emplace_back();
            for (const Reading &reading : step.readings) {
                update(sequence.sensors[reading.sensor], reading, before);
            }
            recorded_.emplace_back();
            recorded_.back().filtered = {x_, square(S_)};
            predict(sequence.processes[step.process]);
        }
    }

    /// Which scalar measurements it took: not those at the rounding floor.
    const Taken &taken() const { return taken_; }

    const Belief<double> &filtered(std::size_t t) const { return recorded_[t].filtered; }

    std::vector<Belief<double>> smooth() const
    {
        std::vector<Belief<double>> past(recorded_.size());
        past.back() = recorded_.back().filtered;
        Matrix<float> S = recorded_.back().root;
        for (std::size_t t = past.size() - 1; t-- > 0;) {
            const Record &now = recorded_[t];
            const Matrix<float> C = gain(now);
            const Eigen::Index n = C.rows();
            Matrix<float> W(n, n + now.Z.cols());
            W << C * S, now.Z;
            triangularise(W, n);
            S = W.leftCols(n);
            past[t].mean = now.filtered.mean + C.cast<double>() * (past[t + 1].mean - now.moved);
            past[t].covariance = square(S);
        }
        return past;
    }

  private:
    struct Record {
        Belief<double> filtered;
        Matrix<float> root;            // S, before the predict
        Matrix<float> predicted, Y, Z; // S-, and Theta's image of S
        Vector<double> moved;          // x-
    };

    static Matrix<double> square(const Matrix<float> &S)
    {
        return S.cast<double>() * S.cast<double>().transpose();
    }

    /// Carlson's update, for each component present.
    void update(const SensorModel &sensor, const Reading &reading, const Matrix<float> &before)
    {
        for (const Eigen::Index c : presentComponents(reading)) {
            const Vector<float> h = sensor.H.row(c).transpose().cast<float>();
            const auto r = static_cast<float>(sensor.R(c, c));
            const Vector<float> f = S_.transpose() * h;
            const float s = r + f.squaredNorm();
            const float reach = r + (before.transpose() * h).squaredNorm();
            const bool counts = s > 16 * std::numeric_limits<float>::epsilon() * reach;
            taken_.back().push_back(counts);
            if (!counts) continue;
            const double e = reading.z(c) - sensor.H.row(c).dot(x_);
            const Vector<float> b = rotate(f, r);
            x_ += b.cast<double>() * (e / static_cast<double>(s));
        }
    }

    Vector<float> rotate(const Vector<float> &f, float r)
    {
        Vector<float> b = Vector<float>::Zero(f.size());
        float variance = r;
        for (Eigen::Index j = 0; j < f.size(); ++j) {
            const float next = variance + f(j) * f(j);
            if (f(j) == 0 || !(next > 0)) continue;
            const float c = std::sqrt(variance / next);
            const float g = variance > 0 ? f(j) / std::sqrt(variance) / std::sqrt(next) : 0;
            const Vector<float> old = S_.col(j);
            S_.col(j) = c * old - g * b;
            b += f(j) * old;
            variance = next;
        }
        return b;
    }

    void predict(const ProcessModel &process)
    {
        const Eigen::Index n = S_.rows(), r = process.F.cols();
        Matrix<float> W = Matrix<float>::Zero(2 * n, n + r);
        W.topLeftCorner(n, n) = process.A.cast<float>() * S_;
        W.topRightCorner(n, r) = process.F.cast<float>();
        W.bottomLeftCorner(n, n) = S_;
        triangularise(W, n);
        x_ = (process.A * x_).eval();
        Record &now = recorded_.back();
        now.root = S_;
        now.predicted = S_ = W.topLeftCorner(n, n);
        now.Y = W.bottomLeftCorner(n, n);
        now.Z = W.bottomRightCorner(n, r);
        now.moved = x_;
    }

    /// C S- = Y by substitution; a pivot below 8 eps of its row counts as 0.
    static Matrix<float> gain(const Record &now)
    {
        const Matrix<float> &S = now.predicted;
        Matrix<float> C = Matrix<float>::Zero(S.rows(), S.cols()), rest = now.Y;
        for (Eigen::Index j = 0; j < S.cols(); ++j) {
            const float floor = 8 * std::numeric_limits<float>::epsilon() * S.row(j).norm();
            if (std::abs(S(j, j)) <= floor) continue;
            C.col(j) = rest.col(j) / S(j, j);
            rest -= C.col(j) * S.row(j);
        }
        return C;
    }

    Vector<double> x_;
    Matrix<float> S_;
    Taken taken_;
    std::vector<Record> recorded_;
};

} // namespace reference

#endif
