// The square-root smoother that the literature has, in float: Rauch, Tung and Striebel with a gain
// C = Y (S-)^+ from the filter's own arrays.  What the library is compared with, not a part of it.
//
//     predict    [A S, G; S, 0] Theta = [S-, 0; Y, Z]
//     smooth     C = Y (S-)^+,  x_s = x + C (x_s+ - x-),  S_s = tria [C S_s+, Z]
//
// The mean is held in double, so that only the covariance arithmetic is compared.
#ifndef KALMANQ_TESTS_REFERENCE_GAIN_SMOOTHER_HPP
#define KALMANQ_TESTS_REFERENCE_GAIN_SMOOTHER_HPP

#include <vector>

#include "bryson_frazier.hpp"
#include "textbook.hpp"

namespace reference
{

/// The estimates of one filter and smoother, and which scalar measurements it took: not those at
/// the rounding floor.
struct Estimates {
    std::vector<Belief<double>> filtered, smoothed;
    Taken taken;
};

Estimates runGainSmoother(const Sequence &sequence);

} // namespace reference

#endif
