// Ordinary models for as many steps as are wanted: f64, f32 and q31 in step, on the same measurements.
//
//     soak [steps [seed]]      steps of all arithmetics together; 3,000,000 and 1
//     soak years [seed]        P of each filter is run until all its bits are as they were before: what follows repeats, for ever
//     soak weak SHARE [seed]   measurements that say as little as 2^-SHARE of their variance, until they have said half of it
//
// Ordinary models (kinds.hpp) are put side by side until there are n = 1 .. 16 states, twice each, the second time with 30 % of
// the updates missing.  Each A is taken times 1 - 10^-u, u in 1.5 .. 3, so that the states stay within q31's ranges, 9 sigma
// of where they come to rest.  Checked every few thousand steps: P symmetric and positive semi-definite, all finite, no event;
// sigmas against the textbook's steady covariance in long double, or f64's where updates are missing; means against f64's.
// At the end: the mean NIS.  "drift" lines are the largest errors between steps 2^k and 2^(k+1) of all models.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "../reference/accuracy.hpp"
#include "../reference/library_run.hpp"
#include "../reference/ranges.hpp"
#include "../reference/verdict.hpp"
#include "held.hpp"
#include "kinds.hpp"

namespace
{

using namespace reference;

constexpr Index mostStates = 16;
constexpr std::uint64_t mostBetween = 4001; // steps between checks, of no period that a filter has
constexpr std::uint64_t mostUntilRepeated = 3000000;
constexpr double reach = 9, missing = 0.3;

/// Numbers N(0, 1) out of a table with mean 0 and variance 1, which costs less than a logarithm.
class Normals
{
  public:
    explicit Normals(std::uint64_t seed) : state_(2 * seed + 1)
    {
        Random random(seed);
        Vector<double> all = normals(random, static_cast<Index>(table_.size()));
        all.array() -= all.mean();
        all /= std::sqrt(all.squaredNorm() / static_cast<double>(all.size()));
        for (std::size_t k = 0; k < table_.size(); ++k) table_[k] = all(static_cast<Index>(k));
    }

    double next() { return table_[bits() >> 48]; }
    bool chance(double p) { return static_cast<double>(bits() >> 11) * 0x1p-53 < p; }

  private:
    std::uint64_t bits()
    {
        state_ ^= state_ >> 12;
        state_ ^= state_ << 25;
        state_ ^= state_ >> 27;
        return state_ * 0x2545F4914F6CDD1DU;
    }

    std::uint64_t state_;
    std::array<double, 65536> table_;
};

Matrix<double> besides(const Matrix<double> &a, const Matrix<double> &b)
{
    Matrix<double> all = Matrix<double>::Zero(a.rows() + b.rows(), a.cols() + b.cols());
    all.topLeftCorner(a.rows(), a.cols()) = a;
    all.bottomRightCorner(b.rows(), b.cols()) = b;
    return all;
}

/// X = A X A' + Q, by doubling
Matrix<double> atRest(Matrix<double> A, Matrix<double> X)
{
    for (int k = 0; k < 30; ++k) {
        X += A * X * A.transpose();
        A = A * A;
    }
    return X;
}

/// Ordinary models side by side.  One without process noise gets a little: else nothing would be left of P.
Sequence drawnModel(std::uint64_t seed, Index n)
{
    ProcessModel process{Matrix<double>(0, 0), Matrix<double>(0, 0), Matrix<double>(0, 0)};
    SensorModel sensor{Matrix<double>(0, 0), Matrix<double>(0, 0)};
    for (std::uint64_t k = 0; process.A.rows() < n; ++k) {
        const campaign::Model one = campaign::drawn("ordinary", seed, k);
        const ProcessModel &p = one.sequence.processes[0];
        const Index states = p.A.rows();
        if (process.A.rows() + states > n) continue;
        const Matrix<double> little = Matrix<double>::Identity(states, states) * (0x1p-10 * one.N[0](0, 0));
        process.A = besides(process.A, p.A);
        process.B = besides(process.B, p.B);
        process.F = besides(process.F, p.F.cols() > 0 ? p.F : little);
        sensor.H = besides(sensor.H, one.sequence.sensors[0].H);
        sensor.R = besides(sensor.R, one.sequence.sensors[0].R);
    }
    Random random(seed);
    process.A = rounded(Matrix<double>(process.A * (1 - logUniform(random, -3, -1.5))));
    Sequence sequence;
    sequence.x0 = Vector<double>::Zero(n);
    sequence.processes.push_back(process);
    sequence.sensors.push_back(sensor);
    return sequence;
}

/// Its P0, no correlations, and its ranges
void declare(Sequence &sequence)
{
    ProcessModel &process = sequence.processes[0];
    SensorModel &sensor = sequence.sensors[0];
    const Matrix<double> moved = process.F * process.F.transpose() + process.B * process.B.transpose() / 16;
    const Matrix<double> X = atRest(process.A, moved), Z = sensor.H * X * sensor.H.transpose() + sensor.R;
    sequence.P0 = rounded(Matrix<double>(X.diagonal().asDiagonal()));
    sequence.range = powersOfTwo(reach * X.diagonal().cwiseSqrt());
    sensor.range = powersOfTwo(reach * Z.diagonal().cwiseSqrt());
    process.range = Vector<double>::Constant(process.B.cols(), 2);
    widenStates(sequence);
    widenMeasurements(sequence);
}

/// The true states, what moves them and what is measured
class Plant
{
  public:
    Plant(const Sequence &sequence, std::uint64_t seed)
        : model_(sequence.processes[0]), sensor_(sequence.sensors[0]), normals_(std::make_unique<Normals>(seed)),
          n_(sequence.states()), controls(model_.B.cols()), components(sensor_.components())
    {
        for (Index c = 0; c < components; ++c) noise_[c] = std::sqrt(sensor_.R(c, c));
    }

    /// Nothing moves, and all is measured.
    explicit Plant(const Sequence &sequence) : Plant(sequence, 1)
    {
        std::fill(u, u + mostStates, 0);
        std::fill(z, z + mostStates, 0);
    }

    void step(bool hasGaps)
    {
        double w[mostStates], before[mostStates];
        std::copy(x_, x_ + n_, before);
        std::fill(x_, x_ + n_, 0);
        for (Index k = 0; k < controls; ++k) u[k] = static_cast<float>(normals_->next() / 4);
        for (Index k = 0; k < model_.F.cols(); ++k) w[k] = normals_->next();
        add(x_, model_.A, before);
        add(x_, model_.F, w);
        add(x_, model_.B, u);
        for (Index c = 0; c < components; ++c) z[c] = noise_[c] * normals_->next();
        add(z, sensor_.H, x_);
        for (Index c = 0; c < components; ++c) z[c] = static_cast<float>(z[c]);
        isMeasured = !hasGaps || !normals_->chance(missing);
    }

  private:
    static void add(double *y, const Matrix<double> &M, const double *x)
    {
        const double *entry = M.data(); // by columns
        for (Index k = 0; k < M.cols(); ++k) {
            for (Index i = 0; i < M.rows(); ++i) y[i] += *entry++ * x[k];
        }
    }

    const ProcessModel &model_;
    const SensorModel &sensor_;
    std::unique_ptr<Normals> normals_;
    Index n_;
    double x_[mostStates] = {}, noise_[mostStates];

  public:
    Index controls, components;
    double u[mostStates], z[mostStates];
    bool isMeasured = true;
};

/// The filtered covariance that the textbook comes to, component by component, and after how many steps nothing of the prior is left
struct Steady {
    Matrix<long double> P;
    std::uint64_t after = 0;

    explicit Steady(const Sequence &sequence) : P(convert<long double>(sequence.P0))
    {
        const Model<long double> model(sequence);
        const Matrix<long double> &A = model.A[0], &H = model.H[0];
        for (long double change = 1; change > 1e-14L; ++after) {
            Matrix<long double> next = A * P * A.transpose() + model.Q[0];
            for (Index c = 0; c < H.rows(); ++c) {
                const Vector<long double> h = H.row(c).transpose(), b = next * h;
                next -= b * b.transpose() / (h.dot(b) + model.R[0](c, c));
            }
            next = symmetric<long double>(next);
            change = normalised<long double>(next - P, next.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff();
            P = next;
        }
    }
};

/// The largest errors, by powers of 2 of the step
struct Drift {
    std::array<double, 64> x{}, P{};

    void add(std::uint64_t t, double meanError, double covarianceError)
    {
        std::size_t k = 0;
        while (t >> (k + 1)) ++k;
        x[k] = std::max(x[k], meanError);
        P[k] = std::max(P[k], covarianceError);
    }

    void add(const Drift &other)
    {
        for (std::size_t k = 0; k < x.size(); ++k) {
            x[k] = std::max(x[k], other.x[k]);
            P[k] = std::max(P[k], other.P[k]);
        }
    }

    void print(const char *name) const
    {
        for (std::size_t k = 0; k < x.size(); ++k) {
            if (x[k] > 0 || P[k] > 0) std::printf("drift %s %zu %.3g %.3g\n", name, k, x[k], P[k]);
        }
    }
};

/// One filter of the library
template <class T> class Filter
{
    using Api = kq::Api<T>;

  public:
    explicit Filter(const Sequence &sequence)
        : states_(sequence.states(), sequence.range), process_(states_, sequence.processes[0], Noise::factor),
          sensor_(states_, sequence.sensors[0], Noise::diagonal), filter_(states_)
    {
        kq::require(filter_.init(sequence.x0, sequence.P0), "filter init");
    }

    void step(const Plant &plant)
    {
        typename Api::Word u[mostStates], z[mostStates];
        for (int k = 0; k < plant.controls; ++k) u[k] = process_.controls().word(k, plant.u[k]);
        for (int c = 0; c < plant.components; ++c) z[c] = sensor_.components().word(c, plant.z[c]);
        const auto *controls = plant.controls > 0 ? u : nullptr;
        if (!plant.isMeasured) return kq::require(Api::predict(filter_.get(), process_.get(), controls), "predict");
        kq::require(Api::step(filter_.get(), process_.get(), controls, sensor_.get(), z), "step");
        nis += static_cast<double>(Formats<T>::score(Api::nis(filter_.get())));
        taken += static_cast<double>(Api::taken(filter_.get()));
    }

    /// P is to be like `right`, the mean like `mean`.
    void check(std::uint64_t t, const Vector<long double> &mean, const Matrix<long double> &right, bool isSteady)
    {
        const auto belief = read(filter_);
        const Vector<long double> x = belief.mean.template cast<long double>();
        const Matrix<long double> P = belief.covariance.template cast<long double>();
        const Vector<long double> sigma = right.diagonal().cwiseSqrt();
        const double meanError = static_cast<double>((x - mean).cwiseQuotient(sigma).cwiseAbs().maxCoeff());
        const double error = static_cast<double>(normalised<long double>(P - right, sigma).cwiseAbs().maxCoeff());
        soundness.inspect(belief, readSigma(filter_));
        soundness.sound = soundness.sound && P == P.transpose() && std::isfinite(meanError) && std::isfinite(error);
        events |= Api::events(filter_.get());
        drift.add(t, meanError, isSteady ? error : 0);
        meanWorst = std::max(meanWorst, meanError);
        if (isSteady) covarianceWorst = std::max(covarianceWorst, error);
    }

    void judge(Verdict &verdict, const std::string &model, Index n, double most = 1e-3)
    {
        const std::string name = model + ", " + Api::name;
        const double spread = 6 * std::sqrt(2 / taken);
        const bool isDouble = std::is_same_v<T, double>;
        std::printf("   %s x %.1e P %.1e nis %.5f", Api::name, meanWorst, covarianceWorst, nis / taken);
        verdict.expect(soundness.sound, name + ": not finite, not symmetric, or a sigma below 0");
        verdict.expect(events == 0, name + ": event " + std::to_string(events));
        verdict.expectAtLeast(soundness.eigenvalue, -eigenvalueRounding<T>(n), name + ": smallest eigenvalue of P");
        verdict.expectAtMost(meanWorst, most, name + ": error of x");
        verdict.expectAtMost(covarianceWorst, isDouble ? 1e-9 : most, name + ": error of P");
        verdict.expectAtMost(std::abs(nis / taken - 1), spread, name + ": mean NIS - 1");
    }

    auto belief() const { return read(filter_); }

    /// Steps until the memory, of mean 0, is what it was before, and then the largest error of P of all that repeats.  P knows no
    /// measurement: that is what P is for ever.  (Brent's search: a saved memory, moved at powers of two.)  Where measurements say
    /// next to nothing their count is part of it, and does not repeat: then it is P after the most steps.
    void settle(Verdict &verdict, const Sequence &sequence, const Matrix<long double> &right, const std::string &model)
    {
        const Plant none(sequence);
        std::vector<typename Api::Word> saved;
        std::uint64_t t = 0, power = 1, period = 0;
        std::uint32_t counted = 0;
        const auto isAsSaved = [&] { return filter_.memory() == saved && filter_.get()->weak == counted; };
        for (; !isAsSaved() && t < mostUntilRepeated; ++t, ++period) {
            if (period == power || t == 0) {
                saved = filter_.memory();
                counted = filter_.get()->weak;
                power *= 2;
                period = 0;
            }
            step(none);
        }
        const bool repeats = isAsSaved(), isWeak = filter_.get()->weak != counted;
        for (std::uint64_t k = 0; k < std::min<std::uint64_t>(period, mostBetween); ++k) {
            check(1, Vector<long double>::Zero(right.rows()), right, true);
            step(none);
        }
        std::printf("%-6s %s %9llu steps, %s %8llu, P %.1e\n", model.c_str(), Api::name, static_cast<unsigned long long>(t),
                    repeats ? "period" : "none within", static_cast<unsigned long long>(period), covarianceWorst);
        std::fflush(stdout);
        verdict.expect(repeats || isWeak, model + ", " + Api::name + ": P has not repeated");
        verdict.expectAtMost(covarianceWorst, 1e-2, model + ", " + Api::name + ": error of P after all years");
    }

    Drift drift;
    Soundness soundness;
    double nis = 0, taken = 0, meanWorst = 0, covarianceWorst = 0;
    unsigned events = 0;

  private:
    Formats<T> states_;
    ProcessOwner<T> process_;
    SensorOwner<T> sensor_;
    FilterOwner<T> filter_;
};

struct Drifts {
    Drift f64, f32, q31;
};

void soak(Verdict &verdict, Drifts &drifts, std::uint64_t seed, Index n, bool hasGaps, std::uint64_t steps)
{
    Sequence sequence = drawnModel(seed, n);
    declare(sequence);
    const std::unique_ptr<const Steady> steady = hasGaps ? nullptr : std::make_unique<Steady>(sequence);
    Filter<double> f64(sequence);
    Filter<float> f32(sequence);
    Filter<Q31> q31(sequence);
    Plant plant(sequence, seed);
    const std::uint64_t between = std::min(mostBetween, steps / 64 | 1);
    for (std::uint64_t t = 1; t <= steps; ++t) {
        plant.step(hasGaps);
        f64.step(plant);
        f32.step(plant);
        q31.step(plant);
        if (t % between != 0) continue;
        const auto exact = f64.belief();
        const Vector<long double> mean = exact.mean.cast<long double>();
        const Matrix<long double> P = hasGaps ? Matrix<long double>(exact.covariance.cast<long double>()) : steady->P;
        const bool isSteady = hasGaps || t >= steady->after;
        f64.check(t, mean, P, isSteady);
        f32.check(t, mean, P, isSteady);
        q31.check(t, mean, P, isSteady);
    }
    const std::string name = "n " + std::to_string(n) + (hasGaps ? ", gaps" : "");
    std::printf("%-11s m %2td %12llu steps", name.c_str(), plant.components, 3ULL * steps);
    f64.judge(verdict, name, n);
    f32.judge(verdict, name, n);
    q31.judge(verdict, name, n);
    std::printf("\n");
    std::fflush(stdout);
    drifts.f64.add(f64.drift);
    drifts.f32.add(f32.drift);
    drifts.q31.add(q31.drift);
}

/// Constants, seen together by sensors of which each says 2^-share of its variance at first.  From three states on another one
/// sees the first state well, and that moves.
Sequence weakModel(std::uint64_t seed, Index n, int share)
{
    Random random(seed);
    const Index components = n < 3 ? n : 3;
    const Vector<double> sigma = normals(random, n).cwiseAbs().cwiseMax(0.1);
    Matrix<double> H = normals(random, components, n);
    if (n >= 3) H.row(0) = Matrix<double>::Identity(1, n);
    const Matrix<double> P0 = sigma.cwiseAbs2().asDiagonal();
    Vector<double> r = (H * P0 * H.transpose()).diagonal() * std::ldexp(1, share);
    if (n >= 3) r(0) = P0(0, 0) / 16;
    Matrix<double> A = Matrix<double>::Identity(n, n);
    Vector<double> moved = Vector<double>::Zero(n);
    if (n >= 3) {
        A(0, 0) = 0.9375;
        moved(0) = sigma(0) / 4;
    }
    Sequence sequence;
    sequence.x0 = Vector<double>::Zero(n);
    sequence.P0 = rounded(P0);
    sequence.processes.push_back({A, Matrix<double>(n, 0), rounded(Matrix<double>(moved.asDiagonal()))});
    sequence.sensors.push_back({rounded(H), rounded(Matrix<double>(r.asDiagonal()))});
    sequence.range = powersOfTwo(reach * sigma);
    sequence.sensors[0].range = powersOfTwo(reach * ((H * P0 * H.transpose()).diagonal() + r).cwiseSqrt());
    widenStates(sequence);
    widenMeasurements(sequence);
    return sequence;
}

/// P is to be f64's after as many measurements as say half of what there is, and there is to be no event.
template <class T> void weak(Verdict &verdict, std::uint64_t seed, Index n, int share)
{
    const Sequence sequence = weakModel(seed, n, share);
    const std::uint64_t steps = std::uint64_t{1} << (share - 1);
    Filter<double> f64(sequence);
    Filter<T> filter(sequence);
    Plant plant(sequence, seed);
    for (std::uint64_t t = 1; t <= steps; ++t) {
        plant.step(false);
        f64.step(plant);
        filter.step(plant);
        if (t % (steps / 64) != 0) continue;
        const auto exact = f64.belief();
        filter.check(t, exact.mean.template cast<long double>(), exact.covariance.template cast<long double>(), true);
    }
    const std::string name = "2^-" + std::to_string(share) + ", n " + std::to_string(n);
    std::printf("%-12s %9llu steps", name.c_str(), static_cast<unsigned long long>(steps));
    const double predicts = std::is_same_v<T, Q31> ? std::ldexp(static_cast<double>(steps), -28) : 0; // what they round P by
    filter.judge(verdict, name, n, 1e-3 + predicts);
    std::printf("\n");
    std::fflush(stdout);
}

int allWeak(int share, std::uint64_t seed)
{
    Verdict verdict;
    for (const Index n : {1, 2, 3, 5, 16}) {
        weak<float>(verdict, 1000 * seed + static_cast<std::uint64_t>(n), n, share);
        weak<Q31>(verdict, 1000 * seed + static_cast<std::uint64_t>(n), n, share);
    }
    return verdict.finish();
}

int years(std::uint64_t seed)
{
    Verdict verdict;
    for (Index n = 1; n <= mostStates; ++n) {
        Sequence sequence = drawnModel(1000 * seed + static_cast<std::uint64_t>(2 * n), n);
        declare(sequence);
        const Steady steady(sequence);
        const std::string name = "n " + std::to_string(n);
        Filter<double>(sequence).settle(verdict, sequence, steady.P, name);
        Filter<float>(sequence).settle(verdict, sequence, steady.P, name);
        Filter<Q31>(sequence).settle(verdict, sequence, steady.P, name);
    }
    return verdict.finish();
}

} // namespace

int main(int argc, char **argv)
{
    if (argc > 1 && std::string(argv[1]) == "years") return years(amountOf(argc, argv, 1));
    if (argc > 2 && std::string(argv[1]) == "weak") return allWeak(std::atoi(argv[2]), amountOf(argc, argv, 1, 3));
    const double wanted = argc > 1 ? std::strtod(argv[1], nullptr) : 3e6;
    const std::uint64_t seed = amountOf(argc, argv, 1);
    double shares = 0, done = 0;
    for (Index n = 1; n <= mostStates; ++n) shares += std::pow(n, -2);
    Verdict verdict;
    Drifts drifts;
    for (Index n = mostStates; n >= 1; --n) {
        const double steps = std::ceil(wanted / 6 * std::pow(n, -2) / shares);
        for (const bool hasGaps : {false, true}) {
            soak(verdict, drifts, 1000 * seed + static_cast<std::uint64_t>(2 * n + hasGaps), n, hasGaps, static_cast<std::uint64_t>(steps));
            done += 3 * steps;
        }
    }
    drifts.f64.print("f64");
    drifts.f32.print("f32");
    drifts.q31.print("q31");
    std::printf("%.0f steps\n", done);
    return verdict.finish();
}
