#include "textbook.hpp"

#include "decompositions.hpp"

namespace reference
{

// ------------------------------------------------------------------ filter

template <class Real> Vector<Real> scale(const Matrix<Real> &P)
{
    Vector<Real> sigma(P.rows());
    for (Index i = 0; i < P.rows(); ++i) {
        sigma(i) = P(i, i) > Real(0) ? squareRoot(P(i, i)) : Real(1);
    }
    return sigma;
}

template <class Real> Matrix<Real> normalised(const Matrix<Real> &P, const Vector<Real> &sigma)
{
    const Vector<Real> inverse = sigma.cwiseInverse();
    Matrix<Real> C(P.rows(), P.cols());
    for (Index j = 0; j < P.cols(); ++j) {
        for (Index i = 0; i < P.rows(); ++i) C(i, j) = inverse(i) * P(i, j) * inverse(j);
    }
    return C;
}

/// A generalised inverse of a covariance: the pseudo-inverse of its correlation matrix, scaled
/// back, so that the decision which pivots are zero (relative size `tolerance`) has no units.
template <class Real>
static Matrix<Real> generalisedInverse(const Matrix<Real> &P, const Real &tolerance)
{
    const Vector<Real> sigma = scale(P);
    const Matrix<Real> inverse = pseudoInverse(normalised(P, sigma), tolerance).inverse;
    return normalised(symmetric(inverse), sigma);
}

template <class Real>
void predict(Belief<Real> &belief, const Matrix<Real> &A, const Matrix<Real> &Q,
             const Vector<Real> &drive)
{
    belief.mean = A * belief.mean + drive;
    belief.covariance = symmetric<Real>(A * belief.covariance * A.transpose() + Q);
}

template <class Real>
Innovation<Real> innovation(const Belief<Real> &belief, const Matrix<Real> &H,
                            const Matrix<Real> &R, const Vector<Real> &z)
{
    Innovation<Real> result;
    result.e = z - H * belief.mean;
    result.S = symmetric<Real>(H * belief.covariance * H.transpose() + R);

    const Vector<Real> sigma = scale(result.S);
    const PivotedQr<Real> factors = pivotedQr(normalised(result.S, sigma));
    const Matrix<Real> inverse = generalisedInverse(result.S, factors.threshold);
    result.rank = factors.rank;
    result.K = belief.covariance * H.transpose() * inverse;
    result.nis = result.e.dot(inverse * result.e);

    Real logDensity = result.nis;
    for (Index i = 0; i < sigma.size(); ++i) {
        const Real pivot = factors.pivots(i) * sigma(i) * sigma(i);
        logDensity += logarithm<Real>(Real(2) * pi<Real>() * pivot);
    }
    result.logLikelihood = -logDensity / Real(2);
    return result;
}

template <class Real>
Innovation<Real> update(Belief<Real> &belief, const Matrix<Real> &H, const Matrix<Real> &R,
                        const Vector<Real> &z)
{
    const Innovation<Real> result = innovation(belief, H, R, z);
    const Index n = belief.mean.size();
    const Matrix<Real> rest = Matrix<Real>::Identity(n, n) - result.K * H;
    belief.mean += result.K * result.e;
    belief.covariance = symmetric<Real>(rest * belief.covariance * rest.transpose() +
                                        result.K * R * result.K.transpose());
    return result;
}

template <class Real> Model<Real>::Model(const Sequence &sequence)
{
    for (const ProcessModel &process : sequence.processes) {
        const Matrix<Real> F = convert<Real>(process.F);
        A.push_back(convert<Real>(process.A));
        B.push_back(convert<Real>(process.B));
        Q.push_back(F * F.transpose());
    }
    for (const SensorModel &sensor : sequence.sensors) {
        H.push_back(convert<Real>(sensor.H));
        R.push_back(convert<Real>(sensor.R));
    }
}

template <class Real> Vector<Real> Model<Real>::drive(const Step &step) const
{
    if (step.u.size() == 0) return Vector<Real>::Zero(A[step.process].rows());
    return B[step.process] * convert<Real>(step.u);
}

std::vector<Index> presentComponents(const Reading &reading)
{
    std::vector<Index> chosen;
    for (Index c = 0; c < reading.z.size(); ++c) {
        if ((reading.present >> c) & 1U) {
            chosen.push_back(c);
        }
    }
    return chosen;
}

template <class Real>
Observation<Real>::Observation(const Model<Real> &model, const Reading &reading)
{
    const std::vector<Index> chosen = presentComponents(reading);
    H = model.H[reading.sensor].chooseRows(chosen);
    R = model.R[reading.sensor].choose(chosen, chosen);
    z = convert<Real>(reading.z).chooseRows(chosen);
}

template <class Real> std::vector<Track<Real>> filter(const Sequence &sequence)
{
    const Model<Real> model(sequence);
    std::vector<Track<Real>> track;
    Belief<Real> belief{convert<Real>(sequence.x0), convert<Real>(sequence.P0)};
    for (const Step &step : sequence.steps) {
        Track<Real> now;
        now.predicted = belief;
        for (const Reading &reading : step.readings) {
            const Observation<Real> seen(model, reading);
            now.updates.push_back(seen.z.size() == 0 ? Innovation<Real>{}
                                                     : update(belief, seen.H, seen.R, seen.z));
        }
        now.filtered = belief;
        track.push_back(now);
        predict(belief, model.A[step.process], model.Q[step.process], model.drive(step));
    }
    return track;
}

template <class Real>
Belief<Real> forecast(const Sequence &sequence, const Belief<Real> &filtered, std::size_t process,
                      const Matrix<double> &u, int count)
{
    const Model<Real> model(sequence);
    Belief<Real> belief = filtered;
    for (int k = 0; k < count; ++k) {
        const Vector<double> now = u.size() == 0 ? Vector<double>() : Vector<double>(u.col(k));
        predict(belief, model.A[process], model.Q[process], model.drive({{}, process, now}));
    }
    return belief;
}

// ------------------------------------------------------------------ smoother

/// Rauch, Tung and Striebel: of step t, from what is known of step t + 1.
template <class Real>
static Smoothed<Real> smoothStep(const Belief<Real> &filtered, const Belief<Real> &predicted,
                                 const Belief<Real> &later, const Matrix<Real> &A,
                                 const Vector<Real> &drive, const Real &tolerance)
{
    const Matrix<Real> G =
        filtered.covariance * A.transpose() * generalisedInverse(predicted.covariance, tolerance);
    Smoothed<Real> result;
    result.belief.mean = filtered.mean + G * (later.mean - predicted.mean);
    result.belief.covariance = symmetric<Real>(
        filtered.covariance + G * (later.covariance - predicted.covariance) * G.transpose());
    result.lagOne = later.covariance * G.transpose();
    result.noiseMean = later.mean - A * result.belief.mean - drive;
    const Matrix<Real> cross = result.lagOne * A.transpose();
    result.noiseCovariance = symmetric<Real>(later.covariance - cross - cross.transpose() +
                                             A * result.belief.covariance * A.transpose());
    return result;
}

template <class Real>
std::vector<Smoothed<Real>> smooth(const Sequence &sequence, const std::vector<Track<Real>> &track,
                                   const Real &tolerance)
{
    const Model<Real> model(sequence);
    std::vector<Smoothed<Real>> past(track.size());
    past.back().belief = track.back().filtered;
    for (std::size_t t = track.size() - 1; t-- > 0;) {
        const Step &step = sequence.steps[t];
        past[t] = smoothStep(track[t].filtered, track[t + 1].predicted, past[t + 1].belief,
                             model.A[step.process], model.drive(step), tolerance);
    }
    return past;
}

/// What the later data say about the state: gradient and information (Bryson and Frazier).
template <class Real> struct Adjoint {
    Vector<Real> gradient;
    Matrix<Real> information;
};

template <class Real>
static void backThroughUpdate(Adjoint<Real> &later, const Observation<Real> &seen,
                              const Innovation<Real> &update)
{
    if (seen.z.size() == 0) return;
    const Index n = seen.H.cols();
    const Real tolerance = Real(64) * std::numeric_limits<Real>::epsilon();
    const Matrix<Real> weight = seen.H.transpose() * generalisedInverse(update.S, tolerance);
    const Matrix<Real> rest = Matrix<Real>::Identity(n, n) - update.K * seen.H;
    later.gradient = rest.transpose() * later.gradient + weight * update.e;
    later.information =
        symmetric<Real>(rest.transpose() * later.information * rest + weight * seen.H);
}

/// The step before a predict; `later` is seen from after it, and then from before it.
template <class Real>
static Smoothed<Real> backThroughPredict(Adjoint<Real> &later, const Matrix<Real> &A,
                                         const Matrix<Real> &Q, const Matrix<Real> &filtered,
                                         const Matrix<Real> &predicted)
{
    Smoothed<Real> result;
    result.noiseMean = Q * later.gradient;
    result.noiseCovariance = symmetric<Real>(Q - Q * later.information * Q);
    result.lagOne = (A - predicted * later.information * A) * filtered;
    later.gradient = A.transpose() * later.gradient;
    later.information = symmetric<Real>(A.transpose() * later.information * A);
    return result;
}

template <class Real>
std::vector<Smoothed<Real>> smoothWithoutInverse(const Sequence &sequence,
                                                 const std::vector<Track<Real>> &track)
{
    const Model<Real> model(sequence);
    const Index n = sequence.states();
    std::vector<Smoothed<Real>> past(track.size());
    Adjoint<Real> later{Vector<Real>::Zero(n), Matrix<Real>::Zero(n, n)};
    for (std::size_t t = track.size(); t-- > 0;) {
        const Step &step = sequence.steps[t];
        const Belief<Real> &now = track[t].filtered;
        if (t + 1 < track.size()) {
            past[t] = backThroughPredict(later, model.A[step.process], model.Q[step.process],
                                         now.covariance, track[t + 1].predicted.covariance);
        }
        const Matrix<Real> &P = now.covariance;
        past[t].belief.mean = now.mean + P * later.gradient;
        past[t].belief.covariance = symmetric<Real>(P - P * later.information * P);
        for (std::size_t k = step.readings.size(); k-- > 0;) {
            const Observation<Real> seen(model, step.readings[k]);
            backThroughUpdate(later, seen, track[t].updates[k]);
        }
    }
    return past;
}

// ------------------------------------------------------------------ the number types

#define INSTANTIATE_MODEL(Real)                                                                    \
    template struct Model<Real>;                                                                   \
    template void predict(Belief<Real> &, const Matrix<Real> &, const Matrix<Real> &,              \
                          const Vector<Real> &);

#define INSTANTIATE(Real)                                                                          \
    INSTANTIATE_MODEL(Real)                                                                        \
    template struct Observation<Real>;                                                             \
    template Vector<Real> scale(const Matrix<Real> &);                                             \
    template Matrix<Real> normalised(const Matrix<Real> &, const Vector<Real> &);                  \
    template Innovation<Real> innovation(const Belief<Real> &, const Matrix<Real> &,               \
                                         const Matrix<Real> &, const Vector<Real> &);              \
    template Innovation<Real> update(Belief<Real> &, const Matrix<Real> &, const Matrix<Real> &,   \
                                     const Vector<Real> &);                                        \
    template std::vector<Track<Real>> filter(const Sequence &);                                    \
    template Belief<Real> forecast(const Sequence &, const Belief<Real> &, std::size_t,            \
                                   const Matrix<double> &, int);                                   \
    template std::vector<Smoothed<Real>> smooth(const Sequence &,                                  \
                                                const std::vector<Track<Real>> &, const Real &);   \
    template std::vector<Smoothed<Real>> smoothWithoutInverse(const Sequence &,                    \
                                                              const std::vector<Track<Real>> &);

INSTANTIATE_MODEL(float)
INSTANTIATE(double)
INSTANTIATE(long double)
INSTANTIATE(Quad)

} // namespace reference
