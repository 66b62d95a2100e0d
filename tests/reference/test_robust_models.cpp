// What the losses cost and gain with models of one to three states: the tables of tests/README.md.
//
//     test_robust_models [SEED]
#include <cstdio>
#include <string>

#include "exact_tracks.hpp"
#include "verdict.hpp"

using namespace reference;

namespace
{

constexpr int steps = 200;

std::vector<Model> velocities()
{
    return {walk("walk 0.1", 0.1),
            walk("walk 1", 1),
            velocity("velocity .001", 0.001),
            velocity("velocity .01", 0.01),
            velocity("velocity .1", 0.1),
            velocity("velocity 1", 1)};
}

// ------------------------------------------------------------------ gates on healthy data

void gates(Verdict &verdict, std::uint64_t seed)
{
    std::printf("gates where nothing is wrong, RMSE over that of the plain filter; left: closed\n");
    std::vector<Model> models = velocities();
    models.push_back(acceleration("acceleration .1", 0.1));
    models.push_back(acceleration("acceleration 1", 1));
    for (const Model &m : models) {
        const std::vector<Run> runs = drawRuns(m, World{}, 500, steps, seed);
        const double plain = rmseOf(runs, m, {"plain", Step::plain, 1});
        std::printf("   %-16s", m.name);
        for (kq_level level : {KQ_LEVEL_95, KQ_LEVEL_99, KQ_LEVEL_9999}) {
            const double closed =
                rmseOf(runs, m, {"", Step::gated, 1, level, KQ_GATE_CLOSED}) / plain;
            const double open = rmseOf(runs, m, {"", Step::gated, 1, level, 0}) / plain;
            std::printf("   %9.3f -> %6.3f", closed, open);
            const double most = level == KQ_LEVEL_9999 ? 1.6 : level == KQ_LEVEL_99 ? 20 : 60;
            verdict.expectAtMost(open, most, std::string("gate, ") + m.name);
        }
        std::printf("\n");
    }
}

// ------------------------------------------------------------------ outliers

struct Sort {
    const char *name;
    World world;
    std::size_t particles;
};

const std::vector<Method> updates = {
    {"plain filter", Step::plain, 1},   {"gate, 99.99 %", Step::gated, 1},
    {"Huber, 1.5", Step::huber, 1.5},   {"Huber, 3", Step::huber, 3, KQ_LEVEL_9999, 0, 1, 1.45},
    {"Student-t, 4", Step::student, 4, KQ_LEVEL_9999, 0, 1, 1.3},
    {"Student-t, 10", Step::student, 10, KQ_LEVEL_9999, 0, 1, 1.45},
    {"jump, 9", Step::jump, 9},
};

/// RMSE over that of the exact posterior mean
void compare(Verdict &verdict, const std::vector<Model> &models, const std::vector<Sort> &sorts,
             const std::vector<Method> &methods, std::uint64_t seed)
{
    for (const Sort &sort : sorts) {
        std::printf("%s: RMSE over the exact posterior mean\n   %-18s", sort.name, "");
        std::vector<std::vector<Run>> runs;
        std::vector<double> best;
        for (const Model &m : models) {
            std::printf(" %14s", m.name);
            runs.push_back(drawRuns(m, sort.world, 100, steps, seed));
            Exact exact(m, sort.world, sort.particles, seed + 1);
            best.push_back(rmse(runs.back(), exact));
        }
        std::printf("\n   %-18s", "exact (RMSE)");
        for (double b : best) std::printf(" %14.4f", b);
        std::printf("\n");
        for (const Method &method : methods) {
            std::printf("   %-18s", method.name);
            for (std::size_t k = 0; k < models.size(); ++k) {
                const double ratio = rmseOf(runs[k], models[k], method) / best[k];
                std::printf(" %14.4f", ratio);
                if (method.most > 0) {
                    verdict.expectAtMost(ratio, method.most,
                                         std::string(sort.name) + ", " + models[k].name);
                }
            }
            std::printf("\n");
        }
    }
}

void outliers(Verdict &verdict, std::uint64_t seed)
{
    const std::vector<Sort> sorts = {
        {"Gaussian", {}, 1},
        {"1 % outliers of sd 10", {{0.01, 10}, {}, 0}, 100},
        {"10 % outliers of sd 10", {{0.1, 10}, {}, 0}, 100},
        {"Student-t, 3 degrees", {{}, {}, 3}, 100},
    };
    compare(verdict, velocities(), sorts, updates, seed);
}

// ------------------------------------------------------------------ jumps

void jumps(Verdict &verdict, std::uint64_t seed)
{
    const std::vector<Method> methods = {
        {"plain filter", Step::plain, 1},
        {"plain, Q x 3", Step::plain, 1, KQ_LEVEL_9999, 0, 3},
        {"plain, Q x 9", Step::plain, 1, KQ_LEVEL_9999, 0, 9},
        {"jump, 9", Step::jump, 9, KQ_LEVEL_9999, 0, 1, 1.3},
        {"jump, 16", Step::jump, 16},
        {"jump, 25", Step::jump, 25},
        {"gate, 99.99 %", Step::gated, 1},
        {"Student-t, 10", Step::student, 10},
    };
    const std::vector<Sort> sorts = {
        {"no jumps", {}, 1},
        {"0.2 % jumps of sd 30", {{}, {0.002, 30}, 0}, 100},
        {"2 % jumps of sd 10", {{}, {0.02, 10}, 0}, 100},
        {"2 % jumps of sd 30", {{}, {0.02, 30}, 0}, 100},
    };
    std::vector<Model> models = velocities();
    models.insert(models.begin(), walk("walk 0.02", 0.02));
    compare(verdict, models, sorts, methods, seed);
}

// ------------------------------------------------------------------ two sensors that share noise

constexpr double level_r[] = {1, 0.7, 0.7, 1}, one[] = {1}, ones[] = {1, 1}, none[] = {0};

/// A level seen by two sensors of correlation 0.7, of which one has 10 % outliers of sd 10
class Pair
{
  public:
    explicit Pair(int bad)
    {
        const double q[] = {0.1};
        std::copy(level_r, level_r + 4, R_.begin());
        std::copy(level_r, level_r + 4, told_.begin());
        told_[std::size_t(3 * bad)] += 100;
        mustBeOk(kq_process_assign_f64(&process_, 1, 0, noise_.data(), 1));
        mustBeOk(kq_process_init_f64(&process_, one, nullptr, q));
        for (int k = 0; k < 2; ++k) {
            mustBeOk(kq_sensor_assign_f64(sensor_ + k, 1, 2, variances_[std::size_t(k)].data(), 3));
            mustBeOk(kq_sensor_init_f64(sensor_ + k, ones, k ? told_.data() : R_.data()));
        }
        mustBeOk(kq_filter_assign_f64(&filter_, 1, memory_.data(), memory_.size()));
    }

    /// nu = 0: the plain filter; below 0: one that is told which are outliers
    double rmse(double nu, int bad, std::uint64_t seed)
    {
        kq_loss_f64 loss = {&kq_loss_student_f64, nu, nullptr, 0, 0, 0};
        Random random(seed);
        double square = 0;
        for (int k = 0; k < 300; ++k) {
            double x = random.normal();
            mustBeOk(kq_filter_init_f64(&filter_, none, one));
            for (int t = 0; t < steps; ++t) {
                const double shared = std::sqrt(0.7) * random.normal();
                double z[2];
                for (double &v : z) v = x + shared + std::sqrt(0.3) * random.normal();
                const bool out = random.chance(0.1);
                z[bad] += out ? 10 * random.normal() : 0;
                mustBeOk(t ? kq_predict_f64(&filter_, &process_, nullptr) : KQ_OK);
                mustBeOk(nu > 0
                             ? kq_update_robust_f64(&filter_, sensor_, z, UINT32_MAX, &loss)
                             : kq_update_f64(&filter_, sensor_ + (nu < 0 && out), z));
                const double e = kq_mean_f64(&filter_, 0) - x;
                square += e * e;
                x += std::sqrt(0.1) * random.normal();
            }
        }
        return std::sqrt(square / 300 / steps);
    }

  private:
    std::array<double, 4> R_{}, told_{};
    std::array<double, 1> noise_{};
    std::array<std::array<double, 3>, 2> variances_{};
    std::array<double, KQ_FILTER_LEN_F64(1)> memory_{};
    kq_process_f64 process_{};
    kq_sensor_f64 sensor_[2]{};
    kq_filter_f64 filter_{};
};

void correlated(Verdict &verdict, std::uint64_t seed)
{
    std::printf("two sensors of correlation 0.7, one with 10 %% outliers: RMSE over that of a "
                "filter that knows which\n");
    double first = 0;
    for (int bad = 0; bad < 2; ++bad) {
        Pair pair(bad);
        const double told = pair.rmse(-1, bad, seed);
        std::printf("   bad %s: plain %.4f", bad ? "last " : "first",
                    pair.rmse(0, bad, seed) / told);
        for (double nu : {4., 10.}) {
            const double ratio = pair.rmse(nu, bad, seed) / told;
            std::printf("  Student-t, %g: %.4f", nu, ratio);
            if (bad == 0 && nu < 5) first = ratio;
            if (bad == 1 && nu < 5) verdict.expectAtMost(first, ratio, "the bad one first");
        }
        std::printf("\n");
    }
}

// ------------------------------------------------------------------ a wrong prior

void wrongPrior(std::uint64_t seed)
{
    std::printf("x0 off by 100 sd: RMSE of the first three steps\n");
    for (const Model &m : {walk("walk 0.1", 0.1), velocity("velocity .01", 0.01)}) {
        std::vector<Run> runs;
        Random random(seed);
        for (int k = 0; k < 200; ++k) runs.push_back(draw(m, World{}, 3, random, 100));
        for (const Method &method :
             {Method{"plain filter", Step::plain, 1}, Method{"jump, 9", Step::jump, 9},
              Method{"gate", Step::gated, 1}}) {
            Track track(m, method);
            std::array<double, 3> square{};
            for (const Run &run : runs) {
                const Series x = track.filtered(run.z);
                for (std::size_t t = 0; t < 3; ++t) {
                    const double e = x[t] - run.truth[t];
                    square[t] += e * e / double(runs.size());
                }
            }
            std::printf("   %-14s %-18s %8.2f %8.2f %8.2f\n", m.name, method.name,
                        std::sqrt(square[0]), std::sqrt(square[1]), std::sqrt(square[2]));
        }
    }
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    Verdict verdict;
    gates(verdict, seed * 1000);
    outliers(verdict, seed * 1000 + 1);
    jumps(verdict, seed * 1000 + 2);
    correlated(verdict, seed * 1000 + 3);
    wrongPrior(seed * 1000 + 4);
    return verdict.finish();
}
