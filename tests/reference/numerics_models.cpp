#include "numerics_models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace reference
{

NumericsModel makeModel(std::string name, const Matrix<double> &A, const Matrix<double> &F,
                        const Matrix<double> &H, const Vector<double> &r, const Vector<double> &P0,
                        const Vector<double> &reach, const Vector<double> &range)
{
    NumericsModel model;
    model.name = std::move(name);
    model.ordinary = false;
    model.process = {rounded(A), Matrix<double>(A.rows(), 0), rounded(F)};
    model.sensor = {rounded(H), rounded(r.asDiagonal()), range};
    model.x0 = Vector<double>::Zero(A.rows());
    model.variances = rounded(P0);
    model.reach = reach;
    model.range = range;
    return model;
}

static NumericsModel ordinary(NumericsModel model)
{
    model.ordinary = true;
    return model;
}

// ------------------------------------------------------------------ the models

NumericsModel localLevel()
{
    return makeModel("n1 local level", rows({{1}}), rows({{0.1}}), rows({{1}}), column({1}),
                     column({100}), column({1024}), column({1024}));
}

NumericsModel constantVelocity()
{
    const double dt = 0.01;
    return makeModel("n2 CV", rows({{1, dt}, {0, 1}}), rows({{dt * dt}, {2 * dt}}), unitRow(2, 0),
                     column({0.01}), column({100, 100}), column({4096, 256}), column({4096}));
}

NumericsModel constantAcceleration()
{
    const double dt = 0.01;
    return makeModel("n3 CA", rows({{1, dt, dt * dt / 2}, {0, 1, dt}, {0, 0, 1}}),
                     rows({{dt * dt * dt / 6}, {dt * dt / 2}, {dt}}), unitRow(3, 0), column({0.01}),
                     column({100, 100, 10}), column({65536, 2048, 64}), column({65536}));
}

NumericsModel planarVelocity()
{
    const double dt = 0.1;
    const Matrix<double> A = rows({{1, dt, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, dt}, {0, 0, 0, 1}});
    const Matrix<double> F = rows({{dt * dt / 2, 0}, {dt, 0}, {0, dt * dt / 2}, {0, dt}});
    const Matrix<double> H = rows({{1, 0, 0, 0}, {0, 0, 1, 0}});
    return makeModel("n4 m2 2-D CV", A, F, H, column({0.04, 0.09}),
                     Vector<double>::Constant(4, 100), column({8192, 64, 8192, 64}),
                     column({8192, 8192}));
}

NumericsModel dense()
{
    Random random(6);
    Matrix<double> A = 0.25 * normals(random, 6, 6);
    A += 0.5 * Matrix<double>::Identity(6, 6);
    A *= 1.25 / (A.cwiseAbs() * Vector<double>::Ones(6)).maxCoeff();
    const Matrix<double> F = (0.3 * normals(random, 6, 6)).upperTriangle();
    return makeModel("n6 m3 dense", A, F, normals(random, 3, 6), column({0.1, 0.2, 0.3}),
                     Vector<double>::Constant(6, 10), Vector<double>::Constant(6, 64),
                     Vector<double>::Constant(3, 256));
}

NumericsModel inertialBias()
{
    const double dt = 0.01;
    Matrix<double> A = Matrix<double>::Identity(9, 9), F = Matrix<double>::Zero(9, 6);
    Vector<double> P0(9), reach(9);
    for (Index axis = 0; axis < 3; ++axis) {
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
    return makeModel("n9 m3 IMU bias", A, F, Matrix<double>::Identity(3, 9),
                     column({0.25, 0.5, 0.75}), P0, reach, Vector<double>::Constant(3, 32768));
}

static NumericsModel sharpVelocity()
{
    const double dt = 0.01;
    return makeModel("n2 R=1e-9 P0=1e6", rows({{1, dt}, {0, 1}}), rows({{0.5e-6}, {1e-4}}),
                     unitRow(2, 0), column({1e-9}), column({1e6, 1e6}), column({8192, 8192}),
                     column({8192}));
}

NumericsModel sharpSums()
{
    Matrix<double> A = 0.95 * Matrix<double>::Identity(4, 4);
    A(0, 1) = A(1, 2) = A(2, 3) = 0.1;
    return makeModel("n4 m2 R=1e-9 P0=1e6", A, rows({{0}, {0}, {0}, {1e-4}}),
                     rows({{1, 1, 1, 1}, {0.5, -1, 1, -1}}), column({1e-9, 1e-9}),
                     Vector<double>::Constant(4, 1e6), Vector<double>::Constant(4, 16384),
                     Vector<double>::Constant(2, 65536));
}

NumericsModel constantState()
{
    return makeModel("n1 Q=0", rows({{1}}), Matrix<double>(1, 0), rows({{1}}), column({1}),
                     column({1e4}), column({512}), column({512}));
}

NumericsModel straightLine()
{
    return makeModel("n2 Q=0", rows({{1, 0.001}, {0, 1}}), Matrix<double>(2, 0), unitRow(2, 0),
                     column({1}), column({1e4, 100}), column({65536, 64}), column({65536}));
}

NumericsModel nearlySingular()
{
    return makeModel("n3 near-singular", rows({{0.9, 0.1, 0}, {0, 0.95, 0}, {0.01, 0, 0.99}}),
                     rows({{1}, {1.0000001}, {0.9999999}}), rows({{1, 1, 1}, {1, -1, 0}}),
                     column({1e-4, 1e-4}), Vector<double>::Constant(3, 1),
                     Vector<double>::Constant(3, 64), column({256, 64}));
}

NumericsModel rotation()
{
    const double c = 0.999 * std::cos(0.1), s = 0.999 * std::sin(0.1);
    return makeModel("n2 rotation", rows({{c, s}, {-s, c}}), 0.01 * Matrix<double>::Identity(2, 2),
                     unitRow(2, 0), column({1}), column({100, 100}), column({64, 64}),
                     column({64}));
}

NumericsModel fallingCovariance()
{
    const double dt = 0.01;
    return makeModel("n2 P 1e6 -> 2e-9", rows({{1, dt}, {0, 1}}), rows({{1e-9}, {1e-7}}),
                     unitRow(2, 0), column({1e-6}), column({1e6, 1e6}), column({8192, 8192}),
                     column({8192}));
}

/// A level, and a season of four that adds up to noise.
static NumericsModel levelAndSeason()
{
    const Matrix<double> A = rows({{1, 0, 0, 0}, {0, -1, -1, -1}, {0, 1, 0, 0}, {0, 0, 1, 0}});
    return makeModel("n4 level+season", A, rows({{0.1, 0}, {0, 0.05}, {0, 0}, {0, 0}}),
                     rows({{1, 1, 0, 0}}), column({1}), Vector<double>::Constant(4, 100),
                     Vector<double>::Constant(4, 512), column({512}));
}

std::vector<NumericsModel> numericsModels()
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

std::array<Mode, 4> numericsModes()
{
    return {{{"plain", 0, false},
             {"30 % missing", 0.3, false},
             {"R varies", 0, true},
             {"both", 0.3, true}}};
}

Vector<double> trueStart(const NumericsModel &model, Random &random)
{
    Vector<double> x = model.x0;
    for (Index i = 0; i < x.size(); ++i) {
        const double sigma = std::sqrt(model.variances(i));
        x(i) += 0.5 * std::min(sigma, model.reach(i) / 16) * random.normal();
    }
    return x;
}

/// The sensor of one step: the model's, or one of another noise.
static SensorModel drawSensor(const NumericsModel &model, const Mode &mode, Random &random)
{
    SensorModel sensor = model.sensor;
    for (Index c = 0; c < sensor.components() && mode.varyingNoise; ++c) {
        sensor.R(c, c) *= logUniform(random, -2, 2);
    }
    sensor.R = rounded(sensor.R);
    return sensor;
}

Reading drawReading(const NumericsModel &model, const Mode &mode, const SensorModel &sensor,
                    const Vector<double> &x, Random &random)
{
    Reading reading{0, sensor.H * x, 0};
    for (Index c = 0; c < reading.z.size(); ++c) {
        const double grid = model.range(c) * 0x1p-23;
        const double z = reading.z(c) + std::sqrt(sensor.R(c, c)) * random.normal();
        reading.z(c) = static_cast<float>(std::rint(z / grid) * grid);
        if (!random.chance(mode.missing)) {
            reading.present |= 1U << c;
        }
    }
    return reading;
}

Vector<double> moved(const NumericsModel &model, const Vector<double> &x, Random &random)
{
    const Matrix<double> &F = model.process.F;
    return model.process.A * x + F * normals(random, F.cols(), 1);
}

Sequence simulate(const NumericsModel &model, const Mode &mode, std::size_t steps,
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
