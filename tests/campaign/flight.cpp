// Sensor faults over a flight: height, climb and the offset of a barometer, seen by a GPS and by the barometer, which is seven times
// as precise.  A word of a sensor is stuck, late, swapped with the other's or taken twice, once in a thousand rows.  What is found, what
// heals and what misleads, with each means that the library has:
//
//     flight ROWS        100000 by default; prints the table in markdown
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <type_traits>
#include <vector>

#include "../reference/owners.hpp"
#include "../reference/random.hpp"
#include "../reference/verdict.hpp"

using namespace reference;

namespace
{

constexpr std::size_t period = 1000, mostLate = 10, settled = 500, window = 50;
constexpr double range = 4096;
enum { gps, barometer };

using Words = std::array<double, 2>;
using All = std::vector<Words>; // of each row

ProcessModel vehicle()
{
    Matrix<double> A = Matrix<double>::Identity(3, 3), F = Matrix<double>::Zero(3, 2);
    A(0, 1) = 0.125, A(1, 0) = -0x1p-8, A(1, 1) = 0.96875; // it returns to its height
    F(1, 0) = 0.5, F(2, 1) = 0x1p-6;
    return {A, Matrix<double>(3, 0), F};
}

SensorModel sensorOf(int which)
{
    Matrix<double> H = Matrix<double>::Zero(1, 3);
    H(0, 0) = 1, H(0, 2) = which == barometer;
    return {H, Matrix<double>::Constant(1, 1, which == barometer ? 0.0625 : 4), Vector<double>::Constant(1, range)};
}

/// What the sensors say, of one true path
All measured(std::size_t rows)
{
    Random random(7);
    const ProcessModel model = vehicle();
    Vector<double> x = Vector<double>::Zero(3);
    x(2) = 5;
    All all;
    for (std::size_t t = 0; t < rows; ++t) {
        x = model.A * x + model.F * normals(random, 2);
        all.push_back({x(0) + 2 * random.normal(), x(0) + x(2) + 0.25 * random.normal()});
    }
    return all;
}

// ------------------------------------------------------------------ faults

enum Means { alone, gate, huber, student, watch, adaptation, allMeans };
const char *const meansName[] = {"none", "gate", "Huber", "Student", "watch", "adaptation"};

struct Fault {
    const char *name;
    std::size_t rows;
    /// Instead of z[t], in a fault that began at `from`, the k-th
    Words (*words)(const All &z, std::size_t t, std::size_t from, std::size_t k);
    int times; // that the barometer's is taken
    std::array<int, allMeans> found, misled; // of a hundred: at least (of none: at most); at most
};

const Fault faults[] = {
    {"none", 100, [](const All &z, std::size_t t, std::size_t, std::size_t) { return z[t]; }, 1,
     {0, 10, 5, 30, 0, 0}, {}},
    {"barometer stuck", 100, [](const All &z, std::size_t t, std::size_t from, std::size_t) { return Words{z[t][gps], z[from][barometer]}; }, 1,
     {0, 95, 85, 95, 95, 0}, {100, 100, 100, 95, 100, 100}},
    {"GPS stuck", 100, [](const All &z, std::size_t t, std::size_t from, std::size_t) { return Words{z[from][gps], z[t][barometer]}; }, 1,
     {0, 35, 10, 50, 95, 0}, {100, 90, 100, 70, 5, 100}},
    {"barometer late", 100, [](const All &z, std::size_t t, std::size_t, std::size_t k) { return Words{z[t][gps], z[t - 1 - k % mostLate][barometer]}; }, 1,
     {0, 20, 10, 25, 15, 0}, {95, 75, 80, 75, 90, 95}},
    {"swapped", 100, [](const All &z, std::size_t t, std::size_t, std::size_t) { return Words{z[t][barometer], z[t][gps]}; }, 1,
     {0, 95, 95, 95, 95, 95}, {100, 5, 5, 5, 5, 30}},
    {"swapped once", 1, [](const All &z, std::size_t t, std::size_t, std::size_t) { return Words{z[t][barometer], z[t][gps]}; }, 1,
     {0, 75, 75, 75, 70, 0}, {}},
    {"barometer twice", 100, [](const All &z, std::size_t t, std::size_t, std::size_t) { return z[t]; }, 2,
     {}, {}},
};

/// The row at which a fault of this thousand begins; the filter has settled by then
std::size_t beginOf(std::size_t t) { return t / period * period + settled; }

// ------------------------------------------------------------------ what protects, and what finds

struct Row {
    std::array<double, 3> mean, sigma;
    bool isTold;
};

template <class T> class Flight : NotCopied
{
    using Api = kq::Api<T>;
    using Score = typename Api::Score;

  public:
    explicit Flight(Means means)
        : means_(means), states_(3, Vector<double>::Constant(3, range)), process_(states_, vehicle(), Noise::factor),
          sensors_{{states_, sensorOf(gps), Noise::covariance}, {states_, sensorOf(barometer), Noise::covariance}}, filter_(states_),
          noises_(Api::length(KQ_OBJECT_ADAPTATION, 3, 1)), root_(rootLength(3))
    {
        for (int s = 0; s < 2; ++s) {
            watched_[s].resize(Api::length(KQ_OBJECT_CONSISTENCY, 0, 1, window));
            kq::require(Api::consistency_assign(&windows_[s], 1, window, watched_[s].data(), watched_[s].size()), "watch");
            losses_[s].kind = means == gate ? Api::gate : means == huber ? Api::huber : Api::student;
            losses_[s].parameter = Api::number(means == huber ? 3 : 10);
            losses_[s].weights = &weights_[s];
            losses_[s].limit = Api::chi_square_limit(1, KQ_LEVEL_9999);
        }
        kq::require(filter_.init(Vector<double>::Zero(3), Matrix<double>::Identity(3, 3) * 64), "init");
        if (means == adaptation) adapt();
    }

    std::vector<Row> fly(const All &z, const Fault &fault)
    {
        std::vector<Row> rows;
        for (std::size_t t = 0; t < z.size(); ++t) {
            const std::size_t from = beginOf(t);
            const bool isNow = t >= from && t < from + fault.rows;
            const Words words = isNow ? fault.words(z, t, from, t / period) : z[t];
            Api::events_clear(filter_.get());
            kq::require(Api::predict(filter_.get(), process_.get(), nullptr), "predict");
            bool isTold = take(gps, words[gps]);
            for (int k = 0; k < (isNow ? fault.times : 1); ++k) isTold |= take(barometer, words[barometer]);
            rows.push_back(read(isTold));
        }
        return rows;
    }

  private:
    void adapt()
    {
        if constexpr (std::is_same_v<T, Q31>) {
            kq::require(kq_adaptation_assign_q31(&scales_, 3, 1, noises_.data(), noises_.size(), root_.data()), "assign");
        } else {
            kq::require(Api::adaptation_assign(&scales_, 3, 1, noises_.data(), noises_.size()), "assign");
        }
        const auto number = Api::number;
        const typename Api::Rule rule = {KQ_ADAPT_SENSOR, 200, number(0.1), number(1), number(1), number(0x1p-10), number(1024)};
        kq::require(Api::adaptation_init(&scales_, process_.get(), sensors_[barometer].get(), &rule), "adaptation");
        kq::require(Api::attach(filter_.get(), &scales_.attached), "attach");
    }

    bool take(int s, double z)
    {
        auto *filter = filter_.get();
        auto *sensor = sensors_[s].get();
        const auto word = sensors_[s].components().word(0, z);
        if (means_ == watch) kq::require(Api::consistency_watch(&windows_[s], filter, sensor, &word, UINT32_MAX), "watch");
        kq::require(means_ == gate || means_ == huber || means_ == student
                        ? Api::update_robust(filter, sensor, &word, UINT32_MAX, &losses_[s])
                        : Api::update(filter, sensor, &word), "update");
        if (means_ == watch) kq::require(Api::consistency_record(&windows_[s], filter), "record");
        return tells(s);
    }

    bool tells(int s)
    {
        typename Api::Coefficient q, r;
        switch (means_) {
        case gate: return (Api::events(filter_.get()) & KQ_EVENT_GATED) != 0;
        case huber: return Api::value(weights_[s]) < 0.5;
        case student: return Api::value(weights_[s]) < 0.5;
        case watch: return isOutside(s);
        case adaptation: kq::require(Api::adaptation_scales(&scales_, &q, &r), "scales"); return Api::value(r) > 2 || Api::value(r) < 0.5;
        default: return Api::events(filter_.get()) != 0;
        }
    }

    /// Any of the three statistics by 5 sigma
    bool isOutside(int s)
    {
        Score nis, low, high, mean, reach, correlation, spread;
        const Score q = std::is_same_v<T, Q31> ? static_cast<Score>(5 * 0x1p24) : static_cast<Score>(5);
        kq::require(Api::consistency_nis(&windows_[s], q, &nis, &low, &high), "nis");
        kq::require(Api::consistency_innovation(&windows_[s], 0, q, &mean, &reach, &correlation, &spread), "innovation");
        return Api::consistency_count(&windows_[s]) == window &&
               (nis < low || nis > high || mean < -reach || mean > reach || correlation < -spread || correlation > spread);
    }

    Row read(bool isTold)
    {
        Row row{{}, {}, isTold};
        for (int i = 0; i < 3; ++i) {
            const auto k = static_cast<std::size_t>(i);
            row.mean[k] = static_cast<double>(states_.value(i, Api::mean(filter_.get(), i), Api::mean_low(filter_.get(), i)));
            row.sigma[k] = static_cast<double>(states_.value(i, Api::sigma(filter_.get(), i)));
        }
        return row;
    }

    Means means_;
    Formats<T> states_;
    ProcessOwner<T> process_;
    SensorOwner<T> sensors_[2];
    FilterOwner<T> filter_;
    std::vector<typename Api::Coefficient> noises_;
    std::vector<std::int32_t> root_;
    typename Api::Adaptation scales_{};
    typename Api::Consistency windows_[2]{};
    std::vector<typename Api::Word> watched_[2];
    typename Api::Loss losses_[2]{};
    typename Api::Coefficient weights_[2]{Api::number(1), Api::number(1)};
};

// ------------------------------------------------------------------ the verdict

/// Of the faults of a flight.  Misled: more than 10 rows that are off by more than 3 sigmas, and nothing has been found.  Healed: within
/// half a sigma from then on, up to the next fault
struct Findings {
    std::vector<std::size_t> foundAfter, healedAfter;
    int count = 0, misled = 0;
    double worst = 0, least = 1; // in sigmas that the filter says; what it says of a sigma, over the undisturbed one
};

/// How far a row is off the undisturbed one, in its own sigmas
double distance(const Row &row, const Row &clean)
{
    double most = 0;
    for (std::size_t i = 0; i < 3; ++i) most = std::max(most, std::fabs(row.mean[i] - clean.mean[i]) / row.sigma[i]);
    return most;
}

void judge(Findings &of, const Row *rows, const Row *clean, std::size_t lasts)
{
    std::size_t foundAt = period, silent = 0, wellFrom = 0;
    for (std::size_t t = 0; t < period; ++t) {
        const double off = distance(rows[t], clean[t]);
        if (rows[t].isTold && foundAt == period && t < lasts + window) foundAt = t;
        silent += off > 3 && foundAt == period;
        if (!(off <= 0.5)) wellFrom = t + 1;
        of.worst = std::max(of.worst, off);
        for (std::size_t i = 0; i < 3; ++i) of.least = std::min(of.least, rows[t].sigma[i] / clean[t].sigma[i]);
    }
    ++of.count;
    of.misled += silent > 10;
    if (foundAt < period) of.foundAfter.push_back(foundAt);
    if (wellFrom < period) of.healedAfter.push_back(wellFrom > lasts ? wellFrom - lasts : 0);
}

std::string median(std::vector<std::size_t> of)
{
    if (of.empty()) return "-";
    std::sort(of.begin(), of.end());
    return std::to_string(of[of.size() / 2]);
}

void expect(Verdict &verdict, const Findings &of, const Fault &fault, Means means, const std::string &what)
{
    const double found = 100.0 * static_cast<double>(of.foundAfter.size()) / of.count, limit = fault.found[means];
    if (&fault == faults) verdict.expectAtMost(found, limit, what + ": found");
    else verdict.expectAtLeast(found, limit, what + ": found");
    verdict.expectAtMost(100.0 * of.misled / of.count, fault.misled[means], what + ": misled");
    verdict.expect(of.healedAfter.size() == static_cast<std::size_t>(of.count), what + ": not all heal");
    verdict.expectAtLeast(of.least, 0.8, what + ": sigma");
}

template <class T> void fly(const All &z, Verdict &verdict)
{
    for (int m = 0; m < allMeans; ++m) {
        const auto means = static_cast<Means>(m);
        const std::vector<Row> clean = Flight<T>(means).fly(z, faults[0]);
        for (const Fault &fault : faults) {
            const std::vector<Row> rows = Flight<T>(means).fly(z, fault);
            Findings of;
            for (std::size_t t = settled; t + period <= z.size(); t += period) judge(of, &rows[t], &clean[t], fault.rows);
            std::printf("| %s | %s | %s | %zu | %s | %d | %s | %.1f | %.2f |\n", kq::Api<T>::name, fault.name, meansName[m], of.foundAfter.size(),
                        median(of.foundAfter).c_str(), of.misled, median(of.healedAfter).c_str(), of.worst, of.least);
            expect(verdict, of, fault, means, std::string(kq::Api<T>::name) + ", " + fault.name + ", " + meansName[m]);
        }
    }
}

} // namespace

int main(int argc, char **argv)
{
    const std::size_t rows = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 100000;
    const All z = measured(rows + settled);
    Verdict verdict;
    std::printf("| | fault | means | found of %zu | after rows | misled | healed after rows | worst, sigmas | least sigma |\n"
                "|---|---|---|---:|---:|---:|---:|---:|---:|\n", rows / period);
    fly<float>(z, verdict);
    fly<Q31>(z, verdict);
    std::printf("\n");
    return verdict.finish();
}
