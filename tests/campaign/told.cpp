// KQ_EVENT_PRECISION beside the textbook in __float128: how many of its events are false, and how many wrong results have
// an event.  told [models [seed [first]]], 300 1 0; told --ordinary ...; told --file NAME...; -v names the models.
//
//   hard        model.hpp, two thirds; whole.hpp (sensors without noise), one third: of q31's events a third may be
//               false, of f32's wrong runs half may have none, of 100 models or more
//   ordinary    plants.hpp: no event of precision may be false
//   file        a model of its own, all numbers of it: in q31 no view may be wrong without an event
//
// A result is wrong where, at some step, a mean is off by more than 1e-2 sigma or an entry of a covariance by more than
// 0.1 of sigma_i sigma_j; sigma as judge.hpp has it where measurements without noise leave nothing of it.  An event is
// false where all that the view and its filter show is right.  Views: of the filter, of a history that has been
// smoothed, of a lag, of a lag for late measurements, and of an instant, at the end of the run.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <string>

#include "arithmetics.hpp"
#include "plants.hpp"
#include "whole.hpp"

using namespace campaign;

namespace
{

constexpr int leastModels = 100; // that are enough to judge shares by
constexpr double mostOfMean = 1e-2, mostOfCovariance = 0.1;

enum ViewKind { ofFilter, ofHistory, ofLag, ofDelay, ofInstant, views };
const char *const viewNames[] = {"filter", "history", "lag", "delay", "instant"};

struct Found {
    double mean = 0, covariance = 0;
    unsigned events = 0;

    bool isWrong() const { return !(mean <= mostOfMean && covariance <= mostOfCovariance); }
};

template <class T> class Runner
{
    using Api = kq::Api<T>;

  public:
    explicit Runner(const Held &held)
        : sequence_(held.sequence), library_(held.sequence), exact_(held.exact), A_(held.inputs.A()), words_(held.words),
          accuracy_(accuracyOf<T>(held.inputs.n())), units_(accuracy_, held.inputs, held.words), filter_(library_.states())
    {
    }

    std::array<Found, views> run()
    {
        smooth();
        follow(ofLag);
        follow(ofDelay);
        followInstant();
        return found_;
    }

  private:
    /// At step t.  A sigma that is less than a rounding of what its mean is the sum of cannot be told from 0: it is left out.
    void look(ViewKind kind, const Belief &mine, const Belief &right, std::size_t t)
    {
        Vec unit = units_.of(right.covariance, t);
        const std::size_t before = t > 0 ? t - 1 : 0;
        for (Index i = 0; i < unit.size(); ++i) {
            Real terms = abs(right.mean(i));
            for (Index k = 0; k < unit.size(); ++k) terms += abs(A_(i, k) * exact_[before].smoothed.mean(k));
            const Real grain = accuracy_.fixedPoint ? words_(i) : terms;
            if (unit(i) < accuracy_.mean * grain) unit(i) = std::numeric_limits<double>::infinity();
        }
        Found &found = found_[kind];
        found.mean = std::max(found.mean, meanError(mine.mean, right.mean, unit));
        found.covariance = std::max(found.covariance, covarianceError(mine.covariance, right.covariance, unit));
    }

    void lookSmoothed(ViewKind kind, const typename Api::Filter &view, std::size_t t)
    {
        look(kind, toBelief(reference::readView(library_.states(), view)), exact_[t].smoothed, t);
        found_[kind].events |= Api::events(&view);
    }

    void update(std::size_t t)
    {
        for (const Reading &reading : sequence_.steps[t].readings) library_.update(filter_.get(), reading);
    }

    template <class Each> void steps(const Each &each)
    {
        for (std::size_t t = 0; t < exact_.size(); ++t) {
            if (t > 0) library_.predict(filter_.get(), sequence_.steps[t - 1]);
            update(t);
            each(t);
        }
    }

    void smooth()
    {
        reference::HistoryOwner<T> history(library_.states(), 2 * maxComponents, exact_.size(), 1);
        library_.init(filter_);
        kq::require(Api::attach(filter_.get(), &history.get()->attached), "history attach");
        steps([&](std::size_t t) { look(ofFilter, toBelief(reference::read(filter_)), exact_[t].filtered, t); });
        found_[ofFilter].events = Api::events(filter_.get());
        kq::require(Api::smooth(history.get()), "smooth");
        for (std::size_t t = 0; t < exact_.size(); ++t) lookSmoothed(ofHistory, reference::viewSmoothed(history, t), t);
    }

    /// All that a lag of the run's length holds at the end
    void follow(ViewKind kind)
    {
        const int n = library_.states().count();
        const std::size_t most = exact_.size() - 1;
        std::vector<typename Api::Word> memory(Api::length(KQ_OBJECT_LAG, n, 2 * maxComponents, most));
        typename Api::Lag lag{};
        const auto assign = kind == ofLag ? Api::lag_assign : Api::delay_assign;
        kq::require(assign(&lag, n, 2 * maxComponents, most, memory.data(), memory.size()), "assign");
        library_.init(filter_);
        kq::require(Api::attach(filter_.get(), &lag.attached), "attach");
        steps([](std::size_t) {});
        for (std::size_t k = 0; k <= most; ++k) {
            typename Api::Filter view;
            kq::require(Api::lagged(&lag, k, &view), "lagged");
            lookSmoothed(kind, view, most - k);
        }
    }

    void followInstant()
    {
        reference::InstantOwner<T> instant(library_.states(), 2 * maxComponents);
        library_.init(filter_);
        update(0);
        instant.attach(filter_);
        for (std::size_t t = 1; t < exact_.size(); ++t) {
            library_.predict(filter_.get(), sequence_.steps[t - 1]);
            update(t);
        }
        Api::events_clear(filter_.get());
        look(ofInstant, toBelief(instant.smooth()), exact_[0].smoothed, 0);
        found_[ofInstant].events = Api::events(filter_.get());
    }

    const Sequence &sequence_;
    reference::Library<T> library_;
    const Exact &exact_;
    const Mat A_;
    const Vec words_;
    const Accuracy accuracy_;
    const Units units_;
    reference::FilterOwner<T> filter_;
    std::array<Found, views> found_;
};

// ------------------------------------------------------------------ what is counted

/// Of one arithmetic and one view
struct Counts {
    int told = 0, falsely = 0, wrong = 0, wrongTold = 0;
};

struct Tally {
    int models = 0, refused = 0;
    std::array<Counts, views> counts;
    Counts any; // of the run: filter and history
};

bool verbose = false;

void add(Counts &counts, bool told, bool event, bool wrong)
{
    counts.told += told;
    counts.falsely += told && !wrong;
    counts.wrong += wrong;
    counts.wrongTold += wrong && event;
}

/// Events that do not say that a result may be off
constexpr unsigned harmless = KQ_EVENT_REDUNDANT;

template <class T> void judge(Tally &tally, const std::string &id, const std::string &text, const Held &held)
{
    std::array<Found, views> all;
    try {
        all = Runner<T>(held).run();
    } catch (const std::exception &error) {
        if (verbose) std::printf("%s %s refused: %s\n", id.c_str(), kq::Api<T>::name, error.what());
        ++tally.refused;
        return;
    }
    ++tally.models;
    const Found &filter = all[ofFilter], &history = all[ofHistory];
    for (int k = 0; k < views; ++k) {
        const unsigned events = all[k].events | filter.events;
        const bool wrong = all[k].isWrong();
        const unsigned own = k == ofFilter ? events : all[k].events;
        add(tally.counts[k], own & KQ_EVENT_PRECISION, events & ~harmless, wrong || (k != ofFilter && (own & KQ_EVENT_PRECISION) && filter.isWrong()));
    }
    const unsigned events = filter.events | history.events;
    add(tally.any, events & KQ_EVENT_PRECISION, events & ~harmless, filter.isWrong() || history.isWrong());
    if (!verbose) return;
    std::printf("%s %s", id.c_str(), kq::Api<T>::name);
    for (int k = 0; k < views; ++k) {
        std::printf("  %s %.0e %.0e %02x", viewNames[k], all[k].mean, all[k].covariance, all[k].events);
    }
    std::printf("  %s\n", text.c_str());
}

struct Tallies {
    Tally f32, f64, q31;

    Tally &of(float) { return f32; }
    Tally &of(double) { return f64; }
    Tally &of(Q31) { return q31; }
};

void study(Tallies &tallies, const std::string &id, const Model &model)
{
    const auto each = [&](auto arithmetic, const Held &held) {
        judge<decltype(arithmetic)>(tallies.of(arithmetic), id, model.text, held);
    };
    const Inputs inputs = heldByFloats(model.sequence);
    const Exact exact = run(inputs);
    if (model.text.find("units") == std::string::npos && !isResolved(inputs, exact)) return;
    judgeFloats(model.sequence, inputs, exact, each);
    judgeWords(model, exact, each);
}

void print(const char *name, const Tally &tally)
{
    std::printf("%s: %d models, %d refused\n", name, tally.models, tally.refused);
    const auto line = [&](const char *what, const Counts &c) {
        std::printf("  %-8s PRECISION %4d, false %4d;  wrong %4d, of them with an event %4d (%.0f %%)\n", what, c.told, c.falsely, c.wrong,
                    c.wrongTold, c.wrong ? 100.0 * c.wrongTold / c.wrong : 100);
    };
    for (int k = 0; k < views; ++k) line(viewNames[k], tally.counts[static_cast<std::size_t>(k)]);
    line("run", tally.any);
}

Model fromFile(const char *name)
{
    std::ifstream in(name);
    Index n, m, l, width, count;
    in >> n >> m >> l >> width >> count;
    const auto read = [&](Index rows, Index columns) {
        Matrix<double> M(rows, columns);
        for (Index i = 0; i < rows; ++i) {
            for (Index j = 0; j < columns; ++j) {
                std::string word;
                in >> word;
                M(i, j) = std::strtod(word.c_str(), nullptr);
            }
        }
        return M;
    };
    Model model;
    Sequence &s = model.sequence;
    reference::ProcessModel process;
    process.A = read(n, n);
    process.B = read(n, l);
    process.F = read(n, width);
    reference::SensorModel sensor;
    sensor.H = read(m, n);
    sensor.R = read(m, m);
    s.x0 = read(n, 1);
    s.P0 = read(n, n);
    const Matrix<double> ranges = read(n, 1), most = read(m, 1), z = read(count, m), u = read(count, l);
    s.processes.push_back(process);
    s.sensors.push_back(sensor);
    for (Index t = 0; t < count; ++t) {
        reference::Step step{{}, 0, Vector<double>()};
        std::uint32_t present = 0;
        Vector<double> now(m);
        for (Index c = 0; c < m; ++c) {
            if (!std::isnan(z(t, c))) present |= UINT32_C(1) << c;
            now(c) = std::isnan(z(t, c)) ? 0 : z(t, c);
        }
        step.readings.push_back({0, now, present});
        if (l > 0) step.u = u.row(t).transpose();
        s.steps.push_back(step);
    }
    model.units = Vector<double>::Ones(n);
    model.largest = ranges / 1.5;
    model.repeated.push_back(false);
    model.text = name;
    return model;
}

} // namespace

int main(int argc, char **argv)
{
    const Options options(argc, argv, 300);
    const bool isOrdinary = options.option == "--ordinary", ofFiles = options.option == "--file";
    Tallies tallies;
    verbose = options.isVerbose;
    for (int k = argc; ofFiles && argv[--k] != options.option;) study(tallies, argv[k], fromFile(argv[k]));
    const auto each = [&](std::uint64_t k, const std::string &id) {
        try {
            study(tallies, id, isOrdinary ? plantModel(options.seed, k) : k % 3 == 2 ? wholeModel(options.seed, k, 0.7)
                                                                                     : randomModel(options.seed, k));
        } catch (const std::exception &error) {
            std::printf("%s not run: %s\n", id.c_str(), error.what());
        }
    };
    if (!ofFiles) options.forEach(each);
    print("f32", tallies.f32);
    print("f64", tallies.f64);
    print("q31", tallies.q31);
    bool good = true;
    if (isOrdinary) {
        for (const Tally *tally : {&tallies.f32, &tallies.f64, &tallies.q31}) good &= tally->any.falsely == 0;
    } else if (ofFiles) {
        for (const Counts &counts : tallies.q31.counts) good &= counts.wrong == counts.wrongTold;
    } else if (options.models >= leastModels) {
        good = 3 * tallies.q31.any.falsely <= tallies.q31.any.told && 2 * tallies.f32.any.wrongTold >= tallies.f32.any.wrong;
    }
    std::printf("%s\n", good ? "passed" : "FAILED");
    return good ? 0 : 1;
}
