// q31 beside the filter that fixed point code usually has: Q16.16, the covariance itself carried, one scalar after the
// other (tests/reference/q16_filter.h).  Both against a textbook filter in quadruple precision, over three seeds of 2000 steps.
//
// x: max over time of |x - x_ref|_i / sigma_i,  P: max of |P - P_ref|_ij / (sigma_i sigma_j).

#include <cmath>
#include <cstdint>
#include <cstdio>

#include "accuracy.hpp"
#include "library_run.hpp"
#include "numerics_models.hpp"
#include "verdict.hpp"

extern "C" {
#include "q16_filter.h"
}

using namespace reference;

namespace
{

constexpr std::size_t stepCount = 2000;
constexpr double negative = -1e-6; // an eigenvalue that is no rounding
constexpr double fixedMeanGoal = 1e-5;
constexpr Mode plain = {"plain", 0, false};

// ------------------------------------------------------------------ Q16.16

std::int32_t narrow(double a) { return static_cast<std::int32_t>(std::floor(a * 65536 + 0.5)); }

void fill(std::int32_t *to, const Matrix<double> &M)
{
    for (Index i = 0; i < M.rows(); ++i) {
        for (Index j = 0; j < M.cols(); ++j) *to++ = narrow(M(i, j));
    }
}

struct Narrow {
    q16_filter f{};
    q16_process p{};
    q16_sensor s{};

    explicit Narrow(const Sequence &sequence)
    {
        const SensorModel &sensor = sequence.sensors[0];
        const Matrix<double> &F = sequence.processes[0].F;
        f.n = p.n = s.n = static_cast<int>(sequence.states());
        s.m = static_cast<int>(sensor.components());
        fill(f.x, sequence.x0);
        fill(f.P, sequence.P0);
        fill(p.A, sequence.processes[0].A);
        fill(p.Q, F * F.transpose());
        fill(s.H, sensor.H);
        fill(s.R, sensor.R.diagonal());
    }
    void update(const Reading &reading)
    {
        std::int32_t z[Q16_COMPONENTS];
        fill(z, reading.z);
        q16_update(&f, &s, z);
    }
    Belief<double> belief() const
    {
        Belief<double> made{Vector<double>(f.n), Matrix<double>(f.n, f.n)};
        for (Index i = 0; i < f.n; ++i) {
            made.mean(i) = std::ldexp(f.x[i], -16);
            for (Index j = 0; j < f.n; ++j) made.covariance(i, j) = std::ldexp(f.P[i * f.n + j], -16);
        }
        return made;
    }
};

// ------------------------------------------------------------------ both

struct Figures : Worst {
    int indefinite = 0; // steps

    template <class Real> void compare(const Belief<Real> &mine, const Belief<Quad> &exact)
    {
        add(mine, exact);
        indefinite += smallestEigenvalue(mine.covariance.template cast<Quad>(), exact.covariance) < negative;
    }
};

void testModel(Verdict &verdict, const NumericsModel &model, std::uint64_t seed)
{
    const Sequence sequence = simulate(model, plain, stepCount, seed);
    const std::vector<Track<Quad>> exact = filter<Quad>(sequence);
    LibraryRun<Q31> run(sequence);
    Narrow other(sequence);
    Figures q31, q16;
    for (std::size_t t = 0; t < stepCount; ++t) {
        const Step &step = sequence.steps[t];
        run.update(step);
        other.update(step.readings[0]);
        q31.compare(run.belief(), exact[t].filtered);
        q16.compare(other.belief(), exact[t].filtered);
        run.predict(step);
        q16_predict(&other.f, &other.p);
    }
    std::printf("%-14s seed %llu   q31 %8.1e %8.1e   Q16.16 %8.1e %8.1e, P indefinite in %d steps\n", model.name.c_str(),
                static_cast<unsigned long long>(seed), q31.x, q31.P, q16.x, q16.P, q16.indefinite);
    verdict.expectAtMost(q31.x, fixedMeanGoal, model.name + ": error of x");
    verdict.expectAtMost(q31.x, q16.x / 1000, model.name + ": error of x beside Q16.16");
    verdict.expectAtMost(q31.P, q16.P / 1000, model.name + ": error of P beside Q16.16");
    verdict.expect(q31.indefinite == 0, model.name + ": P is not semi-definite");
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t first = seedOf(argc, argv);
    Verdict verdict;
    for (std::uint64_t seed = first; seed < first + 3; ++seed) {
        for (const NumericsModel &model : {constantVelocity(), planarVelocity(), inertialBias()}) testModel(verdict, model, seed);
    }
    return verdict.finish();
}
