// Many steps in q31 (q31_long [SEED [STEPS]]; a million unless they are given), a third of the measurements missing: two models that forget nothing
// (no process noise, so that the errors of all steps add up) and one that does.
//
// The reference is the textbook's filter in quadruple precision: its own error is 2^-113 a step.  Beside q31, f32 on the same data.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <string>

#include "accuracy.hpp"
#include "library_run.hpp"
#include "numerics_models.hpp"
#include "verdict.hpp"

using namespace reference;

namespace
{

constexpr Mode gaps = {"30 % missing", 0.3, false};
constexpr double meanGoal = 1e-3, covarianceGoal = 2e-3;
/// Of an error from a tenth of the steps to all, and squared from a hundredth.  The square of time would be 100.
constexpr double growthGoal = 30;

/// The largest error of the second half of a hundredth, a tenth and all of the steps: one instant may be lucky.
struct Growth {
    explicit Growth(std::size_t steps) : ends{steps / 100, steps / 10, steps} {}

    std::array<std::size_t, 3> ends;
    std::array<double, 3> errors{};
    double worst = 0;

    void add(std::size_t t, double error)
    {
        worst = std::max(worst, error);
        for (std::size_t k = 0; k < ends.size(); ++k) {
            if (t < ends[k] && 2 * t >= ends[k]) errors[k] = std::max(errors[k], error);
        }
    }

    void print(const char *name) const
    {
        std::printf("   %s %7.1e %7.1e %7.1e, worst %7.1e", name, errors[0], errors[1], errors[2],
                    worst);
    }
};

/// One filter of the library.
template <class T> class Runner
{
  public:
    Runner(const Sequence &sequence, std::size_t steps) : x(steps), P(steps), run_(sequence) {}

    void update(const Step &step, const Belief<Quad> &exact, std::size_t t)
    {
        run_.update(step);
        const Belief<Wide<T>> mine = run_.belief();
        const Vector<Quad> sigma = sigmas(exact.covariance);
        x.add(t, meanError(mine.mean, exact.mean, sigma));
        P.add(t, covarianceError(mine.covariance, exact.covariance, sigma));
        eigenvalue = std::min(eigenvalue, smallestEigenvalue(mine.covariance));
        events |= run_.events();
    }

    void predict(const Step &step) { run_.predict(step); }

    void print(const std::string &model) const
    {
        std::printf("%-14s %s", model.c_str(), kq::Api<T>::name);
        x.print("x");
        P.print("P");
        std::printf("   %8.1e\n", eigenvalue);
    }

    Growth x, P;
    double eigenvalue = 1;
    unsigned events = 0;

  private:
    LibraryRun<T> run_;
};

void checkGrowth(Verdict &verdict, const Growth &growth, double goal, const std::string &name)
{
    const double least = growthGoal * std::min(growth.errors[1], growthGoal * growth.errors[0]);
    verdict.expectAtMost(growth.worst, goal, name);
    verdict.expectAtMost(growth.errors[2], least, name + " at the end, from a tenth and a hundredth");
}

void check(Verdict &verdict, const Runner<Q31> &runner, const std::string &name, Index n)
{
    verdict.expect(runner.events == 0, name + ": an event was raised");
    verdict.expectAtLeast(runner.eigenvalue, -eigenvalueRounding<Q31>(n),
                          name + ": smallest eigenvalue of P");
    checkGrowth(verdict, runner.x, meanGoal, name + ": error of x");
    checkGrowth(verdict, runner.P, covarianceGoal, name + ": error of P");
}

/// The measurements are drawn on the way: a million of them need not be kept.
void testModel(Verdict &verdict, const NumericsModel &model, std::uint64_t seed, std::size_t steps)
{
    Sequence sequence = simulate(model, gaps, 0, seed);
    sequence.sensors.push_back(model.sensor);
    Random random(seed);
    Vector<double> truth = trueStart(model, random);
    const Model<Quad> quad(sequence);
    Belief<Quad> exact{convert<Quad>(sequence.x0), convert<Quad>(sequence.P0)};
    Runner<Q31> q31(sequence, steps);
    Runner<float> f32(sequence, steps);
    for (std::size_t t = 0; t < steps; ++t) {
        const Step step{
            {drawReading(model, gaps, model.sensor, truth, random)}, 0, Vector<double>()};
        const Observation<Quad> seen(quad, step.readings[0]);
        if (seen.z.size() > 0) update(exact, seen.H, seen.R, seen.z);
        q31.update(step, exact, t);
        f32.update(step, exact, t);
        predict(exact, quad.A[0], quad.Q[0], quad.drive(step));
        q31.predict(step);
        f32.predict(step);
        truth = moved(model, truth, random);
    }
    q31.print(model.name);
    f32.print(model.name);
    check(verdict, q31, model.name, model.states());
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    const std::size_t steps = amountOf(argc, argv, 1000000);
    std::printf("seed %llu, %zu steps, %s\n", static_cast<unsigned long long>(seed), steps,
                gaps.name);
    std::printf("largest error of the second half of a hundredth, a tenth and all of the steps, and of all; smallest "
                "eigenvalue of P\n");
    Verdict verdict;
    for (const NumericsModel &model : {constantState(), straightLine(), rotation()}) {
        testModel(verdict, model, seed, steps);
    }
    return verdict.finish();
}
