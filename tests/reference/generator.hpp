// Seeded models and measurements: random ones, and the named classes of state-space models.
//
// Every number of a sequence is a float, and every x0, u and z a q31 word.  A covariance is built
// as F F' with F = diag(powers of two) * (small integers): its entries are floats too, exactly, and
// it is positive semi-definite without any rounding.
#ifndef KALMANQ_TESTS_REFERENCE_GENERATOR_HPP
#define KALMANQ_TESTS_REFERENCE_GENERATOR_HPP

#include <Eigen/Dense>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "random.hpp"
#include "ranges.hpp"
#include "textbook.hpp"

namespace reference::generator
{

using Index = Eigen::Index;
using Mat = Matrix<double>;
using Vec = Vector<double>;

/// The seed of argv[1], or the default one.
inline std::uint64_t seedOf(int argc, char **argv)
{
    return argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 20240229U;
}

inline Vec normals(Random &random, Index count)
{
    Vec v(count);
    for (Index i = 0; i < count; ++i) v(i) = random.normal();
    return v;
}

inline double toFloat(double x) { return static_cast<double>(static_cast<float>(x)); }

inline Mat toFloat(const Mat &M)
{
    return M.unaryExpr([](double x) { return toFloat(x); });
}

inline Mat matrix(Index rows, Index columns, const std::vector<double> &entries)
{
    Mat M(rows, columns);
    for (Index i = 0; i < rows * columns; ++i) {
        M(i / columns, i % columns) = toFloat(entries[static_cast<std::size_t>(i)]);
    }
    return M;
}

inline Vec constant(Index n, double value) { return Vec::Constant(n, toFloat(value)); }
inline Mat identity(Index n) { return Mat::Identity(n, n); }
inline Mat noControl(Index n) { return Mat::Zero(n, 0); }

// ------------------------------------------------------------------ parts of random models

/// A factor n x rank: integers / 64 with a dominant diagonal, rows scaled by powers of two.
inline Mat randomFactor(Random &random, Index n, Index rank, const Vec &scale)
{
    Mat F(n, rank);
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < rank; ++j) {
            const int size = i == j ? random.integer(32, 96) : random.integer(-32, 32);
            F(i, j) = scale(i) * size / 64;
        }
    }
    return F;
}

inline Mat diagonalFactor(Random &random, Index n, const Vec &scale)
{
    Mat F = Mat::Zero(n, n);
    for (Index i = 0; i < n; ++i) F(i, i) = scale(i) * random.integer(32, 96) / 64;
    return F;
}

inline Mat unitTriangular(Random &random, Index n)
{
    Mat L = identity(n);
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < i; ++j) L(i, j) = random.uniform(-0.5, 0.5);
    }
    return L;
}

/// Blocks on the diagonal with eigenvalues of modulus at most 1: real ones and rotations.
/// Marginal: on the unit circle, and with `chains` short chains of integrators.
inline Mat eigenBlocks(Random &random, Index n, bool marginal, bool chains)
{
    Mat D = Mat::Zero(n, n);
    for (Index i = 0; i < n;) {
        const double modulus = marginal ? 1 : random.uniform(0.2, 0.98);
        if (i + 1 < n && random.chance(0.5)) {
            const double t = random.uniform(0.02, 0.9), length = 1 + t * t;
            const double c = (1 - t * t) / length * modulus, s = 2 * t / length * modulus;
            D.block(i, i, 2, 2) << c, s, -s, c;
            i += 2;
        } else {
            D(i, i) = random.chance(0.2) ? -modulus : modulus;
            const bool first = i == 0 || D(i - 1, i - 1) != D(i, i);
            const bool third = i > 1 && D(i - 2, i - 1) != 0;
            if (chains && !first && !third) D(i - 1, i) = 0.125;
            i += 1;
        }
    }
    return D;
}

/// Dense, with the eigenvalues of the blocks D; in units that differ by powers of two.
inline Mat transition(const Mat &D, const Mat &coordinates, const Vec &units)
{
    const Mat A = coordinates * D * coordinates.inverse();
    const Vec inverse = units.cwiseInverse();
    return toFloat(Mat(units.asDiagonal() * A * inverse.asDiagonal()));
}

inline Mat randomMatrix(Random &random, Index rows, Index columns)
{
    Mat M(rows, columns);
    for (Index i = 0; i < rows; ++i) {
        for (Index j = 0; j < columns; ++j) M(i, j) = toFloat(random.normal());
    }
    return M;
}

inline Vec powersOfTwo(Random &random, Index n, int low, int high)
{
    Vec v(n);
    for (Index i = 0; i < n; ++i) v(i) = std::ldexp(1.0, random.integer(low, high));
    return v;
}

/// H for states in the given units: of order 1 in each.
inline Mat randomMeasurementMatrix(Random &random, Index m, const Vec &units)
{
    const Vec inverse = units.cwiseInverse();
    return randomMatrix(random, m, units.size()) * inverse.asDiagonal();
}

inline SensorModel randomSensor(Random &random, Index m, const Vec &units, bool correlated)
{
    const Vec scale = powersOfTwo(random, m, -5, 2);
    const Mat F = correlated ? randomFactor(random, m, m, scale) : diagonalFactor(random, m, scale);
    return {randomMeasurementMatrix(random, m, units), F * F.transpose()};
}

// ------------------------------------------------------------------ measurements

/// A Cholesky factor for sampling, of a covariance that may be singular.
inline Mat samplingRoot(const Mat &covariance)
{
    const Eigen::LDLT<Mat> factors(covariance);
    const Vec pivots = factors.vectorD().cwiseMax(0).cwiseSqrt();
    const Mat lower = factors.matrixL();
    return factors.transpositionsP().transpose() * Mat(lower * pivots.asDiagonal());
}

/// Fills in the measurements z of all readings from one true path.
inline void simulate(Random &random, Sequence &sequence)
{
    const Index n = sequence.states();
    std::vector<Mat> noise;
    for (const SensorModel &sensor : sequence.sensors) noise.push_back(samplingRoot(sensor.R));
    Vec x = sequence.x0 + samplingRoot(sequence.P0) * normals(random, n);
    for (Step &step : sequence.steps) {
        for (Reading &reading : step.readings) {
            const SensorModel &sensor = sequence.sensors[reading.sensor];
            const Mat &root = noise[reading.sensor];
            reading.z = toFloat(Mat(sensor.H * x + root * normals(random, root.cols())));
        }
        const ProcessModel &process = sequence.processes[step.process];
        x = (process.A * x + process.F * normals(random, process.F.cols())).eval();
        if (step.u.size() > 0) x += process.B * step.u;
    }
}

/// One reading of every sensor at every step, all components present.
inline Sequence &measureAlways(Sequence &sequence, int steps)
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

// ------------------------------------------------------------------ random models

struct Options {
    int steps = 200;
    bool invertible = false; // Q, R and P0 of full rank
};

/// What varies from one random model to the next; from its number, so that all combinations come.
struct Features {
    Index n, m, l;
    bool marginal, correlated, units, changingA, changingH, missing;
    int sensors;

    explicit Features(int number)
        : n(1 + number % 9), m(1 + (number / 2) % 4), l((number / 3) % 4),
          marginal(number % 3 == 0), correlated(number % 2 == 0), units(number % 5 < 2),
          changingA(number % 7 == 0), changingH(number % 8 == 1), missing(number % 4 < 2),
          sensors(1 + (number / 5) % 3)
    {
    }

    std::string text() const
    {
        return "n" + std::to_string(n) + " m" + std::to_string(m) + " l" + std::to_string(l) +
               (marginal ? " marginal" : " stable") + (correlated ? " full R" : "") +
               (units ? " units" : "") + (changingA ? " A_t" : "") + (changingH ? " H_t" : "") +
               (missing ? " gaps" : "") + " sensors " + std::to_string(sensors);
    }
};

/// The first sensor, or one with a matrix for every step, and slower ones of other sizes.
inline void addSensors(Random &random, Sequence &sequence, const Features &features,
                       const Vec &units, int steps)
{
    SensorModel first = randomSensor(random, features.m, units, features.correlated);
    const int versions = features.changingH ? steps : 1;
    for (int k = 0; k < versions; ++k) {
        sequence.sensors.push_back(first);
        first.H = randomMeasurementMatrix(random, features.m, units);
    }
    for (int k = 1; k < features.sensors; ++k) {
        const Index m = 1 + (features.m + k) % 4;
        sequence.sensors.push_back(randomSensor(random, m, units, random.chance(0.5)));
    }
}

inline void addProcesses(Random &random, Sequence &sequence, const Features &features,
                         const Vec &units, const Options &options)
{
    const Index n = features.n;
    const Index rank = options.invertible ? n : random.integer(1, static_cast<int>(n));
    const Vec size = units * std::ldexp(1.0, random.integer(-5, 0));
    const Mat F = randomFactor(random, n, rank, size);
    const Mat B = toFloat(Mat(units.asDiagonal() * randomMatrix(random, n, features.l)));
    // common coordinates: a product of different transitions is then as tame as one of them
    const Mat lower = unitTriangular(random, n);
    const Mat coordinates = lower * unitTriangular(random, n).transpose();
    const int versions = features.changingA ? 5 : 1;
    const bool chains = features.marginal && versions == 1;
    for (int k = 0; k < versions; ++k) {
        const Mat D = eigenBlocks(random, n, features.marginal, chains);
        sequence.processes.push_back({transition(D, coordinates, units), B, F});
    }
}

inline std::uint32_t randomPresence(Random &random, const Features &features)
{
    if (!features.missing || random.chance(0.6)) return UINT32_MAX;
    return static_cast<std::uint32_t>(random.integer(0, 15));
}

/// The first sensor at every step, sensor k at every (k+2)-nd; bursts without any measurement.
inline void addSteps(Random &random, Sequence &sequence, const Features &features, int steps)
{
    const std::size_t versions = features.changingH ? static_cast<std::size_t>(steps) : 1;
    for (int t = 0; t < steps; ++t) {
        const auto now = static_cast<std::size_t>(t);
        Step step{{}, now % sequence.processes.size(), Vec()};
        const bool silent = features.missing && t % 40 > 32;
        for (std::size_t k = 0; !silent && k < static_cast<std::size_t>(features.sensors); ++k) {
            if (k > 0 && now % (k + 2) != 0) continue;
            const std::size_t sensor = k > 0 ? versions - 1 + k : now % versions;
            step.readings.push_back({sensor, Vec(), randomPresence(random, features)});
        }
        if (features.l > 0 && t % 10 != 0) {
            step.u = toFloat(Mat(0.25 * normals(random, features.l)));
        }
        sequence.steps.push_back(step);
    }
}

inline Sequence randomSequence(Random &random, int number, const Options &options = {})
{
    const Features features(number);
    Sequence sequence;
    sequence.name = "random " + std::to_string(number) + ": " + features.text();
    const Index n = features.n;
    const Vec units = features.units ? powersOfTwo(random, n, -8, 8) : constant(n, 1);
    const Vec size = units * std::ldexp(1.0, random.integer(-1, 4));
    const bool singular = !options.invertible && random.chance(0.2);
    const Mat F = randomFactor(random, n, singular ? (n + 1) / 2 : n, size);
    sequence.P0 = F * F.transpose();
    sequence.x0 = toFloat(Mat(units.cwiseProduct(10 * normals(random, n))));
    addProcesses(random, sequence, features, units, options);
    addSensors(random, sequence, features, units, options.steps);
    addSteps(random, sequence, features, options.steps);
    simulate(random, sequence);
    declareRanges(sequence);
    return sequence;
}

// ------------------------------------------------------------------ named models

/// One process, one sensor, x0 = 0.
inline Sequence model(const std::string &name, const Mat &A, const Mat &F, const Mat &H,
                      const Mat &R, const Mat &P0)
{
    Sequence sequence;
    sequence.name = name;
    sequence.x0 = Vec::Zero(A.rows());
    sequence.P0 = P0;
    sequence.processes.push_back({toFloat(A), noControl(A.rows()), toFloat(F)});
    sequence.sensors.push_back({toFloat(H), toFloat(R)});
    return sequence;
}

inline Mat unitRow(Index n, Index i)
{
    Mat row = Mat::Zero(1, n);
    row(0, i) = 1;
    return row;
}

inline Mat scalar(double value) { return Mat::Constant(1, 1, value); }

/// x = (y_t, ..., y_t-p+1), y_t+1 = a'x + w, z = y + v.
inline Sequence autoregressive(const std::vector<double> &a, double q, double r)
{
    const auto p = static_cast<Index>(a.size());
    Mat A = Mat::Zero(p, p), F = Mat::Zero(p, 1);
    A.row(0) = matrix(1, p, a);
    for (Index i = 1; i < p; ++i) A(i, i - 1) = 1;
    F(0, 0) = q;
    const std::string name = "AR(" + std::to_string(p) + ")" + (r > 0 ? "" : " R=0");
    return model(name, A, F, unitRow(p, 0), scalar(r), 4 * identity(p));
}

/// x = (w_t, ..., w_t-q), z = w_t + b'(w_t-1, ...) + v.
inline Sequence movingAverage(const std::vector<double> &b, double q, double r)
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
inline Sequence mixed(const std::vector<double> &a, const std::vector<double> &b, double r)
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
inline Sequence regression(Random &random, Index n, double drift, int steps)
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

inline Sequence localLevel(double q, double r)
{
    return model("local level", scalar(1), scalar(q), scalar(1), scalar(r * r), scalar(100));
}

inline Sequence localTrend(double level, double slope, double r)
{
    const Mat A = matrix(2, 2, {1, 1, 0, 1}), F = matrix(2, 2, {level, 0, 0, slope});
    return model("local linear trend", A, F, unitRow(2, 0), scalar(r * r), 100 * identity(2));
}

/// Trend and a season of the given period with noise: (level, slope, s_t, ..., s_t-period+2).
inline Sequence seasonal(Index period)
{
    const Index n = period + 1;
    Mat A = Mat::Zero(n, n), F = Mat::Zero(n, 3), H = Mat::Zero(1, n);
    A.block(0, 0, 2, 2) << 1, 1, 0, 1;
    A.block(2, 2, 1, period - 1).setConstant(-1);
    for (Index i = 3; i < n; ++i) A(i, i - 1) = 1;
    F.topLeftCorner(3, 3).diagonal() << 0.25, 0.03125, 0.125;
    H(0, 0) = H(0, 2) = 1;
    return model("seasonal " + std::to_string(period), A, F, H, scalar(1), 25 * identity(n));
}

/// Two factors, each AR(1), seen by four series with loadings and noises of their own.
inline Sequence dynamicFactor()
{
    const Mat A = matrix(2, 2, {0.9, 0.1, -0.2, 0.7}), F = matrix(2, 2, {1, 0, 0.5, 0.75});
    const Mat H = matrix(4, 2, {1, 0, 0.8, 0.3, 0.4, 1.1, -0.6, 0.9});
    Mat R = Mat::Zero(4, 4);
    R.diagonal() << 0.25, 0.5, 0.75, 1;
    return model("dynamic factor", A, F, H, R, 4 * identity(2));
}

/// Position and its derivatives up to `order` in `dimensions` axes, ordered position first; white
/// noise on the highest derivative, over a time step that is a power of two.
inline Sequence kinematic(Index order, Index dimensions)
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

inline std::vector<Sequence> unmeasuredNamedModels()
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

/// Every named class, measured over `steps` steps.
inline std::vector<Sequence> namedSequences(Random &random, int steps = 200)
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

#endif
