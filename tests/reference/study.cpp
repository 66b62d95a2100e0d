#include "study.hpp"

#include <cstddef>

#include "decompositions.hpp"

namespace reference
{

double conditionOf(const Matrix<Quad> &P)
{
    const Matrix<Quad> correlations = normalised(P, scale(P));
    const Vector<long double> values = symmetricEigenvalues(correlations.cast<long double>());
    const long double smallest = values.minCoeff();
    return smallest > 1e-14L ? static_cast<double>(values.maxCoeff() / smallest) : infinite;
}

/// The largest eigenvalue of R^-1 S.
static double sharpnessOf(const Matrix<double> &S, const Matrix<double> &R)
{
    const auto root = choleskyRoot(R);
    if (!root) return infinite;
    const Matrix<double> left = solveLower(*root, S);
    const Matrix<double> whitened = solveLower(*root, left.transpose());
    return static_cast<double>(symmetricEigenvalues(whitened.cast<long double>()).maxCoeff());
}

Study::Study(const Sequence &data)
    : sequence(data), track(filter<Quad>(data)), largest(sigmas(convert<Quad>(data.P0)))
{
    const Model<double> model(sequence);
    for (const SensorModel &sensor : sequence.sensors) {
        if (sensor.diagonal()) continue;
        const double correlation = conditionOf(convert<Quad>(sensor.R));
        noiseCondition = std::max(noiseCondition, std::min(correlation, conditionLimit));
    }
    for (std::size_t t = 0; t < track.size(); ++t) {
        largest = largest.cwiseMax(sigmas(track[t].predicted.covariance));
        condition = std::max(condition, conditionOf(track[t].filtered.covariance));
        for (std::size_t k = 0; k < track[t].updates.size(); ++k) {
            const Observation<double> seen(model, sequence.steps[t].readings[k]);
            if (seen.z.size() == 0) continue;
            const Matrix<double> S = track[t].updates[k].S.cast<double>();
            sharpness = std::max(sharpness, sharpnessOf(S, seen.R));
        }
    }
}

Vector<Quad> units(const Study &study, const Matrix<Quad> &P, double floor)
{
    return sigmas(P).cwiseMax(Quad(floor) * study.largest);
}

double fallOf(const Vector<Quad> &before, const Vector<Quad> &after)
{
    return before.cwiseQuotient(after).cast<double>().maxCoeff();
}

template <class T> double roundingOf(const Study &study)
{
    return kq::epsilon<T>() / 2 * static_cast<double>(study.sequence.states());
}

template <> double roundingOf<kq::Q31>(const Study &study)
{
    return 0x1p-30 * static_cast<double>(2 * study.sequence.states() + 4);
}

template <class T> double amplificationOf(const Study &study) { return study.amplification(); }

template <> double amplificationOf<kq::Q31>(const Study &study)
{
    const double floor = floorOf<kq::Q31>();
    double worst = 1; // over the measurements of one step
    for (const Track<Quad> &now : study.track) {
        worst = std::max(worst, fallOf(units(study, now.predicted.covariance, floor),
                                       units(study, now.filtered.covariance, floor)));
    }
    return study.amplification() * worst;
}

/// One rounding of a sum of these terms, over eps / 2.
template <class T>
static Vector<double> roundingOfSum(const Vector<double> &terms, const Vector<double> & /*range*/)
{
    return terms;
}

/// In q31 it is 2^-24 of a word, whatever the terms; a range is 2^30 words.
template <>
Vector<double> roundingOfSum<kq::Q31>(const Vector<double> & /*terms*/, const Vector<double> &range)
{
    return range * (0x1p-54 / (kq::epsilon<kq::Q31>() / 2));
}

/// The ranges of the components that are present; none where none are declared.
static Vector<double> rangesOf(const Sequence &sequence, const Reading &reading)
{
    const Vector<double> &range = sequence.sensors[reading.sensor].range;
    return range.size() > 0 ? range.chooseRows(presentComponents(reading)) : range;
}

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

template <class T> double reachOf(const Study &study) { return Reach<T>(study).value(); }

#define INSTANTIATE(T)                                                                             \
    template double roundingOf<T>(const Study &);                                                  \
    template double amplificationOf<T>(const Study &);                                             \
    template double reachOf<T>(const Study &);

INSTANTIATE(float)
INSTANTIATE(double)
INSTANTIATE(kq::Q31)

} // namespace reference
