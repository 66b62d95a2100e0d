// The filter on fourteen models, in four modes each, against a textbook filter in quadruple
// precision and beside a UD filter in float: f32, f64 and q31, which see the same measurements.
//
// x: max over time of |x - x_ref|_i / sigma_ref_i,  P: max of |P - P_ref|_ij / (sigma_i sigma_j).

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "accuracy.hpp"
#include "library_run.hpp"
#include "numerics_models.hpp"
#include "ud.hpp"
#include "verdict.hpp"

using namespace reference;

namespace
{

constexpr double meanGoal = 1e-4;
/// Where the UD filter is off by more than this, the library has to be ten times better.
constexpr double visibleError = 1e-3;
/// Errors of P below it are rounding in both filters, and not compared.
constexpr double covarianceFloor = 1e-6;

/// In q31, of the ordinary models: x in sigma, and beside UD.  The states of the dense model are
/// a few sigmas, so that UD loses little in a word of 24 bits.
constexpr double fixedMeanGoal = 1e-5, fixedAdvantage = 50, fixedAdvantageDense = 5;
/// In q31, of all runs: (error of x with UD) / (error of x).
constexpr double medianAdvantage = 1000, leastAdvantage = 1;
/// Where both errors of P are below it, neither filter is called the better one.
constexpr double fixedCovarianceFloor = 1e-7;

/// Rows of S that nearly cancel in what is measured: 24 bits of S, not of the mean, limit the
/// gain.  There the goal beside UD is out of reach, and the limit is UD's own error.  A single run
/// is decided by the last bits of both: the medians of several are compared.
constexpr int runsOfLimited = 5;

bool isLimitedByRoot(const NumericsModel &model)
{
    return model.name == "n3 near-singular" || model.name == "n4 m2 R=1e-9 P0=1e6";
}

struct Figures : Worst, Soundness {
    unsigned events = 0;
};

template <class T>
Figures runLibrary(const Sequence &sequence, const std::vector<Track<Quad>> &exact)
{
    Figures figures;
    LibraryRun<T> run(sequence);
    for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
        run.update(sequence.steps[t]);
        const Belief<Wide<T>> filtered = run.belief();
        figures.add(filtered, exact[t].filtered);
        figures.inspect(filtered, run.sigma());
        run.predict(sequence.steps[t]);
        figures.inspect(run.belief(), run.sigma());
    }
    figures.events = run.events();
    return figures;
}

void update(UdFilter &filter, const SensorModel &sensor, const Reading &reading)
{
    for (const Index c : presentComponents(reading)) {
        filter.update(sensor.H.row(c).transpose().cast<float>(), static_cast<float>(sensor.R(c, c)),
                      static_cast<float>(reading.z(c)));
    }
}

Figures runUd(const Sequence &sequence, const std::vector<Track<Quad>> &exact)
{
    Figures figures;
    UdFilter filter(sequence.x0.cast<float>(), sequence.P0.diagonal().cast<float>());
    const Matrix<float> A = sequence.processes[0].A.cast<float>();
    const Matrix<float> F = sequence.processes[0].F.cast<float>();
    for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
        for (const Reading &reading : sequence.steps[t].readings) {
            update(filter, sequence.sensors[reading.sensor], reading);
        }
        figures.add<double>({filter.mean(), filter.covariance()}, exact[t].filtered);
        filter.predict(A, F);
    }
    return figures;
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

/// Errors of x in f32 and with UD, those of this run being given: medians with further runs
void takeMedians(Figures &f32, Figures &ud, const NumericsModel &model, const Mode &mode,
                 std::uint64_t seed, std::size_t steps)
{
    std::vector<double> mine = {f32.x}, other = {ud.x};
    for (int k = 1; k < runsOfLimited; ++k) {
        const Sequence sequence = simulate(model, mode, steps, seed + static_cast<unsigned>(k));
        const std::vector<Track<Quad>> exact = filter<Quad>(sequence);
        mine.push_back(runLibrary<float>(sequence, exact).x);
        other.push_back(runUd(sequence, exact).x);
    }
    f32.x = median(mine);
    ud.x = median(other);
}

void checkSound(Verdict &verdict, const Figures &figures, const std::string &name, double slack)
{
    verdict.expect(figures.sound, name + ": a NaN or a negative sigma");
    // where R varies a measurement beside far better ones may say less than the root's last bits
    verdict.expect((figures.events & ~static_cast<unsigned>(KQ_EVENT_PRECISION)) == 0,
                   name + ": an event was raised");
    verdict.expectAtLeast(figures.eigenvalue, -slack, name + ": smallest eigenvalue of P");
}

void checkAccuracy(Verdict &verdict, const Figures &mine, const Figures &ud,
                   const NumericsModel &model, const std::string &name)
{
    if (model.ordinary) {
        verdict.expectAtMost(mine.x, meanGoal, name + ": error of x");
        verdict.expectAtMost(mine.P, std::max(4 * ud.P, covarianceFloor), name + ": error of P");
    }
    if (ud.x > visibleError) {
        verdict.expectGoal(mine.x, ud.x / 10, isLimitedByRoot(model) ? ud.x : 0,
                           name + ": error of x beside UD");
    }
}

void checkFixed(Verdict &verdict, const Figures &mine, const Figures &ud,
                const NumericsModel &model, const std::string &name)
{
    const double advantage = model.name == "n6 m3 dense" ? fixedAdvantageDense : fixedAdvantage;
    verdict.expectAtMost(mine.x, fixedMeanGoal, name + ": error of x");
    verdict.expectAtMost(mine.x, ud.x / advantage, name + ": error of x beside UD");
    if (mine.P > ud.P && std::max(mine.P, ud.P) < fixedCovarianceFloor) {
        std::printf("both below %.0e  %s: error of P %.3g, UD %.3g\n", fixedCovarianceFloor,
                    name.c_str(), mine.P, ud.P);
        return;
    }
    verdict.expectAtMost(mine.P, ud.P, name + ": error of P beside UD");
}

/// The advantage of q31 over UD in x.
double testRun(Verdict &verdict, const NumericsModel &model, const Mode &mode, std::uint64_t seed, std::size_t steps)
{
    const Sequence sequence = simulate(model, mode, steps, seed);
    const std::vector<Track<Quad>> exact = filter<Quad>(sequence);
    Figures f32 = runLibrary<float>(sequence, exact);
    const Figures f64 = runLibrary<double>(sequence, exact);
    const Figures q31 = runLibrary<Q31>(sequence, exact);
    Figures ud = runUd(sequence, exact);
    const double advantage = ud.x / q31.x;
    if (isLimitedByRoot(model)) takeMedians(f32, ud, model, mode, seed, steps);
    std::printf("%-22s %-13s %8.1e %8.1e %8.1e %8.1e   %8.1e %8.1e %8.1e %8.1e   %8.1e %8.1e\n",
                model.name.c_str(), mode.name, f32.x, f64.x, q31.x, ud.x, f32.P, f64.P, q31.P, ud.P,
                f32.eigenvalue, q31.eigenvalue);
    const Index n = model.states();
    checkSound(verdict, f32, sequence.name + ", f32", eigenvalueRounding<float>(n));
    checkSound(verdict, f64, sequence.name + ", f64", eigenvalueRounding<double>(n));
    checkSound(verdict, q31, sequence.name + ", q31", eigenvalueRounding<Q31>(n));
    checkAccuracy(verdict, f32, ud, model, sequence.name);
    if (model.ordinary) checkFixed(verdict, q31, ud, model, sequence.name + ", q31");
    return advantage;
}

void checkAdvantage(Verdict &verdict, std::vector<double> advantages)
{
    std::sort(advantages.begin(), advantages.end());
    const double middle = median(advantages), least = advantages.front();
    std::printf("error of x, UD over q31, %zu runs: median %.0f, least %.2g, most %.2g\n",
                advantages.size(), middle, least, advantages.back());
    verdict.expectAtLeast(middle, medianAdvantage, "q31: median advantage over UD in x");
    verdict.expectAtLeast(least, leastAdvantage, "q31: least advantage over UD in x");
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    const std::size_t steps = amountOf(argc, argv, 2000);
    std::printf("seed %llu, %zu steps; errors of P below %.0e count as rounding\n",
                static_cast<unsigned long long>(seed), steps, covarianceFloor);
    std::printf("%-36s %-35s   %-35s   %s\n", "", "error of x in sigma", "error of P",
                "smallest eigenvalue");
    std::printf("%-22s %-13s %8s %8s %8s %8s   %8s %8s %8s %8s   %8s %8s\n", "model", "mode", "f32",
                "f64", "q31", "UD f32", "f32", "f64", "q31", "UD f32", "f32", "q31");
    Verdict verdict;
    std::vector<double> advantages;
    for (const NumericsModel &model : numericsModels()) {
        for (const Mode &mode : numericsModes()) {
            advantages.push_back(testRun(verdict, model, mode, seed, steps));
        }
    }
    checkAdvantage(verdict, advantages);
    return verdict.finish();
}
