// Fourteen models that a filter in 32 bits has to get right, from a local level to covariances
// that fall by fifteen decades, and runs drawn from them.
//
// Every number is a float and every measurement lies on a grid of 2^-23 of its range, which is a
// power of two: all arithmetics see the same data.  The process noise is given by its factor, so
// that all have the same Q.
#ifndef KALMANQ_TESTS_REFERENCE_NUMERICS_MODELS_HPP
#define KALMANQ_TESTS_REFERENCE_NUMERICS_MODELS_HPP

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "random.hpp"
#include "textbook.hpp"

namespace reference
{

struct NumericsModel {
    std::string name;
    bool ordinary; // one that no filter has an excuse for
    ProcessModel process;
    SensorModel sensor;
    Vector<double> x0, variances; // P0 is diagonal
    Vector<double> reach;         // of the state: what the run stays within, powers of two
    Vector<double> range;         // of the measurement: 2^23 grid points

    Eigen::Index states() const { return x0.size(); }
};

// ------------------------------------------------------------------ small matrices

inline Matrix<double> rounded(const Matrix<double> &M) { return M.cast<float>().cast<double>(); }

inline Vector<double> column(std::initializer_list<double> entries)
{
    Vector<double> v(static_cast<Eigen::Index>(entries.size()));
    std::copy(entries.begin(), entries.end(), v.data());
    return v;
}

inline Matrix<double> rows(std::initializer_list<std::initializer_list<double>> entries)
{
    Matrix<double> M(static_cast<Eigen::Index>(entries.size()),
                     static_cast<Eigen::Index>(entries.begin()->size()));
    Eigen::Index i = 0;
    for (const auto &row : entries) {
        std::copy(row.begin(), row.end(), M.row(i++).begin());
    }
    return M;
}

inline Matrix<double> randomMatrix(Random &random, Eigen::Index height, Eigen::Index width)
{
    return Matrix<double>::NullaryExpr(height, width, [&random] { return random.normal(); });
}

/// Row c of an identity: the sensor that sees state c.
inline Matrix<double> unitRow(Eigen::Index n, Eigen::Index c)
{
    return Matrix<double>::Identity(n, n).row(c);
}

/// Matrices of a model as they come; the constructor of everything below.
inline NumericsModel makeModel(std::string name, Matrix<double> A, Matrix<double> F,
                               Matrix<double> H, const Vector<double> &r, Vector<double> P0)
{
    NumericsModel model;
    model.name = std::move(name);
    model.ordinary = false;
    model.process = {rounded(A), Matrix<double>(A.rows(), 0), rounded(F)};
    model.sensor = {rounded(H), rounded(r.asDiagonal())};
    model.x0 = Vector<double>::Zero(A.rows());
    model.variances = rounded(P0);
    return model;
}

inline NumericsModel withRanges(NumericsModel model, Vector<double> reach, Vector<double> range)
{
    model.reach = std::move(reach);
    model.range = std::move(range);
    model.sensor.range = model.range;
    return model;
}

inline NumericsModel ordinary(NumericsModel model)
{
    model.ordinary = true;
    return model;
}

// ------------------------------------------------------------------ the models

inline NumericsModel localLevel()
{
    return withRanges(makeModel("n1 local level", rows({{1}}), rows({{0.1}}), rows({{1}}),
                                column({1}), column({100})),
                      column({1024}), column({1024}));
}

inline NumericsModel constantVelocity()
{
    const double dt = 0.01;
    return withRanges(makeModel("n2 CV", rows({{1, dt}, {0, 1}}), rows({{dt * dt}, {2 * dt}}),
                                unitRow(2, 0), column({0.01}), column({100, 100})),
                      column({4096, 256}), column({4096}));
}

inline NumericsModel constantAcceleration()
{
    const double dt = 0.01;
    return withRanges(makeModel("n3 CA", rows({{1, dt, dt * dt / 2}, {0, 1, dt}, {0, 0, 1}}),
                                rows({{dt * dt * dt / 6}, {dt * dt / 2}, {dt}}), unitRow(3, 0),
                                column({0.01}), column({100, 100, 10})),
                      column({65536, 2048, 64}), column({65536}));
}

inline NumericsModel planarVelocity()
{
    const double dt = 0.1;
    const Matrix<double> A = rows({{1, dt, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, dt}, {0, 0, 0, 1}});
    const Matrix<double> F = rows({{dt * dt / 2, 0}, {dt, 0}, {0, dt * dt / 2}, {0, dt}});
    const Matrix<double> H = rows({{1, 0, 0, 0}, {0, 0, 1, 0}});
    return withRanges(
        makeModel("n4 m2 2-D CV", A, F, H, column({0.04, 0.09}), Vector<double>::Constant(4, 100)),
        column({8192, 64, 8192, 64}), column({8192, 8192}));
}

inline NumericsModel dense()
{
    Random random(6);
    Matrix<double> A = 0.25 * randomMatrix(random, 6, 6);
    A.diagonal().array() += 0.5;
    A *= 1.25 / A.cwiseAbs().rowwise().sum().maxCoeff();
    const Matrix<double> F =
        (0.3 * randomMatrix(random, 6, 6)).triangularView<Eigen::Upper>().toDenseMatrix();
    return withRanges(makeModel("n6 m3 dense", A, F, randomMatrix(random, 3, 6),
                                column({0.1, 0.2, 0.3}), Vector<double>::Constant(6, 10)),
                      Vector<double>::Constant(6, 64), Vector<double>::Constant(3, 256));
}

/// Three axes of position, velocity and bias of the accelerometer; sigmas from 1e2 to 1e-5.
inline NumericsModel inertialBias()
{
    const double dt = 0.01;
    Matrix<double> A = Matrix<double>::Identity(9, 9), F = Matrix<double>::Zero(9, 6);
    Vector<double> P0(9), reach(9);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        A(axis, 3 + axis) = dt;
        A(axis, 6 + axis) = -dt * dt / 2;
        A(3 + axis, 6 + axis) = -dt;
        F(axis, axis) = 0.05 * dt * dt / 2;
        F(3 + axis, axis) = 0.05 * dt;
        F(6 + axis, 3 + axis) = 1e-6 * static_cast<double>(1 + axis);
        P0(axis) = 1e4;
        P0(3 + axis) = 100;
        P0(6 + axis) = 1e-4;
        reach(axis) = 32768;
        reach(3 + axis) = 512;
        reach(6 + axis) = 0.125;
    }
    return withRanges(makeModel("n9 m3 IMU bias", A, F, Matrix<double>::Identity(3, 9),
                                column({0.25, 0.5, 0.75}), P0),
                      reach, Vector<double>::Constant(3, 32768));
}

inline NumericsModel sharpVelocity()
{
    const double dt = 0.01;
    return withRanges(makeModel("n2 R=1e-9 P0=1e6", rows({{1, dt}, {0, 1}}),
                                rows({{0.5e-6}, {1e-4}}), unitRow(2, 0), column({1e-9}),
                                column({1e6, 1e6})),
                      column({8192, 8192}), column({8192}));
}

/// The rows of H are sums and differences of all states.
inline NumericsModel sharpSums()
{
    Matrix<double> A = 0.95 * Matrix<double>::Identity(4, 4);
    A(0, 1) = A(1, 2) = A(2, 3) = 0.1;
    return withRanges(makeModel("n4 m2 R=1e-9 P0=1e6", A, rows({{0}, {0}, {0}, {1e-4}}),
                                rows({{1, 1, 1, 1}, {0.5, -1, 1, -1}}), column({1e-9, 1e-9}),
                                Vector<double>::Constant(4, 1e6)),
                      Vector<double>::Constant(4, 16384), Vector<double>::Constant(2, 65536));
}

inline NumericsModel constantState()
{
    return withRanges(makeModel("n1 Q=0", rows({{1}}), Matrix<double>(1, 0), rows({{1}}),
                                column({1}), column({1e4})),
                      column({512}), column({512}));
}

inline NumericsModel straightLine()
{
    return withRanges(makeModel("n2 Q=0", rows({{1, 0.001}, {0, 1}}), Matrix<double>(2, 0),
                                unitRow(2, 0), column({1}), column({1e4, 100})),
                      column({65536, 64}), column({65536}));
}

/// One noise drives all three states alike, but for the last bit of a float.
inline NumericsModel nearlySingular()
{
    return withRanges(
        makeModel("n3 near-singular", rows({{0.9, 0.1, 0}, {0, 0.95, 0}, {0.01, 0, 0.99}}),
                  rows({{1}, {1.0000001}, {0.9999999}}), rows({{1, 1, 1}, {1, -1, 0}}),
                  column({1e-4, 1e-4}), Vector<double>::Constant(3, 1)),
        Vector<double>::Constant(3, 64), column({256, 64}));
}

inline NumericsModel rotation()
{
    const double c = 0.999 * std::cos(0.1), s = 0.999 * std::sin(0.1);
    return withRanges(makeModel("n2 rotation", rows({{c, s}, {-s, c}}),
                                0.01 * Matrix<double>::Identity(2, 2), unitRow(2, 0), column({1}),
                                column({100, 100})),
                      column({64, 64}), column({64}));
}

inline NumericsModel fallingCovariance()
{
    const double dt = 0.01;
    return withRanges(makeModel("n2 P 1e6 -> 2e-9", rows({{1, dt}, {0, 1}}), rows({{1e-9}, {1e-7}}),
                                unitRow(2, 0), column({1e-6}), column({1e6, 1e6})),
                      column({8192, 8192}), column({8192}));
}

/// A level, and a season of four that adds up to noise.
inline NumericsModel levelAndSeason()
{
    const Matrix<double> A = rows({{1, 0, 0, 0}, {0, -1, -1, -1}, {0, 1, 0, 0}, {0, 0, 1, 0}});
    return withRanges(makeModel("n4 level+season", A, rows({{0.1, 0}, {0, 0.05}, {0, 0}, {0, 0}}),
                                rows({{1, 1, 0, 0}}), column({1}),
                                Vector<double>::Constant(4, 100)),
                      Vector<double>::Constant(4, 512), column({512}));
}

inline std::vector<NumericsModel> numericsModels()
{
    return {ordinary(localLevel()),
            ordinary(constantVelocity()),
            ordinary(constantAcceleration()),
            ordinary(planarVelocity()),
            ordinary(dense()),
            ordinary(inertialBias()),
            sharpVelocity(),
            sharpSums(),
            constantState(),
            straightLine(),
            nearlySingular(),
            rotation(),
            fallingCovariance(),
            levelAndSeason()};
}

// ------------------------------------------------------------------ runs

/// How a run is disturbed: a share of the components missing, and R times 1e-2 to 1e2, anew at
/// every measurement.
struct Mode {
    const char *name;
    double missing;
    bool varyingNoise;
};

inline std::array<Mode, 4> numericsModes()
{
    return {{{"plain", 0, false},
             {"30 % missing", 0.3, false},
             {"R varies", 0, true},
             {"both", 0.3, true}}};
}

/// A true start within half a sigma or so of x0, but never far out where P0 is only a way of
/// saying that nothing is known.
inline Vector<double> trueStart(const NumericsModel &model, Random &random)
{
    Vector<double> x = model.x0;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
        const double sigma = std::sqrt(model.variances(i));
        x(i) += 0.5 * std::min(sigma, model.reach(i) / 16) * random.normal();
    }
    return x;
}

/// The sensor of one step: the model's, or one of another noise.
inline SensorModel drawSensor(const NumericsModel &model, const Mode &mode, Random &random)
{
    SensorModel sensor = model.sensor;
    for (Eigen::Index c = 0; c < sensor.components() && mode.varyingNoise; ++c) {
        sensor.R(c, c) *= std::pow(10, random.uniform(-2, 2));
    }
    sensor.R = rounded(sensor.R);
    return sensor;
}

inline Reading drawReading(const NumericsModel &model, const Mode &mode, const SensorModel &sensor,
                           const Vector<double> &x, Random &random)
{
    Reading reading{0, sensor.H * x, 0};
    for (Eigen::Index c = 0; c < reading.z.size(); ++c) {
        const double grid = model.range(c) * 0x1p-23;
        const double z = reading.z(c) + std::sqrt(sensor.R(c, c)) * random.normal();
        reading.z(c) = static_cast<float>(std::rint(z / grid) * grid);
        if (!random.chance(mode.missing)) {
            reading.present |= 1U << c;
        }
    }
    return reading;
}

/// The true state one step later.
inline Vector<double> moved(const NumericsModel &model, const Vector<double> &x, Random &random)
{
    const Matrix<double> &F = model.process.F;
    return model.process.A * x + F * randomMatrix(random, F.cols(), 1);
}

/// One run of a model; sensors[t] is the sensor of step t where the noise varies.
inline Sequence simulate(const NumericsModel &model, const Mode &mode, std::size_t steps,
                         std::uint64_t seed)
{
    Random random(seed);
    Sequence sequence{model.name + ", " + mode.name,
                      model.x0,
                      model.variances.asDiagonal(),
                      {model.process},
                      {},
                      {},
                      model.reach};
    Vector<double> x = trueStart(model, random);
    for (std::size_t t = 0; t < steps; ++t) {
        const SensorModel sensor = drawSensor(model, mode, random);
        Reading reading = drawReading(model, mode, sensor, x, random);
        if (mode.varyingNoise || t == 0) {
            sequence.sensors.push_back(sensor);
        }
        reading.sensor = sequence.sensors.size() - 1;
        sequence.steps.push_back({{reading}, 0, Vector<double>()});
        x = moved(model, x, random);
    }
    return sequence;
}

} // namespace reference

#endif
