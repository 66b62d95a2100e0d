// Fourteen models that a filter in 32 bits has to get right, from a local level to covariances
// that fall by fifteen decades, and runs drawn from them.
//
// Every number is a float and every measurement lies on a grid of 2^-23 of its range, which is a
// power of two: all arithmetics see the same data.  The process noise is given by its factor, so
// that all have the same Q.
#ifndef KALMANQ_TESTS_REFERENCE_NUMERICS_MODELS_HPP
#define KALMANQ_TESTS_REFERENCE_NUMERICS_MODELS_HPP

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "random.hpp"
#include "textbook.hpp"

namespace reference
{

struct NumericsModel {
    std::string name;
    bool ordinary; // one that no filter has an excuse for
    ProcessModel process;
    SensorModel sensor;
    Vector<double> x0, variances; // P0 is diagonal
    Vector<double> reach;         // of the state: what the run stays within, powers of two
    Vector<double> range;         // of the measurement: 2^23 grid points

    Index states() const { return x0.size(); }
};

/// Matrices and ranges of a model as they come; the constructor of everything below.
NumericsModel makeModel(std::string name, const Matrix<double> &A, const Matrix<double> &F,
                        const Matrix<double> &H, const Vector<double> &r, const Vector<double> &P0,
                        const Vector<double> &reach, const Vector<double> &range);

// ------------------------------------------------------------------ the models

NumericsModel localLevel();

NumericsModel constantVelocity();

NumericsModel constantAcceleration();

NumericsModel planarVelocity();

NumericsModel dense();

/// Three axes of position, velocity and bias of the accelerometer; sigmas from 1e2 to 1e-5.
NumericsModel inertialBias();

/// The rows of H are sums and differences of all states.
NumericsModel sharpSums();

NumericsModel constantState();

NumericsModel straightLine();

/// One noise drives all three states alike, but for the last bit of a float.
NumericsModel nearlySingular();

NumericsModel rotation();

NumericsModel fallingCovariance();

std::vector<NumericsModel> numericsModels();

// ------------------------------------------------------------------ runs

/// How a run is disturbed: a share of the components missing, and R times 1e-2 to 1e2, anew at
/// every measurement.
struct Mode {
    const char *name;
    double missing;
    bool varyingNoise;
};

std::array<Mode, 4> numericsModes();

/// A true start within half a sigma or so of x0, but never far out where P0 is only a way of
/// saying that nothing is known.
Vector<double> trueStart(const NumericsModel &model, Random &random);

Reading drawReading(const NumericsModel &model, const Mode &mode, const SensorModel &sensor,
                    const Vector<double> &x, Random &random);

/// The true state one step later.
Vector<double> moved(const NumericsModel &model, const Vector<double> &x, Random &random);

/// One run of a model; sensors[t] is the sensor of step t where the noise varies.
Sequence simulate(const NumericsModel &model, const Mode &mode, std::size_t steps,
                  std::uint64_t seed);

} // namespace reference

#endif
