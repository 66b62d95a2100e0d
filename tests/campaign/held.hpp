// The inputs of a run as an arithmetic holds them: f32 and f64 the floats of the sequence, which
// both hold exactly; q31 what its prepared tables say, to the last bit.
#ifndef KALMANQ_TESTS_CAMPAIGN_HELD_HPP
#define KALMANQ_TESTS_CAMPAIGN_HELD_HPP

#include <cstddef>
#include <cstdint>
#include <vector>

#include "../reference/library.hpp"
#include "exact.hpp"
#include "model.hpp"

namespace campaign
{

using kq::Q31;

inline Inputs heldByFloats(const Sequence &sequence)
{
    std::vector<Vec> grain;
    for (const reference::SensorModel &sensor : sequence.sensors) {
        grain.push_back(Vec::Zero(sensor.components()));
    }
    return {reference::convert<Real>(sequence.x0), reference::convert<Real>(sequence.P0),
            reference::Model<Real>(sequence), grain, sequence.steps};
}

// ------------------------------------------------------------------ q31

inline Real scaled(double mantissa, int exponent) { return Real::of(ldexpq(mantissa, exponent)); }

inline Real valueOf(const kq_scaled_q31 &x) { return scaled(x.mantissa, x.exponent); }

/// A table in units of a row's last bit over a column's.
inline Mat matrixOf(const kq_scaled_q31 *table, const kq_format_q31 *rows, int count,
                    const kq_format_q31 *columns, int width)
{
    Mat M(count, width);
    for (int i = 0; i < count; ++i) {
        for (int j = 0; j < width; ++j) {
            const kq_scaled_q31 entry = table[i * width + j];
            M(i, j) =
                scaled(entry.mantissa, entry.exponent + columns[j].fraction - rows[i].fraction);
        }
    }
    return M;
}

/// S S' of a prepared root.
inline Mat covarianceOf(const std::int32_t *root, const kq_format_q31 *format, int n)
{
    Mat S = Mat::Zero(n, n);
    for (int i = 0; i < n; ++i) {
        const int exponent = root[KQ_TRIANGLE(n) + i] - format[i].fraction;
        for (int j = i; j < n; ++j) S(i, j) = scaled(root[j * (j + 1) / 2 + i], exponent);
    }
    return square(S);
}

/// U D U', or the variances.
inline Mat noiseOf(const kq_sensor_q31 &sensor, const kq_format_q31 *format)
{
    const int m = sensor.components;
    Mat U = Mat::Identity(m, m), D = Mat::Zero(m, m), units = D;
    for (int k = 0; k < m; ++k) {
        const kq_scaled_q31 *column = sensor.noise + k * (k + 1) / 2;
        D(k, k) = valueOf(sensor.correlated ? column[k] : sensor.noise[k]);
        for (int i = 0; i < k && sensor.correlated; ++i) U(i, k) = valueOf(column[i]);
        units(k, k) = scaled(1, -format[k].fraction);
    }
    return sandwich(units * U, D);
}

inline Inputs heldByWords(const Sequence &sequence, reference::Library<Q31> &library)
{
    const int n = static_cast<int>(sequence.states());
    const kq_format_q31 *states = library.states().data();
    const reference::Prior prior(library.states(), sequence.x0, sequence.P0);
    kq::require(prior.status, "root prepare");
    Inputs inputs = heldByFloats(sequence);
    inputs.P0 = covarianceOf(prior.root.data(), states, n);
    for (std::size_t k = 0; k < sequence.processes.size(); ++k) {
        const kq_process_q31 &process = *library.process(k);
        inputs.model.A[k] = matrixOf(process.transition, states, n, states, n);
        inputs.model.Q[k] = covarianceOf(process.noise_root, states, n);
        inputs.model.B[k] = matrixOf(process.control, states, n, process.control_format, process.controls);
    }
    for (std::size_t k = 0; k < sequence.sensors.size(); ++k) {
        const kq_sensor_q31 &sensor = *library.sensor(k);
        const kq_format_q31 *formats = library.components(k).data();
        const int m = sensor.components;
        inputs.model.H[k] = matrixOf(sensor.measurement, formats, m, states, n);
        inputs.model.R[k] = noiseOf(sensor, formats);
        for (int c = 0; c < m; ++c) inputs.grain[k](c) = scaled(1, -24 - formats[c].fraction);
    }
    return inputs;
}

/// Of the last bit of each state
inline Vec wordsOf(const reference::Library<Q31> &library)
{
    Vec words(library.states().count());
    for (Index i = 0; i < words.size(); ++i) {
        words(i) = scaled(1, -library.states().data()[i].fraction);
    }
    return words;
}

// ------------------------------------------------------------------ ranges

/// 1.5 times the largest exact state: true, predicted, after each call of an update, smoothed.
inline Vector<double> declaredRange(const Model &model, const Exact &exact)
{
    Vector<double> most = model.largest;
    const auto include = [&most](const Vec &mean) {
        most = most.cwiseMax(mean.cwiseAbs().cast<double>());
    };
    for (const Instant &now : exact) {
        include(now.predicted.mean);
        for (const Update &update : now.updates) include(update.mean);
        include(now.smoothed.mean);
    }
    return 1.5 * most.cwiseMax(0x1p-40);
}

/// Does every range have a format (prepare.h)?  Data that contradict their model may lead anywhere.
inline bool hasFormats(const Vector<double> &declared)
{
    return declared.minCoeff() > 0x1p-64 && declared.maxCoeff() < 0x1p94;
}

/// The sequence with ranges declared, widened by whole bits where init would ask for them, and its
/// x0, u and z on the grids of the formats.
inline Sequence withRanges(const Model &model, const Exact &exact)
{
    Sequence sequence = model.sequence;
    const Vector<double> declared = declaredRange(model, exact);
    sequence.range = reference::powersOfTwo(declared);
    const Vector<double> before = sequence.range;
    for (reference::ProcessModel &process : sequence.processes) {
        process.range = reference::controlRange(sequence, process.B.cols());
    }
    const std::vector<Vector<double>> most = largestReadings(sequence);
    for (std::size_t k = 0; k < most.size(); ++k) {
        sequence.sensors[k].range = reference::powersOfTwo(1.5 * most[k]);
        const bool same = k > 0 && sequence.sensors[0].R.rows() == sequence.sensors[k].R.rows() &&
                          sequence.sensors[0].R == sequence.sensors[k].R;
        if (!same) continue; // the library's side makes one sensor of them (library.hpp)
        sequence.sensors[0].range = sequence.sensors[0].range.cwiseMax(sequence.sensors[k].range);
        sequence.sensors[k].range = sequence.sensors[0].range;
    }
    reference::widenStates(sequence);
    reference::widenMeasurements(sequence);
    sequence.range = declared.cwiseProduct(sequence.range.cwiseQuotient(before));
    const Vector<double> grid = reference::powersOfTwo(sequence.range);
    sequence.x0 = reference::onGrid(sequence.x0, grid);
    for (Step &step : sequence.steps) {
        if (step.u.size() > 0) step.u = reference::onGrid(step.u, sequence.processes[step.process].range);
        for (Reading &reading : step.readings) {
            reading.z = reference::onGrid(reading.z, sequence.sensors[reading.sensor].range);
        }
    }
    return sequence;
}

} // namespace campaign

#endif
