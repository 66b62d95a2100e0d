// The smoother as what it is: one least-squares problem for the states of all times,
//     min  |x[0] - x0|^2_P0 + sum |x[t+1] - A x[t] - B u[t]|^2_Q + sum |z - H x[t]|^2_R
// with |v|^2_C = v'C^-1 v, solved by QR of the whitened rows.  There is no recursion in it, so it
// shares no mistake with one.  For P0, Q and R of full rank, and few steps.
#ifndef KALMANQ_TESTS_REFERENCE_BATCH_HPP
#define KALMANQ_TESTS_REFERENCE_BATCH_HPP

#include <cstddef>
#include <stdexcept>
#include <vector>

#include "textbook.hpp"

namespace reference
{

template <class Real> class Batch
{
  public:
    explicit Batch(const Sequence &sequence)
        : sequence_(sequence), model_(sequence), n_(sequence.states()),
          columns_(n_ * static_cast<Eigen::Index>(sequence.steps.size()))
    {
        addStart();
        for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
            for (const Reading &reading : sequence.steps[t].readings) addReading(t, reading);
            if (t + 1 < sequence.steps.size()) addMove(t);
        }
        solve();
    }

    std::vector<Smoothed<Real>> smoothed() const
    {
        const std::size_t count = sequence_.steps.size();
        std::vector<Smoothed<Real>> past(count);
        for (std::size_t t = 0; t < count; ++t) {
            past[t].belief = {state(t), covariance(t, t)};
            if (t + 1 < count) addTransition(past[t], t);
        }
        return past;
    }

  private:
    /// Rows [blocks] x = right + noise of the given covariance; block k stands at step at + k.
    void add(const std::vector<Matrix<Real>> &blocks, std::size_t at, const Vector<Real> &right,
             const Matrix<Real> &covariance)
    {
        const Eigen::LLT<Matrix<Real>> root(covariance);
        if (root.info() != Eigen::Success) throw std::runtime_error("batch: singular covariance");
        const Eigen::Index top = rows_.rows(), count = right.size();
        rows_.conservativeResize(top + count, columns_);
        rows_.bottomRows(count).setZero();
        right_.conservativeResize(top + count);
        for (std::size_t k = 0; k < blocks.size(); ++k) {
            const Matrix<Real> white = root.matrixL().solve(blocks[k]);
            rows_.block(top, column(at + k), count, n_) = white;
        }
        const Vector<Real> white = root.matrixL().solve(right);
        right_.tail(count) = white;
    }

    void addStart()
    {
        add({Matrix<Real>::Identity(n_, n_)}, 0, convert<Real>(sequence_.x0),
            convert<Real>(sequence_.P0));
    }

    void addReading(std::size_t t, const Reading &reading)
    {
        const Observation<Real> seen(model_, reading);
        if (seen.z.size() > 0) add({seen.H}, t, seen.z, seen.R);
    }

    void addMove(std::size_t t)
    {
        const Step &step = sequence_.steps[t];
        add({-model_.A[step.process], Matrix<Real>::Identity(n_, n_)}, t, model_.drive(step),
            model_.Q[step.process]);
    }

    void solve()
    {
        const Eigen::HouseholderQR<Matrix<Real>> factors(rows_);
        const Matrix<Real> R = factors.matrixQR().topRows(columns_);
        const Vector<Real> turned = factors.householderQ().adjoint() * right_;
        const auto upper = R.template triangularView<Eigen::Upper>();
        states_ = upper.solve(turned.head(columns_));
        inverse_ = upper.solve(Matrix<Real>::Identity(columns_, columns_));
    }

    Eigen::Index column(std::size_t t) const { return n_ * static_cast<Eigen::Index>(t); }
    Vector<Real> state(std::size_t t) const { return states_.segment(column(t), n_); }
    Matrix<Real> covariance(std::size_t t, std::size_t s) const
    {
        return inverse_.middleRows(column(t), n_) * inverse_.middleRows(column(s), n_).transpose();
    }

    void addTransition(Smoothed<Real> &past, std::size_t t) const
    {
        const Step &step = sequence_.steps[t];
        const Matrix<Real> &A = model_.A[step.process];
        past.lagOne = covariance(t + 1, t);
        past.noiseMean = state(t + 1) - A * state(t) - model_.drive(step);
        const Matrix<Real> root =
            inverse_.middleRows(column(t + 1), n_) - A * inverse_.middleRows(column(t), n_);
        past.noiseCovariance = root * root.transpose();
    }

    const Sequence &sequence_;
    Model<Real> model_;
    Eigen::Index n_, columns_;
    Matrix<Real> rows_, inverse_;
    Vector<Real> right_, states_;
};

} // namespace reference

#endif
