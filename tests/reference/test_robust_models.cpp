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

std::vector<Motion> velocities()
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
    std::vector<Motion> models = velocities();
    models.push_back(acceleration("acceleration .1", 0.1));
    models.push_back(acceleration("acceleration 1", 1));
    for (const Motion &m : models) {
        const std::vector<Run> runs = drawRuns(m, World{}, 500, steps, seed);
        const double plain = rmseOf(runs, m, {"plain", Loss::none, 1});
        std::printf("   %-16s", m.name);
        for (kq_level level : {KQ_LEVEL_95, KQ_LEVEL_99, KQ_LEVEL_9999}) {
            const double closed =
                rmseOf(runs, m, {"", Loss::gate, 1, level, KQ_GATE_CLOSED}) / plain;
            const double open = rmseOf(runs, m, {"", Loss::gate, 1, level, 0}) / plain;
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
    {"plain filter", Loss::none, 1},
    {"gate, 99.99 %", Loss::gate, 1},
    {"Huber, 1.5", Loss::huber, 1.5},
    {"Huber, 3", Loss::huber, 3, KQ_LEVEL_9999, 0, 1, 1.45},
    {"Student-t, 4", Loss::student, 4, KQ_LEVEL_9999, 0, 1, 1.3},
    {"Student-t, 10", Loss::student, 10, KQ_LEVEL_9999, 0, 1, 1.45},
    {"jump, 9", Loss::jump, 9},
};

/// RMSE over that of the exact posterior mean
void compare(Verdict &verdict, const std::vector<Motion> &models, const std::vector<Sort> &sorts,
             const std::vector<Method> &methods, std::uint64_t seed)
{
    for (const Sort &sort : sorts) {
        std::printf("%s: RMSE over the exact posterior mean\n   %-18s", sort.name, "");
        std::vector<std::vector<Run>> runs;
        std::vector<double> best;
        for (const Motion &m : models) {
            std::printf(" %14s", m.name);
            runs.push_back(drawRuns(m, sort.world, 100, steps, seed));
            Exact exact(m, sort.world, sort.particles, seed + 1);
            best.push_back(
                errorsOf(runs.back(), [&](const Series &z) { return exact.filtered(z); }).rmse());
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
        {"plain filter", Loss::none, 1},
        {"plain, Q x 3", Loss::none, 1, KQ_LEVEL_9999, 0, 3},
        {"plain, Q x 9", Loss::none, 1, KQ_LEVEL_9999, 0, 9},
        {"jump, 9", Loss::jump, 9, KQ_LEVEL_9999, 0, 1, 1.3},
        {"jump, 16", Loss::jump, 16},
        {"jump, 25", Loss::jump, 25},
        {"gate, 99.99 %", Loss::gate, 1},
        {"Student-t, 10", Loss::student, 10},
    };
    const std::vector<Sort> sorts = {
        {"no jumps", {}, 1},
        {"0.2 % jumps of sd 30", {{}, {0.002, 30}, 0}, 100},
        {"2 % jumps of sd 10", {{}, {0.02, 10}, 0}, 100},
        {"2 % jumps of sd 30", {{}, {0.02, 30}, 0}, 100},
    };
    std::vector<Motion> models = velocities();
    models.insert(models.begin(), walk("walk 0.02", 0.02));
    compare(verdict, models, sorts, methods, seed);
}

// ------------------------------------------------------------------ two sensors that share noise

/// A level seen by two sensors of correlation 0.7, of which one has 10 % outliers of sd 10
class Pair
{
    using Api = kq::Api<double>;

  public:
    explicit Pair(int bad)
        : bad_(bad), told_(states_, seen(bad == 0 ? 100 : 0, bad == 1 ? 100 : 0), Noise::covariance)
    {
    }

    /// nu = 0: the plain filter; below 0: one that is told which are outliers
    double rmse(double nu, std::uint64_t seed)
    {
        kq_loss_f64 loss = {&kq_loss_student_f64, nu, nullptr, 0, 0, 0};
        Random random(seed);
        double square = 0;
        for (int k = 0; k < 300; ++k) {
            double x = random.normal();
            kq::require(filter_.init(column({0}), rows({{1}})), "filter init");
            for (int t = 0; t < steps; ++t) {
                const double shared = std::sqrt(0.7) * random.normal();
                double z[2];
                for (double &v : z) v = x + shared + std::sqrt(0.3) * random.normal();
                const bool out = random.chance(0.1);
                z[bad_] += out ? 10 * random.normal() : 0;
                if (t) kq::require(Api::predict(filter_.get(), process_.get(), nullptr), "predict");
                SensorOwner<double> &sensor = nu < 0 && out ? told_ : sensor_;
                kq::require(
                    nu > 0 ? Api::update_robust(filter_.get(), sensor.get(), z, UINT32_MAX, &loss)
                           : Api::update(filter_.get(), sensor.get(), z),
                    "update");
                const double e = Api::mean(filter_.get(), 0) - x;
                square += e * e;
                x += std::sqrt(0.1) * random.normal();
            }
        }
        return std::sqrt(square / 300 / steps);
    }

  private:
    static SensorModel seen(double first, double last) // variances of the outliers
    {
        return {rows({{1}, {1}}), rows({{1 + first, 0.7}, {0.7, 1 + last}})};
    }

    int bad_;
    Formats<double> states_{1, {}};
    ProcessOwner<double> process_{
        states_, {rows({{1}}), Matrix<double>(1, 0), rows({{std::sqrt(0.1)}})}, Noise::factor};
    SensorOwner<double> sensor_{states_, seen(0, 0), Noise::covariance}, told_;
    FilterOwner<double> filter_{states_};
};

void correlated(Verdict &verdict, std::uint64_t seed)
{
    std::printf("two sensors of correlation 0.7, one with 10 %% outliers: RMSE over that of a "
                "filter that knows which\n");
    double first = 0;
    for (int bad = 0; bad < 2; ++bad) {
        Pair pair(bad);
        const double told = pair.rmse(-1, seed);
        std::printf("   bad %s: plain %.4f", bad ? "last " : "first", pair.rmse(0, seed) / told);
        for (double nu : {4., 10.}) {
            const double ratio = pair.rmse(nu, seed) / told;
            std::printf("  Student-t, %g: %.4f", nu, ratio);
            if (bad == 0 && nu < 5) first = ratio;
            if (bad == 1 && nu < 5) verdict.expectAtMost(first, ratio, "the bad one first");
        }
        std::printf("\n");
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
    return verdict.finish();
}
