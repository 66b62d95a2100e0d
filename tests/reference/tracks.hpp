// Motions of one to three states that are seen through their position, r = 1, and the library's
// filters and smoothers of them, with the losses of robust.h.
#ifndef KALMANQ_TESTS_REFERENCE_TRACKS_HPP
#define KALMANQ_TESTS_REFERENCE_TRACKS_HPP

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

#include "api.hpp"
#include "owners.hpp"
#include "random.hpp"
#include "readings.hpp"

namespace reference
{

using Three = std::array<double, 3>;
using Nine = std::array<double, 9>;
using Series = std::vector<double>;

struct Motion {
    const char *name;
    int n;
    Nine A, Q;               // n x n
    double p0 = 1;           // variance of each state at the start
    bool movesFirst = false; // before the first measurement
};

inline Motion walk(const char *name, double q) { return {name, 1, {1}, {q}}; }

inline Motion velocity(const char *name, double q)
{
    return {name, 2, {1, 1, 0, 1}, {q / 3, q / 2, q / 2, q}};
}

inline Motion acceleration(const char *name, double q)
{
    const Nine Q = {q / 20, q / 8, q / 6, q / 8, q / 3, q / 2, q / 6, q / 2, q};
    return {name, 3, {1, 1, 0.5, 0, 1, 1, 0, 0, 1}, Q};
}

/// With probability `share`, a standard deviation `times` as large
struct Mixture {
    double share = 0, times = 1;
};

/// The noises of measurement and state; freedom > 0: a Student-t measurement noise
struct World {
    Mixture outliers, jumps;
    int freedom = 0;
};

struct Run {
    Series truth, z;
};

inline Nine lowerRoot(const Nine &Q, int n)
{
    Nine L{};
    for (int j = 0; j < n; ++j) {
        for (int i = j; i < n; ++i) {
            double s = Q[std::size_t(i * n + j)];
            for (int k = 0; k < j; ++k) s -= L[std::size_t(i * n + k)] * L[std::size_t(j * n + k)];
            L[std::size_t(i * n + j)] = i == j ? std::sqrt(s) : s / L[std::size_t(j * n + j)];
        }
    }
    return L;
}

/// a <- A a
inline Three times(const Nine &A, const Three &a, int n)
{
    Three out{};
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            out[std::size_t(i)] += A[std::size_t(i * n + j)] * a[std::size_t(j)];
        }
    }
    return out;
}

inline double drawScale(Random &random, const Mixture &mixture)
{
    return mixture.share > 0 && random.chance(mixture.share) ? mixture.times : 1;
}

/// Of so many degrees of freedom, divided by their number
inline double drawChiSquare(Random &random, int freedom)
{
    double square = 0;
    for (int k = 0; k < freedom; ++k) {
        const double v = random.normal();
        square += v * v;
    }
    return square / freedom;
}

inline double drawMeasurementVariance(Random &random, const World &world)
{
    if (world.freedom) return 1 / drawChiSquare(random, world.freedom);
    const double scale = drawScale(random, world.outliers);
    return scale * scale;
}

/// From N(0, I); the first measurement is of the first state.
inline Run draw(const Motion &m, const World &world, int steps, Random &random)
{
    Run run;
    const Nine L = lowerRoot(m.Q, m.n);
    Three x{};
    for (int i = 0; i < m.n; ++i) x[std::size_t(i)] = random.normal();
    for (int t = 0; t < steps; ++t) {
        run.truth.push_back(x[0]);
        const double r = drawMeasurementVariance(random, world);
        run.z.push_back(x[0] + std::sqrt(r) * random.normal());
        Three e{};
        for (int i = 0; i < m.n; ++i) e[std::size_t(i)] = random.normal();
        const Three w = times(L, e, m.n);
        const double scale = drawScale(random, world.jumps);
        x = times(m.A, x, m.n);
        for (int i = 0; i < m.n; ++i) x[std::size_t(i)] += scale * w[std::size_t(i)];
    }
    return run;
}

// ------------------------------------------------------------------ filters and smoothers

enum class Loss { none, gate, huber, student, jump };

struct Method {
    const char *name;
    Loss loss;
    double parameter;               // k, nu, g
    kq_level level = KQ_LEVEL_9999; // of a gate,
    std::uint16_t run = 0;          // and how many rejections it bears
    double moreNoise = 1;           // what the filter's Q is times the model's
    double most = 0;                // limit of its error over the best; 0: none
};

/// n x n
inline Matrix<double> matrixOf(const Nine &entries, int n)
{
    Matrix<double> M(n, n);
    for (Index k = 0; k < n * n; ++k) M(k / n, k % n) = entries[std::size_t(k)];
    return M;
}

/// The library's filter of a motion, and its smoothers of so many steps
template <class T> class Follower : NotCopied
{
    using Api = kq::Api<T>;

  public:
    explicit Follower(const Motion &m, double moreNoise = 1, std::size_t steps = 0)
        : motion_(m), states_(m.n, Vector<double>::Constant(m.n, range)),
          process_(states_, model(m, moreNoise), Noise::factor),
          scaled_(states_, model(m, moreNoise), Noise::factor),
          sensor_(states_,
                  {Matrix<double>::Identity(1, m.n), Matrix<double>::Ones(1),
                   Vector<double>::Constant(1, range)},
                  Noise::diagonal),
          filter_(states_), history_(states_, 1, steps + 1, steps + 1), weights_(steps),
          scaledRoot_(rootLength(m.n))
    {
    }

    /// The position at each step
    Series filtered(const Series &z, const Method &method)
    {
        Series x;
        begin();
        loss_ = {};
        loss_.kind = kindOf(method.loss);
        loss_.parameter = Api::number(method.parameter);
        loss_.limit = Api::chi_square_limit(1, method.level);
        loss_.run = method.run;
        for (std::size_t t = 0; t < z.size(); ++t) {
            if (t > 0 || motion_.movesFirst) {
                kq::require(Api::predict(filter_.get(), process_.get(), nullptr), "predict");
            }
            update(z[t], method.loss);
            x.push_back(position(*filter_.get()));
        }
        return x;
    }

    /// `passes` of filter and smoother, from q = first everywhere; of a motion that moves first
    Series smoothed(const Series &z, double nu, double first, int passes)
    {
        std::fill(weights_.begin(), weights_.end(), Api::number(first));
        for (int k = 0; k < passes; ++k) {
            record(z, [this](std::size_t t) {
                kq::require(scaleNoise(weights_[t]), "scale noise");
                return scaled_.get();
            });
            kq::require(smoothReweighted(Api::number(nu)), "smooth reweighted");
        }
        return readSmoothed(z.size());
    }

    Series smoothedPlainly(const Series &z)
    {
        record(z, [this](std::size_t) { return process_.get(); });
        kq::require(Api::smooth(history_.get()), "smooth");
        return readSmoothed(z.size());
    }

    /// What this arithmetic has of measurements
    Series inWords(Series z) const
    {
        const Formats<T> &seen = sensor_.components();
        for (double &entry : z) entry = static_cast<double>(seen.value(0, seen.word(0, entry)));
        return z;
    }

  private:
    /// q31: words of 2^-7
    static constexpr double range = INT32_MAX * 0x1p-7;

    static ProcessModel model(const Motion &m, double moreNoise)
    {
        Nine Q = m.Q;
        for (double &q : Q) q *= moreNoise;
        return {matrixOf(m.A, m.n), Matrix<double>(m.n, 0), matrixOf(lowerRoot(Q, m.n), m.n)};
    }

    static auto kindOf(Loss loss)
    {
        switch (loss) {
        case Loss::gate: return Api::gate;
        case Loss::huber: return Api::huber;
        case Loss::student: return Api::student;
        default: return Api::jump;
        }
    }

    void begin()
    {
        const Matrix<double> P0 = motion_.p0 * Matrix<double>::Identity(motion_.n, motion_.n);
        kq::require(filter_.init(Vector<double>::Zero(motion_.n), P0), "filter init");
    }

    void update(double z, Loss loss)
    {
        const auto word = sensor_.components().word(0, z);
        kq::require(loss == Loss::none
                        ? Api::update(filter_.get(), sensor_.get(), &word)
                        : Api::update_robust(filter_.get(), sensor_.get(), &word, 1, &loss_),
                    "update");
    }

    template <class Choose> void record(const Series &z, const Choose &process)
    {
        begin();
        kq::require(Api::attach(filter_.get(), &history_.get()->attached), "attach");
        for (std::size_t t = 0; t < z.size(); ++t) {
            kq::require(Api::predict(filter_.get(), process(t), nullptr), "predict");
            update(z[t], Loss::none);
        }
    }

    /// Behind each predict
    Series readSmoothed(std::size_t steps) const
    {
        Series x;
        for (std::size_t t = 1; t <= steps; ++t) x.push_back(position(viewSmoothed(history_, t)));
        return x;
    }

    double position(const typename Api::Filter &f) const
    {
        return static_cast<double>(states_.value(0, Api::mean(&f, 0), Api::mean_low(&f, 0)));
    }

    kq_status scaleNoise(typename Api::Coefficient q)
    {
        if constexpr (std::is_same_v<T, Q31>) {
            return kq_process_scale_noise_q31(scaled_.get(), process_.get(), scaledRoot_.data(), q);
        } else {
            return Api::process_scale_noise(scaled_.get(), process_.get(), q);
        }
    }

    kq_status smoothReweighted(typename Api::Coefficient nu)
    {
        if constexpr (std::is_same_v<T, Q31>) {
            return kq_smooth_reweighted_q31(history_.get(), scaled_.get(), process_.get(),
                                            scaledRoot_.data(), nu, weights_.data());
        } else {
            return Api::smooth_reweighted(history_.get(), scaled_.get(), process_.get(), nu,
                                          weights_.data());
        }
    }

    Motion motion_;
    Formats<T> states_;
    ProcessOwner<T> process_, scaled_;
    SensorOwner<T> sensor_;
    FilterOwner<T> filter_;
    HistoryOwner<T> history_;
    typename Api::Loss loss_{};
    std::vector<typename Api::Coefficient> weights_;
    std::vector<std::int32_t> scaledRoot_; // q31's
};

// ------------------------------------------------------------------ errors

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

using Estimator = std::function<Series(const Series &)>;

inline Errors errorsOf(const std::vector<Run> &runs, const Estimator &estimator)
{
    Errors errors;
    for (const Run &run : runs) errors.add(run.truth, estimator(run.z));
    return errors;
}

template <class T>
Errors filterErrors(const std::vector<Run> &runs, const Motion &m, const Method &method)
{
    Follower<T> follower(m, method.moreNoise);
    return errorsOf(runs, [&](const Series &z) { return follower.filtered(z, method); });
}

inline double rmseOf(const std::vector<Run> &runs, const Motion &m, const Method &method)
{
    return filterErrors<double>(runs, m, method).rmse();
}

inline std::vector<Run> drawRuns(const Motion &m, const World &world, int count, int steps,
                                 std::uint64_t seed)
{
    Random random(seed);
    std::vector<Run> runs;
    for (int k = 0; k < count; ++k) runs.push_back(draw(m, world, steps, random));
    return runs;
}

} // namespace reference

#endif
