// The textbook filter and smoother, straight from the formulas, in any number type: what the
// library is compared with.  Covariances in full, gains by pseudo-inverse, no economy.
//
//     Sequence sequence = ...;                                  model and measurements, in double
//     auto track = reference::filter<long double>(sequence);    one entry a step
//     auto past = reference::smooth(sequence, track);           one entry a step
//
// Real = double, long double or Quad, which is __float128 (quad.hpp): textbook.cpp compiles these
// three.  Model and predict() are there for float, too.
#ifndef KALMANQ_TESTS_REFERENCE_TEXTBOOK_HPP
#define KALMANQ_TESTS_REFERENCE_TEXTBOOK_HPP

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "matrix.hpp"
#include "quad.hpp"

namespace reference
{

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

    bool diagonal() const { return R.isDiagonal(); }
    Index components() const { return H.rows(); }
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

    Index states() const { return x0.size(); }
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
    Index rank = 0;
};

/// One step of a filter run.
template <class Real> struct Track {
    Belief<Real> predicted, filtered;
    std::vector<Innovation<Real>> updates;
};

template <class Real> Matrix<Real> convert(const Matrix<double> &M) { return M.cast<Real>(); }

template <class Real> Matrix<Real> symmetric(const Matrix<Real> &M)
{
    return (M + M.transpose()) / Real(2);
}

/// Square roots of the diagonal, 1 in place of 0: what makes a covariance dimensionless.
template <class Real> Vector<Real> scale(const Matrix<Real> &P);

/// P_ij / (sigma_i sigma_j)
template <class Real> Matrix<Real> normalised(const Matrix<Real> &P, const Vector<Real> &sigma);

template <class Real>
void predict(Belief<Real> &belief, const Matrix<Real> &A, const Matrix<Real> &Q,
             const Vector<Real> &drive);

/// e, S, K, NIS and log-likelihood of the update to come.  Where S is singular (rank below m)
/// K and the NIS are those of a generalised inverse, and the log-likelihood has no meaning.
template <class Real>
Innovation<Real> innovation(const Belief<Real> &belief, const Matrix<Real> &H,
                            const Matrix<Real> &R, const Vector<Real> &z);

/// Joseph's form, which needs no particular K to keep P positive semi-definite.
template <class Real>
Innovation<Real> update(Belief<Real> &belief, const Matrix<Real> &H, const Matrix<Real> &R,
                        const Vector<Real> &z);

/// The model of a sequence in the number type of the reference.
template <class Real> struct Model {
    std::vector<Matrix<Real>> A, B, Q, H, R;

    explicit Model(const Sequence &sequence);

    /// B u of a step.
    Vector<Real> drive(const Step &step) const;
};

/// The components that are present, in their order.
std::vector<Index> presentComponents(const Reading &reading);

/// The rows of H, R and z that a reading has.
template <class Real> struct Observation {
    Matrix<Real> H, R;
    Vector<Real> z;

    Observation(const Model<Real> &model, const Reading &reading);
};

template <class Real> std::vector<Track<Real>> filter(const Sequence &sequence);

/// The belief `count` steps after step t without measurements; u: l x count, or empty.
template <class Real>
Belief<Real> forecast(const Sequence &sequence, const Belief<Real> &filtered, std::size_t process,
                      const Matrix<double> &u, int count);

// ------------------------------------------------------------------ smoother

/// One step given all measurements.  The last three are of the move to the next step, and are
/// empty at the last one.
template <class Real> struct Smoothed {
    Belief<Real> belief;
    Matrix<Real> lagOne;          // Cov(x[t+1], x[t] | T)
    Vector<Real> noiseMean;       // E[w[t] | T]
    Matrix<Real> noiseCovariance; // Cov(w[t] | T)
};

/// All steps; pivots of a singular predicted covariance below `tolerance` of the largest are 0.
template <class Real>
std::vector<Smoothed<Real>> smooth(const Sequence &sequence, const std::vector<Track<Real>> &track,
                                   const Real &tolerance = Real(64) *
                                                           std::numeric_limits<Real>::epsilon());

/// The results of smooth() without the inverse of a predicted covariance: for models where that
/// one is singular and the gain above unstable.
template <class Real>
std::vector<Smoothed<Real>> smoothWithoutInverse(const Sequence &sequence,
                                                 const std::vector<Track<Real>> &track);

} // namespace reference

#endif
