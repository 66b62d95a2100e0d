// P stays positive semi-definite for 20,000 steps in f32 and q31, where the sensor is up to eight
// decades sharper than the prior: R = 1e-9 with P0 = 1e6, and R = 1e-4 with P0 = 1e8.  Beside it
// the textbook filter in float, P - K H P, and the step at which it stops being one.
//
//     test_psd_long [seed [stride]]      2: each model with one of the two settings

#include <cstdint>
#include <cstdio>
#include <iterator>
#include <string>
#include <utility>

#include "accuracy.hpp"
#include "library_run.hpp"
#include "numerics_models.hpp"
#include "verdict.hpp"

using namespace reference;

namespace
{

constexpr std::size_t stepCount = 20000;
/// A run of that length goes further than the models' ranges, which are for a tenth of it, and a
/// first velocity from two sharp positions after a vague prior is far out.
constexpr double furtherOut = 64;

struct Setting {
    const char *name;
    double r, p;
};

constexpr Setting settings[] = {{"R=1e-9 P0=1e6", 1e-9, 1e6}, {"R=1e-4 P0=1e8", 1e-4, 1e8}};

NumericsModel sharpened(NumericsModel model, const Setting &setting)
{
    model.sensor.R = rounded(
        setting.r * Matrix<double>::Identity(model.sensor.components(), model.sensor.components()));
    model.variances.setConstant(setting.p);
    return model;
}

/// The textbook's update, one component after the other: K = P h / s, P <- P - K h'P.
class Conventional
{
  public:
    explicit Conventional(const Sequence &sequence)
        : model_(sequence), belief_{sequence.x0.cast<float>(), sequence.P0.cast<float>()}
    {
    }

    void update(const Reading &reading)
    {
        for (Index c = 0; c < reading.z.size(); ++c) {
            const Vector<float> h = model_.H[reading.sensor].row(c).transpose();
            const Vector<float> Ph = belief_.covariance * h;
            const Vector<float> K = Ph / (h.dot(Ph) + model_.R[reading.sensor](c, c));
            belief_.mean += K * (static_cast<float>(reading.z(c)) - h.dot(belief_.mean));
            belief_.covariance -= K * Ph.transpose();
        }
    }

    void predict(const Step &step)
    {
        reference::predict<float>(belief_, model_.A[step.process], model_.Q[step.process],
                                  model_.drive(step));
    }

    bool isIndefinite() const
    {
        const Matrix<double> P = symmetric<double>(belief_.covariance.cast<double>());
        return !(P.diagonal().minCoeff() >= 0) ||
               smallestEigenvalue(P) < -eigenvalueRounding<float>(P.rows());
    }

  private:
    Model<float> model_;
    Belief<float> belief_;
};

/// The first step after which its P is indefinite beyond rounding, or -1.
int firstIndefiniteStep(const Sequence &sequence)
{
    Conventional filter(sequence);
    for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
        filter.update(sequence.steps[t].readings[0]);
        if (filter.isIndefinite()) return static_cast<int>(t);
        filter.predict(sequence.steps[t]);
        if (filter.isIndefinite()) return static_cast<int>(t);
    }
    return -1;
}

struct Outcome : Soundness {
    Worst all, late; // late: of the second half
    unsigned events = 0;
};

/// The reference is run beside it: 20,000 covariances need not be kept.
template <class T> Outcome runLibrary(const Sequence &sequence)
{
    const Model<Quad> model(sequence);
    Belief<Quad> exact{convert<Quad>(sequence.x0), convert<Quad>(sequence.P0)};
    LibraryRun<T> run(sequence);
    Outcome outcome;
    for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
        const Step &step = sequence.steps[t];
        const Observation<Quad> seen(model, step.readings[0]);
        update(exact, seen.H, seen.R, seen.z);
        run.update(step);
        const Belief<Wide<T>> filtered = run.belief();
        outcome.all.add(filtered, exact);
        if (2 * t >= sequence.steps.size()) outcome.late.add(filtered, exact);
        outcome.inspect(filtered, run.sigma());
        predict(exact, model.A[0], model.Q[0], model.drive(step));
        run.predict(step);
        outcome.inspect(run.belief(), run.sigma());
    }
    outcome.events = run.events();
    return outcome;
}

Sequence longRun(const NumericsModel &model, std::uint64_t seed)
{
    Sequence sequence = simulate(model, numericsModes()[0], stepCount, seed);
    sequence.range *= furtherOut;
    for (SensorModel &sensor : sequence.sensors) sensor.range *= furtherOut;
    return sequence;
}

template <class T>
void testArithmetic(Verdict &verdict, const std::string &model, const Sequence &sequence,
                    const std::string &textbook)
{
    const Outcome outcome = runLibrary<T>(sequence);
    const std::string name = model + ", " + kq::Api<T>::name;
    std::printf("%-42s %8.1e %8.1e   %8.1e %8.1e   %9.1e   %s\n", name.c_str(), outcome.all.x,
                outcome.late.x, outcome.all.P, outcome.late.P, outcome.eigenvalue,
                textbook.c_str());
    const bool isLost =
        outcome.events == KQ_EVENT_PRECISION && outcome.all.P > 0.05; /* as the event says */
    verdict.expect(outcome.sound && (outcome.events == 0 || isLost), name + ": a NaN, a negative sigma or an event");
    verdict.expectAtLeast(outcome.eigenvalue, -eigenvalueRounding<T>(sequence.states()),
                          name + ": smallest eigenvalue of P");
}

void testModel(Verdict &verdict, const char *kind, const NumericsModel &plain,
               const Setting &setting, std::uint64_t seed)
{
    const Sequence sequence = longRun(sharpened(plain, setting), seed);
    const int broken = firstIndefiniteStep(sequence);
    const std::string name = std::string(setting.name) + ", " + kind;
    testArithmetic<float>(verdict, name, sequence, broken < 0 ? "never" : std::to_string(broken));
    testArithmetic<Q31>(verdict, name, sequence, "");
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    std::printf("seed %llu, %zu steps\n", static_cast<unsigned long long>(seed), stepCount);
    std::printf("%-42s %-17s   %-17s   %9s   %s\n", "", "error of x", "error of P", "smallest",
                "textbook in float");
    std::printf("%-42s %8s %8s   %8s %8s   %9s   %s\n", "", "all", "2nd half", "all", "2nd half",
                "eigenval.", "indefinite at step");
    Verdict verdict;
    const std::pair<const char *, NumericsModel> models[] = {{"n2 CV", constantVelocity()},
                                                             {"n3 CA", constantAcceleration()},
                                                             {"n4 m2 2-D CV", planarVelocity()},
                                                             {"n4 m2 sums of states", sharpSums()}};
    const std::size_t stride = amountOf(argc, argv, 1);
    for (std::size_t s = 0; s < std::size(settings); ++s) {
        for (std::size_t m = 0; m < std::size(models); ++m) {
            if ((s + m) % stride == 0) testModel(verdict, models[m].first, models[m].second, settings[s], seed);
        }
    }
    return verdict.finish();
}
