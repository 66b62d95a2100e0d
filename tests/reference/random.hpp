// Random numbers that are the same on every machine and with every standard library.
#ifndef KALMANQ_TESTS_REFERENCE_RANDOM_HPP
#define KALMANQ_TESTS_REFERENCE_RANDOM_HPP

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "matrix.hpp"

namespace reference
{

/// The seed of argv[1], or the default one.
inline std::uint64_t seedOf(int argc, char **argv, std::uint64_t otherwise = 1)
{
    return argc > 1 ? std::strtoull(argv[1], nullptr, 10) : otherwise;
}

/// The second argument, or another one: how much is run
inline std::uint64_t amountOf(int argc, char **argv, std::uint64_t otherwise, int which = 2)
{
    return argc > which ? std::strtoull(argv[which], nullptr, 10) : otherwise;
}

/// xorshift64* (Vigna 2016), seeded through one step of splitmix64 so that neighbouring seeds
/// have nothing in common.
class Random
{
  public:
    explicit Random(std::uint64_t seed) : state_(mix(seed + 0x9E3779B97F4A7C15U)) {}

    /// In (0, 1), never an end.
    double uniform()
    {
        state_ ^= state_ >> 12;
        state_ ^= state_ << 25;
        state_ ^= state_ >> 27;
        const std::uint64_t top = (state_ * 0x2545F4914F6CDD1DU) >> 11;
        return (static_cast<double>(top) + 0.5) * 0x1p-53;
    }

    double uniform(double low, double high) { return low + (high - low) * uniform(); }

    bool chance(double probability) { return uniform() < probability; }

    /// low, low + 1, ..., high.
    int integer(int low, int high)
    {
        return low + static_cast<int>(uniform() * static_cast<double>(high - low + 1));
    }

    /// Mean 0, variance 1 (Box and Muller).
    double normal()
    {
        const double radius = std::sqrt(-2 * std::log(uniform()));
        return radius * std::cos(6.283185307179586 * uniform());
    }

  private:
    static std::uint64_t mix(std::uint64_t z)
    {
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
        z ^= z >> 31;
        return z == 0 ? 1 : z;
    }

    std::uint64_t state_;
};

/// A power of ten whose exponent is uniform
inline double logUniform(Random &random, double from, double to) { return std::pow(10, random.uniform(from, to)); }

/// Of variance 1, by columns
inline Matrix<double> normals(Random &random, Index rows, Index columns = 1)
{
    return generated(rows, columns, [&random] { return random.normal(); });
}

} // namespace reference

#endif
