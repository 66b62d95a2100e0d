// What the tests on random and named models share: tables of claims, from which the bounds of the figures and
// the figures in roundings are made.
//
// In roundings: the root of P takes a few n eps of its rows at each step, which are amplified to errors of P; the mean
// takes a few n eps of its reach, and has the errors of the gain, which are those of P.
#ifndef KALMANQ_TESTS_REFERENCE_COMPARISON_HPP
#define KALMANQ_TESTS_REFERENCE_COMPARISON_HPP

#include <algorithm>
#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "accuracy.hpp"
#include "api.hpp"
#include "generator.hpp"
#include "report.hpp"
#include "study.hpp"
#include "textbook.hpp"

namespace reference
{

/// The figures of a kind share a limit, but for the fixed ones, which are not counted in roundings.
struct Claims {
    std::vector<std::string> means, covariances, scores;
    Bounds fixed;
};

struct Limits {
    double mean, covariance;
};

template <class T> struct Arithmetic {
    /// What a score is rounded to beside 1: in q31 it has 24 bits after the point, and a logarithm and
    /// a square for each of them.
    static constexpr double scoreRounding = 0;
    static Limits limits(bool isNamed) { return isNamed ? Limits{1e-3, 2e-5} : Limits{infinite, 1e-3}; }
};
template <> struct Arithmetic<kq::Q31> {
    static constexpr double scoreRounding = 0x1p-23;
    static Limits limits(bool isNamed) { return isNamed ? Limits{1e-5, 1e-5} : Limits{1e-4, 1e-4}; }
};

/// refinement: how far a sigma has fallen since what was rounded was that of the filter
template <class T>
Figures inRoundings(const Study &study, const Figures &figures, const Claims &claims, double refinement)
{
    const double unit = roundingOf<T>(study) * refinement, amplification = amplificationOf<T>(study);
    const double ofMean = unit * (reachOf<T>(study) + amplification);
    Figures result;
    const auto add = [&](const char *title, const std::vector<std::string> &names, double rounding) {
        for (const auto &[name, value] : figures) {
            if (std::count(names.begin(), names.end(), name)) result.add(title, value / rounding);
        }
    };
    add("x in roundings", claims.means, ofMean);
    add("P in roundings", claims.covariances, unit * amplification);
    add("scores in roundings", claims.scores, ofMean + Arithmetic<T>::scoreRounding);
    return result;
}

inline Bounds boundsOf(const Claims &claims, const Limits &limits)
{
    Bounds bounds = claims.fixed;
    for (const auto *names : {&claims.means, &claims.scores}) {
        for (const std::string &name : *names) bounds[name] = limits.mean;
    }
    for (const std::string &name : claims.covariances) bounds[name] = limits.covariance;
    return bounds;
}

/// The figures of one sequence against their claims; f64 is held to `wide`.
template <class T>
void judge(Report &report, const std::string &title, bool isNamed, const Study &study, const Figures &figures,
           const Claims &claims, const Limits &wide, double refinement = 1)
{
    Limits limits = wide;
    if constexpr (!std::is_same_v<T, double>) limits = Arithmetic<T>::limits(isNamed);
    const std::string &name = study.sequence.name;
    report.add(kq::Api<T>::name + title, name, figures, boundsOf(claims, limits));
    report.add(kq::Api<T>::name + title, name, inRoundings<T>(study, figures, claims, refinement),
               {{"x in roundings", roundingsLimit<T>(32)},
                {"P in roundings", roundingsLimit<T>(64)},
                {"scores in roundings", roundingsLimit<T>(32)}});
}

/// The largest sigma of the filter over that of a smoother of the same steps, from `first` on: the smoothed mean is the
/// filtered one with a correction, and what rounding did to that one counts in the sigma of the smoother.
inline void refine(double &worst, const Study &study, std::size_t t, const Matrix<Quad> &smoothed, double floor)
{
    worst = std::max(worst, fallOf(units(study, study.track[t].filtered.covariance, floor), units(study, smoothed, floor)));
}

} // namespace reference

#endif
