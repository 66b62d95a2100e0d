// Parts of random models, and the random models.
#include "generator.hpp"

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "decompositions.hpp"
#include "ranges.hpp"

namespace reference::generator
{

static double toFloat(double x) { return static_cast<double>(static_cast<float>(x)); }

static Vec constant(Index n, double value) { return Vec::Constant(n, toFloat(value)); }

Mat identity(Index n) { return Mat::Identity(n, n); }

// ------------------------------------------------------------------ parts of random models

Mat randomFactor(Random &random, Index n, Index rank, const Vec &scale)
{
    Mat F(n, rank);
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < rank; ++j) {
            const int size = i == j ? random.integer(32, 96) : random.integer(-32, 32);
            F(i, j) = scale(i) * size / 64;
        }
    }
    return F;
}

Mat diagonalFactor(Random &random, Index n, const Vec &scale)
{
    Mat F = Mat::Zero(n, n);
    for (Index i = 0; i < n; ++i) F(i, i) = scale(i) * random.integer(32, 96) / 64;
    return F;
}

Mat unitTriangular(Random &random, Index n)
{
    Mat L = identity(n);
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < i; ++j) L(i, j) = random.uniform(-0.5, 0.5);
    }
    return L;
}

Mat eigenBlocks(Random &random, Index n, bool marginal, bool chains)
{
    Mat D = Mat::Zero(n, n);
    for (Index i = 0; i < n;) {
        const double modulus = marginal ? 1 : random.uniform(0.2, 0.98);
        if (i + 1 < n && random.chance(0.5)) {
            const double t = random.uniform(0.02, 0.9), length = 1 + t * t;
            const double c = (1 - t * t) / length * modulus, s = 2 * t / length * modulus;
            D.block(i, i, 2, 2) = rows({{c, s}, {-s, c}});
            i += 2;
        } else {
            D(i, i) = random.chance(0.2) ? -modulus : modulus;
            const bool first = i == 0 || D(i - 1, i - 1) != D(i, i);
            const bool third = i > 1 && D(i - 2, i - 1) != 0;
            if (chains && !first && !third) D(i - 1, i) = 0.125;
            i += 1;
        }
    }
    return D;
}

Mat transition(const Mat &D, const Mat &coordinates, const Vec &units)
{
    const Mat A = coordinates * D * inverse(coordinates);
    return rounded(units.asDiagonal() * A * units.cwiseInverse().asDiagonal());
}

Mat randomMatrix(Random &random, Index rows, Index columns)
{
    Mat M(rows, columns);
    for (Index i = 0; i < rows; ++i) {
        for (Index j = 0; j < columns; ++j) M(i, j) = toFloat(random.normal());
    }
    return M;
}

Vec powersOfTwo(Random &random, Index n, int low, int high)
{
    Vec v(n);
    for (Index i = 0; i < n; ++i) v(i) = std::ldexp(1.0, random.integer(low, high));
    return v;
}

/// H for states in the given units: of order 1 in each.
static Mat randomMeasurementMatrix(Random &random, Index m, const Vec &units)
{
    const Vec inverse = units.cwiseInverse();
    return randomMatrix(random, m, units.size()) * inverse.asDiagonal();
}

static SensorModel randomSensor(Random &random, Index m, const Vec &units, bool correlated)
{
    const Vec scale = powersOfTwo(random, m, -5, 2);
    const Mat F = correlated ? randomFactor(random, m, m, scale) : diagonalFactor(random, m, scale);
    return {randomMeasurementMatrix(random, m, units), F * F.transpose()};
}

// ------------------------------------------------------------------ measurements

void simulate(Random &random, Sequence &sequence)
{
    const Index n = sequence.states();
    std::vector<Mat> noise;
    for (const SensorModel &sensor : sequence.sensors) noise.push_back(samplingRoot(sensor.R));
    Vec x = sequence.x0 + samplingRoot(sequence.P0) * normals(random, n);
    for (Step &step : sequence.steps) {
        for (Reading &reading : step.readings) {
            const SensorModel &sensor = sequence.sensors[reading.sensor];
            const Mat &root = noise[reading.sensor];
            reading.z = rounded(sensor.H * x + root * normals(random, root.cols()));
        }
        const ProcessModel &process = sequence.processes[step.process];
        x = process.A * x + process.F * normals(random, process.F.cols());
        if (step.u.size() > 0) x += process.B * step.u;
    }
}

// ------------------------------------------------------------------ random models

/// What varies from one random model to the next; from its number, so that all combinations come.
struct Features {
    Index n, m, l;
    bool marginal, correlated, units, changingA, changingH, missing;
    int sensors;

    explicit Features(int number)
        : n(1 + number % 9), m(1 + (number / 2) % 4), l((number / 3) % 4),
          marginal(number % 3 == 0), correlated(number % 2 == 0), units(number % 5 < 2),
          changingA(number % 7 == 0), changingH(number % 8 == 1), missing(number % 4 < 2),
          sensors(1 + (number / 5) % 3)
    {
    }

    std::string text() const
    {
        return "n" + std::to_string(n) + " m" + std::to_string(m) + " l" + std::to_string(l) +
               (marginal ? " marginal" : " stable") + (correlated ? " full R" : "") +
               (units ? " units" : "") + (changingA ? " A_t" : "") + (changingH ? " H_t" : "") +
               (missing ? " gaps" : "") + " sensors " + std::to_string(sensors);
    }
};

/// The first sensor, or one with a matrix for every step, and slower ones of other sizes.
static void addSensors(Random &random, Sequence &sequence, const Features &features,
                       const Vec &units, int steps)
{
    SensorModel first = randomSensor(random, features.m, units, features.correlated);
    const int versions = features.changingH ? steps : 1;
    for (int k = 0; k < versions; ++k) {
        sequence.sensors.push_back(first);
        first.H = randomMeasurementMatrix(random, features.m, units);
    }
    for (int k = 1; k < features.sensors; ++k) {
        const Index m = 1 + (features.m + k) % 4;
        sequence.sensors.push_back(randomSensor(random, m, units, random.chance(0.5)));
    }
}

static void addProcesses(Random &random, Sequence &sequence, const Features &features,
                         const Vec &units, const Options &options)
{
    const Index n = features.n;
    const Index rank = options.invertible ? n : random.integer(1, static_cast<int>(n));
    const Vec size = units * std::ldexp(1.0, random.integer(-5, 0));
    const Mat F = randomFactor(random, n, rank, size);
    const Mat B = rounded(units.asDiagonal() * randomMatrix(random, n, features.l));
    // common coordinates: a product of different transitions is then as tame as one of them
    const Mat lower = unitTriangular(random, n);
    const Mat coordinates = lower * unitTriangular(random, n).transpose();
    const int versions = features.changingA ? 5 : 1;
    const bool chains = features.marginal && versions == 1;
    for (int k = 0; k < versions; ++k) {
        const Mat D = eigenBlocks(random, n, features.marginal, chains);
        sequence.processes.push_back({transition(D, coordinates, units), B, F});
    }
}

static std::uint32_t randomPresence(Random &random, const Features &features)
{
    if (!features.missing || random.chance(0.6)) return UINT32_MAX;
    return static_cast<std::uint32_t>(random.integer(0, 15));
}

/// The first sensor at every step, sensor k at every (k+2)-nd; bursts without any measurement.
static void addSteps(Random &random, Sequence &sequence, const Features &features, int steps)
{
    const std::size_t versions = features.changingH ? static_cast<std::size_t>(steps) : 1;
    for (int t = 0; t < steps; ++t) {
        const auto now = static_cast<std::size_t>(t);
        Step step{{}, now % sequence.processes.size(), Vec()};
        const bool silent = features.missing && t % 40 > 32;
        for (std::size_t k = 0; !silent && k < static_cast<std::size_t>(features.sensors); ++k) {
            if (k > 0 && now % (k + 2) != 0) continue;
            const std::size_t sensor = k > 0 ? versions - 1 + k : now % versions;
            step.readings.push_back({sensor, Vec(), randomPresence(random, features)});
        }
        if (features.l > 0 && t % 10 != 0) {
            step.u = rounded(0.25 * normals(random, features.l));
        }
        sequence.steps.push_back(step);
    }
}

Sequence randomSequence(Random &random, int number, const Options &options)
{
    const Features features(number);
    Sequence sequence;
    sequence.name = "random " + std::to_string(number) + ": " + features.text();
    const Index n = features.n;
    const Vec units = features.units ? powersOfTwo(random, n, -8, 8) : constant(n, 1);
    const Vec size = units * std::ldexp(1.0, random.integer(-1, 4));
    const bool singular = !options.invertible && random.chance(0.2);
    const Mat F = randomFactor(random, n, singular ? (n + 1) / 2 : n, size);
    sequence.P0 = F * F.transpose();
    sequence.x0 = rounded(units.cwiseProduct(10 * normals(random, n)));
    addProcesses(random, sequence, features, units, options);
    addSensors(random, sequence, features, units, options.steps);
    addSteps(random, sequence, features, options.steps);
    simulate(random, sequence);
    declareRanges(sequence);
    return sequence;
}

} // namespace reference::generator
