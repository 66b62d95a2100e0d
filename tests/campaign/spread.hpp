// Random models whose prior spans up to five decades: R down to 0, no process noise or noise of low rank, a singular A, a
// fifth of the measurements missing.  P0 is 0 and the first step adds the prior, given by its root: no filter has to take a
// root of it.  A sensor has one component, so that a filter says which it took.
#ifndef KALMANQ_TESTS_CAMPAIGN_SPREAD_HPP
#define KALMANQ_TESTS_CAMPAIGN_SPREAD_HPP

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "../reference/decompositions.hpp"
#include "model.hpp"

namespace campaign
{

constexpr int spreadSteps = 40;

enum class Shape { acceleration, integrators, rotation, companion, general, nearIdentity, shapes };
const char *const shapeNames[] = {"constant acceleration", "chain of integrators", "rotation",
                                  "companion, delay line", "general A", "near identity"};

inline Vector<double> powersOfTen(Random &random, Index n, double low, double high)
{
    return reference::generated(n, 1, [&] { return logUniform(random, low, high); });
}

/// 1 with a probability, otherwise 0
inline Matrix<double> mask(Random &random, Index height, Index width, double probability)
{
    return reference::generated(height, width, [&] { return random.chance(probability) ? 1.0 : 0.0; });
}

/// A in units of order 1
inline Matrix<double> transitionOf(Random &random, Shape shape, Index n)
{
    const Matrix<double> I = Matrix<double>::Identity(n, n);
    Matrix<double> shift = Matrix<double>::Zero(n, n);
    shift.diagonal(1).setConstant(1);
    if (shape == Shape::acceleration || shape == Shape::integrators) return I + 0.1 * shift;
    if (shape == Shape::companion) {
        const bool isDelay = random.chance(0.3);
        for (Index i = 0; i < n && !isDelay; ++i) shift(i, 0) += random.uniform(-0.5, 0.5);
        return shift;
    }
    const Matrix<double> N = reference::normals(random, n, n);
    if (shape == Shape::rotation) return reference::orthogonalFactor(N);
    if (shape == Shape::general) return N * (random.uniform(0.3, 1.3) / std::max(reference::spectralRadius(N), 0.1));
    const Matrix<double> A = I + 0.1 * N;
    return A / std::max(1.0, reference::spectralRadius(A));
}

inline Vector<double> sizesOf(Random &random, Shape shape, Index n)
{
    if (shape == Shape::acceleration || shape == Shape::integrators) return powersOfTen(random, n, -1, 1);
    return shape == Shape::nearIdentity ? powersOfTen(random, n, -3, 3) : Vector<double>(Vector<double>::Ones(n));
}

inline Matrix<double> factorOfQ(Random &random, Shape shape, const Vector<double> &size)
{
    const Index n = size.size();
    Index rank = random.integer(0, static_cast<int>(n));
    if (random.chance(0.25)) rank = 0;
    if (shape == Shape::companion) rank = std::min<Index>(rank, 1);
    return logUniform(random, -5, 0) * size.asDiagonal() * reference::normals(random, n, rank);
}

/// Some of its columns are 0 in three models of ten.
inline Matrix<double> rootOfPrior(Random &random, const Vector<double> &size)
{
    const Index n = size.size();
    const Vector<double> spread = powersOfTen(random, n, -1, random.chance(0.5) ? 1 : 4);
    const Matrix<double> S = size.asDiagonal() * reference::normals(random, n, n) * spread.asDiagonal();
    if (random.chance(0.7)) return S.upperTriangle();
    return S.upperTriangle() * mask(random, n, 1, 0.6).asDiagonal();
}

inline void addSpreadSensor(Random &random, Model &model, const Vector<double> &size, double noisy)
{
    const Index n = size.size();
    const Matrix<double> weights = reference::normals(random, 1, n).cwiseProduct(mask(random, 1, n, 0.7));
    const double r = logUniform(random, -8, 0) * (random.chance(noisy) ? 1 : 0);
    const Matrix<double> R = rounded(Matrix<double>::Constant(1, 1, r));
    model.sequence.sensors.push_back({rounded(weights * size.cwiseInverse().asDiagonal()), R});
    model.N.push_back(R.cwiseSqrt());
    model.repeated.push_back(false);
}

inline Model spreadModel(Random &random, std::uint64_t number)
{
    Model model;
    Sequence &sequence = model.sequence;
    const auto shape = static_cast<Shape>(number % static_cast<unsigned>(Shape::shapes));
    const Index n = shape == Shape::acceleration ? 3 : random.integer(1, 5);
    const Vector<double> size = sizesOf(random, shape, n);
    const Matrix<double> A = size.asDiagonal() * transitionOf(random, shape, n) * size.cwiseInverse().asDiagonal(), none(n, 0);
    sequence.x0 = Vector<double>::Zero(n);
    sequence.P0 = Matrix<double>::Zero(n, n);
    model.F = Matrix<double>(n, 0);
    sequence.processes.push_back({Matrix<double>::Identity(n, n), none, rounded(rootOfPrior(random, size))});
    sequence.processes.push_back({rounded(A), none, rounded(factorOfQ(random, shape, size))});
    const double noisy = random.chance(0.4) ? 0.5 : 1;
    for (int c = random.integer(1, 2); c > 0; --c) addSpreadSensor(random, model, size, noisy);
    sequence.steps.push_back({{}, 0, Vector<double>()});
    for (int t = 0; t < spreadSteps; ++t) {
        Step step{{}, 1, Vector<double>()};
        for (std::size_t k = 0; k < model.N.size(); ++k) {
            step.readings.push_back({k, Vector<double>(), random.chance(0.2) ? 0U : 1U});
        }
        sequence.steps.push_back(step);
    }
    simulate(random, model, 1);
    roundReadings(model);
    model.text = shapeNames[number % static_cast<unsigned>(Shape::shapes)];
    return model;
}

} // namespace campaign

#endif
