// Which results are wrong and what the events say of it, beside the textbook in __float128: told [STUDY] [models [seed [first]]],
// hard 300 1 0; told files NAME...  It names the models that are wrong or have the event for nothing; with -v all that have one.
//
//   hard        kinds.hpp, mixed: KQ_EVENT_PRECISION of all views; of q31's events a third may be false, of f32's wrong runs
//               half may have none
//   ordinary    no event of precision may be false
//   files       models of their own, all numbers of them: in q31 no view may be wrong without an event
//   noise_free  smoothers behind sensors without noise, where the filter is right to a tenth of the limit, and there is a
//               reference: of f32's one in 250 may be wrong without an event of the history
//   noisy       the same where every component has noise: in f32 and f64 no event of precision may be false
//   low_noise   lean sensors beside full ones: of an arithmetic, lean ones may have so many more wrong models as 1 % of all,
//               and up to a P0 / R (`sure`) none may be wrong
//   spread      priors of five decades, a singular A, no noise, beside the textbook that takes the measurements that the
//               arithmetic took.  Where the filter's P is right to 1e-2, and there is a reference, smoothed P is wrong in one
//               model of 100 at most, a mean in one of 25: by 1e-3 and ten times what the filter is off by.  P is positive
//               semi-definite in all; nothing is left out that says something; one filter in 20 may be off
//
// A result is wrong where, at some step, a mean is off by more sigmas, or an entry of a covariance by more of sigma_i
// sigma_j, than its study allows; sigma as judge.hpp has it where measurements without noise leave nothing of it.  An
// event is false where all that the view (exact.hpp) and its filter show is right.  The run is the filter and the history.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "arithmetics.hpp"
#include "claims.hpp"

using namespace campaign;

namespace
{

constexpr int enough = 100;                // models to judge shares by
constexpr int enoughSpread = 900;          // of one in 100
constexpr int classes[] = {6, 10, 15};     // of log10 P0 / R
constexpr double mostOfScore = 0.01;       // of NIS and log-likelihood
constexpr double shareOfFilter = 0.1;      // of a limit: what the filter is off by where its smoother is judged
constexpr double lostFilter = 1e-2;        // of P: a filter that is off by more has no smoother to be judged
constexpr double wrongSpread = 1e-3;       // of mean and P, where a tenth of it is not the filter's
constexpr double informative = 1e-10;      // of the variance of a component that nothing else has told: an arithmetic sees it
constexpr View allViews[] = {ofFilter, ofHistory, ofLag, ofDelay, ofInstant};

bool verbose = false;

struct Limits {
    double mean, covariance;

    bool hold(const Found &found) const { return found.mean <= mean && found.covariance <= covariance; }
};

/// Less than 1e-4 of a sigma before the measurements of the step, or 1e-7 of the largest of the run, is nothing to a float.
std::vector<Vec> leastSigmas(const Exact &exact)
{
    Vec top = Vec::Zero(exact[0].predicted.mean.size());
    for (const Instant &now : exact) top = top.cwiseMax(reference::sigmas(now.predicted.covariance));
    const Vec least = reference::positiveOr(Vec(Real(1e-7) * top), Real(std::numeric_limits<double>::infinity()));
    std::vector<Vec> all;
    for (const Instant &now : exact) all.push_back((Real(1e-4) * reference::sigmas(now.predicted.covariance)).cwiseMax(least));
    return all;
}

std::string upTo(int level) { return "to 1e" + std::to_string(level); }

// ------------------------------------------------------------------ a model in an arithmetic

template <class T> class Study
{
  public:
    Study(Tally &tally, const Held &held)
        : tally_(tally), held_(held), accuracy_(accuracyOf<T>(held.inputs.n())), units_(accuracy_, held.inputs, held.words)
    {
    }

    void judgeAllViews()
    {
        if (held_.model.text.find("units") == std::string::npos && !held_.areFloatsResolved) return;
        const Limits limits = {1e-2, 0.1};
        const Outcome outcome = runOf(false, &Campaigner<T>::runOfAllViews);
        if (!outcome.refused.empty()) return refuse(outcome, {"run"});
        const auto unitOf = [this](const Belief &right, std::size_t t) { return aboveRounding(right, t); };
        const Found filter = worstOf(outcome, held_.exact, ofFilter, unitOf);
        bool isRunWrong = false;
        for (const View view : allViews) {
            const Found found = worstOf(outcome, held_.exact, view, unitOf);
            const bool isTold = found.events & KQ_EVENT_PRECISION, isWrong = !limits.hold(found);
            const bool isOfFilter = isTold && !limits.hold(filter);
            add(viewNames[view], found, {isWrong || isOfFilter, isTold, ((found.events | filter.events) & ~harmless) != 0});
            if (view == ofFilter || view == ofHistory) isRunWrong |= isWrong;
        }
        const unsigned events = outcome.viewEvents[ofFilter] | outcome.viewEvents[ofHistory];
        line("run").add({isRunWrong, (events & KQ_EVENT_PRECISION) != 0, (events & ~harmless) != 0});
    }

    void judgeSmoother()
    {
        if (!isResolved(held_.inputs, held_.exact)) return void(++line("without reference").judged);
        const Outcome outcome = runOf(false, &Campaigner<T>::run);
        if (!outcome.refused.empty()) return refuse(outcome, {"history"});
        const Found filter = worstOf(outcome, held_.exact, ofFilter, plainUnit());
        const double most = shareOfFilter * mostOfSmoother();
        if (!Limits{most, most}.hold(filter) || !std::isfinite(worstScore(outcome, held_.exact))) {
            return void(++line("filter off").judged);
        }
        const auto unitOf = [this](const Belief &right, std::size_t t) { return aboveFilter(right, t); };
        const Found found = worstOf(outcome, held_.exact, ofHistory, unitOf);
        const bool isWrong = !Limits{mostOfSmoother(), mostOfSmoother()}.hold(found);
        const bool hasEvent = found.events != 0 || (found.eventsOnTheWay & ~harmless) != 0;
        add("history", found, {isWrong, (found.events & KQ_EVENT_PRECISION) != 0, hasEvent});
    }

    /// Beside the textbook that takes what the arithmetic took
    void judgeAsTaken()
    {
        const Outcome outcome = runOf(false, &Campaigner<T>::run);
        if (!outcome.refused.empty()) return refuse(outcome, {"history"});
        line("not PSD").add({!(outcome.indefinite <= 1), false, false});
        AsTaken rounding(held_.inputs, outcome.instants);
        const Exact exact = run(held_.inputs, rounding);
        if (!isResolved(held_.inputs, exact)) return void(++line("without reference").judged);
        const std::vector<Vec> least = leastSigmas(exact);
        const auto unitOf = [&least](const Belief &right, std::size_t t) { return reference::sigmas(right.covariance).cwiseMax(least[t]); };
        const Found filter = worstOf(outcome, exact, ofFilter, unitOf);
        const bool isOff = !(filter.covariance < lostFilter);
        line("filter off").judged += isOff;
        if (isOff) return;
        line("left out").add({leavesOut(held_.inputs, exact, informative), false, false});
        const Limits limits = {std::max(wrongSpread, 10 * filter.mean), std::max(wrongSpread, 10 * filter.covariance)};
        for (const View view : {ofHistory, ofLag}) {
            const Found found = worstOf(outcome, exact, view, unitOf);
            const bool hasEvent = ((found.events | filter.events) & ~harmless) != 0;
            add(viewNames[view], found, {!(found.covariance <= limits.covariance), false, hasEvent});
            line(std::string(viewNames[view]) + " mean").add({!(found.mean <= limits.mean), false, hasEvent});
        }
    }

    void judgeFullAndLean()
    {
        const int level = *std::lower_bound(classes, std::end(classes), held_.model.decades);
        for (const bool isLean : {false, true}) {
            form_ = isLean ? " lean" : " full";
            judgeForm(isLean, upTo(level));
        }
    }

  private:
    static double mostOfSmoother() { return std::is_same_v<T, float> ? 0.05 : std::is_same_v<T, double> ? 1e-6 : 1e-3; }

    Counts &line(const std::string &part) { return tally_[kq::Api<T>::name + form_ + " " + part]; }

    template <class Run> Outcome runOf(bool isLean, const Run &run) const
    {
        reference::Library<T> library(held_.sequence, reference::Processes::separate, isLean);
        return (Campaigner<T>(held_.sequence, library).*run)();
    }

    void refuse(const Outcome &outcome, const std::vector<std::string> &parts)
    {
        for (const std::string &part : parts) ++line(part).refused;
        std::printf("%s %s%s refused: %s; %s\n", held_.id.c_str(), kq::Api<T>::name, form_.c_str(), outcome.refused.c_str(),
                    held_.model.text.c_str());
    }

    /// Counts, and names what is wrong or told for nothing.
    void add(const char *part, const Found &found, const Outcry &of)
    {
        line(part).add(of);
        if (!of.isWrong && !of.isTold && !(verbose && (found.events & ~harmless))) return;
        std::printf("%s %s%s %s: mean %.0e covariance %.0e at %zu, events %02x%s%s; %s\n", held_.id.c_str(), kq::Api<T>::name,
                    form_.c_str(), part, found.mean, found.covariance, found.at, found.events, of.isWrong ? ", wrong" : "",
                    of.isWrong && !of.hasEvent ? " without an event" : "", held_.model.text.c_str());
    }

    void addTo(const std::string &level, const char *part, const Found &found, const Outcry &of)
    {
        add(part, found, of);
        line(level + " " + part).add(of);
    }

    void judgeForm(bool isLean, const std::string &level)
    {
        const Limits limits = {0.1, 0.1};
        const Outcome outcome = runOf(isLean, &Campaigner<T>::run);
        if (!outcome.refused.empty()) {
            for (const char *part : {"filter", "history"}) addTo(level, part, {}, {true, false, true});
            return refuse(outcome, {"filter", "history"});
        }
        const auto look = [&](View view) { return worstOf(outcome, held_.exact, view, plainUnit()); };
        const Found filter = look(ofFilter), history = look(ofHistory);
        const unsigned own = filter.events & ~harmless, all = own | history.events;
        const bool isWrong = !limits.hold(filter), isSmoothedWrong = !limits.hold(history);
        bool areMeansWrong = false;
        for (const View view : {ofMeans, ofLag, ofInstant}) areMeansWrong |= !(look(view).mean <= limits.mean);
        addTo(level, "filter", filter, {isWrong, (own & KQ_EVENT_PRECISION) != 0, own != 0});
        addTo(level, "history", history, {isSmoothedWrong, (all & KQ_EVENT_PRECISION) != 0, all != 0});
        addTo(level, "means", {}, {areMeansWrong, false, all != 0});
        line("run").add({isWrong || isSmoothedWrong, (all & KQ_EVENT_PRECISION) != 0, all != 0});
        line("scores").add({!(worstScore(outcome, held_.exact) <= mostOfScore), false, all != 0});
        line("not PSD").add({!(outcome.indefinite <= 1), false, all != 0});
        line("saturated").add({(all & KQ_EVENT_SATURATED) != 0, false, true});
    }

    auto plainUnit() const
    {
        return [this](const Belief &right, std::size_t t) { return units_.of(right.covariance, t); };
    }

    /// A sigma that is less than a rounding of what its mean is the sum of cannot be told from 0: it is left out.
    Vec aboveRounding(const Belief &right, std::size_t t) const
    {
        Vec unit = units_.of(right.covariance, t);
        const Mat &A = held_.inputs.A(t > 0 ? t - 1 : 0);
        const Vec &before = held_.exact[t > 0 ? t - 1 : 0].smoothed.mean;
        for (Index i = 0; i < unit.size(); ++i) {
            Real terms = abs(right.mean(i));
            for (Index k = 0; k < unit.size(); ++k) terms += abs(A(i, k) * before(k));
            const Real grain = accuracy_.fixedPoint ? held_.words(i) : terms;
            if (unit(i) < accuracy_.mean * grain) unit(i) = std::numeric_limits<double>::infinity();
        }
        return unit;
    }

    /// A few roundings of the filtered sigma are no more than the limit.
    Vec aboveFilter(const Belief &right, std::size_t t) const
    {
        Vec unit = units_.of(right.covariance, t);
        for (Index i = 0; i < unit.size(); ++i) {
            const Real rounding = accuracy_.smoother * sigma(held_.exact[t].filtered.covariance, i);
            unit(i) = std::max(unit(i), few * rounding / mostOfSmoother());
        }
        return unit;
    }

    Tally &tally_;
    const Held &held_;
    const Accuracy accuracy_;
    const Units units_;
    std::string form_; // of its sensors
};

// ------------------------------------------------------------------ the studies

constexpr int Counts::*judged = &Counts::judged, Counts::*falsely = &Counts::falsely, Counts::*told = &Counts::told,
                       Counts::*wrong = &Counts::wrong, Counts::*silent = &Counts::silent;

/// Lean sensors; up to a P0 / R, which the arithmetic says, nothing may be wrong.
std::vector<Claim> claimsOfLean(int models)
{
    std::vector<Claim> claims;
    const std::pair<const char *, int> sure[] = {{"f32", 6}, {"f64", 15}, {"q31", 10}};
    for (const auto &[arithmetic, most] : sure) {
        const std::string full = std::string(arithmetic) + " full", lean = std::string(arithmetic) + " lean";
        for (const std::string part : {" filter", " history", " means"}) {
            claims.push_back({lean + part, wrong, 1, full + part, wrong, models / 100});
            for (const int level : classes) {
                if (level > most) continue;
                claims.push_back({full + " " + upTo(level) + part, wrong});
                claims.push_back({lean + " " + upTo(level) + part, wrong});
            }
        }
    }
    return claims;
}

/// q31 leaves out what its last bits hide.  Of few models two more may be wrong: shares of them are chance.
std::vector<Claim> claimsOfSpread(int models)
{
    const int slack = models < enoughSpread ? 200 : 0;
    std::vector<Claim> claims = {{"f32 left out", wrong}, {"f64 left out", wrong}, {"q31 left out", wrong, 100, "q31 left out", judged}};
    for (const std::string arithmetic : {"f32", "f64", "q31"}) {
        claims.push_back({arithmetic + " not PSD", wrong});
        claims.push_back({arithmetic + " filter off", judged, 20, arithmetic + " history", judged});
        for (const std::string view : {" history", " lag"}) {
            claims.push_back({arithmetic + view, wrong, 100, arithmetic + view, judged, slack});
            claims.push_back({arithmetic + view + " mean", wrong, 25, arithmetic + view, judged});
        }
    }
    return claims;
}

std::vector<Claim> claimsOf(const std::string &study, int models)
{
    if (study == "hard" && models < enough) return {};
    if (study == "hard") return {{"q31 run", falsely, 3, "q31 run", told}, {"f32 run", silent, 2, "f32 run", wrong}};
    if (study == "ordinary") return {{"f32 run", falsely}, {"f64 run", falsely}, {"q31 run", falsely}};
    if (study == "files") {
        return {{"q31 filter", silent}, {"q31 history", silent}, {"q31 lag", silent}, {"q31 delay", silent}, {"q31 instant", silent}};
    }
    if (study == "noise_free") return {{"f32 history", silent, 250, "f32 history", judged}};
    if (study == "noisy") return {{"f32 history", falsely}, {"f64 history", falsely}};
    if (study == "low_noise") return claimsOfLean(models);
    if (study == "spread") return claimsOfSpread(models);
    std::printf("FAILED  nothing is claimed of %s: give it a row in claimsOf\n", study.c_str());
    std::exit(1);
}

/// By rows; NaN, too
Matrix<double> matrixFrom(std::ifstream &in, Index rows, Index columns)
{
    Matrix<double> M(rows, columns);
    std::string word;
    for (Index k = 0; k < rows * columns && in >> word; ++k) M(k / columns, k % columns) = std::strtod(word.c_str(), nullptr);
    return M;
}

Model fromFile(const char *name)
{
    std::ifstream in(name);
    Index n, m, l, width, count;
    in >> n >> m >> l >> width >> count;
    Model model;
    Sequence &s = model.sequence;
    s.processes.resize(1), s.sensors.resize(1);
    reference::ProcessModel &process = s.processes[0];
    for (const auto &[M, columns] : {std::pair(&process.A, n), std::pair(&process.B, l), std::pair(&process.F, width)}) {
        *M = matrixFrom(in, n, columns);
    }
    s.sensors[0].H = matrixFrom(in, m, n);
    s.sensors[0].R = matrixFrom(in, m, m);
    s.x0 = matrixFrom(in, n, 1);
    s.P0 = matrixFrom(in, n, n);
    model.units = Vector<double>::Ones(n);
    model.largest = matrixFrom(in, n, 1) / 1.5; // of the declared ranges
    (void)matrixFrom(in, m, 1);                 // those of the measurements: they are made of the data
    const Matrix<double> z = matrixFrom(in, count, m), u = matrixFrom(in, count, l);
    for (Index t = 0; t < count; ++t) {
        Reading reading{0, Vector<double>(m), 0};
        for (Index c = 0; c < m; ++c) {
            if (std::isnan(z(t, c))) continue;
            reading.present |= UINT32_C(1) << c;
            reading.z(c) = z(t, c);
        }
        s.steps.push_back({{reading}, 0, l > 0 ? Vector<double>(u.row(t).transpose()) : Vector<double>()});
    }
    model.repeated.push_back(false);
    model.text = name;
    return model;
}

} // namespace

int main(int argc, char **argv)
{
    const Options options(argc, argv, 300);
    const std::string study = options.what.empty() ? "hard" : options.what;
    Tally tally;
    verbose = options.isVerbose;
    const auto judge = [&](auto arithmetic, const Held &held) {
        Study<decltype(arithmetic)> now(tally, held);
        if (study == "low_noise") now.judgeFullAndLean();
        else if (study == "spread") now.judgeAsTaken();
        else if (study == "noise_free" || study == "noisy") now.judgeSmoother();
        else now.judgeAllViews();
    };
    for (int k = argc; study == "files" && argv[--k] != study;) through(argv[k], fromFile(argv[k]), judge);
    const int notRun = study == "files" ? 0 : options.through(study == "hard" ? "mixed" : study, judge).notRun;
    tally.print();
    const bool isComplete = study != "low_noise" || notRun == 0; // of the other kinds what is not run is named, and left out
    return tally.fulfils(claimsOf(study, static_cast<int>(options.models))) && isComplete ? 0 : 1;
}
