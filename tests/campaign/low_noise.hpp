// Random models of low noise, P0 / R from 1e2 to 1e15 by a uniform exponent: n = 1..16, m = 1..4, up to 3 sensors, rows that
// are 1e-4 apart, chains of integrators, and models that grow, with outages of 20 steps.
#ifndef KALMANQ_TESTS_CAMPAIGN_LOW_NOISE_HPP
#define KALMANQ_TESTS_CAMPAIGN_LOW_NOISE_HPP

#include <cmath>
#include <string>

#include "model.hpp"

namespace campaign
{

constexpr int lowNoiseSteps = 60, outageFrom = 20, outageTo = 40;

/// A chain of integrators of which the last one walks, or dense and stable; growing: by 2 % a step, or by the chain
inline reference::ProcessModel lowNoiseProcess(Random &random, Index n, bool isChain, bool grows)
{
    Matrix<double> A = Matrix<double>::Identity(n, n), F = Matrix<double>::Zero(n, n);
    if (!isChain) A = 0.3 / static_cast<double>(n + 2) * reference::normals(random, n, n);
    for (Index i = 0; i < n && !isChain; ++i) A(i, i) += grows ? 0.816 : 0.8;
    for (Index i = 0; i + 1 < n && isChain; ++i) A(i, i + 1) = 0.1;
    if (isChain) F(n - 1, n - 1) = 0.1;
    else F = 0.1 / std::sqrt(n) * reference::normals(random, n, n);
    return {rounded(A), Matrix<double>(n, 0), rounded(F)};
}

inline void addLowNoiseSensor(Random &random, Model &model, double ratio, bool isNear)
{
    const Index n = model.F.rows(), m = random.integer(1, 4);
    reference::SensorModel sensor{reference::normals(random, m, n), Matrix<double>::Zero(m, m)};
    std::vector<reference::SensorModel> &all = model.sequence.sensors;
    for (Index c = 0; c < m; ++c) {
        sensor.R(c, c) = static_cast<float>(random.uniform(1, 2) / ratio);
        if (!isNear || (c == 0 && all.empty())) continue;
        const Matrix<double> other = all.empty() ? sensor.H : all[0].H;
        for (Index k = 0; k < n; ++k) sensor.H(c, k) = other(0, k) * (1 + 1e-4 * random.normal());
    }
    sensor.H = rounded(sensor.H);
    model.N.push_back(Matrix<double>(sensor.R.cwiseSqrt()));
    all.push_back(sensor);
    model.repeated.push_back(false);
}

/// The other sensors speak at every third step.
inline Model lowNoiseModel(Random &random)
{
    Model model;
    const Index n = random.integer(1, random.chance(0.2) ? 16 : 6);
    const bool isChain = random.chance(0.25), hasOutage = random.chance(0.33), isNear = random.chance(0.15);
    model.decades = random.uniform(2, 15);
    model.F = random.chance(0.5) ? Matrix<double>::Identity(n, n)
                                 : reference::generator::randomFactor(random, n, n, Vector<double>::Ones(n));
    model.sequence.P0 = model.F * model.F.transpose();
    model.sequence.x0 = Vector<double>::Zero(n);
    model.sequence.processes.push_back(lowNoiseProcess(random, n, isChain, hasOutage));
    for (int k = random.chance(0.3) ? random.integer(2, 3) : 1; k > 0; --k) {
        addLowNoiseSensor(random, model, std::pow(10, model.decades), isNear);
    }
    for (int t = 0; t < lowNoiseSteps; ++t) {
        Step step{{}, 0, Vector<double>()};
        const bool isSilent = hasOutage && t >= outageFrom && t < outageTo;
        for (std::size_t k = 0; k < model.N.size() && !isSilent; ++k) {
            if (k == 0 || t % 3 == 0) step.readings.push_back({k, Vector<double>(), UINT32_MAX});
        }
        model.sequence.steps.push_back(step);
    }
    simulate(random, model, 1);
    roundReadings(model);
    model.text = "P0/R 1e" + std::to_string(model.decades) + " n" + std::to_string(n) + " sensors " + std::to_string(model.N.size()) + (isChain ? " chain" : "") +
                 (hasOutage ? " outage" : "") + (isNear ? " near" : "");
    return model;
}

} // namespace campaign

#endif
