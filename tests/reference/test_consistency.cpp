// How often the statistics of consistency are within their bounds: 95 % of the time if the model
// is right; and how often a wrong one shows.  Windows do not overlap.
//
//     test_consistency [SEED]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "owners.hpp"
#include "plants.hpp"
#include "verdict.hpp"

using namespace reference;

namespace
{

template <class T> typename kq::Api<T>::Score scoreOf(double q) { return static_cast<T>(q); }
template <> std::int64_t scoreOf<Q31>(double q) { return std::llround(q * 0x1p24); }

/// What the filter's model has wrong: its Q and R are the plant's times these; a bias of the first
/// component in sigmas of its noise.
struct Fault {
    const char *name;
    double q, r, bias;
};

// ------------------------------------------------------------------ shares of windows

/// Shares of windows whose statistic is outside of its 95 % bounds
struct Outside {
    double low = 0, high = 0, mean = 0, correlation = 0, any = 0;
};

template <class T> class Watch
{
    using Api = kq::Api<T>;
    using Score = typename Api::Score;

  public:
    Watch(int m, int window) : m_(m), memory_(Api::length(KQ_OBJECT_CONSISTENCY, 0, m, static_cast<std::size_t>(window)))
    {
        kq::require(Api::consistency_assign(&handle_, m, window, memory_.data(), memory_.size()),
                    "consistency assign");
    }

    void update(FilterOwner<T> &filter, SensorOwner<T> &sensor, const Vector<double> &z,
                std::uint32_t present)
    {
        const auto words = sensor.components().words(z);
        kq::require(
            Api::consistency_watch(&handle_, filter.get(), sensor.get(), words.data(), present),
            "watch");
        kq::require(Api::update_subset(filter.get(), sensor.get(), words.data(), present),
                    "update");
        kq::require(Api::consistency_record(&handle_, filter.get()), "record");
    }

    /// Of the window as it is; then it begins anew.
    void count(Outside &outside)
    {
        Score nis, low, high, mean, reach, correlation, spread;
        const Score q = scoreOf<T>(1.96);
        kq::require(Api::consistency_nis(&handle_, q, &nis, &low, &high), "nis");
        bool any = nis < low || nis > high;
        outside.low += nis < low;
        outside.high += nis > high;
        for (int c = 0; c < m_; ++c) {
            kq::require(
                Api::consistency_innovation(&handle_, c, q, &mean, &reach, &correlation, &spread),
                "innovation");
            const bool biased = mean < -reach || mean > reach;
            const bool coloured = correlation < -spread || correlation > spread;
            outside.mean += biased / static_cast<double>(m_);
            outside.correlation += coloured / static_cast<double>(m_);
            any = any || biased || coloured;
        }
        outside.any += any;
        kq::require(Api::consistency_clear(&handle_), "clear");
    }

  private:
    int m_;
    std::vector<typename Api::Word> memory_;
    typename Api::Consistency handle_{};
};

template <class T>
Outside run(Plant plant, const Fault &fault, int window, int windows, std::uint64_t seed)
{
    const Index n = plant.states(), m = plant.components();
    const Formats<T> states(n, Vector<double>::Constant(n, plantRange));
    ProcessOwner<T> process(
        states, ProcessModel{plant.A, Matrix<double>(n, 0), std::sqrt(fault.q) * plant.F},
        Noise::factor);
    SensorOwner<T> sensor(
        states, SensorModel{plant.H, fault.r * plant.R, Vector<double>::Constant(m, plantRange)},
        Noise::diagonal);
    FilterOwner<T> filter(states);
    const Matrix<double> P0 = 0x1p-10 * Matrix<double>::Identity(n, n);
    kq::require(filter.init(Vector<double>::Zero(n), P0), "filter init");
    plant.bias = fault.bias;
    Watch<T> watch(static_cast<int>(m), window);
    Simulation simulation(plant, seed);
    Outside outside;
    for (int k = -window; k < windows * window; ++k) { // the first window is to settle
        const std::uint32_t present = simulation.present();
        watch.update(filter, sensor, simulation.measure(), present);
        simulation.advance();
        kq::require(kq::Api<T>::predict(filter.get(), process.get(), nullptr), "predict");
        if ((k + 1) % window != 0) continue;
        Outside of_this;
        watch.count(k < 0 ? of_this : outside);
    }
    for (double *share :
         {&outside.low, &outside.high, &outside.mean, &outside.correlation, &outside.any}) {
        *share /= windows;
    }
    return outside;
}

void print(const char *arithmetic, const Plant &plant, int window, const Fault &fault,
           const Outside &outside)
{
    std::printf("%s  %-18s W %3d  %-10s outside, %%: NIS below %5.1f above %5.1f  mean %5.1f  "
                "correlation %5.1f  any %5.1f\n",
                arithmetic, plant.name.c_str(), window, fault.name, 100 * outside.low,
                100 * outside.high, 100 * outside.mean, 100 * outside.correlation,
                100 * outside.any);
}

// ------------------------------------------------------------------ what is expected

constexpr double grid = 0x1p-10;

Plant level()
{
    return {"local level", rows({{1}}), rows({{0.5}}), rows({{1}}), rows({{1}}), 0, grid};
}

/// Position and velocity in two dimensions; the velocities die away, or the positions would leave
/// q31's ranges
Plant motion()
{
    return {"2-D velocity",
            rows({{1, 1, 0, 0}, {0, 0.875, 0, 0}, {0, 0, 1, 1}, {0, 0, 0, 0.875}}),
            rows({{0.25, 0}, {0.5, 0}, {0, 0.25}, {0, 0.5}}),
            rows({{1, 0, 0, 0}, {0, 0, 1, 0}}),
            rows({{1, 0}, {0, 4}}),
            0,
            grid};
}

/// One level, two sensors: a bias of a single one would be taken for the level's.
Plant twins()
{
    return {"two sensors",
            rows({{1}}),
            rows({{0.5}}),
            rows({{1}, {1}}),
            Matrix<double>::Identity(2, 2),
            0,
            grid};
}

/// Half of each component is missing, so that a quarter of its pairs is left.
Plant gaps(Plant plant)
{
    plant.name = plant.components() > 1 ? "2-D, half missing" : "half missing";
    plant.lost = 0.5;
    return plant;
}

/// A share of `windows` independent ones whose expectation is `expected`: within 4 sigma
void expectShare(Verdict &verdict, double share, double expected, double windows,
                 const std::string &what)
{
    const double reach = 4 * std::sqrt(expected * (1 - expected) / windows);
    verdict.expectAtMost(std::abs(share - expected), reach, what + ", share");
}

template <class T> void rightModel(Verdict &verdict, const Plant &plant, std::uint64_t seed)
{
    static const Fault none = {"right", 1, 1, 0};
    const int windows = 800;
    for (int window : {50, 200}) {
        const Outside outside = run<T>(plant, none, window, windows, seed);
        print(kq::Api<T>::name, plant, window, none, outside);
        const std::string what = std::string(kq::Api<T>::name) + ", " + plant.name + ", W " +
                                 std::to_string(window) + ", ";
        const double independent = windows * static_cast<double>(plant.components());
        expectShare(verdict, outside.low, 0.025, windows, what + "NIS below");
        expectShare(verdict, outside.high, 0.025, windows, what + "NIS above");
        expectShare(verdict, outside.mean, 0.05, independent, what + "mean");
        expectShare(verdict, outside.correlation, 0.05, independent, what + "correlation");
    }
}

/// Shares of 100 windows that a fault shows in: of 200 updates, nearly all
template <class T>
void fault(Verdict &verdict, const Plant &plant, const Fault &wrong, std::uint64_t seed)
{
    for (int window : {50, 200}) {
        const Outside outside = run<T>(plant, wrong, window, 100, seed);
        print(kq::Api<T>::name, plant, window, wrong, outside);
        if (window < 200) continue;
        const std::string what = std::string(kq::Api<T>::name) + ", " + plant.name + ", " +
                                 wrong.name + ", shares that show it";
        const double shown = wrong.bias > 0 ? outside.mean : std::max(outside.low, outside.high);
        verdict.expectAtLeast(shown, 0.75, what);
    }
}

template <class T> void wrongModels(Verdict &verdict, const Plant &plant, std::uint64_t seed)
{
    fault<T>(verdict, plant, {"Q x 4", 4, 1, 0}, seed);
    fault<T>(verdict, plant, {"Q / 4", 0.25, 1, 0}, seed);
    fault<T>(verdict, plant, {"R x 4", 1, 4, 0}, seed);
    fault<T>(verdict, plant, {"R / 4", 1, 0.25, 0}, seed);
}

/// What a mean of nu outside of its bound does not tell: a bias that the state takes up does not
/// show, and a Q that is far too small does.
template <class T> void meansThatMislead(Verdict &verdict, std::uint64_t seed)
{
    for (const Fault &wrong : {Fault{"biased", 1, 1, 1}, Fault{"Q / 10", 0.1, 1, 0}}) {
        for (int window : {50, 200}) {
            const Outside outside = run<T>(level(), wrong, window, 400, seed);
            print(kq::Api<T>::name, level(), window, wrong, outside);
            if (wrong.bias > 0) verdict.expectAtMost(outside.mean, 0.1, "a bias that is taken up");
            else verdict.expectAtLeast(outside.mean, 0.15, "a small Q shows in the mean, too");
        }
    }
}

template <class T> void all(Verdict &verdict, std::uint64_t seed)
{
    for (const Plant &plant : {level(), motion()}) {
        rightModel<T>(verdict, plant, seed);
        wrongModels<T>(verdict, plant, seed + 1);
    }
    rightModel<T>(verdict, twins(), seed);
    rightModel<T>(verdict, gaps(level()), seed);
    rightModel<T>(verdict, gaps(motion()), seed);
    fault<T>(verdict, twins(), {"biased", 1, 1, 1}, seed + 1);
    meansThatMislead<T>(verdict, seed + 2);
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    Verdict verdict;
    all<float>(verdict, seed);
    all<double>(verdict, seed);
    all<Q31>(verdict, seed);
    return verdict.finish();
}
