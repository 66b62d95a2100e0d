#include "gain_smoother.hpp"

#include <cmath>
#include <cstddef>
#include <limits>

#include "eigen.hpp"

namespace reference
{

namespace
{

/// W Theta = [L, 0] in its first n rows, L upper triangular; rows below are carried along.
/// Householder, rows from n - 1 up, over columns 0..i and n.. of W.
void triangularise(EigenMatrix<float> &W, Index n)
{
    const Index width = W.cols();
    for (Index i = n - 1; i >= 0; --i) {
        EigenVector<float> v = W.row(i).transpose();
        v.segment(i + 1, n - 1 - i).setZero();
        const float norm = v.stableNorm();
        if (norm == std::abs(v(i))) continue;
        v /= norm;
        const float kappa = 1 / (1 + std::abs(v(i)));
        v(i) += v(i) < 0 ? -1.0F : 1.0F;
        for (Index k = 0; k < W.rows(); ++k) {
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
        : x_(toEigen(sequence.x0)),
          S_(EigenMatrix<float>::Zero(sequence.states(), sequence.states()))
    {
        for (const Step &step : sequence.steps) {
            const EigenMatrix<float> before = S_;
            taken_.emplace_back();
            for (const Reading &reading : step.readings) {
                update(sequence.sensors[reading.sensor], reading, before);
            }
            recorded_.emplace_back();
            recorded_.back().filtered = {x_, square(S_)};
            predict(sequence.processes[step.process]);
        }
    }

    Estimates estimates() const
    {
        Estimates result{{}, {}, taken_};
        for (const Record &now : recorded_) result.filtered.push_back(plain(now.filtered));
        for (const Known &now : smooth()) result.smoothed.push_back(plain(now));
        return result;
    }

  private:
    struct Known {
        EigenVector<double> mean;
        EigenMatrix<double> covariance;
    };

    static Belief<double> plain(const Known &known)
    {
        return {fromEigen<double>(known.mean), fromEigen<double>(known.covariance)};
    }

    std::vector<Known> smooth() const
    {
        std::vector<Known> past(recorded_.size());
        past.back() = recorded_.back().filtered;
        EigenMatrix<float> S = recorded_.back().root;
        for (std::size_t t = past.size() - 1; t-- > 0;) {
            const Record &now = recorded_[t];
            const EigenMatrix<float> C = gain(now);
            const Index n = C.rows();
            EigenMatrix<float> W(n, n + now.Z.cols());
            W << C * S, now.Z;
            triangularise(W, n);
            S = W.leftCols(n);
            past[t].mean = now.filtered.mean + C.cast<double>() * (past[t + 1].mean - now.moved);
            past[t].covariance = square(S);
        }
        return past;
    }

    struct Record {
        Known filtered;
        EigenMatrix<float> root;            // S, before the predict
        EigenMatrix<float> predicted, Y, Z; // S-, and Theta's image of S
        EigenVector<double> moved;          // x-
    };

    static EigenMatrix<double> square(const EigenMatrix<float> &S)
    {
        return S.cast<double>() * S.cast<double>().transpose();
    }

    /// Carlson's update, for each component present.
    void update(const SensorModel &sensor, const Reading &reading, const EigenMatrix<float> &before)
    {
        for (const Index c : presentComponents(reading)) {
            const EigenVector<float> h = toEigen(sensor.H).row(c).transpose().cast<float>();
            const auto r = static_cast<float>(sensor.R(c, c));
            const EigenVector<float> f = S_.transpose() * h;
            const float s = r + f.squaredNorm();
            const float reach = r + (before.transpose() * h).squaredNorm();
            const bool counts = s > 16 * std::numeric_limits<float>::epsilon() * reach;
            taken_.back().push_back(counts);
            if (!counts) continue;
            const double e = reading.z(c) - toEigen(sensor.H).row(c).dot(x_);
            const EigenVector<float> b = rotate(f, r);
            x_ += b.cast<double>() * (e / static_cast<double>(s));
        }
    }

    EigenVector<float> rotate(const EigenVector<float> &f, float r)
    {
        EigenVector<float> b = EigenVector<float>::Zero(f.size());
        float variance = r;
        for (Index j = 0; j < f.size(); ++j) {
            const float next = variance + f(j) * f(j);
            if (f(j) == 0 || !(next > 0)) continue;
            const float c = std::sqrt(variance / next);
            const float g = variance > 0 ? f(j) / std::sqrt(variance) / std::sqrt(next) : 0;
            const EigenVector<float> old = S_.col(j);
            S_.col(j) = c * old - g * b;
            b += f(j) * old;
            variance = next;
        }
        return b;
    }

    void predict(const ProcessModel &process)
    {
        const EigenMatrix<double> A = toEigen(process.A);
        const Index n = S_.rows(), r = process.F.cols();
        EigenMatrix<float> W = EigenMatrix<float>::Zero(2 * n, n + r);
        W.topLeftCorner(n, n) = A.cast<float>() * S_;
        W.topRightCorner(n, r) = toEigen(process.F).cast<float>();
        W.bottomLeftCorner(n, n) = S_;
        triangularise(W, n);
        x_ = (A * x_).eval();
        Record &now = recorded_.back();
        now.root = S_;
        now.predicted = S_ = W.topLeftCorner(n, n);
        now.Y = W.bottomLeftCorner(n, n);
        now.Z = W.bottomRightCorner(n, r);
        now.moved = x_;
    }

    /// C S- = Y by substitution; a pivot below 8 eps of its row counts as 0.
    static EigenMatrix<float> gain(const Record &now)
    {
        const EigenMatrix<float> &S = now.predicted;
        EigenMatrix<float> C = EigenMatrix<float>::Zero(S.rows(), S.cols()), rest = now.Y;
        for (Index j = 0; j < S.cols(); ++j) {
            const float floor = 8 * std::numeric_limits<float>::epsilon() * S.row(j).norm();
            if (std::abs(S(j, j)) <= floor) continue;
            C.col(j) = rest.col(j) / S(j, j);
            rest -= C.col(j) * S.row(j);
        }
        return C;
    }

    EigenVector<double> x_;
    EigenMatrix<float> S_;
    Taken taken_;
    std::vector<Record> recorded_;
};

} // namespace

Estimates runGainSmoother(const Sequence &sequence) { return GainSmoother(sequence).estimates(); }

} // namespace reference
