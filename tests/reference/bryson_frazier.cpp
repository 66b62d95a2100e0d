#include "bryson_frazier.hpp"

namespace reference
{

BrysonFrazier::BrysonFrazier(const Sequence &sequence, const Taken &taken)
    : sequence_(sequence), model_(sequence)
{
    Belief<Quad> belief{convert<Quad>(sequence.x0), convert<Quad>(sequence.P0)};
    Belief<Quad> unmeasured = belief;
    for (std::size_t t = 0; t < sequence.steps.size(); ++t) {
        const Step &step = sequence.steps[t];
        Track<Quad> now;
        now.predicted = belief;
        corrections_.emplace_back();
        unmeasured_.push_back(unmeasured.covariance);
        update(belief, step, taken.empty() ? std::vector<bool>() : taken[t]);
        now.filtered = belief;
        track_.push_back(now);
        predict(belief, step);
        predict(unmeasured, step);
    }
}

std::vector<Smoothed<Quad>> BrysonFrazier::smooth() const
{
    const Index n = sequence_.states();
    Adjoint adjoint{Vector<Quad>::Zero(n), Matrix<Quad>::Zero(n, n)};
    std::vector<Smoothed<Quad>> past(track_.size());
    for (std::size_t t = track_.size(); t-- > 0;) {
        past[t].belief = smoothed(track_[t].filtered, adjoint);
        for (std::size_t k = corrections_[t].size(); k-- > 0;) {
            undoUpdate(adjoint, corrections_[t][k]);
        }
        if (t > 0) past[t - 1].lagOne = undoPredict(adjoint, t);
    }
    return past;
}

void BrysonFrazier::predict(Belief<Quad> &belief, const Step &step) const
{
    reference::predict(belief, model_.A[step.process], model_.Q[step.process],
                       model_.drive(step));
}

void BrysonFrazier::update(Belief<Quad> &belief, const Step &step, const std::vector<bool> &taken)
{
    const Vector<Quad> reach = unmeasured_.back().diagonal().eval().cwiseSqrt();
    information_.emplace_back();
    std::size_t k = 0;
    for (const Reading &reading : step.readings) {
        for (const Index c : presentComponents(reading)) {
            const Vector<Quad> h = model_.H[reading.sensor].row(c).transpose();
            const Quad r = model_.R[reading.sensor](c, c);
            const Quad s = h.dot(belief.covariance * h) + r;
            information_.back().push_back(share(s, h, reach, r));
            const bool isRedundant = r == Quad(0) && information_.back().back() <= redundant;
            const bool isTaken = taken.empty() || taken[k++];
            if (isTaken && !isRedundant) correct(belief, h, r, Quad(reading.z(c)), s);
        }
    }
}

double BrysonFrazier::share(const Quad &s, const Vector<Quad> &h, const Vector<Quad> &sigma,
                            const Quad &r)
{
    const Quad span = h.cwiseAbs().dot(sigma);
    const Quad most = span * span + r;
    return most > Quad(0) ? static_cast<double>(s / most) : 0;
}

void BrysonFrazier::correct(Belief<Quad> &belief, const Vector<Quad> &h, const Quad &r,
                            const Quad &z, const Quad &s)
{
    const Index n = belief.mean.size();
    const Vector<Quad> K = belief.covariance * h / s;
    const Quad e = z - h.dot(belief.mean);
    const Matrix<Quad> J = Matrix<Quad>::Identity(n, n) - K * h.transpose();
    belief.mean += K * e;
    belief.covariance =
        symmetric<Quad>(J * belief.covariance * J.transpose() + r * K * K.transpose());
    corrections_.back().push_back({h, K, e, s});
}

Belief<Quad> BrysonFrazier::smoothed(const Belief<Quad> &filtered, const Adjoint &adjoint)
{
    const Matrix<Quad> &P = filtered.covariance;
    return {filtered.mean + P * adjoint.lambda, symmetric<Quad>(P - P * adjoint.Lambda * P)};
}

void BrysonFrazier::undoUpdate(Adjoint &adjoint, const Correction &done)
{
    const Vector<Quad> &h = done.h;
    const Index n = h.size();
    const Matrix<Quad> J = Matrix<Quad>::Identity(n, n) - done.K * h.transpose();
    adjoint.lambda = h * (done.e / done.s) + J.transpose() * adjoint.lambda;
    adjoint.Lambda =
        symmetric<Quad>(h * h.transpose() / done.s + J.transpose() * adjoint.Lambda * J);
}

Matrix<Quad> BrysonFrazier::undoPredict(Adjoint &adjoint, std::size_t t) const
{
    const Index n = sequence_.states();
    const Matrix<Quad> &A = model_.A[sequence_.steps[t - 1].process];
    const Matrix<Quad> rest =
        Matrix<Quad>::Identity(n, n) - track_[t].predicted.covariance * adjoint.Lambda;
    const Matrix<Quad> lagOne = rest * A * track_[t - 1].filtered.covariance;
    adjoint.lambda = A.transpose() * adjoint.lambda;
    adjoint.Lambda = symmetric<Quad>(A.transpose() * adjoint.Lambda * A);
    return lagOne;
}

} // namespace reference
