// Recursive least squares against the normal equations in quadruple precision: weighted, with
// exponential forgetting, over 10^5 measurements; and the filter with fading memory against the
// textbook's.  Errors of a mean are in sigma, of a covariance in sigma_i sigma_j.
//
//     test_least_squares [SEED]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <type_traits>
#include <vector>

#include "accuracy.hpp"
#include "decompositions.hpp"
#include "owners.hpp"
#include "random.hpp"
#include "readings.hpp"
#include "report.hpp"

using namespace reference;

namespace
{

// ------------------------------------------------------------------ the library

/// Begins, and takes rows in physical units.
template <class T> class Fit
{
    using Api = kq::Api<T>;

  public:
    Fit(FilterOwner<T> &filter, double lambda, const Formats<T> &measured)
        : states_(filter.states()), measured_(measured)
    {
        if constexpr (std::is_same_v<T, Q31>) {
            kq::require(kq_least_squares_init_q31(&handle_, filter.get(), Api::number(lambda),
                                                  measured_.data()),
                        "init");
        } else {
            kq::require(Api::least_squares_init(&handle_, filter.get(), Api::number(lambda)),
                        "init");
        }
    }

    void add(const Vector<double> &h, double z, double r)
    {
        const auto words = measured_.words(Vector<double>::Constant(1, z));
        const auto row = coefficients(h.transpose());
        const auto noise = noiseOf(r);
        kq::require(Api::least_squares_add(&handle_, row.data(), words.data(), &noise, 1), "add");
    }

    double residual() const
    {
        return static_cast<double>(Formats<T>::score(Api::least_squares_residual(&handle_)));
    }

  private:
    auto coefficients(const Matrix<double> &row) const
    {
        if constexpr (std::is_same_v<T, Q31>) return prepared(row, measured_, states_);
        else return flattened<T>(row);
    }

    typename Api::Coefficient noiseOf(double r) const
    {
        typename Api::Coefficient noise = Api::number(r);
        if constexpr (std::is_same_v<T, Q31>) {
            kq::require(kq_noise_prepare_diagonal_q31(&noise, &r, 1, measured_.data()),
                        "noise prepare");
        }
        return noise;
    }

    const Formats<T> &states_, &measured_;
    typename Api::LeastSquares handle_{};
};

// ------------------------------------------------------------------ the normal equations

class NormalEquations
{
  public:
    NormalEquations(const Vector<double> &x0, const Matrix<double> &P0, double lambda)
        : lambda_(lambda), W_(inverse(convert<Quad>(P0))), b_(W_ * x0.cast<Quad>()),
          c_(x0.cast<Quad>().dot(b_))
    {
    }

    void add(const Vector<double> &h, double z, double r)
    {
        const Vector<Quad> row = h.cast<Quad>();
        const Quad weight = Quad(1) / Quad(r);
        W_ = lambda_ * W_ + weight * row * row.transpose();
        b_ = lambda_ * b_ + weight * Quad(z) * row;
        c_ = lambda_ * c_ + weight * Quad(z) * Quad(z);
    }

    Belief<Quad> solution() const
    {
        const Matrix<Quad> P = inverse(W_);
        return {P * b_, P};
    }

    double residual(const Belief<Quad> &solution) const
    {
        return static_cast<double>(c_ - b_.dot(solution.mean));
    }

  private:
    Quad lambda_;
    Matrix<Quad> W_;
    Vector<Quad> b_;
    Quad c_;
};

// ------------------------------------------------------------------ data

/// To 20 bits of a power of two, so that a number is a float and a q31 word alike.
double onGrid(double x, double range) { return std::round(x / range * 0x1p20) * range * 0x1p-20; }

struct Data {
    Vector<double> x0;
    Matrix<double> P0;
    std::vector<Vector<double>> h;
    std::vector<double> z, r;
};

constexpr double stateRange = 64, measuredRange = 1024;

Data someData(Random &random, int n, int count)
{
    Data data;
    Matrix<double> root(n, n);
    data.x0.resize(n);
    Vector<double> x(n);
    for (int i = 0; i < n; ++i) {
        data.x0(i) = onGrid(random.normal(), stateRange);
        for (int j = 0; j < n; ++j) root(i, j) = onGrid(random.normal(), 4);
    }
    data.P0 =
        (root * root.transpose() + Matrix<double>::Identity(n, n)).cast<float>().cast<double>();
    for (int i = 0; i < n; ++i) x(i) = data.x0(i) + 2 * random.normal();
    for (int k = 0; k < count; ++k) {
        Vector<double> h(n);
        for (int i = 0; i < n; ++i) h(i) = onGrid(i == 0 ? 1 : random.uniform(-1, 1), 1);
        const double r = std::exp2(random.integer(-3, 1));
        data.h.push_back(h);
        data.r.push_back(r);
        data.z.push_back(onGrid(h.dot(x) + std::sqrt(r) * random.normal(), measuredRange));
    }
    return data;
}

// ------------------------------------------------------------------ comparison

template <class T>
void compare(Figures &figures, const Belief<Quad> &expected, const Belief<Wide<T>> &actual)
{
    Worst worst;
    worst.add(actual, expected);
    figures.add("mean", worst.x);
    figures.add("P", worst.P);
}

template <class T> Bounds goals();
template <> Bounds goals<float>() { return {{"mean", 1e-4}, {"P", 1e-4}, {"residual", 1e-4}}; }
template <> Bounds goals<double>() { return {{"mean", 1e-12}, {"P", 1e-12}, {"residual", 1e-12}}; }
template <> Bounds goals<Q31>() { return {{"mean", 1e-6}, {"P", 1e-6}, {"residual", 1e-6}}; }

/// Without forgetting nothing that was rounded is ever forgotten: one rounding for every row, all
/// in one direction.
template <class T> Bounds unforgotten(int rows)
{
    const double most = rows * kq::epsilon<T>();
    return {{"mean", most}, {"P", most}, {"residual", most}};
}

bool isCheckpoint(int k, int count) { return count <= 1000 ? k % 10 == 0 : k % (count / 20) == 0; }

template <class T> Figures run(const Data &data, double lambda)
{
    const auto n = data.x0.size();
    const Formats<T> states(n, Vector<double>::Constant(n, stateRange));
    const Formats<T> measured(1, Vector<double>::Constant(1, measuredRange));
    FilterOwner<T> filter(states);
    kq::require(filter.init(data.x0, data.P0), "filter init");
    Fit<T> fit(filter, lambda, measured);
    NormalEquations equations(data.x0, data.P0, lambda);
    Figures figures;
    const int count = static_cast<int>(data.z.size());
    for (int k = 1; k <= count; ++k) {
        const auto at = static_cast<std::size_t>(k - 1);
        fit.add(data.h[at], data.z[at], data.r[at]);
        equations.add(data.h[at], data.z[at], data.r[at]);
        if (k > 1 && !isCheckpoint(k, count)) continue;
        const Belief<Quad> solution = equations.solution();
        compare<T>(figures, solution, read(filter));
        const double residual = equations.residual(solution);
        figures.add("residual", std::abs(fit.residual() - residual) / (1 + residual));
    }
    // after 100,000 rows one that says little says less than the root's last bits
    const unsigned others = ~unsigned{KQ_EVENT_PRECISION};
    if ((kq::Api<T>::events(filter.get()) & others) != 0) figures.add("mean", NAN);
    return figures;
}

std::string lambdaText(double lambda)
{
    char text[32];
    std::snprintf(text, sizeof text, "lambda %.4g", lambda);
    return text;
}

template <class T> void shortRuns(Report &report, std::uint64_t seed)
{
    static const int sizes[] = {1, 2, 3, 4, 6, 10, 16};
    for (double lambda : {1.0, 0.998046875, 0.990234375, 0.96875}) {
        Random random(seed);
        for (int n : sizes) {
            for (int k = 0; k < 5; ++k) {
                const Figures figures = run<T>(someData(random, n, 300), lambda);
                report.add(std::string(kq::Api<T>::name) + ", 300 rows, " + lambdaText(lambda),
                           "n " + std::to_string(n), figures, goals<T>());
            }
        }
    }
}

template <class T> void longRuns(Report &report, std::uint64_t seed)
{
    for (double lambda : {1.0, 0.9990234375, 0.990234375}) {
        Random random(seed + 1);
        for (int n : {1, 2, 3}) {
            const Figures figures = run<T>(someData(random, n, 100000), lambda);
            const Bounds bounds = lambda < 1 ? goals<T>() : unforgotten<T>(100000);
            report.add(std::string(kq::Api<T>::name) + ", 100000 rows, " + lambdaText(lambda),
                       "n " + std::to_string(n), figures, bounds);
        }
    }
}

// ------------------------------------------------------------------ fading memory

/// P- = A P A' / lambda + Q
template <class T> Figures fadingRun(Random &random, double lambda)
{
    const Matrix<double> A = rows({{1, 0.5}, {0, 1}});
    const Matrix<double> F = rows({{0.125, 0.0625}, {0, 0.25}});
    const Matrix<double> H = rows({{1, 0}});
    const Matrix<double> R = Matrix<double>::Constant(1, 1, 0.5);
    const Vector<double> x0 = Vector<double>::Zero(2);
    const Matrix<double> P0 = 4 * Matrix<double>::Identity(2, 2);
    const Formats<T> states(2, Vector<double>::Constant(2, 256));
    ProcessOwner<T> process(states, ProcessModel{A, Matrix<double>(2, 0), F}, Noise::factor);
    SensorOwner<T> sensor(states, SensorModel{H, R, Vector<double>::Constant(1, 256)},
                          Noise::diagonal);
    FilterOwner<T> filter(states);
    kq::require(filter.init(x0, P0), "filter init");
    Belief<Quad> now{x0.cast<Quad>(), convert<Quad>(P0)};
    const Matrix<Quad> AQ = convert<Quad>(A), Q = convert<Quad>(F) * convert<Quad>(F).transpose();
    Figures figures;
    for (int k = 0; k < 1000; ++k) {
        const double z = onGrid(10 * std::sin(0.01 * k) + random.normal(), 256);
        const auto words = sensor.components().words(Vector<double>::Constant(1, z));
        kq::require(kq::Api<T>::update(filter.get(), sensor.get(), words.data()), "update");
        const Quad S = now.covariance(0, 0) + Quad(0.5);
        const Vector<Quad> gain = now.covariance.col(0) / S;
        now.mean = now.mean + gain * (Quad(z) - now.mean(0));
        now.covariance = now.covariance - gain * gain.transpose() * S;
        compare<T>(figures, now, read(filter));
        kq::require(kq::Api<T>::forget(filter.get(), kq::Api<T>::number(lambda)), "fade");
        kq::require(kq::Api<T>::predict(filter.get(), process.get(), nullptr), "predict");
        now.mean = AQ * now.mean;
        now.covariance = AQ * now.covariance * AQ.transpose() / Quad(lambda) + Q;
    }
    return figures;
}

template <class T> void fadingRuns(Report &report, std::uint64_t seed)
{
    for (double lambda : {0.99609375, 0.953125, 0.75}) {
        Random random(seed + 2);
        report.add(std::string(kq::Api<T>::name) + ", fading memory, " + lambdaText(lambda), "",
                   fadingRun<T>(random, lambda), goals<T>());
    }
}

template <class T> void all(Report &report, std::uint64_t seed)
{
    shortRuns<T>(report, seed);
    longRuns<T>(report, seed);
    fadingRuns<T>(report, seed);
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    Report report;
    all<float>(report, seed);
    all<double>(report, seed);
    all<Q31>(report, seed);
    report.print();
    return report.verdict.finish();
}
