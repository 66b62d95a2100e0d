// Random models of small whole numbers, their data every other time: components that have no noise, say a thing twice,
// say a sum or a difference, and processes that have little noise or none.
#ifndef KALMANQ_TESTS_CAMPAIGN_WHOLE_HPP
#define KALMANQ_TESTS_CAMPAIGN_WHOLE_HPP

#include <cmath>
#include <cstdint>
#include <string>

#include "model.hpp"

namespace campaign
{

constexpr int wholeSteps = 30;

/// A signed permutation, a chain, a part of it that forgets, or whole numbers below a diagonal.
inline Matrix<double> wholeTransition(Random &random, Index n)
{
    Matrix<double> A = Matrix<double>::Zero(n, n);
    const int kind = random.integer(0, 3);
    for (Index i = 0; i < n; ++i) {
        if (kind == 0) A(i, (i + 1) % n) = random.chance(0.5) ? 1 : -1;
        if (kind == 1) A(i, i) = 1;
        if (kind == 1 && i + 1 < n) A(i, i + 1) = 1;
        if (kind == 2) A(i, i) = random.chance(0.5) ? 1 : 0.5;
        if (kind == 3) A(i, i) = random.integer(-1, 1);
        for (Index j = i + 1; j < n && kind >= 2; ++j) A(i, j) = random.chance(0.4) ? random.integer(-1, 1) : 0;
    }
    if (random.chance(0.15)) A.row(random.integer(0, static_cast<int>(n) - 1)).setZero();
    return A;
}

inline Matrix<double> wholeNumbers(Random &random, Index height, Index width, double share)
{
    Matrix<double> M(height, width);
    for (Index i = 0; i < height; ++i) {
        for (Index j = 0; j < width; ++j) M(i, j) = random.chance(share) ? random.integer(-2, 2) : 0;
    }
    return M;
}

/// Components of small whole numbers, some of them what the ones before have said.
inline reference::SensorModel wholeSensor(Random &random, Index m, Index n, double noiseFree)
{
    reference::SensorModel s;
    s.H = wholeNumbers(random, m, n, 0.7);
    s.R = Matrix<double>::Zero(m, m);
    for (Index c = 0; c < m; ++c) {
        if (c > 0 && random.chance(0.2)) s.H.row(c) = Matrix<double>(2 * s.H.row(c - 1));
        if (c > 1 && random.chance(0.2)) s.H.row(c) = Matrix<double>(s.H.row(0) + s.H.row(1));
        s.R(c, c) = random.chance(noiseFree) ? 0 : std::ldexp(1, random.integer(-12, 2));
    }
    return s;
}

/// Small whole numbers, or normal ones
inline Matrix<double> drawn(Random &random, bool whole, Index count)
{
    return whole ? wholeNumbers(random, count, 1, 1)
                 : Matrix<double>(reference::normals(random, count));
}

inline Model wholeModel(Random &random, double noiseFree)
{
    Model model;
    Sequence &sequence = model.sequence;
    const Index n = random.integer(2, 6), rank = random.integer(0, static_cast<int>(n));
    const double quiet = std::ldexp(1, random.integer(-6, 1));
    model.units = Vector<double>::Ones(n);
    model.F = wholeNumbers(random, n, n, 0.6) * std::ldexp(1, random.integer(-1, 4));
    sequence.P0 = model.F * model.F.transpose();
    sequence.x0 = wholeNumbers(random, n, 1, 1);
    Matrix<double> A = wholeTransition(random, n);
    sequence.processes.push_back({A, Matrix<double>(n, 0), Matrix<double>(wholeNumbers(random, n, rank, 0.5) * quiet)});
    for (int k = random.integer(1, 2); k > 0; --k) {
        sequence.sensors.push_back(wholeSensor(random, random.integer(1, 3), n, noiseFree));
        model.repeated.push_back(false);
    }
    const reference::ProcessModel &process = sequence.processes[0];
    const bool whole = random.chance(0.5);
    Vector<double> x = sequence.x0 + model.F * drawn(random, whole, n);
    model.largest = x.cwiseAbs();
    for (int t = 0; t < wholeSteps; ++t) {
        reference::Step step{{}, 0, Vector<double>()};
        model.largest = model.largest.cwiseMax(x.cwiseAbs());
        for (std::size_t k = 0; k < sequence.sensors.size(); ++k) {
            const reference::SensorModel &s = sequence.sensors[k];
            if (random.chance(0.2)) continue;
            Vector<double> z = s.H * x;
            z += s.R.diagonal().cwiseSqrt().cwiseProduct(Vector<double>(drawn(random, whole, z.size())));
            const bool all = random.chance(0.8);
            const auto some = static_cast<std::uint32_t>(random.integer(1, 7));
            step.readings.push_back({k, rounded(z), all ? UINT32_MAX : some});
        }
        sequence.steps.push_back(step);
        x = process.A * x + process.F * drawn(random, whole, process.F.cols());
    }
    model.text = "n" + std::to_string(n) + " Q rank " + std::to_string(rank);
    return model;
}

} // namespace campaign

#endif
