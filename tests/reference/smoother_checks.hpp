// What holds for every smoother, whatever the model: figures for a report.
#ifndef KALMANQ_TESTS_REFERENCE_SMOOTHER_CHECKS_HPP
#define KALMANQ_TESTS_REFERENCE_SMOOTHER_CHECKS_HPP

#include "accuracy.hpp"
#include "formats.hpp"
#include "textbook.hpp"

namespace reference
{

/// P_s <= P_f in units of the variances of the filter, over the rounding of a covariance that is
/// handed over in T.
template <class T>
double aboveFilter(const Belief<Wide<T>> &filtered, const Belief<Wide<T>> &smoothed)
{
    const Matrix<Wide<T>> gained = filtered.covariance - smoothed.covariance;
    return -smallestEigenvalue(gained, filtered.covariance) /
           eigenvalueRounding<T>(filtered.mean.size());
}

/// P >= 0 in units of its own variances, over the same.
template <class T> double indefinite(const Belief<Wide<T>> &belief)
{
    return -smallestEigenvalue(belief.covariance) / eigenvalueRounding<T>(belief.mean.size());
}

/// 0 where every bit is the same
template <class Real> double difference(const Belief<Real> &a, const Belief<Real> &b)
{
    return a.mean == b.mean && a.covariance == b.covariance ? 0 : 1;
}

} // namespace reference

#endif
