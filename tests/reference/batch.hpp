// The smoother as what it is: one least-squares problem for the states of all times,
//     min  |x[0] - x0|^2_P0 + sum |x[t+1] - A x[t] - B u[t]|^2_Q + sum |z - H x[t]|^2_R
// with |v|^2_C = v'C^-1 v, solved by QR of the whitened rows.  There is no recursion in it, so it
// shares no mistake with one.  For P0, Q and R of full rank, and few steps.
#ifndef KALMANQ_TESTS_REFERENCE_BATCH_HPP
#define KALMANQ_TESTS_REFERENCE_BATCH_HPP

#include <vector>

#include "textbook.hpp"

namespace reference
{

std::vector<Smoothed<long double>> smoothByLeastSquares(const Sequence &sequence);

} // namespace reference

#endif
