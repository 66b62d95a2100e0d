// A random model, its data, and those of the hard kind, with 200 steps.
//
// States and measurements in units that span 8 decades; A stable or marginal, or with integrators;
// Q and P0 of any rank, Q also 0; R diagonal, full, singular or 0, down to 1e-10 of the signal;
// sensors without noise that say a thing twice or say a sum; gaps and missing components;
// controls.  H and z are made so that what is redundant is so exactly, in floats and in words.
#ifndef KALMANQ_TESTS_CAMPAIGN_MODEL_HPP
#define KALMANQ_TESTS_CAMPAIGN_MODEL_HPP

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "../reference/generator.hpp"
#include "../reference/ranges.hpp"
#include "arrays.hpp"

namespace campaign
{

using reference::Random;
using reference::Sequence;

constexpr int steps = 200, maxComponents = 3;

enum class NoiseKind { diagonal, full, singular, partlyZero, repeated };

/// A model, its factors (P0 = F F', R = N N'), and the true states behind its data.
struct Model {
    Sequence sequence;
    Matrix<double> F;
    std::vector<Matrix<double>> N;
    std::vector<bool> repeated;    // the sensor's last component follows from the others
    Vector<double> units, largest; // of the states
    std::string text;
    double decades = 0; // of P0 / R, where a kind has them
};

inline const char *nameOf(NoiseKind kind)
{
    static const char *const names[] = {"diagonal", "full", "singular", "partly 0", "repeated"};
    return names[static_cast<int>(kind)];
}

inline NoiseKind randomKind(Random &random, Index m)
{
    if (m == 1) return random.chance(0.85) ? NoiseKind::diagonal : NoiseKind::partlyZero;
    const double x = random.uniform();
    if (x < 0.35) return NoiseKind::diagonal;
    if (x < 0.60) return NoiseKind::full;
    if (x < 0.72) return NoiseKind::singular;
    return x < 0.86 ? NoiseKind::partlyZero : NoiseKind::repeated;
}

inline Matrix<double> noiseFactor(Random &random, NoiseKind kind, const Vector<double> &scale)
{
    using namespace reference::generator;
    const Index m = scale.size();
    if (kind == NoiseKind::full) return randomFactor(random, m, m, scale);
    if (kind == NoiseKind::singular) return randomFactor(random, m, m - 1, scale);
    Matrix<double> N = diagonalFactor(random, m, scale);
    if (kind == NoiseKind::partlyZero) {
        for (Index c = 0; c < m; ++c) N(c, c) *= m == 1 || random.chance(0.6) ? 0 : 1;
    }
    if (kind == NoiseKind::repeated) {
        for (Index c = m - 1; c >= 0 && c >= m - 3; --c) N(c, c) = 0;
    }
    return N;
}

/// A row of order 1 in each state's unit: one state as it is, or multiples of 1/1024.
inline Vector<double> randomRow(Random &random, const Vector<double> &units, bool selects)
{
    const Index n = units.size();
    Vector<double> h = Vector<double>::Zero(n);
    if (selects) {
        h(random.integer(0, static_cast<int>(n) - 1)) = 1;
        return h;
    }
    for (Index k = 0; k < n; ++k) {
        if (random.chance(0.8)) h(k) = std::rint(1024 * random.normal()) / 1024 / units(k);
    }
    return h;
}

inline void addSensor(Random &random, Model &model, Index m, std::string &text)
{
    const NoiseKind kind = randomKind(random, m);
    const bool selects = kind != NoiseKind::repeated && random.chance(0.3);
    const bool sharp = random.chance(0.15);
    reference::SensorModel sensor;
    sensor.H.resize(m, model.units.size());
    Vector<double> scale(m);
    for (Index c = 0; c < m; ++c) {
        const Vector<double> h = randomRow(random, model.units, selects);
        const int unit = kind == NoiseKind::repeated || selects ? 0 : random.integer(-13, 13);
        sensor.H.row(c) = std::ldexp(1, unit) * h.transpose();
        const double size = h.cwiseProduct(model.units).cwiseAbs().maxCoeff();
        const int level = sharp ? random.integer(-18, -12) : random.integer(-8, 3);
        scale(c) = reference::powerOfTwo(size > 0 ? size : 1) * std::ldexp(1, unit + level);
    }
    if (kind == NoiseKind::repeated) {
        sensor.H.row(m - 1) = m == 2 ? Matrix<double>(4 * sensor.H.row(0))
                                     : Matrix<double>(sensor.H.row(0) + sensor.H.row(1));
    }
    model.N.push_back(noiseFactor(random, kind, scale));
    sensor.R = model.N.back() * model.N.back().transpose();
    model.repeated.push_back(kind == NoiseKind::repeated);
    model.sequence.sensors.push_back(sensor);
    text += std::string(" R ") + nameOf(kind) + (sharp ? " sharp" : "") + " m" + std::to_string(m);
}

inline void addProcess(Random &random, Model &model, std::string &text)
{
    using namespace reference::generator;
    const Index n = model.units.size();
    const bool marginal = random.chance(0.4);
    const int l = random.chance(0.6) ? 0 : random.integer(1, 2);
    const double kind = random.uniform();
    const Index rank = kind < 0.12 ? 0 : kind < 0.5 ? random.integer(1, static_cast<int>(n)) : n;
    const int level = random.integer(-10, 2);
    const Matrix<double> lower = unitTriangular(random, n);
    const Matrix<double> coordinates =
        random.chance(0.7) ? Matrix<double>(lower * unitTriangular(random, n).transpose())
                           : identity(n);
    const Matrix<double> D = eigenBlocks(random, n, marginal, marginal);
    const Matrix<double> B = model.units.asDiagonal() * randomMatrix(random, n, l);
    model.sequence.processes.push_back(
        {transition(D, coordinates, model.units), rounded(B),
         randomFactor(random, n, rank, model.units * std::ldexp(1.0, level))});
    text += std::string(marginal ? " marginal" : " stable") + " Q rank " + std::to_string(rank) +
            " 2^" + std::to_string(level) + " l" + std::to_string(l);
}

inline void addPrior(Random &random, Model &model, std::string &text)
{
    using namespace reference::generator;
    const Index n = model.units.size();
    const Index rank = random.chance(0.8) ? n : random.integer(0, static_cast<int>(n));
    const int level = random.integer(-4, 10);
    model.F = randomFactor(random, n, rank, model.units * std::ldexp(1.0, level));
    model.sequence.P0 = model.F * model.F.transpose();
    const double offset = random.chance(0.8) ? 10 : 1000;
    const Vector<double> x0 = model.units.cwiseProduct(offset * normals(random, n));
    model.sequence.x0 = rounded(x0);
    text += " P0 rank " + std::to_string(rank) + " 2^" + std::to_string(level);
}

/// The second sensor speaks at every third step; bursts without any, and components missing.
inline void addSteps(Random &random, Model &model, std::string &text)
{
    const bool gaps = random.chance(0.5);
    const Index l = model.sequence.processes[0].B.cols();
    for (int t = 0; t < steps; ++t) {
        reference::Step step{{}, 0, Vector<double>()};
        const bool silent = gaps && t % 50 > 40;
        for (std::size_t k = 0; k < model.sequence.sensors.size() && !silent; ++k) {
            if (k > 0 && t % 3 != 0) continue;
            const bool whole = !gaps || random.chance(0.6);
            const auto some = static_cast<std::uint32_t>(random.integer(0, 7));
            step.readings.push_back({k, Vector<double>(), whole ? UINT32_MAX : some});
        }
        if (l > 0 && t % 10 != 0) {
            step.u = rounded(0.25 * reference::normals(random, l));
        }
        model.sequence.steps.push_back(step);
    }
    if (gaps) text += " gaps";
}

/// The true state begins within `share` of the prior's sigma.
inline void simulate(Random &random, Model &model, double share)
{
    using reference::normals;
    Sequence &sequence = model.sequence;
    Vector<double> x = sequence.x0 + share * (model.F * normals(random, model.F.cols()));
    model.largest = x.cwiseAbs();
    for (reference::Step &step : sequence.steps) {
        model.largest = model.largest.cwiseMax(x.cwiseAbs());
        for (reference::Reading &reading : step.readings) {
            const Matrix<double> &N = model.N[reading.sensor];
            reading.z = sequence.sensors[reading.sensor].H * x + N * normals(random, N.cols());
        }
        const reference::ProcessModel &process = sequence.processes[step.process];
        x = process.A * x + process.F * normals(random, process.F.cols());
        if (step.u.size() > 0) x += process.B * step.u;
    }
}

/// z to floats
inline void roundReadings(Model &model)
{
    for (reference::Step &step : model.sequence.steps) {
        for (reference::Reading &reading : step.readings) reading.z = rounded(reading.z);
    }
}

/// The largest |z| of each sensor's components; 1 where all are 0.
inline std::vector<Vector<double>> largestReadings(const Sequence &sequence)
{
    std::vector<Vector<double>> most;
    for (const reference::SensorModel &sensor : sequence.sensors) {
        most.push_back(Vector<double>::Zero(sensor.components()));
    }
    for (const reference::Step &step : sequence.steps) {
        for (const reference::Reading &reading : step.readings) {
            Vector<double> &now = most[reading.sensor];
            now = now.cwiseMax(reading.z.cwiseAbs());
        }
    }
    for (Vector<double> &now : most) {
        now = now.unaryExpr([](double v) { return v > 0 ? v : 1.0; });
    }
    return most;
}

/// z on 20 bits of its largest, so that floats and words hold it; what is repeated, exactly so.
inline void putOnGrid(Model &model)
{
    const std::vector<Vector<double>> most = largestReadings(model.sequence);
    for (reference::Step &step : model.sequence.steps) {
        for (reference::Reading &reading : step.readings) {
            const bool repeated = model.repeated[reading.sensor];
            Vector<double> range = reference::powersOfTwo(16 * most[reading.sensor]);
            const Index last = range.size() - 1;
            if (repeated) range.topRows(last).setConstant(range.topRows(last).maxCoeff());
            Vector<double> &z = reading.z;
            z = reference::onGrid(z, range);
            if (repeated) z(last) = last == 1 ? 4 * z(0) : z(0) + z(1);
        }
    }
}

inline Model hardModel(Random &random, double share)
{
    Model model;
    const Index n = random.integer(1, 8), m = random.integer(1, 3);
    const bool wide = random.chance(0.7);
    model.units = wide ? reference::generator::powersOfTwo(random, n, -13, 13)
                       : Vector<double>(Vector<double>::Ones(n));
    std::string text = "n" + std::to_string(n) + (wide ? " units" : "");
    addPrior(random, model, text);
    addProcess(random, model, text);
    addSensor(random, model, m, text);
    if (random.chance(0.3)) addSensor(random, model, random.integer(1, 2), text);
    addSteps(random, model, text);
    simulate(random, model, share);
    putOnGrid(model);
    model.text = text;
    return model;
}

} // namespace campaign

#endif
