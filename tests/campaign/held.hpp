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

inline Mat toMat(const Matrix<double> &M)
{
    Mat result{};
    for (Index i = 0; i < M.rows(); ++i) {
        for (Index j = 0; j < M.cols(); ++j) {
            result[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = M(i, j);
        }
    }
    return result;
}

inline Vec toVec(const Vector<double> &x)
{
    Vec result{};
    for (Index i = 0; i < x.size(); ++i) result[static_cast<std::size_t>(i)] = x(i);
    return result;
}

/// B u and z, which are the same words in each arithmetic once the sequence is on its grids.
inline std::vector<Moment> momentsOf(const Sequence &sequence, const Mat &B)
{
    std::vector<Moment> moments;
    for (const reference::Step &step : sequence.steps) {
        Moment moment{};
        const Vec u = toVec(step.u);
        moment.drive = times(B, u, maxStates);
        for (const reference::Reading &reading : step.readings) {
            moment.readings.push_back({reading.sensor, reading.present, toVec(reading.z)});
        }
        moments.push_back(moment);
    }
    return moments;
}

inline Inputs heldByFloats(const Sequence &sequence)
{
    const int n = static_cast<int>(sequence.states());
    const reference::ProcessModel &process = sequence.processes[0];
    const int width = static_cast<int>(process.F.cols());
    Inputs inputs{n, toVec(sequence.x0), toMat(sequence.P0), {toMat(process.A), {}}, {}, {}};
    inputs.process.Q = square(toMat(process.F), n, width);
    for (const reference::SensorModel &sensor : sequence.sensors) {
        inputs.sensors.push_back(
            {static_cast<int>(sensor.components()), toMat(sensor.H), toMat(sensor.R), {}});
    }
    inputs.moments = momentsOf(sequence, toMat(process.B));
    return inputs;
}

// ------------------------------------------------------------------ q31

inline Real valueOf(const kq_scaled_q31 &x) { return ldexpq(x.mantissa, x.exponent); }

/// A table in units of a row's last bit over a column's.
inline Mat matrixOf(const kq_scaled_q31 *table, const kq_format_q31 *rows, int count,
                    const kq_format_q31 *columns, int width)
{
    Mat M{};
    for (int i = 0; i < count; ++i) {
        for (int j = 0; j < width; ++j) {
            const int shift = columns[j].fraction - rows[i].fraction;
            M[i][j] = ldexpq(valueOf(table[i * width + j]), shift);
        }
    }
    return M;
}

/// S S' of a prepared root.
inline Mat covarianceOf(const std::int32_t *root, const kq_format_q31 *format, int n)
{
    Mat S{};
    for (int i = 0; i < n; ++i) {
        const int exponent = root[KQ_TRIANGLE(n) + i] - format[i].fraction;
        for (int j = i; j < n; ++j) S[i][j] = ldexpq(root[j * (j + 1) / 2 + i], exponent);
    }
    return square(S, n, n);
}

/// U D U', or the variances.
inline Mat noiseOf(const kq_sensor_q31 &sensor, const kq_format_q31 *format)
{
    const int m = sensor.components;
    Mat R{};
    for (int i = 0; i < m; ++i) {
        for (int j = 0; j < m; ++j) {
            const int from = i > j ? i : j;
            for (int k = from; k < m; ++k) {
                const kq_scaled_q31 *column = sensor.noise + k * (k + 1) / 2;
                if (!sensor.correlated && (i != j || k != i)) continue;
                const Real d = valueOf(sensor.correlated ? column[k] : sensor.noise[k]);
                const Real left = i < k ? valueOf(column[i]) : Real(1);
                const Real right = j < k ? valueOf(column[j]) : Real(1);
                R[i][j] += ldexpq(d * left * right, -format[i].fraction - format[j].fraction);
            }
        }
    }
    return R;
}

inline Inputs heldByWords(const Sequence &sequence, reference::Library<Q31> &library)
{
    const int n = static_cast<int>(sequence.states());
    const kq_format_q31 *states = library.states().data();
    const kq_process_q31 &process = *library.process(0);
    std::vector<std::int32_t> root(reference::rootLength(n));
    kq::require(kq_root_prepare_q31(root.data(), reference::flattened<double>(sequence.P0).data(),
                                    n, states),
                "root prepare");
    Inputs inputs{n, toVec(sequence.x0), covarianceOf(root.data(), states, n), {}, {}, {}};
    inputs.process = {matrixOf(process.transition, states, n, states, n),
                      covarianceOf(process.noise_root, states, n)};
    for (std::size_t k = 0; k < sequence.sensors.size(); ++k) {
        const kq_sensor_q31 &sensor = *library.sensor(k);
        const kq_format_q31 *formats = library.components(k).data();
        Sensor held{sensor.components,
                    matrixOf(sensor.measurement, formats, sensor.components, states, n),
                    noiseOf(sensor, formats),
                    {}};
        for (int c = 0; c < held.components; ++c) {
            held.grain[c] = ldexpq(1, -24 - formats[c].fraction);
        }
        inputs.sensors.push_back(held);
    }
    const int l = process.controls;
    const Mat B = l == 0 ? Mat{} : matrixOf(process.control, states, n, process.control_format, l);
    inputs.moments = momentsOf(sequence, B);
    return inputs;
}

// ------------------------------------------------------------------ ranges

/// 1.5 times the largest exact state: true, predicted, after each call of an update, smoothed.
inline Vector<double> declaredRange(const Model &model, const Exact &exact)
{
    Vector<double> most = model.largest;
    const auto include = [&most](const Vec &mean) {
        for (Index i = 0; i < most.size(); ++i) {
            const Real size = fabsq(mean[static_cast<std::size_t>(i)]);
            most(i) = std::max(most(i), static_cast<double>(size));
        }
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
    reference::ProcessModel &process = sequence.processes[0];
    process.range = reference::controlRange(sequence, process.B.cols());
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
    for (reference::Step &step : sequence.steps) {
        if (step.u.size() > 0) step.u = reference::onGrid(step.u, process.range);
        for (reference::Reading &reading : step.readings) {
            reading.z = reference::onGrid(reading.z, sequence.sensors[reading.sensor].range);
        }
    }
    return sequence;
}

} // namespace campaign

#endif
