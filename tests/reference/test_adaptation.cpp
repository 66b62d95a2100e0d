// The adaptation of the noise scales on simulated data: how many updates until the scales are those
// of the plant, how far they wander when they are, and that the three arithmetics learn the same.
//
//     test_adaptation [SEED [STRIDE]]      2: each second plant in double, and each second kind of outliers
//     test_adaptation SEED long            the table of adaptation.h, in some minutes
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "owners.hpp"
#include "plants.hpp"
#include "verdict.hpp"

using namespace reference;

namespace
{

/// With its memory, which in q31 has a root, too
template <class T> struct Adaptation : NotCopied {
    using Api = kq::Api<T>;

    typename Api::Adaptation object{};
    std::vector<typename Api::Coefficient> memory;
    std::vector<std::int32_t> root;

    Adaptation(int n, int m) : memory(Api::length(KQ_OBJECT_ADAPTATION, n, m)), root(rootLength(n))
    {
        if constexpr (std::is_same_v<T, Q31>) {
            kq::require(
                kq_adaptation_assign_q31(&object, n, m, memory.data(), memory.size(), root.data()),
                "assign");
        } else {
            kq::require(Api::adaptation_assign(&object, n, m, memory.data(), memory.size()),
                        "assign");
        }
    }
};

// ------------------------------------------------------------------ the plants

Plant level(double q)
{
    char name[32];
    std::snprintf(name, sizeof name, "level, Q/R %g", q);
    return {name, rows({{1}}), rows({{std::sqrt(q)}}), rows({{1}}), rows({{1}})};
}

/// A velocity that lasts 100 steps, seen through its position
Plant velocity(double lost)
{
    return {lost > 0 ? "velocity, 20 % lost" : "velocity",
            rows({{1, 0.125}, {0, 0.99}}),
            rows({{0.0225}, {0.36}}),
            rows({{1, 0}}),
            rows({{0.0625}}),
            lost};
}

Plant alternating()
{
    Plant plant = level(0.5);
    plant.name = "AR(1), -0.9";
    plant.A = rows({{-0.9}});
    return plant;
}

Plant two(double lost)
{
    const double shared = lost > 0 ? 0.5 : 0;
    return {lost > 0 ? "two, correlated, 20 % lost" : "two states, two sensors",
            rows({{0.95, 0.1}, {0, 0.9}}),
            rows({{0.3, 0}, {0, 0.6}}),
            rows({{1, 0}, {0.5, 1}}),
            rows({{0.25, shared}, {shared, 4}}),
            lost};
}

// ------------------------------------------------------------------ a run

/// The scales that the adaptation is to find: the filter is given Q / q and R / r.
struct Truth {
    double q, r;
};

struct Rule {
    kq_adapted scales;
    int memory;
};

/// log of (scale / true scale), of q and of r
using Errors = std::array<double, 2>;

template <class T> class Run
{
    using Api = kq::Api<T>;

  public:
    Run(const Plant &plant, const Truth &truth, const Rule &rule, std::uint64_t seed)
        : truth_(truth),
          states_(plant.states(), Vector<double>::Constant(plant.states(), plantRange)),
          process_(states_,
                   ProcessModel{plant.A, Matrix<double>(plant.states(), 0),
                                plant.F / std::sqrt(truth.q)},
                   Noise::factor),
          sensor_(states_,
                  SensorModel{plant.H, plant.R / truth.r,
                              Vector<double>::Constant(plant.components(), plantRange)},
                  Noise::covariance),
          filter_(states_), simulation_(plant, seed),
          tool_(static_cast<int>(plant.states()), static_cast<int>(plant.components()))
    {
        const Index n = plant.states();
        const auto number = Api::number;
        kq::require(filter_.init(Vector<double>::Zero(n), 16 * Matrix<double>::Identity(n, n)),
                    "filter init");
        const typename Api::Rule of{rule.scales,     rule.memory,    number(0.1),
                                     number(0x1p-10), number(0x1p10), number(0x1p-10),
                                     number(0x1p10)};
        kq::require(Api::adaptation_init(&tool_.object, process_.get(), sensor_.get(), &of), "init");
        kq::require(Api::attach(filter_.get(), &tool_.object.attached), "attach");
    }

    void step()
    {
        const auto z = sensor_.components().words(simulation_.measure());
        kq::require(Api::update_subset(filter_.get(), sensor_.get(), z.data(),
                                             simulation_.present()),
                    "update");
        kq::require(Api::predict(filter_.get(), process_.get(), nullptr), "predict");
        simulation_.advance();
    }

    Errors errors() const
    {
        typename Api::Coefficient q{}, r{};
        kq::require(Api::adaptation_scales(&tool_.object, &q, &r), "scales");
        return {std::log(Api::value(q) / truth_.q), std::log(Api::value(r) / truth_.r)};
    }

  private:
    Truth truth_;
    Formats<T> states_;
    ProcessOwner<T> process_;
    SensorOwner<T> sensor_;
    FilterOwner<T> filter_;
    Simulation simulation_;
    Adaptation<T> tool_;
};

// ------------------------------------------------------------------ how soon

constexpr int every = 10; // updates between two looks

double median(std::vector<double> values)
{
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Updates until the medians of both scales over the runs are within 1.25 of the truth for good
template <class T>
int settled(const Plant &plant, const Truth &truth, const Rule &rule, int updates, int runs,
            std::uint64_t seed)
{
    const std::size_t looks = static_cast<std::size_t>(updates / every);
    std::vector<std::vector<double>> q(looks), r(looks);
    for (int k = 0; k < runs; ++k) {
        Run<T> run(plant, truth, rule, seed + static_cast<std::uint64_t>(k));
        for (std::size_t look = 0; look < looks; ++look) {
            for (int t = 0; t < every; ++t) run.step();
            const Errors errors = run.errors();
            q[look].push_back(errors[0]);
            r[look].push_back(errors[1]);
        }
    }
    std::size_t last = looks;
    const double reach = std::log(1.25);
    while (last > 0 && std::abs(median(q[last - 1])) <= reach &&
           std::abs(median(r[last - 1])) <= reach) {
        --last;
    }
    return static_cast<int>(last + 1) * every;
}

/// Of all starts in which one or both scales are wrong by the factor, those of them that `scales`
/// leaves to be learnt
template <class T>
int settledFrom(double factor, const Plant &plant, const Rule &rule, int updates, int runs,
                std::uint64_t seed)
{
    int worst = 0;
    for (double q : {1 / factor, 1.0, factor}) {
        for (double r : {1 / factor, 1.0, factor}) {
            if (q == 1 && r == 1) continue;
            if (rule.scales == KQ_ADAPT_PROCESS && r != 1) continue;
            if (rule.scales == KQ_ADAPT_SENSOR && q != 1) continue;
            worst = std::max(worst, settled<T>(plant, {q, r}, rule, updates, runs, seed));
        }
    }
    return worst;
}

// ------------------------------------------------------------------ how well

struct Spread {
    Errors bias, deviation, largest; // largest: bias of a tenth of the run, any of them
};

template <class T>
Spread spread(const Plant &plant, const Rule &rule, int updates, int seeds, std::uint64_t seed)
{
    Errors sum{}, squares{}, largest{};
    const int settling = 5 * rule.memory, part = updates / 10;
    for (int k = 0; k < seeds; ++k) {
        Run<T> run(plant, {1, 1}, rule, seed + static_cast<std::uint64_t>(k));
        Errors tenth{};
        for (int t = 0; t < settling; ++t) run.step();
        for (int t = 0; t < updates; ++t) {
            run.step();
            const Errors errors = run.errors();
            for (std::size_t i = 0; i < 2; ++i) {
                sum[i] += errors[i];
                squares[i] += errors[i] * errors[i];
                tenth[i] += errors[i] / part;
                if ((t + 1) % part != 0) continue;
                largest[i] = std::max(largest[i], std::abs(tenth[i]));
                tenth[i] = 0;
            }
        }
    }
    Spread result;
    const double count = static_cast<double>(updates) * seeds;
    for (std::size_t i = 0; i < 2; ++i) {
        result.bias[i] = sum[i] / count;
        result.deviation[i] = std::sqrt(squares[i] / count - result.bias[i] * result.bias[i]);
    }
    result.largest = largest;
    return result;
}

// ------------------------------------------------------------------ what is expected

/// Limits for M = 200: updates until the scales are found from 4, spread of log q and log r
struct Expected {
    Plant plant;
    int from4;
    Errors deviation;
};

std::vector<Expected> expectations()
{
    return {{level(0.01), 2000, {0.35, 0.1}},   {level(0.1), 1200, {0.26, 0.1}},
            {level(1), 1000, {0.19, 0.17}},     {velocity(0), 900, {0.24, 0.1}},
            {velocity(0.2), 1000, {0.24, 0.1}}, {alternating(), 900, {0.21, 0.14}},
            {two(0), 700, {0.19, 0.09}},        {two(0.2), 700, {0.2, 0.1}}};
}

template <class T>
void finds(Verdict &verdict, const Plant &plant, const Rule &rule, double factor, int limit,
           int runs, std::uint64_t seed)
{
    const int updates = settledFrom<T>(factor, plant, rule, limit + limit / 2, runs, seed);
    std::printf("%s  %-26s M %4d  %s  from %2g: %5d updates\n", kq::Api<T>::name,
                plant.name.c_str(), rule.memory,
                rule.scales == KQ_ADAPT_BOTH      ? "q and r"
                : rule.scales == KQ_ADAPT_PROCESS ? "q only "
                                                  : "r only ",
                factor, updates);
    verdict.expectAtMost(updates, limit, std::string(kq::Api<T>::name) + ", " + plant.name);
}

/// The right model: no tenth of 100,000 updates of three runs is off by more than two spreads
template <class T>
void stays(Verdict &verdict, const Plant &plant, const Errors &limit, std::uint64_t seed)
{
    const Spread s = spread<T>(plant, {KQ_ADAPT_BOTH, 200}, 100000, 3, seed);
    std::printf("%s  %-26s M  200  right model: bias %+.3f %+.3f  spread %.3f %.3f  "
                "worst tenth %.3f %.3f\n",
                kq::Api<T>::name, plant.name.c_str(), s.bias[0], s.bias[1], s.deviation[0],
                s.deviation[1], s.largest[0], s.largest[1]);
    const std::string what = std::string(kq::Api<T>::name) + ", " + plant.name + ", ";
    for (std::size_t i = 0; i < 2; ++i) {
        verdict.expectAtMost(s.deviation[i], limit[i], what + "spread");
        verdict.expectAtMost(std::abs(s.bias[i]), limit[i] / 3, what + "bias");
        verdict.expectAtMost(s.largest[i], limit[i], what + "worst tenth");
    }
}

/// The other arithmetics learn what double learns, all along a run.
template <class T> void agrees(Verdict &verdict, double limit, std::uint64_t seed)
{
    for (const Plant &plant : {velocity(0), two(0.2)}) {
        Run<double> exact(plant, {4, 0.25}, {KQ_ADAPT_BOTH, 200}, seed);
        Run<T> run(plant, {4, 0.25}, {KQ_ADAPT_BOTH, 200}, seed);
        double worst = 0;
        for (int t = 0; t < 3000; ++t) {
            exact.step();
            run.step();
            const Errors a = exact.errors(), b = run.errors();
            for (std::size_t i = 0; i < 2; ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
        }
        std::printf("%s  %-26s log of the scales beside f64's: %.2e\n", kq::Api<T>::name,
                    plant.name.c_str(), worst);
        verdict.expectAtMost(worst, limit, std::string(kq::Api<T>::name) + ", " + plant.name);
    }
}

/// K is nearly 1: q is found, and r stays within its limits, wherever it is.
void cannotTell(Verdict &verdict, std::uint64_t seed)
{
    const Spread s = spread<double>(level(10), {KQ_ADAPT_BOTH, 200}, 100000, 3, seed);
    std::printf("f64  %-26s M  200  right model: bias %+.3f %+.3f  spread %.3f %.3f\n",
                level(10).name.c_str(), s.bias[0], s.bias[1], s.deviation[0], s.deviation[1]);
    verdict.expectAtMost(s.deviation[0], 0.13, "Q far above R, spread of q");
    verdict.expectAtMost(std::abs(s.bias[0]), 0.05, "Q far above R, bias of q");
    verdict.expectAtMost(s.deviation[1], 0.5, "Q far above R, spread of r");
    finds<double>(verdict, level(10), {KQ_ADAPT_PROCESS, 200}, 16, 600, 100, seed);
}

/// Outliers are taken for a larger r, and count as 4 sigma: seldom ones do little.
void outliers(Verdict &verdict, Plant plant, double share, double limit, std::uint64_t seed)
{
    plant.wild = share;
    const Spread s = spread<double>(plant, {KQ_ADAPT_BOTH, 200}, 100000, 1, seed);
    std::printf("f64  %-26s M  200  %2g %% outliers of sd 10: bias %+.3f %+.3f\n",
                plant.name.c_str(), 100 * share, s.bias[0], s.bias[1]);
    verdict.expectAtMost(std::abs(s.bias[0]), limit, "outliers, q");
    verdict.expectAtMost(std::abs(s.bias[1]), limit, "outliers, r");
}

struct Wild {
    Plant plant;
    double share, limit;
};

std::vector<Wild> wilds()
{
    return {{level(0.01), 0.01, 0.45}, {level(0.1), 0.01, 0.25},   {level(1), 0.01, 0.25},
            {velocity(0), 0.01, 0.34}, {two(0), 0.01, 0.25},
            {level(0.1), 0.1, std::log(10.9)}}; // what their variance is
}

void checks(Verdict &verdict, std::uint64_t seed, std::size_t stride)
{
    const Rule both{KQ_ADAPT_BOTH, 200};
    const std::vector<Expected> expected = expectations();
    for (std::size_t k = 0; k < expected.size(); k += stride) {
        finds<double>(verdict, expected[k].plant, both, 4, expected[k].from4, 100, seed);
        stays<double>(verdict, expected[k].plant, expected[k].deviation, seed);
    }
    for (const Plant &plant : {level(0.1), velocity(0)}) {
        finds<double>(verdict, plant, both, 16, 2200, 100, seed);
        finds<double>(verdict, plant, {KQ_ADAPT_PROCESS, 200}, 16, 1000, 100, seed);
        finds<double>(verdict, plant, {KQ_ADAPT_SENSOR, 200}, 16, 600, 100, seed);
    }
    cannotTell(verdict, seed);
    const std::vector<Wild> wild = wilds();
    for (std::size_t k = stride - 1; k < wild.size(); k += stride) {
        outliers(verdict, wild[k].plant, wild[k].share, wild[k].limit, seed);
    }
    finds<float>(verdict, velocity(0), both, 4, 900, 100, seed);
    stays<float>(verdict, velocity(0), {0.24, 0.1}, seed);
    finds<Q31>(verdict, velocity(0), both, 4, 900, 10, seed);
    stays<Q31>(verdict, velocity(0), {0.24, 0.1}, seed);
    agrees<float>(verdict, 1e-4, seed);
    agrees<Q31>(verdict, 1e-6, seed);
}

void table(std::uint64_t seed)
{
    for (const Plant &plant : {level(0.01), level(0.1), level(1), level(10), velocity(0),
                               velocity(0.2), alternating(), two(0), two(0.2)}) {
        for (int memory : {50, 200, 1000}) {
            const Rule rule{KQ_ADAPT_BOTH, memory};
            const Spread s = spread<double>(plant, rule, 100000, 4, seed);
            std::printf("%-26s M %4d  from 4: %5d  from 16: %5d  bias %+.3f %+.3f  spread %.3f "
                        "%.3f\n",
                        plant.name.c_str(), memory,
                        settledFrom<double>(4, plant, rule, 6000, 100, seed),
                        settledFrom<double>(16, plant, rule, 8000, 100, seed), s.bias[0], s.bias[1],
                        s.deviation[0], s.deviation[1]);
            std::fflush(stdout);
        }
    }
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    if (argc > 2 && std::strcmp(argv[2], "long") == 0) {
        table(seed);
        return 0;
    }
    Verdict verdict;
    checks(verdict, seed, amountOf(argc, argv, 1));
    return verdict.finish();
}
