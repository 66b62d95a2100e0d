// Outliers and jumps: what the robust steps gain, and what they cost where they are not needed.
//
// A random walk seen with noise, seeded.  Measurement outliers: beside the exact posterior mean, on
// a grid, for the noise that was drawn.  Jumps: alpha-stable increments, a filter that is given the
// Gaussian of the same scale, Q = 2 sigma^2.  The goals are for double, with 2000 runs; float and
// fixed point must have the same error on the first of these runs.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

#include "api.hpp"
#include "kalmanq/prepare.h"
#include "random.hpp"
#include "verdict.hpp"

using namespace reference;
using kq::Api;
using kq::Q31;

namespace
{

/// All runs are for what has a goal, some for what a step costs where it does not belong, few for
/// the comparison of the arithmetics.
constexpr std::size_t runCount = 2000, someRuns = 500, fewRuns = 200;
constexpr double pi = 3.14159265358979324;

// ---------------------------------------------------------------- the three arithmetics

/// What a walk needs of an arithmetic: numbers, objects of one state, the robust steps.
template <class T> struct Arithmetic;

template <class T> struct FloatArithmetic {
    T noiseMemory[1], scaledMemory[1], sensorMemory[1];
    T A[1] = {1}, H[1] = {1};

    static T word(double a) { return static_cast<T>(a); }
    static double wordValue(double a) { return a; }

    void process(typename Api<T>::Process &p, typename Api<T>::Process &scaled, double Q)
    {
        const T q[] = {static_cast<T>(Q)};
        kq::require(Api<T>::process_assign(&p, 1, 0, noiseMemory, 1), "process");
        kq::require(Api<T>::process_assign(&scaled, 1, 0, scaledMemory, 1), "process");
        kq::require(Api<T>::process_init(&p, A, nullptr, q), "process");
    }

    void sensor(typename Api<T>::Sensor &s, double R)
    {
        const T r[] = {static_cast<T>(R)};
        kq::require(Api<T>::sensor_assign(&s, 1, 1, sensorMemory, 1), "sensor");
        kq::require(Api<T>::sensor_init(&s, H, r), "sensor");
    }

    void start(typename Api<T>::Filter &f, double P0)
    {
        const T x[] = {0}, P[] = {static_cast<T>(P0)};
        kq::require(Api<T>::filter_init(&f, x, P), "filter");
    }
};

template <> struct Arithmetic<float> : FloatArithmetic<float> {
    static constexpr auto scaleNoise = kq_process_scale_noise_f32;
    static constexpr auto smoothReweighted = kq_smooth_reweighted_f32;
};

template <> struct Arithmetic<double> : FloatArithmetic<double> {
    static constexpr auto scaleNoise = kq_process_scale_noise_f64;
    static constexpr auto smoothReweighted = kq_smooth_reweighted_f64;
};

/// Words of 2^-7 over +-2^24: an increment may be as large as that.
template <> struct Arithmetic<Q31> {
    kq_format_q31 format[1] = {{INT32_MAX, 7}};
    kq_scaled_q31 A[1] = {{1 << 30, -30}}, H[1] = {{1 << 30, -30}}, noise[1];
    int32_t root[KQ_ROOT_LEN_Q31(1)], priorRoot[KQ_ROOT_LEN_Q31(1)], zero[1] = {0};
    static inline int32_t scaledRoot[KQ_ROOT_LEN_Q31(1)];
    kq_process_table_q31 processTable{};
    kq_sensor_table_q31 sensorTable{};
    kq_prior_table_q31 prior{};

    static int32_t word(double a) { return static_cast<int32_t>(std::llround(a * 0x1p7)); }
    static double wordValue(double a) { return a * 0x1p-7; }

    void process(kq_process_q31 &p, kq_process_q31 &, double Q)
    {
        kq::require(kq_root_prepare_q31(root, &Q, 1, format), "root");
        processTable = {1, 0, format, nullptr, A, nullptr, root};
        kq::require(kq_process_init_q31(&p, &processTable, nullptr), "process");
    }

    void sensor(kq_sensor_q31 &s, double R)
    {
        kq::require(kq_noise_prepare_q31(noise, &R, 1, format), "noise");
        sensorTable = {1, 1, 0, format, format, H, noise};
        kq::require(kq_sensor_init_q31(&s, &sensorTable, nullptr), "sensor");
    }

    void start(kq_filter_q31 &f, double P0)
    {
        kq::require(kq_root_prepare_q31(priorRoot, &P0, 1, format), "root");
        prior = {1, format, zero, priorRoot};
        kq::require(kq_filter_init_q31(&f, &prior, nullptr), "filter");
    }

    static kq_status scaleNoise(kq_process_q31 *target, const kq_process_q31 *source,
                                kq_scaled_q31 q)
    {
        return kq_process_scale_noise_q31(target, source, scaledRoot, q);
    }
    static kq_status smoothReweighted(kq_history_q31 *h, kq_process_q31 *target,
                                      const kq_process_q31 *source, kq_scaled_q31 nu,
                                      kq_scaled_q31 *q)
    {
        return kq_smooth_reweighted_q31(h, target, source, scaledRoot, nu, q);
    }
};

// ---------------------------------------------------------------- filters of a random walk

struct Model {
    double Q, R, P0;
    bool movesFirst; ///< a predict before the first measurement
};

enum class Step { plain, gated, huber, student, jump };

struct Method {
    const char *name;
    Step step;
    double parameter;
};

using Series = std::vector<double>;

template <class T> class Walk
{
  public:
    Walk(const Model &model, std::size_t steps)
        : model_(model), tape_(Api<T>::length(KQ_OBJECT_HISTORY, 1, 1, steps + 1)), weights_(steps)
    {
        arithmetic_.process(process_, scaled_, model.Q);
        arithmetic_.sensor(sensor_, model.R);
        kq::require(Api<T>::filter_assign(&filter_, 1, memory_.data(), memory_.size()), "filter");
        kq::require(Api<T>::history_assign(&history_, 1, tape_.data(), tape_.size()), "history");
    }

    Series filtered(const Series &z, const Method &method)
    {
        Series x;
        arithmetic_.start(filter_, model_.P0);
        loss_ = {};
        loss_.kind = kindOf(method.step);
        loss_.parameter = Api<T>::number(method.parameter);
        loss_.limit = Api<T>::chi_square_limit(1, KQ_LEVEL_9999);
        for (std::size_t t = 0; t < z.size(); ++t) {
            const auto word = Its::word(z[t]);
            kq::require(take(word, method, t > 0 || model_.movesFirst), method.name);
            x.push_back(mean());
        }
        return x;
    }

    /// `passes` of filter and smoother, from q = first everywhere
    Series smoothed(const Series &z, double nu, double first, int passes)
    {
        std::fill(weights_.begin(), weights_.end(), Api<T>::number(first));
        for (int k = 0; k < passes; ++k) pass(z, nu);
        return readSmoothed(z.size());
    }

    Series smoothedPlainly(const Series &z)
    {
        record(z, [this](std::size_t) { return &process_; });
        kq::require(Api<T>::smooth(&history_), "smooth");
        return readSmoothed(z.size());
    }

  private:
    using Its = Arithmetic<T>;

    kq_status take(typename Api<T>::Word z, const Method &method, bool moves)
    {
        if (moves) kq::require(Api<T>::predict(&filter_, &process_, nullptr), "predict");
        if (method.step == Step::plain) return Api<T>::update(&filter_, &sensor_, &z);
        return Api<T>::update_robust(&filter_, &sensor_, &z, 1, &loss_);
    }

    static auto kindOf(Step step)
    {
        switch (step) {
        case Step::gated: return Api<T>::gate;
        case Step::huber: return Api<T>::huber;
        case Step::student: return Api<T>::student;
        default: return Api<T>::jump;
        }
    }

    template <class Choose> void record(const Series &z, const Choose &process)
    {
        arithmetic_.start(filter_, model_.P0);
        kq::require(Api<T>::attach(&filter_, &history_.attached), "attach");
        for (std::size_t t = 0; t < z.size(); ++t) {
            const auto word = Its::word(z[t]);
            kq::require(Api<T>::predict(&filter_, process(t), nullptr), "predict");
            kq::require(Api<T>::update(&filter_, &sensor_, &word), "update");
        }
    }

    void pass(const Series &z, double nu)
    {
        record(z, [this](std::size_t t) {
            kq::require(Its::scaleNoise(&scaled_, &process_, weights_[t]), "scale");
            return &scaled_;
        });
        kq::require(
            Its::smoothReweighted(&history_, &scaled_, &process_, Api<T>::number(nu), weights_.data()),
            "smooth");
    }

    Series readSmoothed(std::size_t steps) const
    {
        Series x;
        for (std::size_t t = 1; t <= steps; ++t) {
            typename Api<T>::Filter view;
            kq::require(Api<T>::smoothed(&history_, t, &view), "smoothed");
            const double low = static_cast<double>(Api<T>::mean_low(&view, 0));
            const double high = static_cast<double>(Api<T>::mean(&view, 0));
            x.push_back(Its::wordValue(high + low * lowUnit));
        }
        return x;
    }

    double mean() const
    {
        return Its::wordValue(static_cast<double>(Api<T>::mean(&filter_, 0)) +
                              static_cast<double>(Api<T>::mean_low(&filter_, 0)) * lowUnit);
    }

    static constexpr double lowUnit = std::is_same_v<T, Q31> ? 0x1p-24 : 1;

    Model model_;
    Its arithmetic_;
    typename Api<T>::Process process_{}, scaled_{};
    typename Api<T>::Sensor sensor_{};
    typename Api<T>::Filter filter_{};
    typename Api<T>::History history_{};
    typename Api<T>::Loss loss_{};
    std::vector<typename Api<T>::Word> memory_ = std::vector<typename Api<T>::Word>(Api<T>::length(KQ_OBJECT_FILTER, 1));
    std::vector<typename Api<T>::Word> tape_;
    std::vector<typename Api<T>::Coefficient> weights_;
};

// ---------------------------------------------------------------- errors

/// Of all steps of all runs; standard errors over runs
class Errors
{
  public:
    void add(const Series &truth, const Series &estimate)
    {
        double square = 0, size = 0;
        for (std::size_t t = 0; t < truth.size(); ++t) {
            const double e = estimate[t] - truth[t];
            square += e * e;
            size += std::fabs(e);
        }
        square_.push_back(square / static_cast<double>(truth.size()));
        size_.push_back(size / static_cast<double>(truth.size()));
    }

    double rmse() const { return std::sqrt(meanOf(square_)); }
    double mae() const { return meanOf(size_); }
    double rmseError() const { return standardError(square_) / (2 * rmse()); }
    double maeError() const { return standardError(size_); }

    void print(const char *name) const
    {
        std::printf("   %-28s rmse %7.4f +- %.4f   mae %7.4f +- %.4f", name, rmse(), rmseError(),
                    mae(), maeError());
    }

  private:
    static double meanOf(const Series &a)
    {
        double sum = 0;
        for (const double v : a) sum += v;
        return sum / static_cast<double>(a.size());
    }
    static double standardError(const Series &a)
    {
        const double m = meanOf(a), count = static_cast<double>(a.size());
        double sum = 0;
        for (const double v : a) sum += (v - m) * (v - m);
        return std::sqrt(sum / (count - 1) / count);
    }

    Series square_, size_;
};

struct Run {
    Series truth, z;
};

using Estimator = std::function<Series(const Series &)>;

Errors errorsOf(const std::vector<Run> &runs, std::size_t count, const Estimator &estimator)
{
    Errors errors;
    for (std::size_t k = 0; k < count; ++k) errors.add(runs[k].truth, estimator(runs[k].z));
    return errors;
}

template <class T>
Errors filterErrors(const std::vector<Run> &runs, std::size_t count, const Model &model,
                    const Method &method)
{
    Walk<T> walk(model, runs[0].z.size());
    return errorsOf(runs, count, [&](const Series &z) { return walk.filtered(z, method); });
}

/// Float and fixed point on the first runs: the error of double, up to `share` of it.
void checkOthers(Verdict &verdict, const std::string &name, double f64, double f32, double q31,
                 double share = 1e-3)
{
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
    double square = 0;
    for (int k = 0; k < freedom; ++k) {
        const double v = random.normal();
        square += v * v;
    }
    return random.normal() / std::sqrt(square / freedom);
}

// ---------------------------------------------------------------- the exact posterior mean

/// Of a random walk, on a grid that moves with the posterior.  Its steps are a third of the
/// smallest standard deviation: sums over it are exact to 1e-9 for smooth densities.
class Exact
{
  public:
    Exact(const Model &model, const std::function<double(double)> &density)
        : model_(model), density_(density)
    {
        for (int k = -reach; k <= reach; ++k) {
            kernel_.push_back(std::exp(-0.5 * k * k * step * step / model.Q));
        }
    }

    Series means(const Series &z)
    {
        Series x;
        long centre = 0;
        Series p(width);
        for (std::size_t i = 0; i < width; ++i) {
            const double at = place(i, 0);
            p[i] = std::exp(-0.5 * at * at / model_.P0);
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

    Model model_;
    std::function<double(double)> density_;
    Series kernel_;
};

// ---------------------------------------------------------------- measurement outliers

constexpr Model quiet = {0.1, 1, 1, false};
constexpr Method plain = {"plain filter", Step::plain, 1};
constexpr Method gated = {"gate, 99.99 %", Step::gated, 1};
constexpr Method huber = {"Huber, k = 1.5", Step::huber, 1.5};
constexpr Method student = {"Student-t update, nu = 4", Step::student, 4};
constexpr Method jumpGate = {"jump gate, g = 9", Step::jump, 9};

std::vector<Run> drawOutliers(const Noise &noise, std::uint64_t seed)
{
    std::vector<Run> runs(runCount);
    Random random(seed);
    for (Run &run : runs) {
        double x = random.normal() * std::sqrt(quiet.P0);
        for (int t = 0; t < 100; ++t) {
            if (t > 0) x += random.normal() * std::sqrt(quiet.Q);
            run.truth.push_back(x);
            run.z.push_back(x + noise.draw(random));
        }
    }
    return runs;
}

/// The switch for the other noise
void printHarm(const std::vector<Run> &runs, const Model &model, const std::vector<Method> &methods)
{
    const Errors usual = filterErrors<double>(runs, someRuns, model, plain);
    for (const Method &method : methods) {
        const Errors errors = filterErrors<double>(runs, someRuns, model, method);
        errors.print(method.name);
        std::printf("   %.3f of the plain (mae %.3f), %zu runs\n", errors.rmse() / usual.rmse(),
                    errors.mae() / usual.mae(), someRuns);
    }
}

void testOutliers(Verdict &verdict, const Noise &noise, std::uint64_t seed)
{
    const std::vector<Run> runs = drawOutliers(noise, seed);
    const bool gaussian = std::string(noise.name) == "Gaussian";
    Exact exact(quiet, noise.density);
    const Errors best = errorsOf(runs, runCount, [&](const Series &z) { return exact.means(z); });
    std::printf("measurement noise: %s\n", noise.name);
    best.print("exact posterior mean");
    std::printf("\n");
    double f64 = 0, kalman = 0;
    for (const Method &method : {plain, gated, huber, student}) {
        const Errors errors = filterErrors<double>(runs, runCount, quiet, method);
        if (method.step == Step::plain) kalman = errors.rmse();
        if (method.step == Step::student) f64 = errors.rmse();
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
    checkOthers(verdict, noise.name, filterErrors<double>(runs, fewRuns, quiet, student).rmse(),
                filterErrors<float>(runs, fewRuns, quiet, student).rmse(),
                filterErrors<Q31>(runs, fewRuns, quiet, student).rmse());
}

void testMeasurementNoise(Verdict &verdict, std::uint64_t seed)
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
    for (const Noise &noise : noises) testOutliers(verdict, noise, seed++);
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
Errors smootherErrors(const std::vector<Run> &runs, std::size_t count, const Model &model,
                      int passes)
{
    Walk<T> walk(model, runs[0].z.size());
    return errorsOf(runs, count, [&](const Series &z) {
        return passes == 0 ? walk.smoothedPlainly(z)
                           : walk.smoothed(z, smootherNu, smootherStart, passes);
    });
}

/// With measurements that q31 has, too: one that is rounded to the other side of the limit is another one.
std::vector<Run> inWords(std::vector<Run> runs)
{
    using Words = Arithmetic<Q31>;
    for (Run &run : runs) {
        for (double &z : run.z) z = Words::wordValue(Words::word(z));
    }
    return runs;
}

void testJumps(Verdict &verdict, const Jumps &jumps, std::uint64_t seed)
{
    const Model model = {2 * jumps.sigma * jumps.sigma, 1, 0, true};
    const std::vector<Run> runs = drawJumps(jumps, seed);
    std::printf("state noise: stable, alpha %.1f, Q / R = %g, %d steps\n", jumps.alpha,
                model.Q, jumps.steps);
    double f64 = 0;
    for (const Method &method : {plain, jumpGate}) {
        const Errors errors = filterErrors<double>(runs, runCount, model, method);
        errors.print(method.name);
        std::printf("\n");
        f64 = errors.rmse();
    }
    printHarm(runs, model, {gated, huber, student});
    smootherErrors<double>(runs, runCount, model, 0).print("plain smoother");
    std::printf("\n");
    const Errors smoothed = smootherErrors<double>(runs, runCount, model, smootherPasses);
    smoothed.print("reweighted smoother, 5 passes");
    std::printf("\n");
    smootherErrors<double>(runs, someRuns, model, 12).print("the same, 12 passes");
    std::printf("   %zu runs\n", someRuns);
    const std::string name =
        "alpha " + std::to_string(jumps.alpha) + ", Q/R " + std::to_string(model.Q);
    if (jumps.filter > 0) {
        verdict.expectAtMost(f64, jumps.filter, name + ": filter");
        verdict.expectAtMost(smoothed.rmse(), jumps.smooth, name + ": smoother");
    }
    const std::vector<Run> seen = inWords(runs);
    checkOthers(verdict, name + ": filter",
                filterErrors<double>(seen, fewRuns, model, jumpGate).rmse(),
                filterErrors<float>(seen, fewRuns, model, jumpGate).rmse(),
                filterErrors<Q31>(seen, fewRuns, model, jumpGate).rmse());
    checkOthers(verdict, name + ": smoother",
                smootherErrors<double>(runs, fewRuns, model, smootherPasses).rmse(),
                smootherErrors<float>(runs, fewRuns, model, smootherPasses).rmse(),
                smootherErrors<Q31>(runs, fewRuns, model, smootherPasses).rmse());
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    std::printf("seed %llu, %zu runs\n", static_cast<unsigned long long>(seed), runCount);
    Verdict verdict;
    testMeasurementNoise(verdict, seed * 100);
    const Jumps all[] = {
        {1.3, 1, 100, 0.928, 0.835},    {1.5, 1, 100, 0.909, 0.820},
        {1.7, 1, 100, 0.892, 0.805},    {2.0, 1, 100, 0, 0},
        {1.3, 0.1, 200, 0.638, 0.415}, {1.5, 0.1, 200, 0.555, 0.365},
        {1.7, 0.1, 200, 0.488, 0.320},  {2.0, 0.1, 200, 0, 0},
    };
    std::uint64_t next = seed * 100 + 50;
    for (const Jumps &jumps : all) testJumps(verdict, jumps, next++);
    return verdict.finish();
}
