// KQ_EVENT_PRECISION of a filter beside covariances in __float128, in f32, f64 and q31: precision [models [seed]].
//   ordinary  a position and what moves it, seen by two sensors, one 1e2 to 1e4 times worse, with gaps, 1000 steps
//   sharp     dense rows, 20 steps, A upper triangular or dense; P0 / R as far beyond what the numbers resolve as
//             1e12, 1e13 and 1e14 are in f32
//   unseen    two dense rows see 3 to 5 constants, 1500 steps, P0 / R from 1e4 to 1e12 and as far beyond
//   long      the same with one or two rows, a fifth as many models, 10,000 steps, P0 / R from 1e2 to 1e6
//   mixed     the same, one of the constants moves by 0.03 to 10 sigma of R a step, 2000 steps, P0 / R from 10 to 1e5
//   drifting  half as many: a position, its rate and the offset of one or two sensors, or in reverse order, no process noise, 10,000 steps, P0 / R from 1e3 to 1e7
//   walking   the same, whose rate walks by 1e-3 to 1 in a second, position and offset being about 1
// Of each: models with a sigma off by more than 5 %, those of them without an event, and events without such a sigma.
// No ordinary model may have an event, of the mixed ones one in 50 for nothing, of the drifting ones one in 5, of the walking ones one in 10.  Of the wrong sharp
// and drifting ones a fifth may go without, of the unseen and long ones a tenth, of the walking ones half; half of the events of the sharp ones
// may be for nothing: a rounding that may be as large as a sigma is so by chance.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "../reference/library.hpp"
#include "../reference/random.hpp"
#include "../reference/ranges.hpp"
#include "arrays.hpp"
#include "claims.hpp"
#include "kind.hpp"

using namespace campaign;
using reference::Random;
using reference::Sequence;

namespace
{

struct Plan {
    Sequence sequence;
    int gap = 1, secondEvery = 1, steps = 0;
};

double asFloat(double value) { return static_cast<double>(static_cast<float>(value)); }

/// Drawn row by row
Matrix<double> normals(Random &random, Index rows, Index columns, double scale)
{
    return reference::generated(columns, rows, [&] { return asFloat(scale * random.normal()); })
        .transpose();
}

reference::SensorModel scalar(const Matrix<double> &h, double r)
{
    return {h, Matrix<double>::Constant(1, 1, asFloat(r))};
}

Plan ordinary(Random &random, double /*ratio*/)
{
    const Index n = random.integer(1, 4);
    Plan plan;
    plan.gap = random.integer(2, 10);
    plan.secondEvery = random.integer(1, 3);
    plan.steps = 1000;
    const double dt = std::pow(10, -random.uniform(0, 2)), r = logUniform(random, -2, 2);
    const double worse = logUniform(random, 2, 4);
    Matrix<double> A = Matrix<double>::Identity(n, n), F = Matrix<double>::Zero(n, n), P = F, h = Matrix<double>::Zero(1, n);
    for (Index i = 0; i < n; ++i) {
        if (i + 1 < n) A(i, i + 1) = asFloat(dt);
        P(i, i) = asFloat(logUniform(random, 0, 4));
        F(i, i) = asFloat(std::sqrt(dt * std::pow(10, -random.uniform(0, 4))));
    }
    h(0, 0) = 1;
    plan.sequence.P0 = P;
    plan.sequence.processes = {{A, Matrix<double>(n, 0), F}};
    plan.sequence.sensors = {scalar(h, r), scalar(h, r * worse * worse)};
    return plan;
}

Plan sharp(Random &random, double ratio, bool dense)
{
    const Index n = random.integer(2, 5);
    Plan plan;
    plan.gap = 1000;
    plan.steps = 20;
    Matrix<double> A = dense ? normals(random, n, n, 0.3) : Matrix<double>(Matrix<double>::Zero(n, n));
    for (Index i = 0; i < n; ++i) {
        A(i, i) = asFloat(A(i, i) + 1);
        if (!dense && i + 1 < n) A(i, i + 1) = asFloat(0.1);
    }
    const Matrix<double> F = normals(random, n, n, 1);
    plan.sequence.P0 = Matrix<double>(F * F.transpose()).cast<float>().cast<double>();
    plan.sequence.processes = {{A, Matrix<double>(n, 0), normals(random, n, n, 0.1 / std::sqrt(ratio))}};
    plan.sequence.sensors = {scalar(normals(random, 1, n, 1), 1 / ratio), scalar(normals(random, 1, n, 1), 1 / ratio)};
    return plan;
}

Plan sharpChain(Random &random, double ratio) { return sharp(random, ratio, false); }
Plan sharpDense(Random &random, double ratio) { return sharp(random, ratio, true); }

// Two sensors that do not see all of some constants, for long: what is not seen stays as little known as it was.
Plan unseen(Random &random, double ratio)
{
    const Index n = random.integer(3, 5);
    Plan plan;
    plan.gap = 10000;
    plan.steps = 1500;
    const double most = random.uniform(0, 1) < 0.5 ? 0 : std::pow(10, -random.uniform(1, 4));
    plan.sequence.P0 = Matrix<double>::Identity(n, n) * asFloat(ratio);
    plan.sequence.processes = {{Matrix<double>::Identity(n, n), Matrix<double>(n, 0),
                                Matrix<double>::Identity(n, n) * asFloat(most)}};
    plan.sequence.sensors = {scalar(normals(random, 1, n, 1), 1), scalar(normals(random, 1, n, 1), 1)};
    return plan;
}

// The same for longer: what each update rounds adds up.
Plan lasting(Random &random, double ratio)
{
    Plan plan = unseen(random, ratio);
    plan.steps = 10000;
    plan.secondEvery = random.integer(0, 1) ? 1 : plan.steps;
    return plan;
}

// One state moves and is measured well, the others do not move, and a part of them is not seen.
Plan mixed(Random &random, double ratio)
{
    Plan plan = unseen(random, ratio);
    const Index n = plan.sequence.P0.rows(), moves = random.integer(0, static_cast<int>(n) - 1);
    plan.steps = 2000;
    Matrix<double> F = Matrix<double>::Zero(n, n);
    F(moves, moves) = asFloat(logUniform(random, -1.5, 1));
    plan.sequence.processes[0].F = F;
    if (random.uniform(0, 1) < 0.5) {
        plan.sequence.sensors[0].H.setZero();
        plan.sequence.sensors[0].H(0, moves) = 1;
    }
    return plan;
}

// A position and its rate, seen with an offset that does not move, by one sensor or by two of which each has its own.
Plan drifting(Random &random, double ratio)
{
    const Index sensors = random.integer(1, 2), n = 2 + sensors;
    const bool reversed = random.integer(0, 1) == 1;
    Plan plan;
    plan.gap = 10000;
    plan.steps = 10000;
    plan.secondEvery = sensors == 2 ? 1 : plan.steps;
    Matrix<double> A = Matrix<double>::Identity(n, n), P = Matrix<double>::Zero(n, n);
    A(0, 1) = asFloat(logUniform(random, -3, 0));
    for (Index i = 0; i < n; ++i) P(i, i) = asFloat(logUniform(random, -1, 1));
    plan.sequence.P0 = P;
    plan.sequence.processes = {{A, Matrix<double>(n, 0), Matrix<double>::Zero(n, n)}};
    for (Index c = 0; c < 2; ++c) {
        Matrix<double> h = Matrix<double>::Zero(1, n);
        h(0, 0) = h(0, c < sensors ? 2 + c : 2) = 1;
        plan.sequence.sensors.push_back(scalar(reversed ? Matrix<double>(h.rowwise().reverse()) : h, std::pow(10, random.uniform(-1, 1)) / ratio));
    }
    if (reversed) plan.sequence.processes[0].A = A.reverse();
    return plan;
}

// The same whose rate walks.
Plan walking(Random &random, double ratio)
{
    Plan plan = drifting(random, ratio);
    reference::ProcessModel &process = plan.sequence.processes[0];
    const Index n = process.A.rows(), rate = process.A(0, 1) > 0 ? 1 : n - 2;
    const double dt = rate == 1 ? process.A(0, 1) : process.A(n - 1, n - 2);
    process.F(rate, rate) = asFloat(std::sqrt(dt * logUniform(random, -6, 0)));
    return plan;
}

// ------------------------------------------------------------------ what is right

struct Exactly {
    reference::Model<Real> model;
    Mat P;

    explicit Exactly(const Sequence &s) : model(s), P(reference::convert<Real>(s.P0)) {}

    void update(std::size_t sensor)
    {
        const Vec h = model.H[sensor].row(0).transpose(), b = P * h;
        P -= b * b.transpose() / (h.dot(b) + model.R[sensor](0, 0));
    }

    void predict() { P = sandwich(model.A[0], P) + model.Q[0]; }
};

// ------------------------------------------------------------------ what the library says

template <class T> class Study
{
    using Api = kq::Api<T>;

  public:
    explicit Study(Plan &plan) : plan_(plan), library_(plan.sequence), filter_(library_.states()), exact_(plan.sequence)
    {
        library_.init(filter_);
    }

    Outcry run()
    {
        for (int k = 0; k < plan_.steps; ++k) {
            if (k % plan_.gap != plan_.gap - 1) update(0);
            if (k % plan_.secondEvery == 0) update(1);
            look();
            library_.predict(filter_.get(), {{}, 0, Vector<double>()});
            exact_.predict();
        }
        const bool isTold = Api::events(filter_.get()) != 0;
        return {wrong_, isTold, isTold};
    }

  private:
    void update(std::size_t sensor)
    {
        library_.update(filter_.get(), {sensor, Vector<double>::Zero(1), UINT32_MAX});
        exact_.update(sensor);
    }

    void look()
    {
        const auto P = reference::read(filter_).covariance;
        for (Index i = 0; i < P.rows(); ++i) {
            const double share = static_cast<double>(P(i, i)) / static_cast<double>(exact_.P(i, i));
            wrong_ |= !(std::fabs(std::sqrt(share) - 1) <= 0.05);
        }
    }

    Plan &plan_;
    reference::Library<T> library_;
    reference::FilterOwner<T> filter_;
    Exactly exact_;
    bool wrong_ = false;
};

/// Ranges for q31: of what is not known, ten sigma.
void declare(Plan &plan)
{
    Sequence &s = plan.sequence;
    s.range = reference::powersOfTwo(10 * Vector<double>(s.P0.diagonal()).cwiseSqrt());
    for (reference::SensorModel &sensor : s.sensors) {
        const Matrix<double> most = sensor.H.cwiseAbs() * s.range;
        sensor.range = reference::powersOfTwo(Vector<double>::Constant(1, most(0, 0)));
    }
}

/// How far f32 is from this arithmetic, in variances
template <class T> constexpr double beyondF32() { return 1; }
template <> constexpr double beyondF32<double>() { return 0x1p58; }
template <> constexpr double beyondF32<kq::Q31>() { return 0x1p12; }

// ------------------------------------------------------------------ kinds, and what they must fulfil

/// What the study draws of a kind, which is given P0 / R
struct Part {
    Kind<Plan, double> kind;
    double least, most; // of log10 P0 / R in f32
    int every;          // of the models that are asked for
    const char *group;
};

const Part parts[] = {
    {{"ordinary", ordinary}, 0, 0, 1, ""},
    {{"chain 12", sharpChain}, 12, 12, 1, "sharp"},
    {{"dense 12", sharpDense}, 12, 12, 1, "sharp"},
    {{"chain 13", sharpChain}, 13, 13, 1, "sharp"},
    {{"dense 13", sharpDense}, 13, 13, 1, "sharp"},
    {{"chain 14", sharpChain}, 14, 14, 1, "sharp"},
    {{"dense 14", sharpDense}, 14, 14, 1, "sharp"},
    {{"unseen", unseen}, 4, 12, 1, ""},
    {{"long", lasting}, 2, 6, 5, ""},
    {{"mixed", mixed}, 1, 5, 1, ""},
    {{"drifting", drifting}, 3, 7, 2, ""},
    {{"walking", walking}, 3, 7, 2, ""},
};

std::vector<Claim> claimsOf(const std::string &arithmetic)
{
    const std::string plain = arithmetic + " ordinary", hard = arithmetic + " sharp", hidden = arithmetic + " unseen",
                      lastingOnes = arithmetic + " long", mixedOnes = arithmetic + " mixed", drifts = arithmetic + " drifting", walks = arithmetic + " walking";
    return {{plain, &Counts::falsely},
            {plain, &Counts::wrong},
            {hard, &Counts::silent, 5, hard, &Counts::wrong},
            {hard, &Counts::falsely, 2, hard, &Counts::told},
            {hidden, &Counts::silent, 10, hidden, &Counts::wrong},
            {lastingOnes, &Counts::silent, 10, lastingOnes, &Counts::wrong},
            {mixedOnes, &Counts::falsely, 50, mixedOnes, &Counts::judged},
            {drifts, &Counts::silent, 5, drifts, &Counts::wrong},
            {drifts, &Counts::falsely, 5, drifts, &Counts::judged},
            {walks, &Counts::falsely, 10, walks, &Counts::judged},
            {walks, &Counts::silent, 2, walks, &Counts::wrong}};
}

template <class T> void study(Tally &tally, const std::string &group, const std::string &line, int number, Plan plan)
{
    plan.sequence.x0 = Vector<double>::Zero(plan.sequence.P0.rows());
    declare(plan);
    try {
        const Outcry found = Study<T>(plan).run();
        tally[line].add(found);
        if (found.isWrong != found.isTold) {
            std::printf("%s, model %d: %s\n", line.c_str(), number, found.isWrong ? "wrong without an event" : "an event for nothing");
        }
        if (!group.empty()) tally[std::string(kq::Api<T>::name) + " " + group].add(found);
    } catch (const std::exception &) {
        ++tally[line].refused;
    }
}

template <class T> bool campaignOf(int models, std::uint64_t seed)
{
    const std::string name = kq::Api<T>::name;
    Random random(seed);
    Tally tally;
    for (const Part &part : parts) {
        for (int k = 0; k < models; ++k) {
            const double decades = part.least < part.most ? random.uniform(part.least, part.most) : part.least;
            const double ratio = std::pow(10, decades) * beyondF32<T>();
            if (k % part.every == 0) study<T>(tally, part.group, name + " " + part.kind.name, k, part.kind.draw(random, ratio));
        }
    }
    tally.print();
    return tally.fulfils(claimsOf(name));
}

} // namespace

int main(int argc, char **argv)
{
    const int models = argc > 1 ? std::atoi(argv[1]) : 300;
    const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
    bool good = campaignOf<float>(models, seed);
    good &= campaignOf<kq::Q31>(models, seed);
    good &= campaignOf<double>(models, seed);
    return good ? 0 : 1;
}
