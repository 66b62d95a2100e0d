// Outliers and jumps: what the robust steps gain, and what they cost where they are not needed.
//
// A random walk seen with noise, seeded.  Measurement outliers: beside the exact posterior mean, on
// a grid, for the noise that was drawn.  Jumps: alpha-stable increments, a filter that is given the
// Gaussian of the same scale, Q = 2 sigma^2.  The goals are for double, with 2000 runs; float and
// fixed point must have the same error on the first of these runs.
//
//     test_robust [seed [stride]]      2: each second noise, of the measurements and of the state

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "tracks.hpp"
#include "verdict.hpp"

using namespace reference;

namespace
{

/// All runs are for what has a goal, some for what a step costs where it does not belong, few for
/// the comparison of the arithmetics.
constexpr std::size_t runCount = 2000, someRuns = 500, fewRuns = 200;
constexpr double pi = 3.14159265358979324;

std::vector<Run> firstOf(const std::vector<Run> &runs, std::size_t count)
{
    return {runs.begin(), runs.begin() + static_cast<std::ptrdiff_t>(count)};
}

/// Float and fixed point: the error of double, but for a thousandth of it.
void checkOthers(Verdict &verdict, const std::string &name, double f64, double f32, double q31)
{
    constexpr double share = 1e-3;
    verdict.expectAtMost(std::fabs(f32 / f64 - 1), share, name + ": f32 from f64");
    verdict.expectAtMost(std::fabs(q31 / f64 - 1), share, name + ": q31 from f64");
}

// ---------------------------------------------------------------- noises and their densities

/// S(alpha, 0, 1), Chambers, Mallows and Stuck 1976, as corrected by Weron 1996; alpha = 2 is
/// Gaussian with variance 2.
double drawStable(Random &random, double alpha)
{
    const double v = pi * (random.uniform() - 0.5), w = -std::log(random.uniform());
    return std::sin(alpha * v) / std::pow(std::cos(v), 1 / alpha) *
           std::pow(std::cos((1 - alpha) * v) / w, (1 - alpha) / alpha);
}

/// The density of S(alpha, 0, 1): Fourier inversion of exp(-|k|^alpha) with k = u^2, by the
/// trapezoid rule with the correction for the slope 2 of the integrand at 0, and the series of its
/// tail.
class StableDensity
{
  public:
    explicit StableDensity(double alpha) : alpha_(alpha)
    {
        for (std::size_t i = 0; i <= count; ++i) table_.push_back(inverted(step * double(i)));
    }

    double operator()(double x) const
    {
        const double at = std::fabs(x) / step;
        if (at >= double(count)) return tail(std::fabs(x));
        const auto i = static_cast<std::size_t>(at);
        const double share = at - double(i);
        return table_[i] + share * (table_[i + 1] - table_[i]);
    }

    double inverted(double x) const
    {
        constexpr double du = 1e-3;
        double sum = du / 6;
        for (double u = du; u < 4; u += du) {
            sum += std::exp(-std::pow(u, 2 * alpha_)) * std::cos(x * u * u) * 2 * u;
        }
        return sum * du / pi;
    }

    double tail(double x) const
    {
        double sum = 0, sign = 1;
        for (int j = 1; j <= 5; ++j, sign = -sign) {
            sum += sign * std::tgamma(alpha_ * j + 1) / std::tgamma(j + 1.0) *
                   std::sin(j * pi * alpha_ / 2) * std::pow(x, -alpha_ * j - 1);
        }
        return sum / pi;
    }

    static constexpr double step = 0.01;
    static constexpr std::size_t count = 2000;

  private:
    double alpha_;
    Series table_;
};

struct Noise {
    const char *name;
    std::function<double(Random &)> draw;
    std::function<double(double)> density; ///< up to a factor
};

double drawStudent(Random &random, int freedom)
{
    const double square = drawChiSquare(random, freedom);
    return random.normal() / std::sqrt(square);
}

// ---------------------------------------------------------------- the exact posterior mean

/// Of a random walk, on a grid that moves with the posterior.  Its steps are a third of the
/// smallest standard deviation: sums over it are exact to 1e-9 for smooth densities.
class Exact
{
  public:
    Exact(const Motion &model, const std::function<double(double)> &density)
        : model_(model), density_(density)
    {
        for (int k = -reach; k <= reach; ++k) {
            kernel_.push_back(std::exp(-0.5 * k * k * step * step / model.Q[0]));
        }
    }

    Series means(const Series &z)
    {
        Series x;
        long centre = 0;
        Series p(width);
        for (std::size_t i = 0; i < width; ++i) {
            const double at = place(i, 0);
            p[i] = std::exp(-0.5 * at * at / model_.p0);
        }
        for (std::size_t t = 0; t < z.size(); ++t) {
            if (t > 0) p = moved(p);
            double sum = 0, first = 0;
            for (std::size_t i = 0; i < width; ++i) {
                p[i] *= density_(z[t] - place(i, centre));
                sum += p[i];
                first += p[i] * place(i, centre);
            }
            x.push_back(first / sum);
            for (double &v : p) v /= sum;
            const long next = std::lround(x.back() / step);
            p = shifted(p, next - centre);
            centre = next;
        }
        return x;
    }

  private:
    static constexpr double step = 0.1;
    static constexpr int reach = 22, half = 75;
    static constexpr std::size_t width = 2 * half + 1;

    static double place(std::size_t i, long centre)
    {
        return step * (static_cast<double>(i) - half + static_cast<double>(centre));
    }

    Series moved(const Series &p) const
    {
        Series padded(width + 2 * reach), out(width);
        std::copy(p.begin(), p.end(), padded.begin() + reach);
        for (std::size_t k = 0; k < kernel_.size(); ++k) {
            for (std::size_t i = 0; i < width; ++i) out[i] += kernel_[k] * padded[i + k];
        }
        return out;
    }

    static Series shifted(const Series &p, long by)
    {
        Series out(width);
        for (std::size_t i = 0; i < width; ++i) {
            const long from = static_cast<long>(i) + by;
            if (from >= 0 && from < static_cast<long>(width)) {
                out[i] = p[static_cast<std::size_t>(from)];
            }
        }
        return out;
    }

    Motion model_;
    std::function<double(double)> density_;
    Series kernel_;
};

// ---------------------------------------------------------------- measurement outliers

const Motion quiet = walk("walk", 0.1);
constexpr Method plain = {"plain filter", Loss::none, 1};
constexpr Method gated = {"gate, 99.99 %", Loss::gate, 1};
constexpr Method huber = {"Huber, k = 1.5", Loss::huber, 1.5};
constexpr Method student = {"Student-t update, nu = 4", Loss::student, 4};
constexpr Method jumpGate = {"jump gate, g = 9", Loss::jump, 9};

std::vector<Run> drawOutliers(const Noise &noise, std::uint64_t seed)
{
    std::vector<Run> runs(runCount);
    Random random(seed);
    for (Run &run : runs) {
        double x = random.normal() * std::sqrt(quiet.p0);
        for (int t = 0; t < 100; ++t) {
            if (t > 0) x += random.normal() * std::sqrt(quiet.Q[0]);
            run.truth.push_back(x);
            run.z.push_back(x + noise.draw(random));
        }
    }
    return runs;
}

/// The switch for the other noise
void printHarm(const std::vector<Run> &all, const Motion &model, const std::vector<Method> &methods)
{
    const std::vector<Run> runs = firstOf(all, someRuns);
    const Errors usual = filterErrors<double>(runs, model, plain);
    for (const Method &method : methods) {
        const Errors errors = filterErrors<double>(runs, model, method);
        errors.print(method.name);
        std::printf("   %.3f of the plain (mae %.3f), %zu runs\n", errors.rmse() / usual.rmse(),
                    errors.mae() / usual.mae(), someRuns);
    }
}

void checkFilters(Verdict &verdict, const std::string &name, const std::vector<Run> &all,
                  const Motion &model, const Method &method)
{
    const std::vector<Run> runs = firstOf(all, fewRuns);
    checkOthers(verdict, name, filterErrors<double>(runs, model, method).rmse(),
                filterErrors<float>(runs, model, method).rmse(),
                filterErrors<Q31>(runs, model, method).rmse());
}

void testOutliers(Verdict &verdict, const Noise &noise, std::uint64_t seed)
{
    const std::vector<Run> runs = drawOutliers(noise, seed);
    const bool gaussian = std::string(noise.name) == "Gaussian";
    Exact exact(quiet, noise.density);
    const Errors best = errorsOf(runs, [&](const Series &z) { return exact.means(z); });
    std::printf("measurement noise: %s\n", noise.name);
    best.print("exact posterior mean");
    std::printf("\n");
    double f64 = 0, kalman = 0;
    for (const Method &method : {plain, gated, huber, student}) {
        const Errors errors = filterErrors<double>(runs, quiet, method);
        if (method.loss == Loss::none) kalman = errors.rmse();
        if (method.loss == Loss::student) f64 = errors.rmse();
        errors.print(method.name);
        std::printf("   %.4f of the exact, %.3f of the plain\n", errors.rmse() / best.rmse(),
                    errors.rmse() / kalman);
    }
    printHarm(runs, quiet, {jumpGate});
    if (gaussian) {
        verdict.expectAtMost(std::fabs(kalman / best.rmse() - 1), 1e-6,
                             "the grid on Gaussian noise");
    } else {
        verdict.expectAtLeast(kalman / best.rmse(), 1.2, std::string(noise.name) + ": plain");
    }
    verdict.expectAtMost(f64 / best.rmse(), gaussian ? 1.035 : 1.03,
                         std::string(noise.name) + ": Student-t of the exact");
    checkFilters(verdict, noise.name, runs, quiet, student);
}

void testMeasurementNoise(Verdict &verdict, std::uint64_t seed, std::size_t stride)
{
    const StableDensity stable(1.5);
    const double end = StableDensity::step * StableDensity::count;
    verdict.expectAtMost(std::fabs(stable.tail(end) / stable.inverted(end) - 1), 1e-6,
                         "the two formulas of the stable density");
    const auto density = [&stable](double scale) {
        return [&stable, scale](double v) { return stable(v / scale); };
    };
    const double root = std::sqrt(0.5);
    const std::array<Noise, 5> noises = {{
        {"Gaussian", [](Random &r) { return r.normal(); },
         [](double v) { return std::exp(-0.5 * v * v); }},
        {"10 % outliers of sd 10",
         [](Random &r) { return r.chance(0.1) ? 10 * r.normal() : r.normal(); },
         [](double v) { return 0.9 * std::exp(-0.5 * v * v) + 0.01 * std::exp(-0.005 * v * v); }},
        {"Student-t, 3 degrees", [](Random &r) { return drawStudent(r, 3); },
         [](double v) { return 1 / ((1 + v * v / 3) * (1 + v * v / 3)); }},
        {"stable, alpha 1.5, sigma 1", [](Random &r) { return drawStable(r, 1.5); }, density(1)},
        {"stable, alpha 1.5, 2 sigma^2 = 1",
         [root](Random &r) { return root * drawStable(r, 1.5); }, density(root)},
    }};
    for (std::size_t k = 0; k < noises.size(); k += stride) testOutliers(verdict, noises[k], seed + k);
}

// ---------------------------------------------------------------- jumps

struct Jumps {
    double alpha, sigma;
    int steps;
    double filter, smooth; ///< the goals; 0: none
};

constexpr double smootherNu = 2, smootherStart = 16;
constexpr int smootherPasses = 5;

std::vector<Run> drawJumps(const Jumps &jumps, std::uint64_t seed)
{
    std::vector<Run> runs(runCount);
    Random random(seed);
    for (Run &run : runs) {
        double x = 0;
        for (int t = 0; t < jumps.steps; ++t) {
            x += jumps.sigma * drawStable(random, jumps.alpha);
            run.truth.push_back(x);
            run.z.push_back(x + random.normal());
        }
    }
    return runs;
}

template <class T>
Errors smootherErrors(const std::vector<Run> &runs, const Motion &model, int passes)
{
    Follower<T> follower(model, 1, runs[0].z.size());
    return errorsOf(runs, [&](const Series &z) {
        return passes == 0 ? follower.smoothedPlainly(z)
                           : follower.smoothed(z, smootherNu, smootherStart, passes);
    });
}

/// With measurements that q31 has, too: one that is rounded to the other side of the limit is another one.
std::vector<Run> inWords(std::vector<Run> runs, const Motion &model)
{
    const Follower<Q31> follower(model);
    for (Run &run : runs) run.z = follower.inWords(run.z);
    return runs;
}

void testJumps(Verdict &verdict, const Jumps &jumps, std::uint64_t seed)
{
    Motion model = walk("jumps", 2 * jumps.sigma * jumps.sigma);
    model.p0 = 0;
    model.movesFirst = true;
    const std::vector<Run> runs = drawJumps(jumps, seed);
    std::printf("state noise: stable, alpha %.1f, Q / R = %g, %d steps\n", jumps.alpha, model.Q[0],
                jumps.steps);
    double f64 = 0;
    for (const Method &method : {plain, jumpGate}) {
        const Errors errors = filterErrors<double>(runs, model, method);
        errors.print(method.name);
        std::printf("\n");
        f64 = errors.rmse();
    }
    printHarm(runs, model, {gated, huber, student});
    smootherErrors<double>(runs, model, 0).print("plain smoother");
    std::printf("\n");
    const Errors smoothed = smootherErrors<double>(runs, model, smootherPasses);
    smoothed.print("reweighted smoother, 5 passes");
    std::printf("\n");
    smootherErrors<double>(firstOf(runs, someRuns), model, 12).print("the same, 12 passes");
    std::printf("   %zu runs\n", someRuns);
    const std::string name =
        "alpha " + std::to_string(jumps.alpha) + ", Q/R " + std::to_string(model.Q[0]);
    if (jumps.filter > 0) {
        verdict.expectAtMost(f64, jumps.filter, name + ": filter");
        verdict.expectAtMost(smoothed.rmse(), jumps.smooth, name + ": smoother");
    }
    checkFilters(verdict, name + ": filter", inWords(runs, model), model, jumpGate);
    const std::vector<Run> few = firstOf(runs, fewRuns);
    checkOthers(verdict, name + ": smoother",
                smootherErrors<double>(few, model, smootherPasses).rmse(),
                smootherErrors<float>(few, model, smootherPasses).rmse(),
                smootherErrors<Q31>(few, model, smootherPasses).rmse());
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    const std::size_t stride = amountOf(argc, argv, 1);
    std::printf("seed %llu, %zu runs\n", static_cast<unsigned long long>(seed), runCount);
    Verdict verdict;
    testMeasurementNoise(verdict, seed * 100, stride);
    const std::array<Jumps, 8> all = {{
        {1.3, 1, 100, 0.928, 0.835},    {1.5, 1, 100, 0.909, 0.820},
        {1.7, 1, 100, 0.892, 0.805},    {2.0, 1, 100, 0, 0},
        {1.3, 0.1, 200, 0.638, 0.415}, {1.5, 0.1, 200, 0.555, 0.365},
        {1.7, 0.1, 200, 0.488, 0.320},  {2.0, 0.1, 200, 0, 0},
    }};
    for (std::size_t k = 0; k < all.size(); k += stride) testJumps(verdict, all[k], seed * 100 + 50 + k);
    return verdict.finish();
}
