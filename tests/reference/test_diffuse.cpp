// An unknown start against its limit, the generalised least-squares solution (flat.hpp), in
// quadruple precision.
//
//     test_diffuse [seed]
//
// x: max |x - x_ref|_i / sigma_ref_i,  P: max |P - P_ref|_ij / (sigma_i sigma_j), over the steps
// from which on the state is determined, filtered, and over all steps, smoothed; l: |llf -
// llf_ref|. Whether a component is determined is held against the rank of the least-squares problem
// at every step, filtered and smoothed.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "accuracy.hpp"
#include "api.hpp"
#include "flat.hpp"
#include "generator.hpp"
#include "library.hpp"
#include "readings.hpp"
#include "study.hpp"
#include "verdict.hpp"

using namespace reference;

namespace
{

constexpr int randomModels = 80, randomSteps = 12, namedSteps = 30;

/// A run and what is right for it.
struct Case {
    const Sequence &sequence;
    std::uint32_t unknown;
    std::vector<PartBelief> filtered, smoothed;
    double logLikelihood, strength;
    double reach = 1; // the most sigmas that a mean is from where it was counted from
    Vector<Quad> largest;

    Case(const Sequence &data, std::uint32_t mask)
        : sequence(data), unknown(mask), largest(sigmas(convert<Quad>(data.P0)))
    {
        const Flat flat(data, mask);
        for (std::size_t t = 0; t < data.steps.size(); ++t) {
            filtered.push_back(flat.filtered(t));
            smoothed.push_back(flat.smoothed(t));
            note(filtered.back());
            note(smoothed.back());
        }
        logLikelihood = static_cast<double>(flat.logLikelihood());
        strength = flat.weakest();
        for (const SensorModel &sensor : data.sensors) {
            if (!sensor.diagonal()) strength /= conditionOf(convert<Quad>(sensor.R));
        }
    }

    /// sigma, but no less than a part of the largest one of what is known
    template <class T> Vector<Quad> unit(const Matrix<Quad> &P) const
    {
        return sigmas(P).cwiseMax(Quad(floorOf<T>()) * largest);
    }

    /// What rounding explains: an entry of D, and with it k, is off by eps / strength for each of
    /// the n terms that it is the sum of, a mean by that times what it has moved.
    template <class T> double rounding() const
    {
        return static_cast<double>(sequence.states()) * kq::epsilon<T>() / strength;
    }

  private:
    void note(const PartBelief &now)
    {
        const Vector<Quad> sigma = sigmas(now.belief.covariance);
        for (Index i = 0; i < sigma.size(); ++i) {
            if (!now.known[static_cast<std::size_t>(i)] || sigma(i) == 0) continue;
            if (sigma(i) > largest(i)) largest(i) = sigma(i);
            const Quad move = now.belief.mean(i) - Quad(sequence.x0(i));
            reach = std::max(reach, ratio(move, sigma(i)));
        }
    }
};

/// The errors of one run.
struct Errors {
    Worst filtered, smoothed;
    double logLikelihood = 0;
    int wrong = 0; // components whose determinedness is not the reference's
    unsigned events = 0;
};

template <class T> class StartOwner : NotCopied
{
    using Api = kq::Api<T>;

  public:
    StartOwner(int n, std::size_t early) : memory_(Api::length(KQ_OBJECT_DIFFUSE, n, 0, early))
    {
        kq::require(Api::diffuse_assign(&handle_, n, early, memory_.data(), memory_.size()),
                    "start assign");
    }
    typename Api::Start *get() { return &handle_; }

  private:
    std::vector<typename Api::Word> memory_;
    typename Api::Start handle_{};
};

template <class T>
kq_status init(StartOwner<T> &start, FilterOwner<T> &filter, const Sequence &sequence,
               std::uint32_t unknown)
{
    if constexpr (std::is_same_v<T, Q31>) {
        const Prior prior(filter.states(), sequence.x0, sequence.P0);
        kq::require(prior.status, "root prepare");
        return kq_diffuse_init_q31(start.get(), filter.get(), &prior.table, unknown, nullptr);
    } else {
        return kq::Api<T>::diffuse_init(start.get(), filter.get(), flattened<T>(sequence.x0).data(),
                                        flattened<T>(sequence.P0).data(), unknown);
    }
}

template <class Word> bool isKnown(Word word) { return !std::isnan(word); }
template <> bool isKnown(std::int32_t word) { return word != KQ_NOT_A_VALUE_Q31; }

template <class T> class Run
{
    using Api = kq::Api<T>;

  public:
    explicit Run(const Case &model)
        : model_(model), library_(model.sequence), filter_(library_.states()),
          history_(library_.states(), std::max(1, depth(model.sequence)),
                   model.sequence.steps.size(), changes(model.sequence)),
          start_(library_.states().count(), model.sequence.steps.size())
    {
        kq::require(init(start_, filter_, model.sequence, model.unknown), "start init");
        kq::require(Api::attach(filter_.get(), &history_.get()->attached), "history attach");
    }

    Errors errors()
    {
        const std::vector<Step> &steps = model_.sequence.steps;
        for (std::size_t t = 0; t < steps.size(); ++t) {
            for (const Reading &reading : steps[t].readings) {
                library_.update(filter_.get(), reading);
            }
            compareFiltered(t);
            if (t + 1 < steps.size()) library_.predict(filter_.get(), steps[t]);
        }
        const auto logLikelihood =
            static_cast<double>(Formats<T>::score(Api::log_likelihood(filter_.get())));
        errors_.logLikelihood = std::fabs(logLikelihood - model_.logLikelihood);
        errors_.events = Api::events(filter_.get());
        kq::require(Api::diffuse_smooth(start_.get()), "start smooth");
        for (std::size_t t = 0; t < steps.size(); ++t) compareSmoothed(t);
        return errors_;
    }

  private:
    void countWrong(const typename Api::Filter &found, const std::vector<bool> &known)
    {
        for (std::size_t i = 0; i < known.size(); ++i) {
            errors_.wrong += isKnown(Api::mean(&found, static_cast<int>(i))) != known[i];
        }
    }

    void compareFiltered(std::size_t t)
    {
        const PartBelief &exact = model_.filtered[t];
        countWrong(*filter_.get(), exact.known);
        if (Api::diffuse_count(start_.get()) > 0) return;
        errors_.filtered.add(read(filter_), exact.belief, model_.unit<T>(exact.belief.covariance));
    }

    void compareSmoothed(std::size_t t)
    {
        const PartBelief &exact = model_.smoothed[t];
        typename Api::Filter view;
        kq::require(Api::diffuse_smoothed(start_.get(), t, &view), "start smoothed");
        countWrong(view, exact.known);
        const Formats<T> &states = library_.states();
        const auto n = static_cast<std::size_t>(states.count());
        std::vector<typename Api::Coefficient> P(n * n);
        if (Api::covariance(&view, P.data()) != KQ_OK) return;
        errors_.smoothed.add(readView(states, view), exact.belief,
                             model_.unit<T>(exact.belief.covariance));
    }

    const Case &model_;
    Library<T> library_;
    FilterOwner<T> filter_;
    HistoryOwner<T> history_;
    StartOwner<T> start_;
    Errors errors_;
};

/// All runs of one group in one arithmetic.
struct Group {
    std::map<std::string, std::vector<double>> figures;
    int wrong = 0, saturated = 0;

    /// rounding: of P; reach: times that, of x
    void add(const Errors &errors, double rounding, double reach)
    {
        if (errors.events & KQ_EVENT_SATURATED) {
            ++saturated;
            return;
        }
        wrong += errors.wrong;
        figures["x"].push_back(errors.filtered.x);
        figures["P"].push_back(errors.filtered.P);
        figures["smoothed x"].push_back(errors.smoothed.x);
        figures["smoothed P"].push_back(errors.smoothed.P);
        figures["l"].push_back(errors.logLikelihood);
        figures["x in roundings"].push_back(std::max(errors.filtered.x, errors.smoothed.x) /
                                            (rounding * reach));
        figures["P in roundings"].push_back(std::max(errors.filtered.P, errors.smoothed.P) /
                                            rounding);
    }

    double share(const std::string &name, double quantile)
    {
        std::vector<double> &values = figures[name];
        if (values.empty()) return 0;
        std::sort(values.begin(), values.end());
        const auto last = static_cast<double>(values.size() - 1);
        return values[static_cast<std::size_t>(quantile * last)];
    }
};

using Groups = std::map<std::string, Group>;

/// The goals of a group: x and P filtered, x and P smoothed, l; x and P in roundings.  Infinite:
/// reported only.
struct Goals {
    const char *group;
    double x, P, smoothedX, smoothedP, l, xInRoundings, PInRoundings;
};

/// A smoothed state has the errors of the tape's 26 bits in q31, and what is weak is held to
/// nothing.
constexpr Goals goals[] = {
    {"named models, f64", 1e-11, 1e-12, 1e-11, 1e-12, 1e-10, infinite, infinite},
    {"named models, f32", 1e-4, 2e-5, 1e-4, 2e-5, 1e-3, infinite, infinite},
    {"named models, q31", 1e-6, 1e-6, 1e-5, 1e-5, 1e-5, infinite, infinite},
    {"noise-free models, f64", 1e-8, 1e-8, 1e-8, 1e-8, 1e-8, infinite, infinite},
    {"noise-free models, f32", 1e-3, 2e-5, 1e-3, 2e-5, 1e-3, infinite, infinite},
    {"noise-free models, q31", 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, infinite, infinite},
    {"random models, f64", 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, infinite, infinite},
    {"random models, f32", infinite, infinite, infinite, infinite, infinite, 32, 64},
    {"random models, q31", 1e-4, 1e-4, 1e-4, 1e-4, 1e-3, infinite, infinite},
    {"weak models, f64", infinite, infinite, infinite, infinite, infinite, infinite, infinite},
    {"weak models, f32", infinite, infinite, infinite, infinite, infinite, infinite, infinite},
    {"weak models, q31", infinite, infinite, infinite, infinite, infinite, infinite, infinite}};

/// Determined by less than this share of the terms: a float cannot tell it well from nothing.
constexpr double weakness = 1e-3;

/// A particular solution of what is not yet determined may be beyond the words of q31.
constexpr double saturatedShare = 0.15;

void judge(Verdict &verdict, const Goals &goal, Group &group)
{
    const std::pair<const char *, double> limits[] = {{"x", goal.x},
                                                      {"P", goal.P},
                                                      {"smoothed x", goal.smoothedX},
                                                      {"smoothed P", goal.smoothedP},
                                                      {"l", goal.l},
                                                      {"x in roundings", goal.xInRoundings},
                                                      {"P in roundings", goal.PInRoundings}};
    const std::string title = goal.group;
    const std::size_t runs = group.figures["x"].size();
    std::printf("%s: %zu runs, %d saturated, %d wrong\n", goal.group, runs, group.saturated,
                group.wrong);
    for (const auto &[name, limit] : limits) {
        std::printf("    %-15s %8.1e %8.1e %8.1e\n", name, group.share(name, 0.5),
                    group.share(name, 0.9), group.share(name, 1));
        verdict.expectAtMost(group.share(name, 1), limit, title + ": " + name);
    }
    const bool weak = title.find("weak") == 0;
    verdict.expect(weak || group.wrong == 0, title + ": what is determined");
    verdict.expect(weak || runs > 0, title + ": no runs");
    verdict.expect(weak || group.saturated <= saturatedShare * static_cast<double>(runs) + 1,
                   title + ": too many saturated");
}

template <class T> void addRun(Groups &groups, const std::string &group, const Case &model)
{
    const Errors errors = Run<T>(model).errors();
    groups[group + ", " + kq::Api<T>::name].add(errors, model.rounding<T>(), model.reach);
}

/// Ranges, declared from a run with a prior, are made so wide that q31 has no need of them as a prior.
constexpr double room = 64;

/// Is a state at some time so uncertain that its range says more? Then q31 takes that for a prior.
bool isBounded(const Case &model)
{
    for (Index i = 0; i < model.largest.size(); ++i) {
        if (model.largest(i) > Quad(model.sequence.range(i) / 12)) return true;
    }
    return false;
}

void compare(Groups &groups, const std::string &kind, Sequence sequence, std::uint32_t unknown)
{
    sequence.range *= room;
    for (SensorModel &sensor : sequence.sensors) sensor.range *= room;
    const Case model(sequence, unknown);
    const std::string group =
        kind == "random models" && model.strength < weakness ? "weak models" : kind;
    addRun<double>(groups, group, model);
    addRun<float>(groups, group, model);
    addRun<Q31>(groups, isBounded(model) ? "weak models" : group, model);
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv, generator::defaultSeed);
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    Random random(seed);
    Groups groups;
    for (int number = 0; number < randomModels; ++number) {
        generator::Options options;
        options.steps = randomSteps;
        options.invertible = number % 2 == 0;
        const Sequence sequence = generator::randomSequence(random, number, options);
        const auto all = (UINT32_C(1) << sequence.states()) - 1;
        const std::uint32_t unknown =
            number % 3 == 0 ? all : static_cast<std::uint32_t>(random.integer(1, int(all)));
        compare(groups, "random models", sequence, unknown);
    }
    for (const Sequence &sequence : generator::namedSequences(random, namedSteps)) {
        const auto all = (UINT32_C(1) << sequence.states()) - 1;
        const bool noiseFree = sequence.sensors[0].R.isZero(0);
        const std::string group = noiseFree ? "noise-free models" : "named models";
        compare(groups, group, sequence, all);
        compare(groups, group, sequence, 1);
    }
    std::printf("median, 90 %%, largest\n");
    Verdict verdict;
    for (const Goals &goal : goals) judge(verdict, goal, groups[goal.group]);
    return verdict.finish();
}
