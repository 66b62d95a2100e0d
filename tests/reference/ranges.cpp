#include "ranges.hpp"

#include <cmath>
#include <cstddef>
#include <vector>

namespace reference
{

double powerOfTwo(double x) { return x > 0 ? std::exp2(std::ceil(std::log2(x))) : 1; }

Vector<double> powersOfTwo(const Vector<double> &x)
{
    return x.unaryExpr([](double v) { return powerOfTwo(v); });
}

/// What the means stay within, with four sigmas for the smoother, and twice that for forecasts.
static Vector<double> stateRange(const Sequence &sequence)
{
    Vector<double> most = Vector<double>::Zero(sequence.states());
    for (const Track<double> &now : filter<double>(sequence)) {
        for (const Belief<double> &belief : {now.predicted, now.filtered}) {
            const Vector<double> sigma = belief.covariance.diagonal().cwiseMax(0).cwiseSqrt();
            most = most.cwiseMax(belief.mean.cwiseAbs() + 4 * sigma);
        }
    }
    return powersOfTwo(2 * most);
}

Vector<double> controlRange(const Sequence &sequence, Index controls)
{
    Vector<double> most = Vector<double>::Zero(controls);
    for (const Step &step : sequence.steps) {
        if (step.u.size() > 0) most = most.cwiseMax(step.u.cwiseAbs());
    }
    return powersOfTwo(most);
}

/// One range for the sensors of one R: they may be one sensor whose H changes.
static void declareMeasurementRanges(Sequence &sequence)
{
    std::vector<SensorModel> &sensors = sequence.sensors;
    std::vector<std::size_t> first(sensors.size());
    for (std::size_t k = 0; k < sensors.size(); ++k) {
        while (sensors[first[k]].R.rows() != sensors[k].R.rows() ||
               sensors[first[k]].R != sensors[k].R) {
            ++first[k];
        }
        sensors[k].range = Vector<double>::Zero(sensors[k].components());
    }
    for (const Step &step : sequence.steps) {
        for (const Reading &reading : step.readings) {
            Vector<double> &most = sensors[first[reading.sensor]].range;
            most = most.cwiseMax(reading.z.cwiseAbs());
        }
    }
    for (std::size_t k = 0; k < sensors.size(); ++k) {
        sensors[k].range = powersOfTwo(sensors[first[k]].range);
    }
}

/// The library's limit for sum_k |M_ik| in words.
static constexpr double wordSumLimit = 16;

/// Doubles what is too small for the sums that it has to hold; whether it did.
static bool widen(Vector<double> &range, const Vector<double> &sums)
{
    bool changed = false;
    for (Index i = 0; i < range.size(); ++i) {
        for (; sums(i) > wordSumLimit * range(i); changed = true) range(i) *= 2;
    }
    return changed;
}

void widenStates(Sequence &sequence)
{
    for (bool changed = true; changed;) {
        changed = false;
        for (const ProcessModel &process : sequence.processes) {
            Vector<double> sums = process.A.cwiseAbs() * sequence.range;
            if (process.range.size() > 0) sums += process.B.cwiseAbs() * process.range;
            changed = widen(sequence.range, sums) || changed;
        }
    }
}

void widenMeasurements(Sequence &sequence)
{
    for (SensorModel &sensor : sequence.sensors) {
        const Vector<double> sums = sensor.H.cwiseAbs() * sequence.range;
        for (SensorModel &other : sequence.sensors) {
            const bool same = other.R.rows() == sensor.R.rows() && other.R == sensor.R;
            if (same) widen(other.range, sums);
        }
    }
}

Vector<double> onGrid(const Vector<double> &x, const Vector<double> &range)
{
    const Vector<double> grid = range * 0x1p-24;
    return x.binaryExpr(grid, [](double v, double g) { return std::rint(v / g) * g; });
}

void declareRanges(Sequence &sequence)
{
    sequence.range = stateRange(sequence);
    for (ProcessModel &process : sequence.processes) {
        process.range = controlRange(sequence, process.B.cols());
    }
    declareMeasurementRanges(sequence);
    widenStates(sequence);
    widenMeasurements(sequence);
    sequence.x0 = onGrid(sequence.x0, sequence.range);
    for (Step &step : sequence.steps) {
        if (step.u.size() > 0) {
            step.u = onGrid(step.u, sequence.processes[step.process].range);
        }
        for (Reading &reading : step.readings) {
            reading.z = onGrid(reading.z, sequence.sensors[reading.sensor].range);
        }
    }
}

} // namespace reference
