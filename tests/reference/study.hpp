// A sequence with its reference, how hard it is, and the size of the errors that rounding explains.
#ifndef KALMANQ_TESTS_REFERENCE_STUDY_HPP
#define KALMANQ_TESTS_REFERENCE_STUDY_HPP

#include <algorithm>
#include <cmath>
#include <cstddef>
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
inline double conditionOf(const Matrix<Quad> &P)
{
    const Matrix<double> C = normalised(P, scale(P)).cast<double>();
    const Eigen::SelfAdjointEigenSolver<Matrix<double>> solver(C, Eigen::EigenvaluesOnly);
    const Vector<double> values = solver.eigenvalues();
    const double smallest = values.minCoeff();
    return smallest > 1e-14 ? values.maxCoeff() / smallest : infinite;
}

/// The largest eigenvalue of R^-1 S.
inline double sharpnessOf(const Matrix<double> &S, const Matrix<double> &R)
{
    const Eigen::LLT<Matrix<double>> root(R);
    if (root.info() != Eigen::Success) return infinite;
    const Matrix<double> left = root.matrixL().solve(S);
    const Matrix<double> whitened = root.matrixL().solve(left.transpose());
    const Eigen::SelfAdjointEigenSolver<Matrix<double>> solver(whitened, Eigen::EigenvaluesOnly);
    return solver.eigenvalues().maxCoeff();
}

inline Study::Study(const Sequence &data)
    : sequence(data), track(filter<Quad>(data)), largest(sigmas(convert<Quad>(data.P0)))
{
    const Model<double> model(sequence);
    for (const SensorModel &sensor : sequence.sensors) {
        if (sensor.diagonal()) continue;
        const double correlation = conditionOf(convert<Quad>(sensor.R));
        noiseCondition = std::max(noiseCondition, std::min(correlation, conditionLimit));
    }
    for (std::size_t t = 0; t < track.size(); ++t) {
        largest = largest.cwiseMax(sigmas(track[t].predicted.covariance)).eval();
        condition = std::max(condition, conditionOf(track[t].filtered.covariance));
        for (std::size_t k = 0; k < track[t].updates.size(); ++k) {
            const Observation<double> seen(model, sequence.steps[t].readings[k]);
            if (seen.z.size() == 0) continue;
            const Matrix<double> S = track[t].updates[k].S.cast<double>();
            sharpness = std::max(sharpness, sharpnessOf(S, seen.R));
        }
    }
}

template <class T> constexpr double floorOf() { return kq::epsilon<T>() > 1e-12 ? 1e-3 : 1e-6; }

/// The unit of each state: its sigma, but no less than `floor` times the largest of the run.  A
/// state that is known exactly has sigma 0, and one that a noise-free sensor took from 1 to
/// `floor` is known to the digits that are left.
inline Vector<Quad> units(const Study &study, const Matrix<Quad> &P, double floor)
{
    return sigmas(P).cwiseMax(Quad(floor) * study.largest);
}

/// What a step may do to a row of the root: half an ulp of 1 in T, times the number of states.
template <class T> double roundingOf(const Study &study)
{
    return kq::epsilon<T>() / 2 * static_cast<double>(study.sequence.states());
}

/// In q31 the library promises (2n + 4) 2^-30 of a row.
template <> inline double roundingOf<kq::Q31>(const Study &study)
{
    return 0x1p-30 * static_cast<double>(2 * study.sequence.states() + 4);
}

/// How many of these an error may be.  In q31 they are the worst that a step can do.
template <class T> constexpr double roundingsLimit(double floating) { return floating; }
template <> constexpr double roundingsLimit<kq::Q31>(double /*floating*/) { return 8; }

/// The largest fall of a sigma over the measurements of one step.
inline double fallOf(const Study &study, double floor)
{
    double worst = 1;
    for (const Track<Quad> &now : study.track) {
        const Vector<Quad> before = units(study, now.predicted.covariance, floor);
        const Vector<Quad> after = units(study, now.filtered.covariance, floor);
        worst = std::max(worst, before.cwiseQuotient(after).cast<double>().maxCoeff());
    }
    return worst;
}

/// What turns roundings into errors of P.
template <class T> double amplificationOf(const Study &study) { return study.amplification(); }

/// The entries of a row have one exponent: where measurements shorten the row, its digits go too.
template <> inline double amplificationOf<kq::Q31>(const Study &study)
{
    return study.amplification() * fallOf(study, floorOf<kq::Q31>());
}

/// One rounding of a sum of these terms, over eps / 2.
template <class T>
Vector<double> roundingOfSum(const Vector<double> &terms, const Vector<double> & /*range*/)
{
    return terms;
}

/// In q31 it is 2^-24 of a word, whatever the terms; a range is 2^30 words.
template <>
inline Vector<double> roundingOfSum<kq::Q31>(const Vector<double> & /*terms*/,
                                             const Vector<double> &range)
{
    return range * (0x1p-54 / (kq::epsilon<kq::Q31>() / 2));
}

/// The ranges of the components that are present; none where none are declared.
inline Vector<double> rangesOf(const Sequence &sequence, const Reading &reading)
{
    const Vector<double> &range = sequence.sensors[reading.sensor].range;
    return range.size() > 0 ? range(presentComponents(reading)).eval() : range;
}

/// Sizes of rounding errors of the mean over eps: one rounding of every term that a step adds up,
/// in units of the result.  Large where the mean is many sigmas.
template <class T> class Reach
{
  public:
    explicit Reach(const Study &study) : study_(study), model_(study.sequence)
    {
        const std::vector<Step> &steps = study.sequence.steps;
        for (std::size_t t = 0; t < steps.size(); ++t) {
            for (std::size_t k = 0; k < steps[t].readings.size(); ++k) addUpdate(t, k);
            if (t + 1 < steps.size()) addPredict(t);
        }
    }
    double value() const { return worst_; }

  private:
    /// A x + B u
    void addPredict(std::size_t t)
    {
        const Step &step = study_.sequence.steps[t];
        const Vector<double> x = study_.track[t].filtered.mean.cast<double>().cwiseAbs();
        Vector<double> terms = model_.A[step.process].cwiseAbs() * x;
        if (step.u.size() > 0) terms += model_.B[step.process].cwiseAbs() * step.u.cwiseAbs();
        add(roundingOfSum<T>(terms, study_.sequence.range),
            units(study_, study_.track[t + 1].predicted.covariance, floorOf<T>()));
    }

    /// z - H x, and K times that
    void addUpdate(std::size_t t, std::size_t k)
    {
        const Track<Quad> &now = study_.track[t];
        const Observation<double> seen(model_, study_.sequence.steps[t].readings[k]);
        if (seen.z.size() == 0) return;
        const Vector<Quad> x = now.predicted.mean.cwiseAbs().cwiseMax(now.filtered.mean.cwiseAbs());
        const Reading &reading = study_.sequence.steps[t].readings[k];
        const Vector<double> terms =
            roundingOfSum<T>(seen.H.cwiseAbs() * x.cast<double>() + seen.z.cwiseAbs(),
                             rangesOf(study_.sequence, reading));
        add(terms, sigmas(now.updates[k].S));
        add(now.updates[k].K.cast<double>().cwiseAbs() * terms,
            units(study_, now.filtered.covariance, floorOf<T>()));
    }

    void add(const Vector<double> &terms, const Vector<Quad> &unit)
    {
        worst_ = std::max(worst_, terms.cwiseQuotient(unit.cast<double>()).maxCoeff());
    }

    const Study &study_;
    Model<double> model_;
    double worst_ = 1;
};

} // namespace reference

#endif
