// A sequence with its reference, how hard it is, and the size of the errors that rounding explains.
#ifndef KALMANQ_TESTS_REFERENCE_STUDY_HPP
#define KALMANQ_TESTS_REFERENCE_STUDY_HPP

#include <algorithm>
#include <cmath>
#include <vector>

#include "accuracy.hpp"
#include "api.hpp"
#include "textbook.hpp"

namespace reference
{

/// Largest condition number of a model that is well-conditioned for an ordinary filter in double.
constexpr double conditionLimit = 1e8;

struct Study {
    const Sequence &sequence;
    std::vector<Track<Quad>> track;
    Vector<Quad> largest;      // sigma of each state, the largest of the run
    double condition = 1;      // of the correlation matrix of P, the worst of the run
    double sharpness = 1;      // S / R in its worst direction, the worst of the run
    double noiseCondition = 1; // of the correlation matrix of R, the worst of the sensors

    explicit Study(const Sequence &data);
    bool wellConditioned() const
    {
        return condition <= conditionLimit && sharpness <= conditionLimit;
    }
    /// What turns roundings into errors of P: the condition number of its root, which the filter
    /// carries, or that of a correlated R, whose entries are rounded where it is decorrelated.
    double amplification() const
    {
        return std::max(std::sqrt(std::min(condition, conditionLimit)), noiseCondition);
    }
};

/// Largest over smallest eigenvalue of the correlations; infinite where P is singular in double.
double conditionOf(const Matrix<Quad> &P);

template <class T> constexpr double floorOf() { return kq::epsilon<T>() > 1e-12 ? 1e-3 : 1e-6; }

/// The unit of each state: its sigma, but no less than `floor` times the largest of the run.  A
/// state that is known exactly has sigma 0, and one that a noise-free sensor took from 1 to
/// `floor` is known to the digits that are left.
Vector<Quad> units(const Study &study, const Matrix<Quad> &P, double floor);

/// The largest fall of a sigma from one covariance to another of the same state.
double fallOf(const Vector<Quad> &before, const Vector<Quad> &after);

// ------------------------------------------------------------------ for float, double and Q31

/// What a step may do to a row of the root: half an ulp of 1 in T, times the number of states.  In
/// q31 the library promises (2n + 4) 2^-30 of a row.
template <class T> double roundingOf(const Study &study);

/// What turns roundings into errors of P.  In q31 the entries of a row have one exponent: where
/// measurements shorten the row, its digits go too.
template <class T> double amplificationOf(const Study &study);

/// Sizes of rounding errors of the mean over eps: one rounding of every term that a step adds up,
/// in units of the result.  Large where the mean is many sigmas.
template <class T> double reachOf(const Study &study);

/// How many roundings an error may be.  In q31 they are the worst that a step can do.
template <class T> constexpr double roundingsLimit(double floating) { return floating; }
template <> constexpr double roundingsLimit<kq::Q31>(double /*floating*/) { return 8; }

} // namespace reference

#endif
