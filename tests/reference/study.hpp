// A sequence with its reference, how hard it is, and the size of the errors that rounding explains.
#ifndef KALMANQ_TESTS_REFERENCE_STUDY_HPP
#define KALMANQ_TESTS_REFERENCE_STUDY_HPP

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "accuracy.hpp"
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

template <class T> constexpr double floorOf() { return sizeof(T) == sizeof(float) ? 1e-3 : 1e-6; }

/// The unit of each state: its sigma, but no less than `floor` times the largest of the run.  A
/// state that is known exactly has sigma 0, and one that a noise-free sensor took from 1 to
/// `floor` is known to the digits that are left.
inline Vector<Quad> units(const Study &study, const Matrix<Quad> &P, double floor)
{
    return sigmas(P).cwiseMax(Quad(floor) * study.largest);
}

/// Half an ulp of 1 in T, times the number of states.
template <class T> double roundingOf(const Study &study)
{
    const double eps = static_cast<double>(std::numeric_limits<T>::epsilon()) / 2;
    return eps * static_cast<double>(study.sequence.states());
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
        add(terms, units(study_, study_.track[t + 1].predicted.covariance, floorOf<T>()));
    }

    /// z - H x, and K times that
    void addUpdate(std::size_t t, std::size_t k)
    {
        const Track<Quad> &now = study_.track[t];
        const Observation<double> seen(model_, study_.sequence.steps[t].readings[k]);
        if (seen.z.size() == 0) return;
        const Vector<Quad> x = now.predicted.mean.cwiseAbs().cwiseMax(now.filtered.mean.cwiseAbs());
        const Vector<double> terms = seen.H.cwiseAbs() * x.cast<double>() + seen.z.cwiseAbs();
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
