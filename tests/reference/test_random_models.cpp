// Filter, forecast and smoother against the textbook formulas in quadruple precision: random models and the
// named classes of state-space models, and short ones whose smoother is one dense solve.
//
//     test_random_models [seed [models [steps]]]
//
// Units of the filter: an error of the mean counts in sigma of the reference at that time, of a covariance in
// sigma_i sigma_j, of an innovation in sqrt(S), of a gain in sigma_i / sqrt(S_jj).
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "batch.hpp"
#include "smoother_comparison.hpp"

using namespace reference;

namespace
{

constexpr int randomModels = 216;
constexpr int shortModels = 54;
constexpr int shortSteps = 12; // of a dense solve
constexpr int furthest = 10; // steps of a forecast

const Claims filterClaims = {
    {"x-", "x", "e", "forecast x", "forecast z"},
    {"P-", "P", "S", "K", "forecast P", "forecast S"},
    {"nis", "logp", "sum logp"},
    {{"events", 0}, {"taken", 0}, {"forecast changed", 0}}};

// ------------------------------------------------------------------ one sequence

/// The reference before a reading, and the innovation of all components of its sensor, present or not
struct Ahead {
    Belief<Quad> belief;
    Innovation<Quad> all;
};

/// Of each step's readings
std::vector<std::vector<Ahead>> aheadOf(const Study &study)
{
    const Model<Quad> model(study.sequence);
    std::vector<std::vector<Ahead>> ahead(study.track.size());
    for (std::size_t t = 0; t < ahead.size(); ++t) {
        Belief<Quad> belief = study.track[t].predicted;
        for (const Reading &reading : study.sequence.steps[t].readings) {
            const Matrix<Quad> &H = model.H[reading.sensor], &R = model.R[reading.sensor];
            ahead[t].push_back({belief, innovation(belief, H, R, convert<Quad>(reading.z))});
            const Observation<Quad> seen(model, reading);
            if (seen.z.size() > 0) update(belief, seen.H, seen.R, seen.z);
        }
    }
    return ahead;
}

/// One filter of the library beside the reference.
template <class T> class Comparison
{
  public:
    using Api = kq::Api<T>;

    Comparison(const Study &study, const std::vector<std::vector<Ahead>> &ahead)
        : study_(study), expected_(ahead), sequence_(study.sequence), model_(sequence_), library_(sequence_, Processes::shared),
          filter_(library_.states()), ahead_(library_.states())
    {
        library_.init(filter_);
    }

    Figures run()
    {
        for (std::size_t t = 0; t < sequence_.steps.size(); ++t) {
            const Step &step = sequence_.steps[t];
            compareBelief("-", study_.track[t].predicted);
            for (std::size_t k = 0; k < step.readings.size(); ++k) {
                compareInnovation(expected_[t][k].belief, step.readings[k], expected_[t][k].all);
                library_.update(filter_.get(), step.readings[k]);
                compareLikelihood(study_.track[t].updates[k]);
            }
            compareBelief("", study_.track[t].filtered);
            if (t % 23 == 7) compareForecast(t);
            library_.predict(filter_.get(), step);
        }
        // a sensor that says little, beside better ones, is no defect
        figures_.add("events", Api::events(filter_.get()) & ~unsigned{KQ_EVENT_PRECISION});
        return figures_;
    }

  private:
    void compareBelief(const std::string &when, const Belief<Quad> &exact)
    {
        const Belief<Wide<T>> belief = read(filter_);
        const Vector<Quad> unit = units(study_, exact.covariance, floorOf<T>());
        figures_.add("x" + when, meanError(belief.mean, exact.mean, unit));
        figures_.add("P" + when, covarianceError(belief.covariance, exact.covariance, unit));
    }

    /// Innovation, S and gain of all components of the sensor, present or not.
    void compareInnovation(const Belief<Quad> &belief, const Reading &reading,
                           const Innovation<Quad> &exact)
    {
        const auto *sensor = library_.sensor(reading.sensor);
        const Formats<T> &states = library_.states(),
                         &components = library_.components(reading.sensor);
        const auto n = static_cast<std::size_t>(states.count()),
                   m = static_cast<std::size_t>(components.count());
        const auto z = components.words(reading.z);
        std::vector<typename Api::Word> e(m);
        std::vector<typename Api::Coefficient> S(m * m), K(n * m);
        kq::require(Api::innovation(filter_.get(), sensor, z.data(), e.data()), "innovation");
        kq::require(Api::measurement(filter_.get(), sensor, nullptr, S.data()), "measurement");
        kq::require(Api::gain(filter_.get(), sensor, K.data()), "gain");

        const Vector<Quad> deviation = sigmas(exact.S);
        const Vector<Quad> state = units(study_, belief.covariance, floorOf<T>());
        figures_.add("e", meanError(components.values(e, exact.e), exact.e, deviation));
        figures_.add("S",
                     covarianceError(components.covariance(S, components), exact.S, deviation));
        figures_.add("K", covarianceError(states.map(K, components), exact.K, state,
                                          deviation.cwiseInverse()));
    }

    /// NIS beside 1 + NIS; log-likelihood of the run beside the number of scalar measurements.
    void compareLikelihood(const Innovation<Quad> &exact)
    {
        exactLogLikelihood_ += exact.logLikelihood;
        measured_ += static_cast<int>(exact.e.size());
        const Quad nis(Formats<T>::score(Api::nis(filter_.get())));
        const Quad sum(Formats<T>::score(Api::log_likelihood(filter_.get())));
        const Quad last(Formats<T>::score(Api::log_likelihood_last(filter_.get())));
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
        const Index l = sequence_.processes[process].B.cols();
        Matrix<double> u = Matrix<double>::Zero(l, furthest);
        for (std::size_t k = 0; k < furthest && t + k < sequence_.steps.size(); ++k) {
            const Vector<double> &control = sequence_.steps[t + k].u;
            if (control.size() > 0) u.col(static_cast<Index>(k)) = control;
        }
        const auto bytes = *filter_.get();
        const auto memory = filter_.memory();
        for (int k = 1; k <= furthest; ++k) {
            compareForecast(forecast(sequence_, study_.track[t].filtered, process, u, k), process,
                            u, k);
        }
        const bool same = std::memcmp(&bytes, filter_.get(), sizeof bytes) == 0 &&
                          std::memcmp(memory.data(), filter_.memory().data(),
                                      memory.size() * sizeof(typename Api::Word)) == 0;
        figures_.add("forecast changed", same ? 0 : 1);
    }

    void compareForecast(const Belief<Quad> &exact, std::size_t process, const Matrix<double> &u,
                         int steps)
    {
        const auto controls = library_.controls(process).words(u);
        kq::require(Api::forecast(filter_.get(), library_.process(process), dataOrNull(controls),
                                  steps, ahead_.get()),
                    "forecast");
        const Belief<Wide<T>> belief = read(ahead_);
        const Vector<Quad> unit = units(study_, exact.covariance, floorOf<T>());
        figures_.add("forecast x", meanError(belief.mean, exact.mean, unit));
        figures_.add("forecast P", covarianceError(belief.covariance, exact.covariance, unit));

        const Matrix<Quad> &H = model_.H[0], &R = model_.R[0];
        const auto *sensor = library_.sensor(0);
        const Formats<T> &components = library_.components(0);
        const auto m = static_cast<std::size_t>(components.count());
        std::vector<typename Api::Word> z(m);
        std::vector<typename Api::Coefficient> S(m * m);
        kq::require(Api::measurement(ahead_.get(), sensor, z.data(), S.data()), "measurement");
        const Matrix<Quad> exactS = symmetric<Quad>(H * exact.covariance * H.transpose() + R);
        const Vector<Quad> deviation = sigmas(exactS);
        const Vector<Quad> exactZ = H * exact.mean;
        figures_.add("forecast z", meanError(components.values(z, exactZ), exactZ, deviation));
        figures_.add("forecast S",
                     covarianceError(components.covariance(S, components), exactS, deviation));
    }

    const Study &study_;
    const std::vector<std::vector<Ahead>> &expected_;
    const Sequence &sequence_;
    const Model<Quad> model_;
    Library<T> library_;
    FilterOwner<T> filter_, ahead_;
    Figures figures_;
    Quad exactLogLikelihood_ = 0;
    int measured_ = 0;
};

// ------------------------------------------------------------------ the reference itself

/// The same formulas in a shorter type, against quadruple precision.
template <class Real> Figures selfCheck(const Study &study, double floor)
{
    Figures figures;
    const std::vector<Track<Real>> track = filter<Real>(study.sequence);
    for (std::size_t t = 0; t < track.size(); ++t) {
        const Belief<Quad> &exact = study.track[t].filtered;
        const Vector<Quad> unit = units(study, exact.covariance, floor);
        const Belief<Real> &belief = track[t].filtered;
        figures.add("x", meanError(belief.mean.template cast<double>(), exact.mean, unit));
        figures.add("P", covarianceError(belief.covariance.template cast<double>(),
                                         exact.covariance, unit));
    }
    return figures;
}

// ------------------------------------------------------------------ groups

template <class T> void smoothLibrary(Report &report, const std::string &title, bool isNamed, const Case &model)
{
    judge<T>(report, title, isNamed, model, smootherFigures<T>(model), smootherClaims, {1e-9, 1e-10},
             model.refinement(floorOf<T>()));
}

void smoothAll(Report &report, const std::string &group, const Case &model)
{
    const bool isNamed = group == "named models";
    const std::string title = " smoother, " + group;
    compareGain(report, group, model);
    smoothLibrary<double>(report, title, isNamed, model);
    smoothLibrary<float>(report, title, isNamed, model);
    smoothLibrary<Q31>(report, title, isNamed, model);
}

template <class T>
void filterLibrary(Report &report, const std::string &title, bool isNamed, const Study &study, const std::vector<std::vector<Ahead>> &ahead)
{
    judge<T>(report, title, isNamed, study, Comparison<T>(study, ahead).run(), filterClaims, {1e-9, 1e-11});
}

void compareAll(Report &report, const std::string &group, const Sequence &sequence)
{
    const Case study(sequence);
    const bool easy = study.wellConditioned(), isNamed = group == "named models";
    const std::string title = ", " + group + (easy ? "" : ", not well-conditioned");
    report.add("reference in double" + title, sequence.name,
               selfCheck<double>(study, floorOf<double>()),
               easy ? Bounds{{"x", 1e-7}, {"P", 1e-9}} : Bounds{});
    report.add("reference in long double" + title, sequence.name,
               selfCheck<long double>(study, floorOf<double>()),
               easy ? Bounds{{"x", 1e-10}, {"P", 1e-12}} : Bounds{});
    const std::vector<std::vector<Ahead>> ahead = aheadOf(study);
    filterLibrary<double>(report, title, isNamed, study, ahead);
    filterLibrary<float>(report, title, isNamed, study, ahead);
    filterLibrary<Q31>(report, title, isNamed, study, ahead);
    smoothAll(report, group, study);
}

void compareBatch(Report &report, Random &random, int number, bool isCompared)
{
    generator::Options options;
    options.steps = shortSteps;
    options.invertible = true;
    const Sequence sequence = generator::randomSequence(random, number, options);
    if (!isCompared) return;
    const Case model(sequence);
    report.add("dense solve", sequence.name, compareReference(model, smoothByLeastSquares(sequence)),
               boundsOf(smootherClaims, {1e-10, 1e-13}));
    smoothAll(report, "12 steps", model);
}

// ------------------------------------------------------------------ singular covariances

/// Exact and positive semi-definite, of about half rank: it has to be accepted, and to come back.
template <class T> Figures singularStart(const Matrix<double> &P0, const Vector<double> &range)
{
    Figures figures;
    const Index n = P0.rows();
    const Formats<T> states(n, range);
    FilterOwner<T> filter(states);
    const bool refused = filter.init(Vector<double>::Zero(n), P0) != KQ_OK;
    figures.add("refused", refused ? 1 : 0);
    if (refused) return figures;
    const Matrix<Quad> exact = convert<Quad>(P0);
    const double error = covarianceError(read(filter).covariance, exact, sigmas(exact));
    figures.add("P over n eps", error / (static_cast<double>(n) * kq::epsilon<T>()));
    return figures;
}

void compareSingular(Report &report, Random &random)
{
    for (int number = 0; number < 500; ++number) {
        const Index n = 2 + number % 8;
        const Vector<double> scale = generator::powersOfTwo(random, n, -4, 4);
        const Matrix<double> F = generator::randomFactor(random, n, (n + 1) / 2, scale);
        const Matrix<double> P0 = F * F.transpose();
        const std::string name = "covariance " + std::to_string(number);
        const Bounds bounds{{"refused", 0}, {"P over n eps", 16}};
        report.add("f64, singular P0", name, singularStart<double>(P0, scale), bounds);
        report.add("f32, singular P0", name, singularStart<float>(P0, scale), bounds);
        report.add("q31, singular P0", name, singularStart<Q31>(P0, scale), bounds);
    }
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv, generator::defaultSeed);
    const int compared = static_cast<int>(amountOf(argc, argv, randomModels)); // all are drawn
    generator::Options options;
    options.steps = static_cast<int>(amountOf(argc, argv, 200, 3));
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    Random random(seed);
    Report report;
    for (int number = 0; number < randomModels; ++number) {
        const Sequence sequence = generator::randomSequence(random, number, options);
        if (number < compared) compareAll(report, "random models", sequence);
    }
    for (const Sequence &sequence : generator::namedSequences(random, options.steps)) {
        compareAll(report, "named models", sequence);
    }
    Random others = random;
    compareSingular(report, random);
    for (int number = 0; number < shortModels; ++number) compareBatch(report, others, number, number < compared);
    report.print();
    return report.verdict.finish();
}
