// The textbook filter and smoother, straight from the formulas, in any number type: what the
// library is compared with.  Covariances in full, gains by pseudo-inverse, no economy.
//
//     Sequence sequence = ...;                                  model and measurements, in double
//     auto track = reference::filter<long double>(sequence);    one entry a step
//     auto past = reference::smooth(sequence, track);           one entry a step
//
// Real = double, long double or Quad, which is __float128 (quad.hpp).
#ifndef KALMANQ_TESTS_REFERENCE_TEXTBOOK_HPP
#define KALMANQ_TESTS_REFERENCE_TEXTBOOK_HPP

#include <Eigen/Dense>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "quad.hpp"

namespace reference
{

template <class Real> using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
template <class Real> using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

// ------------------------------------------------------------------ the data of one run

/// x[t+1] = A x[t] + B u[t] + w[t],  w ~ N(0, F F').  B is n x 0 without controls.
struct ProcessModel {
    Matrix<double> A, B, F;
    Vector<double> range = Vector<double>(); // of u, for q31 only
};

/// z = H x + v,  v ~ N(0, R).
struct SensorModel {
    Matrix<double> H, R;
    Vector<double> range = Vector<double>(); // of z, for q31 only

    bool diagonal() const { return R.isDiagonal(0); }
    Eigen::Index components() const { return H.rows(); }
};

/// One measurement, to be taken by sensor number `sensor`; bit c of `present`: component c.
struct Reading {
    std::size_t sensor;
    Vector<double> z;
    std::uint32_t present;
};

/// One time: its measurements in their order, then the process that moves it on with control u
/// (size 0: none).  The process of the last step is not used.
struct Step {
    std::vector<Reading> readings;
    std::size_t process;
    Vector<double> u;
};

/// A run: update, predict, update, ..., update.  Every number in it is a float, so that all
/// number types see the same data.  Where ranges are declared, x0, u and z are on the grids of
/// the q31 formats too.
struct Sequence {
    std::string name;
    Vector<double> x0;
    Matrix<double> P0;
    std::vector<ProcessModel> processes;
    std::vector<SensorModel> sensors;
    std::vector<Step> steps;
    Vector<double> range = Vector<double>(); // of x, for q31 only

    Eigen::Index states() const { return x0.size(); }
};

// ------------------------------------------------------------------ filter

template <class Real> struct Belief {
    Vector<Real> mean;
    Matrix<Real> covariance;
};

/// What one update yields beside the new belief.  Of the components present, in their order.
template <class Real> struct Innovation {
    Vector<Real> e;
    Matrix<Real> S, K;
    Real nis = 0, logLikelihood = 0;
    Eigen::Index rank = 0;
};

/// One step of a filter run.
template <class Real> struct Track {
    Belief<Real> predicted, filtered;
    std::vector<Innovation<Real>> updates;
};

/// A copy in another number type; evaluated here, because the cast refers to its argument.
template <class Real> Matrix<Real> convert(const Matrix<double> &M) { return M.cast<Real>(); }

template <class Real> Matrix<Real> symmetric(const Matrix<Real> &M)
{
    return (M + M.transpose()) / Real(2);
}

/// Square roots of the diagonal, 1 in place of 0: what makes a covariance dimensionless.
template <class Real> Vector<Real> scale(const Matrix<Real> &P)
{
    Vector<Real> sigma(P.rows());
    for (Eigen::Index i = 0; i < P.rows(); ++i) {
        sigma(i) = P(i, i) > Real(0) ? squareRoot(P(i, i)) : Real(1);
    }
    return sigma;
}

template <class Real> Matrix<Real> normalised(const Matrix<Real> &P, const Vector<Real> &sigma)
{
    const Vector<Real> inverse = sigma.cwiseInverse();
    return inverse.asDiagonal() * P * inverse.asDiagonal();
}

/// A generalised inverse of a covariance: the pseudo-inverse of its correlation matrix, scaled
/// back, so that the decision which pivots are zero (relative size `tolerance`) has no units.
template <class Real> Matrix<Real> generalisedInverse(const Matrix<Real> &P, const Real &tolerance)
{
    const Vector<Real> sigma = scale(P);
    Eigen::CompleteOrthogonalDecomposition<Matrix<Real>> factors(P.rows(), P.cols());
    factors.setThreshold(tolerance);
    factors.compute(normalised(P, sigma));
    const Matrix<Real> inverse = factors.pseudoInverse();
    return normalised(symmetric(inverse), sigma);
}

template <class Real>
void predict(Belief<Real> &belief, const Matrix<Real> &A, const Matrix<Real> &Q,
             const Vector<Real> &drive)
{
    belief.mean = (A * belief.mean + drive).eval();
    belief.covariance = symmetric<Real>(A * belief.covariance * A.transpose() + Q);
}

/// e, S, K, NIS and log-likelihood of the update to come.  Where S is singular (rank below m)
/// K and the NIS are those of a generalised inverse, and the log-likelihood has no meaning.
template <class Real>
Innovation<Real> innovation(const Belief<Real> &belief, const Matrix<Real> &H,
                            const Matrix<Real> &R, const Vector<Real> &z)
{
    Innovation<Real> result;
    result.e = z - H * belief.mean;
    result.S = symmetric<Real>(H * belief.covariance * H.transpose() + R);

    const Vector<Real> sigma = scale(result.S);
    const Eigen::ColPivHouseholderQR<Matrix<Real>> factors(normalised(result.S, sigma));
    const Matrix<Real> inverse = generalisedInverse(result.S, factors.threshold());
    result.rank = factors.rank();
    result.K = belief.covariance * H.transpose() * inverse;
    result.nis = result.e.dot(inverse * result.e);

    Real logDensity = result.nis;
    for (Eigen::Index i = 0; i < sigma.size(); ++i) {
        const Real pivot = magnitude<Real>(factors.matrixR()(i, i)) * sigma(i) * sigma(i);
        logDensity += logarithm<Real>(Real(2) * pi<Real>() * pivot);
    }
    result.logLikelihood = -logDensity / Real(2);
    return result;
}

/// Joseph's form, which needs no particular K to keep P positive semi-definite.
template <class Real>
Innovation<Real> update(Belief<Real> &belief, const Matrix<Real> &H, const Matrix<Real> &R,
                        const Vector<Real> &z)
{
    const Innovation<Real> result = innovation(belief, H, R, z);
    const Eigen::Index n = belief.mean.size();
    const Matrix<Real> rest = Matrix<Real>::Identity(n, n) - result.K * H;
    belief.mean += result.K * result.e;
    belief.covariance = symmetric<Real>(rest * belief.covariance * rest.transpose() +
                                        result.K * R * result.K.transpose());
    return result;
}

/// The model of a sequence in the number type of the reference.
template <class Real> struct Model {
    std::vector<Matrix<Real>> A, B, Q, H, R;

    explicit Model(const Sequence &sequence)
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

    /// B u of a step.
    Vector<Real> drive(const Step &step) const
    {
        const Eigen::Index n = A[step.process].rows();
        if (step.u.size() == 0) {
            return Vector<Real>::Zero(n);
        }
        return B[step.process] * convert<Real>(step.u);
    }
};

/// The components that are present, in their order.
inline std::vector<Eigen::Index> presentComponents(const Reading &reading)
{
    std::vector<Eigen::Index> chosen;
    for (Eigen::Index c = 0; c < reading.z.size(); ++c) {
        if ((reading.present >> c) & 1U) {
            chosen.push_back(c);
        }
    }
    return chosen;
}

/// The rows of H, R and z that a reading has.
template <class Real> struct Observation {
    Matrix<Real> H, R;
    Vector<Real> z;

    Observation(const Model<Real> &model, const Reading &reading)
    {
        const std::vector<Eigen::Index> chosen = presentComponents(reading);
        H = model.H[reading.sensor](chosen, Eigen::all);
        R = model.R[reading.sensor](chosen, chosen);
        z = convert<Real>(reading.z)(chosen, 0);
    }
};

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

/// The belief `count` steps after step t without measurements; u: l x count, or empty.
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

/// One step given all measurements.  The last three are of the move to the next step, and are
/// empty at the last one.
template <class Real> struct Smoothed {
    Belief<Real> belief;
    Matrix<Real> lagOne;          // Cov(x[t+1], x[t] | T)
    Vector<Real> noiseMean;       // E[w[t] | T]
    Matrix<Real> noiseCovariance; // Cov(w[t] | T)
};

/// Rauch, Tung and Striebel: of step t, from what is known of step t + 1.
template <class Real>
Smoothed<Real> smoothStep(const Belief<Real> &filtered, const Belief<Real> &predicted,
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

/// All steps; `tolerance` as in generalisedInverse, for a singular predicted covariance.
template <class Real>
std::vector<Smoothed<Real>> smooth(const Sequence &sequence, const std::vector<Track<Real>> &track,
                                   const Real &tolerance = Real(64) *
                                                           Eigen::NumTraits<Real>::epsilon())
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
void backThroughUpdate(Adjoint<Real> &later, const Observation<Real> &seen,
                       const Innovation<Real> &update)
{
    if (seen.z.size() == 0) return;
    const Eigen::Index n = seen.H.cols();
    const Real tolerance = Real(64) * Eigen::NumTraits<Real>::epsilon();
    const Matrix<Real> weight = seen.H.transpose() * generalisedInverse(update.S, tolerance);
    const Matrix<Real> rest = Matrix<Real>::Identity(n, n) - update.K * seen.H;
    later.gradient = (rest.transpose() * later.gradient + weight * update.e).eval();
    later.information =
        symmetric<Real>(rest.transpose() * later.information * rest + weight * seen.H);
}

/// The step before a predict; `later` is seen from after it, and then from before it.
template <class Real>
Smoothed<Real> backThroughPredict(Adjoint<Real> &later, const Matrix<Real> &A,
                                  const Matrix<Real> &Q, const Matrix<Real> &filtered,
                                  const Matrix<Real> &predicted)
{
    Smoothed<Real> result;
    result.noiseMean = Q * later.gradient;
    result.noiseCovariance = symmetric<Real>(Q - Q * later.information * Q);
    result.lagOne = (A - predicted * later.information * A) * filtered;
    later.gradient = (A.transpose() * later.gradient).eval();
    later.information = symmetric<Real>(A.transpose() * later.information * A);
    return result;
}

/// The results of smooth() without the inverse of a predicted covariance: for models where that
/// one is singular and the gain above unstable.
template <class Real>
std::vector<Smoothed<Real>> smoothWithoutInverse(const Sequence &sequence,
                                                 const std::vector<Track<Real>> &track)
{
    const Model<Real> model(sequence);
    const Eigen::Index n = sequence.states();
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

} // namespace reference

#endif
