#include "batch.hpp"

#include <cstddef>
#include <stdexcept>

#include "decompositions.hpp"

namespace reference
{

namespace
{

/// One above the other
Matrix<long double> stacked(const std::vector<Matrix<long double>> &parts)
{
    Index height = 0, top = 0;
    for (const auto &part : parts) height += part.rows();
    Matrix<long double> M(height, parts[0].cols());
    for (const auto &part : parts) {
        M.block(top, 0, part.rows(), part.cols()) = part;
        top += part.rows();
    }
    return M;
}

class Batch
{
    using Real = long double;
    using Mat = Matrix<Real>;
    using Vec = Vector<Real>;

  public:
    explicit Batch(const Sequence &sequence)
        : sequence_(sequence), model_(sequence), n_(sequence.states()),
          columns_(n_ * static_cast<Index>(sequence.steps.size()))
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
    void add(const std::vector<Mat> &blocks, std::size_t at, const Vec &right,
             const Mat &covariance)
    {
        const auto root = choleskyRoot(covariance);
        if (!root) throw std::runtime_error("batch: singular covariance");
        Mat row = Mat::Zero(right.size(), columns_);
        for (std::size_t k = 0; k < blocks.size(); ++k) {
            row.block(0, column(at + k), right.size(), n_) = solveLower(*root, blocks[k]);
        }
        rows_.push_back(row);
        rights_.push_back(solveLower(*root, right));
    }

    void addStart()
    {
        add({Mat::Identity(n_, n_)}, 0, convert<Real>(sequence_.x0),
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
        add({-model_.A[step.process], Mat::Identity(n_, n_)}, t, model_.drive(step),
            model_.Q[step.process]);
    }

    void solve()
    {
        const LeastSquares fit = leastSquares(stacked(rows_), stacked(rights_));
        states_ = fit.solution;
        inverse_ = fit.inverseRoot;
    }

    Index column(std::size_t t) const { return n_ * static_cast<Index>(t); }
    Mat rows(std::size_t t) const { return inverse_.middleRows(column(t), n_); }
    Vec state(std::size_t t) const { return states_.middleRows(column(t), n_); }
    Mat covariance(std::size_t t, std::size_t s) const
    {
        return rows(t) * rows(s).transpose();
    }

    void addTransition(Smoothed<Real> &past, std::size_t t) const
    {
        const Step &step = sequence_.steps[t];
        const Mat &A = model_.A[step.process];
        past.lagOne = covariance(t + 1, t);
        past.noiseMean = state(t + 1) - A * state(t) - model_.drive(step);
        const Mat root = rows(t + 1) - A * rows(t);
        past.noiseCovariance = root * root.transpose();
    }

    const Sequence &sequence_;
    Model<Real> model_;
    Index n_, columns_;
    std::vector<Mat> rows_, rights_; // whitened
    Mat inverse_;
    Vec states_;
};

} // namespace

std::vector<Smoothed<long double>> smoothByLeastSquares(const Sequence &sequence)
{
    return Batch(sequence).smoothed();
}

} // namespace reference
