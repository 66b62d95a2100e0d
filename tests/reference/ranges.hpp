// Ranges for the q31 formats, as somebody declares them who knows the plant: from a run of the
// filter.  x0, u and z are rounded to grids of 24 bits of these ranges, which are floats and q31
// words alike.
#ifndef KALMANQ_TESTS_REFERENCE_RANGES_HPP
#define KALMANQ_TESTS_REFERENCE_RANGES_HPP

#include "textbook.hpp"

namespace reference
{

/// The smallest power of two that is not below x > 0; 1 for 0.
double powerOfTwo(double x);

Vector<double> powersOfTwo(const Vector<double> &x);

/// Of u, from its largest.
Vector<double> controlRange(const Sequence &sequence, Index controls);

/// Doubles ranges of x and z until a row of A, B and H times the ranges is within the library's
/// limit for such a sum.
void widenStates(Sequence &sequence);
void widenMeasurements(Sequence &sequence);

/// 24 bits of |x| <= range.
Vector<double> onGrid(const Vector<double> &x, const Vector<double> &range);

/// Of x, u and z; x0, u and z are then rounded to their grids.
void declareRanges(Sequence &sequence);

} // namespace reference

#endif
