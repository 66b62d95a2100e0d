// Filter and forecast against the textbook formulas in quadruple precision: random models and the
// named classes of state-space models, 200 steps each.
//
//     test_random_models [seed]
//
// Units: an error of the mean counts in sigma of the reference at that time, of a covariance in
// sigma_i sigma_j, of an innovation in sqrt(S), of a gain in sigma_i / sqrt(S_jj).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "accuracy.hpp"
#include "api.hpp"
#include "generator.hpp"
#include "library.hpp"
#include "report.hpp"
#include "textbook.hpp"

using namespace reference;

namespace
{

constexpr int randomModels = 216;
constexpr int furthest = 10;           // steps of a forecast
constexpr double conditionLimit = 1e8; // of a model that is well-conditioned in double

/// A sequence, what is right for it, and how hard it is.
struct Case {
    Sequence sequence;
    std::vector<Track<Quad>> exact;
    Vector<Quad> largest; // sigma of each state, the largest of the run
    double condition = 1; // of the correlation matrix of P, the worst of the run
    double sharpness = 1; // S / R in its worst direction, the worst of the run

    /// Neither is near the limits of an ordinary filter in double.
    bool wellConditioned() const
    {
        return condition <= conditionLimit && sharpness <= conditionLimit;
    }
};

/// The unit of each state: its sigma, but no less than `floor` times the largest of the run.  A
/// state that is known exactly has sigma 0, and one that a noise-free sensor took from 1 to
/// `floor` is known to the digits that are left.
Vector<Quad> units(const Case &model, const Matrix<Quad> &P, double floor)
{
    return sigmas(P).cwiseMax(Quad(floor) * model.largest);
}

template <class T> constexpr double floorOf() { return sizeof(T) == sizeof(float) ? 1e-3 : 1e-6; }

/// Largest over smallest eigenvalue; infinite where P is singular to double precision.
double conditionOf(const Matrix<Quad> &P)
{
    const Matrix<double> C = normalised(P, scale(P)).cast<double>();
    const Eigen::SelfAdjointEigenSolver<Matrix<double>> solver(C, Eigen::EigenvaluesOnly);
    const Vector<double> values = solver.eigenvalues();
    const double smallest = values.minCoeff();
    return smallest > 1e-14 ? values.maxCoeff() / smallest : infinite;
}

/// The largest eigenvalue of R^-1 S.
double sharpnessOf(const Matrix<double> &S, const Matrix<double> &R)
{
    const Eigen::LLT<Matrix<double>> root(R);
    if (root.info() != Eigen::Success) return infinite;
    const Matrix<double> left = root.matrixL().solve(S);
    const Matrix<double> whitened = root.matrixL().solve(left.transpose());
    const Eigen::SelfAdjointEigenSolver<Matrix<double>> solver(whitened, Eigen::EigenvaluesOnly);
    return solver.eigenvalues().maxCoeff();
}

void studyStep(Case &model, std::size_t t, const Model<double> &matrices)
{
    const Track<Quad> &now = model.exact[t];
    model.condition = std::max(model.condition, conditionOf(now.filtered.covariance));
    for (std::size_t k = 0; k < now.updates.size(); ++k) {
        if (now.updates[k].e.size() == 0) continue;
        const Observation<double> seen(matrices, model.sequence.steps[t].readings[k]);
        const Matrix<double> S = now.updates[k].S.cast<double>();
        model.sharpness = std::max(model.sharpness, sharpnessOf(S, seen.R));
    }
}

Case study(const Sequence &sequence)
{
    Case model{sequence, filter<Quad>(sequence), {}};
    model.largest = sigmas(sequence.P0.cast<Quad>().eval());
    for (const Track<Quad> &now : model.exact) {
        model.largest = model.largest.cwiseMax(sigmas(now.predicted.covariance));
    }
    const Model<double> matrices(sequence);
    for (std::size_t t = 0; t < model.exact.size(); ++t) studyStep(model, t, matrices);
    return model;
}

// ------------------------------------------------------------------ what rounding explains

/// Sizes of rounding errors of the mean over eps: one rounding of every term that a step adds up,
/// in units of the result.  Large where the mean is many sigmas.
template <class T> class Reach
{
  public:
    explicit Reach(const Case &model) : case_(model), matrices_(model.sequence)
    {
        const std::vector<Step> &steps = model.sequence.steps;
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
        const Step &step = case_.sequence.steps[t];
        const Vector<double> x = case_.exact[t].filtered.mean.cast<double>().cwiseAbs();
        Vector<double> terms = matrices_.A[step.process].cwiseAbs() * x;
        if (step.u.size() > 0) terms += matrices_.B[step.process].cwiseAbs() * step.u.cwiseAbs();
        add(terms, units(case_, case_.exact[t + 1].predicted.covariance, floorOf<T>()));
    }

    /// z - H x, and K times that
    void addUpdate(std::size_t t, std::size_t k)
    {
        const Track<Quad> &now = case_.exact[t];
        const Observation<double> seen(matrices_, case_.sequence.steps[t].readings[k]);
        if (seen.z.size() == 0) return;
        const Vector<Quad> x = now.predicted.mean.cwiseAbs().cwiseMax(now.filtered.mean.cwiseAbs());
        const Vector<double> terms = seen.H.cwiseAbs() * x.cast<double>() + seen.z.cwiseAbs();
        add(terms, sigmas(now.updates[k].S));
        add(now.updates[k].K.cast<double>().cwiseAbs() * terms,
            units(case_, now.filtered.covariance, floorOf<T>()));
    }

    void add(const Vector<double> &terms, const Vector<Quad> &unit)
    {
        worst_ = std::max(worst_, terms.cwiseQuotient(unit.cast<double>()).maxCoeff());
    }

    const Case &case_;
    Model<double> matrices_;
    double worst_ = 1;
};

bool isOfCovariance(const std::string &name)
{
    return name.back() == 'P' || name.back() == 'S' || name == "P-" || name == "K";
}

/// The figures once more, in roundings.  The root of P takes a few n eps of its rows at each step,
/// which its condition number, the root of that of P, turns into errors of P; the mean takes a few
/// n eps of its reach, and has the gain's errors from P.
template <class T> Figures inRoundings(const Case &model, const Figures &figures)
{
    const double eps = static_cast<double>(std::numeric_limits<T>::epsilon()) / 2;
    const double n = static_cast<double>(model.sequence.states());
    const double root = std::sqrt(std::min(model.condition, conditionLimit));
    const double reach = Reach<T>(model).value();
    Figures result;
    for (const auto &[name, value] : figures) {
        if (name == "events" || name == "taken" || name == "forecast changed") continue;
        if (isOfCovariance(name)) result.add("P in roundings", value / (n * eps * root));
        else result.add("x in roundings", value / (n * eps * (reach + root)));
    }
    return result;
}

// ------------------------------------------------------------------ one sequence

/// One filter of the library beside the reference.
template <class T> class Comparison
{
  public:
    using Api = kq::Api<T>;

    explicit Comparison(const Case &model)
        : case_(model), sequence_(model.sequence), library_(sequence_, Processes::shared),
          filter_(library_.filter()), ahead_(static_cast<int>(sequence_.states()))
    {
    }

    Figures run()
    {
        for (std::size_t t = 0; t < sequence_.steps.size(); ++t) {
            const Step &step = sequence_.steps[t];
            compareBelief("-", case_.exact[t].predicted);
            Belief<Quad> belief = case_.exact[t].predicted;
            for (std::size_t k = 0; k < step.readings.size(); ++k) {
                compareUpdate(belief, step.readings[k], case_.exact[t].updates[k]);
            }
            compareBelief("", case_.exact[t].filtered);
            if (t % 23 == 7) compareForecast(t);
            library_.predict(filter_.get(), step);
        }
        figures_.add("events", Api::events(filter_.get()));
        return figures_;
    }

  private:
    void compareBelief(const std::string &when, const Belief<Quad> &exact)
    {
        const Belief<double> belief = read<T>(filter_.get(), sequence_.states());
        const Vector<Quad> unit = units(case_, exact.covariance, floorOf<T>());
        figures_.add("x" + when, meanError(belief.mean, exact.mean, unit));
        figures_.add("P" + when, covarianceError(belief.covariance, exact.covariance, unit));
    }

    /// `belief` is the reference before this reading, and then after it.
    void compareUpdate(Belief<Quad> &belief, const Reading &reading, const Innovation<Quad> &exact)
    {
        const Model<Quad> model(sequence_);
        const Matrix<Quad> &H = model.H[reading.sensor], &R = model.R[reading.sensor];
        const Vector<Quad> z = convert<Quad>(reading.z);
        compareInnovation(belief, reading, innovation(belief, H, R, z));
        library_.update(filter_.get(), reading);
        compareLikelihood(exact);
        const Observation<Quad> seen(model, reading);
        if (seen.z.size() > 0) update(belief, seen.H, seen.R, seen.z);
    }

    /// Innovation, S and gain of all components of the sensor, present or not.
    void compareInnovation(const Belief<Quad> &belief, const Reading &reading,
                           const Innovation<Quad> &exact)
    {
        const auto *sensor = library_.sensor(reading.sensor);
        const Eigen::Index n = sequence_.states(), m = reading.z.size();
        const auto width = static_cast<std::size_t>(m);
        std::vector<T> z = flattened<T>(reading.z), e(width), S(width * width),
                       K(static_cast<std::size_t>(n) * width);
        kq::require(Api::innovation(filter_.get(), sensor, z.data(), e.data()), "innovation");
        kq::require(Api::measurement(filter_.get(), sensor, nullptr, S.data()), "measurement");
        kq::require(Api::gain(filter_.get(), sensor, K.data()), "gain");

        const Vector<Quad> deviation = sigmas(exact.S);
        const Vector<Quad> state = units(case_, belief.covariance, floorOf<T>());
        figures_.add("e", meanError(unflattened(e, m, 1), exact.e, deviation));
        figures_.add("S", covarianceError(unflattened(S, m), exact.S, deviation));
        figures_.add(
            "K", covarianceError(unflattened(K, n, m), exact.K, state, deviation.cwiseInverse()));
    }

    /// NIS beside 1 + NIS; log-likelihood of the run beside the number of scalar measurements.
    void compareLikelihood(const Innovation<Quad> &exact)
    {
        exactLogLikelihood_ += exact.logLikelihood;
        measured_ += static_cast<int>(exact.e.size());
        const Quad nis(Api::nis(filter_.get())), sum(Api::logLikelihood(filter_.get()));
        const Quad last(Api::logLikelihoodLast(filter_.get()));
        figures_.add("nis", ratio(nis - exact.nis, Quad(1) + exact.nis));
        figures_.add("logp", ratio(last - exact.logLikelihood, Quad(1) + exact.nis));
        figures_.add("sum logp", ratio(sum - exactLogLikelihood_, Quad(1 + measured_)));
        const bool counted = Api::taken(filter_.get()) == static_cast<int>(exact.e.size());
        figures_.add("taken", counted ? 0 : 1);
    }

    /// 1 .. furthest steps ahead of time t, with the controls that will come.
    void compareForecast(std::size_t t)
    {
        const std::size_t process = sequence_.steps[t].process;
        const Eigen::Index l = sequence_.processes[process].B.cols();
        Matrix<double> u = Matrix<double>::Zero(l, furthest);
        for (std::size_t k = 0; k < furthest && t + k < sequence_.steps.size(); ++k) {
            const Vector<double> &control = sequence_.steps[t + k].u;
            if (control.size() > 0) u.col(static_cast<Eigen::Index>(k)) = control;
        }
        const auto bytes = *filter_.get();
        const std::vector<T> memory = filter_.memory();
        for (int k = 1; k <= furthest; ++k) {
            compareForecast(forecast(sequence_, case_.exact[t].filtered, process, u, k), process, u,
                            k);
        }
        const bool same =
            std::memcmp(&bytes, filter_.get(), sizeof bytes) == 0 &&
            std::memcmp(memory.data(), filter_.memory().data(), memory.size() * sizeof(T)) == 0;
        figures_.add("forecast changed", same ? 0 : 1);
    }

    void compareForecast(const Belief<Quad> &exact, std::size_t process, const Matrix<double> &u,
                         int steps)
    {
        const std::vector<T> controls = flattened<T>(u.transpose());
        kq::require(Api::forecast(filter_.get(), library_.process(process),
                                  kq::dataOrNull(controls), steps, ahead_.get()),
                    "forecast");
        const Belief<double> belief = read<T>(ahead_.get(), sequence_.states());
        const Vector<Quad> unit = units(case_, exact.covariance, floorOf<T>());
        figures_.add("forecast x", meanError(belief.mean, exact.mean, unit));
        figures_.add("forecast P", covarianceError(belief.covariance, exact.covariance, unit));

        const Model<Quad> model(sequence_);
        const Matrix<Quad> &H = model.H[0], &R = model.R[0];
        const Eigen::Index m = H.rows();
        std::vector<T> z(static_cast<std::size_t>(m)), S(static_cast<std::size_t>(m * m));
        kq::require(Api::measurement(ahead_.get(), library_.sensor(0), z.data(), S.data()),
                    "measurement");
        const Matrix<Quad> exactS = symmetric<Quad>(H * exact.covariance * H.transpose() + R);
        const Vector<Quad> deviation = sigmas(exactS);
        figures_.add("forecast z", meanError(unflattened(z, m, 1), H * exact.mean, deviation));
        figures_.add("forecast S", covarianceError(unflattened(S, m), exactS, deviation));
    }

    const Case &case_;
    const Sequence &sequence_;
    Library<T> library_;
    kq::FilterOwner<T> filter_, ahead_;
    Figures figures_;
    Quad exactLogLikelihood_ = 0;
    int measured_ = 0;
};

// ------------------------------------------------------------------ the reference itself

/// The same formulas in a shorter type, against quadruple precision.
template <class Real> Figures selfCheck(const Case &model, double floor)
{
    Figures figures;
    const std::vector<Track<Real>> track = filter<Real>(model.sequence);
    for (std::size_t t = 0; t < track.size(); ++t) {
        const Belief<Quad> &exact = model.exact[t].filtered;
        const Vector<Quad> unit = units(model, exact.covariance, floor);
        const Belief<Real> &belief = track[t].filtered;
        figures.add("x", meanError(belief.mean.template cast<double>(), exact.mean, unit));
        figures.add("P", covarianceError(belief.covariance.template cast<double>(),
                                         exact.covariance, unit));
    }
    return figures;
}

// ------------------------------------------------------------------ groups and bounds

Bounds allOf(double bound)
{
    Bounds bounds{{"events", 0}, {"taken", 0}, {"forecast changed", 0}};
    for (const char *name : {"x-", "P-", "x", "P", "e", "S", "K", "nis", "logp", "sum logp",
                             "forecast x", "forecast P", "forecast z", "forecast S"}) {
        bounds[name] = bound;
    }
    return bounds;
}

template <class T>
void compare(Report &report, const std::string &group, const Case &model, double allowed)
{
    const std::string name = model.sequence.name;
    const Figures figures = Comparison<T>(model).run();
    report.add(kq::Api<T>::name + group, name, figures, allOf(allowed));
    report.add(kq::Api<T>::name + group, name, inRoundings<T>(model, figures),
               {{"x in roundings", 32}, {"P in roundings", 64}});
}

void compareAll(Report &report, const std::string &group, const Sequence &sequence)
{
    const Case model = study(sequence);
    const bool easy = model.wellConditioned();
    const std::string title = ", " + group + (easy ? "" : ", not well-conditioned");
    report.add("reference in double" + title, sequence.name,
               selfCheck<double>(model, floorOf<double>()),
               easy ? Bounds{{"x", 1e-7}, {"P", 1e-9}} : Bounds{});
    report.add("reference in long double" + title, sequence.name,
               selfCheck<long double>(model, floorOf<double>()),
               easy ? Bounds{{"x", 1e-10}, {"P", 1e-12}} : Bounds{});
    compare<double>(report, title, model, 1e-9);
    compare<float>(report, title, model, infinite);
}

// ------------------------------------------------------------------ singular covariances

/// Exact and positive semi-definite, of about half rank: it has to be accepted, and to come back.
template <class T> Figures singularStart(const Matrix<double> &P0)
{
    Figures figures;
    const auto n = static_cast<int>(P0.rows());
    kq::FilterOwner<T> filter(n);
    const std::vector<T> x0(static_cast<std::size_t>(n)), P = flattened<T>(P0);
    const bool refused = kq::Api<T>::filterInit(filter.get(), x0.data(), P.data()) != KQ_OK;
    figures.add("refused", refused ? 1 : 0);
    if (refused) return figures;
    const double eps = static_cast<double>(std::numeric_limits<T>::epsilon());
    const Matrix<Quad> exact = P0.cast<Quad>();
    const Matrix<double> covariance = read<T>(filter.get(), n).covariance;
    figures.add("P over n eps", covarianceError(covariance, exact, sigmas(exact)) / (n * eps));
    return figures;
}

void compareSingular(Report &report, Random &random)
{
    for (int number = 0; number < 500; ++number) {
        const generator::Index n = 2 + number % 8;
        const Vector<double> scale = generator::powersOfTwo(random, n, -4, 4);
        const Matrix<double> F = generator::randomFactor(random, n, (n + 1) / 2, scale);
        const Matrix<double> P0 = F * F.transpose();
        const std::string name = "covariance " + std::to_string(number);
        const Bounds bounds{{"refused", 0}, {"P over n eps", 16}};
        report.add("f64, singular P0", name, singularStart<double>(P0), bounds);
        report.add("f32, singular P0", name, singularStart<float>(P0), bounds);
    }
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = generator::seedOf(argc, argv);
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    Random random(seed);
    Report report;
    for (int number = 0; number < randomModels; ++number) {
        compareAll(report, "random models", generator::randomSequence(random, number));
    }
    for (const Sequence &sequence : generator::namedSequences(random)) {
        compareAll(report, "named models", sequence);
    }
    compareSingular(report, random);
    report.print();
    return report.verdict.finish();
}
