// The named classes of state-space models.
#include "generator.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "ranges.hpp"

namespace reference::generator
{

static Mat noControl(Index n) { return Mat::Zero(n, 0); }

/// One reading of every sensor at every step, all components present.
static Sequence &measureAlways(Sequence &sequence, int steps)
{
    for (int t = 0; t < steps; ++t) {
        Step step{{}, 0, Vec()};
        for (std::size_t k = 0; k < sequence.sensors.size(); ++k) {
            step.readings.push_back({k, Vec(), UINT32_MAX});
        }
        sequence.steps.push_back(step);
    }
    return sequence;
}

/// One process, one sensor, x0 = 0.
static Sequence model(const std::string &name, const Mat &A, const Mat &F, const Mat &H,
                      const Mat &R, const Mat &P0)
{
    Sequence sequence;
    sequence.name = name;
    sequence.x0 = Vec::Zero(A.rows());
    sequence.P0 = P0;
    sequence.processes.push_back({rounded(A), noControl(A.rows()), rounded(F)});
    sequence.sensors.push_back({rounded(H), rounded(R)});
    return sequence;
}

static Mat scalar(double value) { return Mat::Constant(1, 1, value); }

/// x = (y_t, ..., y_t-p+1), y_t+1 = a'x + w, z = y + v.
static Sequence autoregressive(const std::vector<double> &a, double q, double r)
{
    const auto p = static_cast<Index>(a.size());
    Mat A = Mat::Zero(p, p), F = Mat::Zero(p, 1);
    for (Index i = 0; i < p; ++i) A(0, i) = a[static_cast<std::size_t>(i)];
    for (Index i = 1; i < p; ++i) A(i, i - 1) = 1;
    F(0, 0) = q;
    const std::string name = "AR(" + std::to_string(p) + ")" + (r > 0 ? "" : " R=0");
    return model(name, A, F, unitRow(p, 0), scalar(r), 4 * identity(p));
}

/// x = (w_t, ..., w_t-q), z = w_t + b'(w_t-1, ...) + v.
static Sequence movingAverage(const std::vector<double> &b, double q, double r)
{
    const auto n = static_cast<Index>(b.size()) + 1;
    Mat A = Mat::Zero(n, n), F = Mat::Zero(n, 1), H = unitRow(n, 0);
    for (Index i = 1; i < n; ++i) {
        A(i, i - 1) = 1;
        H(0, i) = b[static_cast<std::size_t>(i) - 1];
    }
    F(0, 0) = q;
    const std::string name = "MA(" + std::to_string(n - 1) + ")" + (r > 0 ? "" : " R=0");
    return model(name, A, F, H, scalar(r), q * q * identity(n));
}

/// Harvey's form: n = max(p, q + 1), A = [a, I; 0], F = (1, b), z = x_0 + v.
static Sequence mixed(const std::vector<double> &a, const std::vector<double> &b, double r)
{
    const std::size_t n = std::max(a.size(), b.size() + 1);
    const auto size = static_cast<Index>(n);
    Mat A = Mat::Zero(size, size), F = Mat::Zero(size, 1);
    F(0, 0) = 1;
    for (Index i = 0; i < size; ++i) {
        const auto k = static_cast<std::size_t>(i);
        if (k < a.size()) A(i, 0) = a[k];
        if (k < b.size()) F(i + 1, 0) = b[k];
        if (i + 1 < size) A(i, i + 1) = 1;
    }
    const std::string name = "ARMA(" + std::to_string(a.size()) + "," + std::to_string(b.size()) +
                             ")" + (r > 0 ? "" : " R=0");
    return model(name, A, F, unitRow(size, 0), scalar(r), 4 * identity(size));
}

/// Coefficients that drift (drift = 0: recursive least squares), regressors that change.
static Sequence regression(Random &random, Index n, double drift, int steps)
{
    const std::string name =
        std::string("regression ") + (drift > 0 ? "TVC" : "fixed") + " n" + std::to_string(n);
    Sequence sequence = model(name, identity(n), drift * identity(n), unitRow(n, 0), scalar(0.25),
                              16 * identity(n));
    const SensorModel first = sequence.sensors[0];
    sequence.sensors.clear();
    for (int t = 0; t < steps; ++t) {
        Mat H = randomMatrix(random, 1, n);
        H(0, 0) = 1;
        sequence.sensors.push_back({H, first.R});
        sequence.steps.push_back({{{static_cast<std::size_t>(t), Vec(), UINT32_MAX}}, 0, Vec()});
    }
    return sequence;
}

static Sequence localLevel(double q, double r)
{
    return model("local level", scalar(1), scalar(q), scalar(1), scalar(r * r), scalar(100));
}

static Sequence localTrend(double level, double slope, double r)
{
    const Mat A = rows({{1, 1}, {0, 1}}), F = rows({{level, 0}, {0, slope}});
    return model("local linear trend", A, F, unitRow(2, 0), scalar(r * r), 100 * identity(2));
}

/// Trend and a season of the given period with noise: (level, slope, s_t, ..., s_t-period+2).
static Sequence seasonal(Index period)
{
    const Index n = period + 1;
    Mat A = Mat::Zero(n, n), F = Mat::Zero(n, 3), H = Mat::Zero(1, n);
    A.block(0, 0, 2, 2) = rows({{1, 1}, {0, 1}});
    A.block(2, 2, 1, period - 1).setConstant(-1);
    for (Index i = 3; i < n; ++i) A(i, i - 1) = 1;
    F.diagonal() = column({0.25, 0.03125, 0.125});
    H(0, 0) = H(0, 2) = 1;
    return model("seasonal " + std::to_string(period), A, F, H, scalar(1), 25 * identity(n));
}

/// Two factors, each AR(1), seen by four series with loadings and noises of their own.
static Sequence dynamicFactor()
{
    const Mat A = rows({{0.9, 0.1}, {-0.2, 0.7}}), F = rows({{1, 0}, {0.5, 0.75}});
    const Mat H = rows({{1, 0}, {0.8, 0.3}, {0.4, 1.1}, {-0.6, 0.9}});
    Mat R = Mat::Zero(4, 4);
    R.diagonal() = column({0.25, 0.5, 0.75, 1});
    return model("dynamic factor", A, F, H, R, 4 * identity(2));
}

/// Position and its derivatives up to `order` in `dimensions` axes, ordered position first; white
/// noise on the highest derivative, over a time step that is a power of two.
static Sequence kinematic(Index order, Index dimensions)
{
    const double dt = 0.25;
    const Index n = (order + 1) * dimensions;
    Mat A = identity(n), F = Mat::Zero(n, dimensions), H = Mat::Zero(dimensions, n);
    for (Index axis = 0; axis < dimensions; ++axis) {
        for (Index i = 0; i <= order; ++i) {
            double term = 1;
            for (Index j = i + 1; j <= order + 1; ++j) {
                term *= dt / static_cast<double>(j - i);
                if (j <= order) A(i * dimensions + axis, j * dimensions + axis) = term;
            }
            F(i * dimensions + axis, axis) = 0.5 * term / dt;
        }
        H(axis, axis) = 1;
    }
    const std::string name =
        std::string(order == 1 ? "constant velocity " : "constant acceleration ") +
        std::to_string(dimensions) + "-D";
    return model(name, A, F, H, 4 * identity(dimensions), 100 * identity(n));
}

static std::vector<Sequence> unmeasuredNamedModels()
{
    return {autoregressive({0.8}, 1, 0.5),
            autoregressive({1.3, -0.5}, 1, 0.25),
            autoregressive({0.6, -0.3, 0.2, 0.4}, 1, 0.5),
            autoregressive({1.3, -0.5}, 1, 0),
            movingAverage({0.6}, 1, 0.25),
            movingAverage({0.7, -0.4, 0.3}, 1, 0.5),
            movingAverage({0.5, 0.25}, 1, 0),
            mixed({0.7}, {0.4}, 0.25),
            mixed({1.2, -0.5}, {0.5, 0.2}, 0.5),
            mixed({0.9, -0.2}, {0.37}, 0),
            localLevel(0.5, 2),
            localLevel(0.0078125, 1),
            localTrend(0.5, 0.125, 2),
            localTrend(0, 0.0625, 4),
            seasonal(4),
            seasonal(7),
            dynamicFactor(),
            kinematic(1, 1),
            kinematic(1, 2),
            kinematic(1, 3),
            kinematic(2, 1),
            kinematic(2, 2),
            kinematic(2, 3)};
}

std::vector<Sequence> namedSequences(Random &random, int steps)
{
    std::vector<Sequence> all = unmeasuredNamedModels();
    for (Sequence &sequence : all) measureAlways(sequence, steps);
    all.push_back(regression(random, 2, 0.0625, steps));
    all.push_back(regression(random, 4, 0.25, steps));
    all.push_back(regression(random, 3, 0, steps));
    for (Sequence &sequence : all) {
        simulate(random, sequence);
        declareRanges(sequence);
    }
    return all;
}

} // namespace reference::generator
