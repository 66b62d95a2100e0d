// Tracks of one to three states that are seen through their position, r = 1, and the library's
// filters of them.
#ifndef KALMANQ_TESTS_REFERENCE_TRACKS_HPP
#define KALMANQ_TESTS_REFERENCE_TRACKS_HPP

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "kalmanq/kalmanq.h"
#include "random.hpp"

namespace reference
{

using Three = std::array<double, 3>;
using Nine = std::array<double, 9>;
using Series = std::vector<double>;

struct Model {
    const char *name;
    int n;
    Nine A, Q; // n x n
};

inline Model walk(const char *name, double q) { return {name, 1, {1}, {q}}; }

inline Model velocity(const char *name, double q)
{
    return {name, 2, {1, 1, 0, 1}, {q / 3, q / 2, q / 2, q}};
}

inline Model acceleration(const char *name, double q)
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

inline void mustBeOk(int status)
{
    if (status) std::abort();
}

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

inline double drawMeasurementVariance(Random &random, const World &world)
{
    if (world.freedom) {
        double square = 0;
        for (int k = 0; k < world.freedom; ++k) {
            const double v = random.normal();
            square += v * v;
        }
        return world.freedom / square;
    }
    const double scale = drawScale(random, world.outliers);
    return scale * scale;
}

/// From N(start, I); the first measurement is of the first state.
inline Run draw(const Model &m, const World &world, int steps, Random &random, double start = 0)
{
    Run run;
    const Nine L = lowerRoot(m.Q, m.n);
    Three x{};
    for (int i = 0; i < m.n; ++i) x[std::size_t(i)] = random.normal();
    x[0] += start;
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

enum class Step { plain, gated, huber, student, jump };

struct Method {
    const char *name;
    Step step;
    double parameter;               // k, nu, g
    kq_level level = KQ_LEVEL_9999; // of a gate,
    std::uint16_t run = 0;          // and how many rejections it bears
    double moreNoise = 1;           // what the filter's Q is times the model's
    double most = 0;                // limit of its error over the best; 0: none
};

/// The library's filter of a model, in double
class Track
{
  public:
    Track(const Model &m, const Method &method) : method_(method), n_(m.n)
    {
        Nine Q = m.Q;
        for (double &q : Q) q *= method.moreNoise;
        const std::array<double, 3> H = {1, 0, 0};
        const double r = 1;
        mustBeOk(kq_process_assign_f64(&process_, n_, 0, noise_.data(), KQ_PROCESS_LEN(3)));
        mustBeOk(kq_sensor_assign_f64(&sensor_, n_, 1, &variance_, 1));
        mustBeOk(kq_filter_assign_f64(&filter_, n_, memory_.data(), memory_.size()));
        A_ = m.A;
        H_ = H;
        mustBeOk(kq_process_init_f64(&process_, A_.data(), nullptr, Q.data()));
        mustBeOk(kq_sensor_init_f64(&sensor_, H_.data(), &r));
    }

    Series filtered(const Series &z)
    {
        Series x;
        Nine P0{};
        const Three x0{};
        for (int i = 0; i < n_; ++i) P0[std::size_t(i * n_ + i)] = 1;
        mustBeOk(kq_filter_init_f64(&filter_, x0.data(), P0.data()));
        loss_ = {kindOf(method_.step), method_.parameter, nullptr, kq_chi_square_limit_f64(1, method_.level),
                 method_.run, 0};
        for (std::size_t t = 0; t < z.size(); ++t) {
            mustBeOk(take(&z[t], t > 0));
            x.push_back(kq_mean_f64(&filter_, 0));
        }
        return x;
    }

  private:
    kq_status take(const double *z, bool moves)
    {
        if (moves) mustBeOk(kq_predict_f64(&filter_, &process_, nullptr));
        if (method_.step == Step::plain) return kq_update_f64(&filter_, &sensor_, z);
        return kq_update_robust_f64(&filter_, &sensor_, z, 1, &loss_);
    }

    static const kq_loss_kind_f64 *kindOf(Step step)
    {
        switch (step) {
        case Step::gated: return &kq_loss_gate_f64;
        case Step::huber: return &kq_loss_huber_f64;
        case Step::student: return &kq_loss_student_f64;
        default: return &kq_loss_jump_f64;
        }
    }

    Method method_;
    int n_;
    Nine A_{};
    Three H_{};
    std::array<double, KQ_PROCESS_LEN(3)> noise_{};
    std::array<double, KQ_FILTER_LEN_F64(3)> memory_{};
    double variance_ = 0;
    kq_process_f64 process_{};
    kq_sensor_f64 sensor_{};
    kq_filter_f64 filter_{};
    kq_loss_f64 loss_{};
};

/// Of all steps of all runs
class MeanSquare
{
  public:
    void add(const Series &truth, const Series &estimate)
    {
        for (std::size_t t = 0; t < truth.size(); ++t) {
            const double e = estimate[t] - truth[t];
            sum_ += e * e;
        }
        count_ += double(truth.size());
    }

    double root() const { return std::sqrt(sum_ / count_); }

  private:
    double sum_ = 0, count_ = 0;
};

/// Root mean square error of any estimator with filtered(z)
template <class Estimator> double rmse(const std::vector<Run> &runs, Estimator &estimator)
{
    MeanSquare square;
    for (const Run &run : runs) square.add(run.truth, estimator.filtered(run.z));
    return square.root();
}

inline double rmseOf(const std::vector<Run> &runs, const Model &m, const Method &method)
{
    Track track(m, method);
    return rmse(runs, track);
}

inline std::vector<Run> drawRuns(const Model &m, const World &world, int count, int steps,
                                 std::uint64_t seed)
{
    Random random(seed);
    std::vector<Run> runs;
    for (int k = 0; k < count; ++k) runs.push_back(draw(m, world, steps, random));
    return runs;
}

} // namespace reference

#endif
