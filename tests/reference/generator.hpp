// Seeded models and measurements: random ones, and the named classes of state-space models.
//
// Every number of a sequence is a float, and every x0, u and z a q31 word.  A covariance is built
// as F F' with F = diag(powers of two) * (small integers): its entries are floats too, exactly, and
// it is positive semi-definite without any rounding.
#ifndef KALMANQ_TESTS_REFERENCE_GENERATOR_HPP
#define KALMANQ_TESTS_REFERENCE_GENERATOR_HPP

#include <cstdint>
#include <string>
#include <vector>

#include "random.hpp"
#include "textbook.hpp"

namespace reference::generator
{

using Mat = Matrix<double>;
using Vec = Vector<double>;

/// Of the tests of random models
constexpr std::uint64_t defaultSeed = 20240229;

Mat identity(Index n);

// ------------------------------------------------------------------ parts of random models

/// A factor n x rank: integers / 64 with a dominant diagonal, rows scaled by powers of two.
Mat randomFactor(Random &random, Index n, Index rank, const Vec &scale);

Mat diagonalFactor(Random &random, Index n, const Vec &scale);
Mat unitTriangular(Random &random, Index n);

/// Blocks on the diagonal with eigenvalues of modulus at most 1: real ones and rotations.
/// Marginal: on the unit circle, and with `chains` short chains of integrators.
Mat eigenBlocks(Random &random, Index n, bool marginal, bool chains);

/// Dense, with the eigenvalues of the blocks D; in units that differ by powers of two.
Mat transition(const Mat &D, const Mat &coordinates, const Vec &units);

Mat randomMatrix(Random &random, Index rows, Index columns);
Vec powersOfTwo(Random &random, Index n, int low, int high);

// ------------------------------------------------------------------ measurements

/// Fills in the measurements z of all readings from one true path.
void simulate(Random &random, Sequence &sequence);

// ------------------------------------------------------------------ random models

struct Options {
    int steps = 200;
    bool invertible = false; // Q, R and P0 of full rank
};

/// Model `number` of a kind of its own: all combinations of sizes and features come.
Sequence randomSequence(Random &random, int number, const Options &options = {});

// ------------------------------------------------------------------ named models

/// Every named class, measured over `steps` steps.
std::vector<Sequence> namedSequences(Random &random, int steps = 200);

} // namespace reference::generator

#endif
