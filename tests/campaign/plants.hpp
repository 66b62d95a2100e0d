// Random models of the ordinary kind, as firmware has them, with 200 steps of data.  Each has a scale of its own, a noise of
// its own, a prior up to 1e4 sigma of the measurements wide, and every other one gaps.
#ifndef KALMANQ_TESTS_CAMPAIGN_PLANTS_HPP
#define KALMANQ_TESTS_CAMPAIGN_PLANTS_HPP

#include <cmath>
#include <cstdint>
#include <string>

#include "model.hpp"

namespace campaign
{

/// What a plant is before it has its scales.
struct Plant {
    const char *name;
    Matrix<double> A, B, F, H;
};

/// Position and its derivatives, of which the last one walks; all axes alike, positions are measured.
inline Plant chain(Random &random, Index order, Index axes)
{
    const Index n = order * axes;
    const double dt = logUniform(random, -3, 0), q = logUniform(random, -3, 2);
    Plant plant{"chain", Matrix<double>::Identity(n, n), Matrix<double>(n, 0), Matrix<double>::Zero(n, axes),
                Matrix<double>::Zero(axes, n)};
    for (Index a = 0; a < axes; ++a) {
        double power = 1;
        for (Index k = 1; k < order; ++k) {
            power *= dt / static_cast<double>(k);
            for (Index i = 0; i + k < order; ++i) plant.A(a * order + i, a * order + i + k) = power;
        }
        for (Index i = 0; i < order; ++i) {
            plant.F(a * order + i, a) = q * std::sqrt(dt) * std::pow(dt, static_cast<double>(order - 1 - i));
        }
        plant.H(a, a * order) = 1;
    }
    return plant;
}

/// Position and velocity moved by an accelerometer with a bias, or an angle by a gyro with one
inline Plant inertial(Random &random, Index order)
{
    const Index n = order + 1;
    Plant plant = chain(random, order, 1);
    const double dt = order > 1 ? plant.A(0, 1) : logUniform(random, -3, 0);
    Plant result{"inertial", Matrix<double>::Identity(n, n), Matrix<double>::Zero(n, 1), Matrix<double>::Zero(n, 2),
                 Matrix<double>::Zero(1, n)};
    result.A.block(0, 0, order, order) = plant.A;
    for (Index i = 0; i < order; ++i) {
        result.B(i, 0) = i + 1 == order ? dt : dt * dt / 2;
        result.A(i, order) = -result.B(i, 0);
        result.F(i, 0) = plant.F(i, 0);
    }
    result.F(order, 1) = plant.F(order - 1, 0) * logUniform(random, -3, -1);
    result.H(0, 0) = 1;
    return result;
}

/// Temperatures one beside the other, the first of them heated, one or two measured
inline Plant thermal(Random &random, Index n)
{
    Plant plant{"thermal", Matrix<double>::Zero(n, n), Matrix<double>::Zero(n, 1), Matrix<double>::Zero(n, n),
                Matrix<double>::Zero(random.integer(1, 2), n)};
    for (Index i = 0; i < n; ++i) {
        const double loss = logUniform(random, -3, -1);
        plant.A(i, i) = 1 - 2 * loss;
        if (i > 0) plant.A(i, i - 1) = loss;
        if (i + 1 < n) plant.A(i, i + 1) = loss;
        plant.F(i, i) = logUniform(random, -3, 0);
    }
    plant.B(0, 0) = logUniform(random, -2, 0);
    for (Index c = 0; c < plant.H.rows(); ++c) plant.H(c, c == 0 ? n - 1 : 0) = 1;
    return plant;
}

/// A vibration with an offset
inline Plant vibration(Random &random)
{
    const double turn = random.uniform(0.02, 2), damping = 1 - logUniform(random, -4, -1);
    Plant plant{"vibration", Matrix<double>::Identity(3, 3), Matrix<double>(3, 0), Matrix<double>::Zero(3, 3),
                Matrix<double>::Zero(1, 3)};
    plant.A(0, 0) = plant.A(1, 1) = damping * std::cos(turn);
    plant.A(0, 1) = damping * std::sin(turn);
    plant.A(1, 0) = -plant.A(0, 1);
    plant.F(0, 0) = plant.F(1, 1) = logUniform(random, -2, 1);
    plant.F(2, 2) = logUniform(random, -4, -1);
    plant.H(0, 0) = plant.H(0, 2) = 1;
    return plant;
}

/// Level, slope and a season of four
inline Plant seasonal(Random &random)
{
    Plant plant{"seasonal", Matrix<double>::Zero(5, 5), Matrix<double>(5, 0), Matrix<double>::Zero(5, 3),
                Matrix<double>::Zero(1, 5)};
    plant.A(0, 0) = plant.A(0, 1) = plant.A(1, 1) = plant.A(3, 2) = plant.A(4, 3) = 1;
    for (Index j = 2; j < 5; ++j) plant.A(2, j) = -1;
    plant.F(0, 0) = logUniform(random, -2, 0);
    plant.F(1, 1) = logUniform(random, -4, -2);
    plant.F(2, 2) = logUniform(random, -3, 0);
    plant.H(0, 0) = plant.H(0, 2) = 1;
    return plant;
}

/// Constants to be calibrated, seen by dense rows
inline Plant constants(Random &random, Index n)
{
    Plant plant{"constants", Matrix<double>::Identity(n, n), Matrix<double>(n, 0), Matrix<double>::Zero(n, 0),
                Matrix<double>(n, n)};
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) plant.H(i, j) = random.normal() + (i == j ? 2 : 0);
    }
    return plant;
}

inline Plant randomPlant(Random &random)
{
    switch (random.integer(0, 8)) {
    case 0: return chain(random, 1, 1);
    case 1: return chain(random, 2, 1);
    case 2: return chain(random, 3, 1);
    case 3: return chain(random, 2, random.integer(2, 3));
    case 4: return inertial(random, random.integer(1, 2));
    case 5: return thermal(random, random.integer(2, 4));
    case 6: return vibration(random);
    case 7: return seasonal(random);
    default: return constants(random, random.integer(1, 3));
    }
}

/// The second sensor of some: the same, up to 100 times worse, at every third step (model.hpp).
inline Model plantModel(Random &random)
{
    Model model;
    const Plant plant = randomPlant(random);
    const Index n = plant.A.rows(), m = plant.H.rows();
    const double unit = logUniform(random, -3, 3);
    const auto single = [](double a) { return static_cast<double>(static_cast<float>(a)); };
    model.units = Vector<double>::Ones(n);
    model.F = Matrix<double>::Zero(n, n);
    model.sequence.x0 = Vector<double>::Zero(n);
    for (Index i = 0; i < n; ++i) {
        model.F(i, i) = std::ldexp(1, static_cast<int>(std::log2(unit * logUniform(random, 0, 4))));
        model.sequence.x0(i) = single(unit * random.normal());
    }
    model.sequence.P0 = model.F * model.F.transpose();
    Matrix<double> F = unit * plant.F;
    model.sequence.processes.push_back({rounded(plant.A), rounded(Matrix<double>(unit * plant.B)), rounded(F)});
    const int sensors = random.chance(0.3) ? 2 : 1;
    for (int k = 0; k < sensors; ++k) {
        const double sigma = std::ldexp(1, static_cast<int>(std::log2(unit * (k ? logUniform(random, 0, 2) : 1))));
        model.N.push_back(Matrix<double>(Matrix<double>::Identity(m, m) * sigma));
        model.sequence.sensors.push_back({rounded(plant.H), model.N.back() * model.N.back().transpose()});
        model.repeated.push_back(false);
    }
    model.text = plant.name;
    addSteps(random, model, model.text);
    simulate(random, model, 1);
    putOnGrid(model);
    return model;
}

} // namespace campaign

#endif
