#include "bryson_frazier.hpp"

#include <utility>

namespace reference
{

/// The share below which the rounding of quadruple precision may have made it up.
constexpr double redundant = 1e-30;

BrysonFrazier::BrysonFrazier(const Sequence &sequence, const Taken &taken) : sequence_(sequence), model_(sequence)
{
    Belief<Quad> belief{convert<Quad>(sequence.x0), convert<Quad>(sequence.P0)};
    Belief<Quad> unmeasured = belief;
    for (std::size_t t = 0; t < sequence_.steps.size(); ++t) {
        Step &step = sequence_.steps[t];
        Track<Quad> now;
        now.predicted = now.filtered = belief;
        unmeasured_.push_back(unmeasured.covariance);
        update(now, step, taken.empty() ? std::vector<bool>() : taken[t]);
        belief = now.filtered;
        track_.push_back(std::move(now));
        for (Belief<Quad> *one : {&belief, &unmeasured}) {
            predict(*one, model_.A[step.process], model_.Q[step.process], model_.drive(step));
        }
    }
}

/// s as a share of the largest that sigma allows.
static double share(const Quad &s, const Vector<Quad> &h, const Vector<Quad> &sigma, const Quad &r)
{
    const Quad span = h.cwiseAbs().dot(sigma);
    const Quad most = span * span + r;
    return most > Quad(0) ? static_cast<double>(s / most) : 0;
}

void BrysonFrazier::update(Track<Quad> &now, Step &step, const std::vector<bool> &taken)
{
    const Vector<Quad> reach = unmeasured_.back().diagonal().cwiseSqrt();
    const std::vector<Reading> readings = std::exchange(step.readings, {});
    std::size_t k = 0;
    for (const Reading &reading : readings) {
        for (const Index c : presentComponents(reading)) {
            Reading one = reading;
            one.present = UINT32_C(1) << c;
            const Observation<Quad> seen(model_, one);
            const Vector<Quad> h = seen.H.row(0).transpose();
            const Quad r = seen.R(0, 0), s = h.dot(now.filtered.covariance * h) + r;
            const bool isRedundant = r == Quad(0) && share(s, h, reach, r) <= redundant;
            const bool isTaken = taken.empty() || taken[k++];
            if (!isTaken || isRedundant) continue;
            now.updates.push_back(reference::update(now.filtered, seen.H, seen.R, seen.z));
            step.readings.push_back(one);
        }
    }
}

} // namespace reference
