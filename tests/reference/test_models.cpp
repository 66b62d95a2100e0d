// The model builders against exact formulas in quadruple precision:
//   - stationary covariances against the linear equations that define them;
//   - the log-likelihood of ARMA series, through the filter, against the density of the whole
//     series as one Gaussian vector, whose covariance comes from the weights of past noises;
//   - the noise of motion models against quadrature of its integral.
//
//     test_models [SEED]
#include <cmath>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "api.hpp"
#include "decompositions.hpp"
#include "random.hpp"
#include "report.hpp"
#include "textbook.hpp"

#include "kalmanq/kalmanq.h"

using namespace reference;
using kq::require;

namespace
{

// ------------------------------------------------------------------ the library

template <class T> struct Api;

template <> struct Api<float> {
    static constexpr const char *name = "f32";
    using Model = kq_model_f32;
    using Filter = kq_filter_f32;
    using Process = kq_process_f32;
    using Sensor = kq_sensor_f32;
    static constexpr auto assign = kq_model_assign_f32;
    static constexpr auto arma = kq_model_arma_f32;
    static constexpr auto ar = kq_model_ar_f32;
    static constexpr auto ma = kq_model_ma_f32;
    static constexpr auto factor = kq_model_factor_f32;
    static constexpr auto velocity = kq_model_velocity_f32;
    static constexpr auto acceleration = kq_model_acceleration_f32;
    static constexpr auto stationary = kq_stationary_covariance_f32;
    static constexpr auto processAssign = kq_process_assign_f32;
    static constexpr auto processInit = kq_process_init_factor_f32;
    static constexpr auto sensorAssign = kq_sensor_assign_f32;
    static constexpr auto sensorInit = kq_sensor_init_diagonal_f32;
    static constexpr auto filterAssign = kq_filter_assign_f32;
    static constexpr auto filterInit = kq_filter_init_f32;
    static constexpr auto update = kq_update_f32;
    static constexpr auto predict = kq_predict_f32;
    static constexpr auto logLikelihood = kq_log_likelihood_f32;
    static constexpr std::size_t filterLength = KQ_FILTER_LEN_F32(16);
};

template <> struct Api<double> {
    static constexpr const char *name = "f64";
    using Model = kq_model_f64;
    using Filter = kq_filter_f64;
    using Process = kq_process_f64;
    using Sensor = kq_sensor_f64;
    static constexpr auto assign = kq_model_assign_f64;
    static constexpr auto arma = kq_model_arma_f64;
    static constexpr auto ar = kq_model_ar_f64;
    static constexpr auto ma = kq_model_ma_f64;
    static constexpr auto factor = kq_model_factor_f64;
    static constexpr auto velocity = kq_model_velocity_f64;
    static constexpr auto acceleration = kq_model_acceleration_f64;
    static constexpr auto stationary = kq_stationary_covariance_f64;
    static constexpr auto processAssign = kq_process_assign_f64;
    static constexpr auto processInit = kq_process_init_factor_f64;
    static constexpr auto sensorAssign = kq_sensor_assign_f64;
    static constexpr auto sensorInit = kq_sensor_init_diagonal_f64;
    static constexpr auto filterAssign = kq_filter_assign_f64;
    static constexpr auto filterInit = kq_filter_init_f64;
    static constexpr auto update = kq_update_f64;
    static constexpr auto predict = kq_predict_f64;
    static constexpr auto logLikelihood = kq_log_likelihood_f64;
    static constexpr std::size_t filterLength = KQ_FILTER_LEN_F64(16);
};

/// A model with its memory
template <class T> class Made
{
  public:
    Made(int n, int r, int m) : memory_(static_cast<std::size_t>(KQ_MODEL_LEN(n, r, m)))
    {
        require(Api<T>::assign(&handle, n, r, m, memory_.data(), memory_.size()), "assign");
    }

    Matrix<Quad> matrix(const T *entries, int rows, int columns) const
    {
        Matrix<Quad> M(rows, columns);
        for (int k = 0; k < rows * columns; ++k) M(k / columns, k % columns) = Quad(entries[k]);
        return M;
    }
    Matrix<Quad> A() const { return matrix(handle.A, handle.states, handle.states); }
    Matrix<Quad> F() const { return matrix(handle.F, handle.states, handle.noises); }
    Matrix<Quad> P0() const { return matrix(handle.P0, handle.states, handle.states); }

    typename Api<T>::Model handle{};

  private:
    std::vector<T> memory_;
};

template <class T> std::vector<T> rounded(const std::vector<double> &values)
{
    return std::vector<T>(values.begin(), values.end());
}

template <class T> std::vector<double> asDouble(const std::vector<T> &values)
{
    return std::vector<double>(values.begin(), values.end());
}

// ------------------------------------------------------------------ random models

/// Coefficients of a stationary autoregression from partial autocorrelations k within +-most, and
/// how far their rounding goes: the product of (1 + |k|) / (1 - |k|)
std::vector<double> stationary(Random &random, int p, double most, double &condition)
{
    std::vector<double> phi;
    condition = 1;
    for (int j = 0; j < p; ++j) {
        const double k = random.uniform(-most, most);
        condition *= (1 + std::abs(k)) / (1 - std::abs(k));
        const std::vector<double> before = phi;
        for (int i = 0; i < j; ++i) {
            phi[static_cast<std::size_t>(i)] -= k * before[static_cast<std::size_t>(j - 1 - i)];
        }
        phi.push_back(k);
    }
    return phi;
}

std::vector<double> someCoefficients(Random &random, int q)
{
    std::vector<double> theta;
    for (int j = 0; j < q; ++j) theta.push_back(random.uniform(-0.9, 0.9));
    return theta;
}

double largestOf(const Matrix<Quad> &error, const Matrix<Quad> &P)
{
    double worst = 0;
    for (Index i = 0; i < P.rows(); ++i) {
        for (Index j = 0; j < P.rows(); ++j) {
            const Quad scale = squareRoot(P(i, i)) * squareRoot(P(j, j));
            worst = worse(worst, std::abs(static_cast<double>(error(i, j) / scale)));
        }
    }
    return worst;
}

// ------------------------------------------------------------------ stationary covariances

/// Autocovariances of an autoregression: the Yule-Walker equations
Vector<Quad> yuleWalker(const std::vector<double> &phi, double variance, int count)
{
    const int p = static_cast<int>(phi.size());
    Matrix<Quad> M = Matrix<Quad>::Identity(p + 1, p + 1);
    Vector<Quad> right = Vector<Quad>::Zero(p + 1);
    right(0) = Quad(variance);
    for (int j = 0; j <= p; ++j) {
        for (int i = 1; i <= p; ++i) {
            M(j, std::abs(j - i)) -= Quad(phi[static_cast<std::size_t>(i - 1)]);
        }
    }
    const Vector<Quad> first = solve(M, right);
    Vector<Quad> gamma = Vector<Quad>::Zero(std::max(count, p + 1));
    gamma.head(p + 1) = first;
    for (int j = p + 1; j < count; ++j) {
        for (int i = 1; i <= p; ++i) {
            gamma(j) += Quad(phi[static_cast<std::size_t>(i - 1)]) * gamma(j - i);
        }
    }
    return gamma;
}

/// P = A P A' + Q as linear equations in the upper triangle of P
Matrix<Quad> lyapunov(const Matrix<Quad> &A, const Matrix<Quad> &Q)
{
    const Index n = A.rows(), count = n * (n + 1) / 2;
    const auto at = [](Index i, Index j) {
        return i < j ? j * (j + 1) / 2 + i : i * (i + 1) / 2 + j;
    };
    Matrix<Quad> M = Matrix<Quad>::Identity(count, count);
    Vector<Quad> right(count);
    for (Index j = 0; j < n; ++j) {
        for (Index i = 0; i <= j; ++i) {
            right(at(i, j)) = Q(i, j);
            for (Index k = 0; k < n; ++k) {
                for (Index l = 0; l < n; ++l) M(at(i, j), at(k, l)) -= A(i, k) * A(j, l);
            }
        }
    }
    const Vector<Quad> solution = solve(M, right);
    Matrix<Quad> P(n, n);
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) P(i, j) = solution(at(i, j));
    }
    return P;
}

/// In float the coefficients' own rounding may be worth more than 1e-4: that is the bound, and it
/// is one for double, too.
template <class T> Bounds covarianceGoal(double condition)
{
    const double eps = static_cast<double>(std::numeric_limits<T>::epsilon());
    const double most = eps * (4 + condition);
    const double goal = eps > 1e-10 ? most : std::min(most, 1e-12);
    return {{"P0", goal}, {"by doubling", most}};
}

template <class T> void armaCovariance(Report &report, Random &random, double most)
{
    const int p = random.integer(1, 16), q = random.integer(0, 15), n = KQ_ARMA_STATES(p, q);
    double condition;
    const auto phi = rounded<T>(stationary(random, p, most, condition));
    const auto theta = rounded<T>(someCoefficients(random, q));
    Made<T> made(n, 1, 1);
    require(Api<T>::arma(&made.handle, phi.data(), p, theta.data(), q, 2, 0), "arma");
    const Vector<Quad> gamma = yuleWalker(asDouble(phi), 2, n);
    Matrix<Quad> P(n, n);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) P(i, j) = gamma(std::abs(i - j));
    }
    Figures figures;
    figures.add("P0", largestOf(made.P0() - P, P));
    std::vector<T> doubled(static_cast<std::size_t>(n * n));
    require(Api<T>::stationary(doubled.data(), made.handle.A, made.handle.F, n, 1), "doubling");
    figures.add("by doubling", largestOf(made.matrix(doubled.data(), n, n) - P, P));
    char group[64];
    std::snprintf(group, sizeof group, "%s ARMA, partial autocorrelations within %.2g",
                  Api<T>::name, most);
    report.add(group, std::to_string(p) + "," + std::to_string(q), figures,
               covarianceGoal<T>(condition));
}

template <class T> void factorCovariance(Report &report, Random &random)
{
    const int n = random.integer(1, 8);
    Matrix<double> A(n, n);
    for (double &entry : A) entry = random.normal();
    A *= random.uniform(0.3, 0.95) / spectralRadius(A);
    std::vector<T> transition, loadings, drift, noise(1, 1);
    for (int i = 0; i < n; ++i) {
        drift.push_back(static_cast<T>(random.uniform(0.1, 2)));
        loadings.push_back(static_cast<T>(random.normal()));
        for (int j = 0; j < n; ++j) transition.push_back(static_cast<T>(A(i, j)));
    }
    Made<T> made(n, n, 1);
    require(Api<T>::factor(&made.handle, n, 1, loadings.data(), transition.data(), drift.data(),
                           noise.data()),
            "factor");
    Matrix<Quad> Q = Matrix<Quad>::Zero(n, n);
    for (int i = 0; i < n; ++i) Q(i, i) = Quad(drift[static_cast<std::size_t>(i)]);
    const Matrix<Quad> P = lyapunov(made.A(), Q);
    Figures figures;
    figures.add("P0", largestOf(made.P0() - P, P));
    report.add(std::string(Api<T>::name) + " factors", std::to_string(n), figures,
               covarianceGoal<T>(100));
}

// ------------------------------------------------------------------ likelihood of a series

/// Autocovariances of ARMA from its weights psi of past noises, summed until nothing is left
std::vector<Quad> armaAutocovariances(const std::vector<double> &phi,
                                      const std::vector<double> &theta, double variance,
                                      std::size_t count)
{
    std::vector<Quad> psi;
    for (std::size_t j = 0; j < 6000; ++j) {
        Quad weight = j == 0 ? 1 : j <= theta.size() ? Quad(theta[j - 1]) : Quad(0);
        for (std::size_t i = 1; i <= phi.size() && i <= j; ++i) {
            weight += Quad(phi[i - 1]) * psi[j - i];
        }
        psi.push_back(weight);
    }
    std::vector<Quad> gamma(count, Quad(0));
    for (std::size_t lag = 0; lag < count; ++lag) {
        for (std::size_t j = 0; j + lag < psi.size(); ++j) gamma[lag] += psi[j] * psi[j + lag];
        gamma[lag] *= Quad(variance);
    }
    return gamma;
}

/// log N(z; 0, Gamma)
Quad density(const std::vector<Quad> &gamma, double noise, const std::vector<double> &z)
{
    const auto count = static_cast<Index>(z.size());
    Matrix<Quad> G(count, count);
    Vector<Quad> values(count);
    for (Index i = 0; i < count; ++i) {
        values(i) = Quad(z[static_cast<std::size_t>(i)]);
        for (Index j = 0; j < count; ++j) {
            G(i, j) = gamma[static_cast<std::size_t>(std::abs(i - j))];
        }
        G(i, i) += Quad(noise);
    }
    const Matrix<Quad> L = choleskyRoot(G).value();
    const Vector<Quad> white = solveLower(L, values);
    Quad sum = white.squaredNorm() + Quad(static_cast<double>(count)) * logarithm(2 * pi<Quad>());
    for (Index i = 0; i < count; ++i) {
        sum += 2 * logarithm(L(i, i));
    }
    return -sum / Quad(2);
}

template <class T> double filtered(const Made<T> &made, const std::vector<double> &z)
{
    const auto &m = made.handle;
    const int n = m.states;
    std::vector<T> words(KQ_PROCESS_LEN(16)), noises(1), state(Api<T>::filterLength);
    typename Api<T>::Process process{};
    typename Api<T>::Sensor sensor{};
    typename Api<T>::Filter filter{};
    require(Api<T>::processAssign(&process, n, 0, words.data(), words.size()), "process");
    require(Api<T>::sensorAssign(&sensor, n, 1, noises.data(), noises.size()), "sensor");
    require(Api<T>::filterAssign(&filter, n, state.data(), state.size()), "filter");
    require(Api<T>::processInit(&process, m.A, nullptr, m.F, m.noises), "process init");
    require(Api<T>::sensorInit(&sensor, m.H, m.R), "sensor init");
    require(Api<T>::filterInit(&filter, m.x0, m.P0), "filter init");
    for (std::size_t t = 0; t < z.size(); ++t) {
        const T value = static_cast<T>(z[t]);
        if (t > 0) require(Api<T>::predict(&filter, &process, nullptr), "predict");
        require(Api<T>::update(&filter, &sensor, &value), "update");
    }
    return static_cast<double>(Api<T>::logLikelihood(&filter));
}

/// A series that is not even from the model: the density is what it is.
std::vector<double> someSeries(Random &random, std::size_t count)
{
    std::vector<double> z;
    double level = 0;
    for (std::size_t t = 0; t < count; ++t) {
        level = 0.7 * level + random.normal();
        z.push_back(static_cast<double>(static_cast<float>(level)));
    }
    return z;
}

template <class T> Bounds likelihoodGoal();
template <> Bounds likelihoodGoal<float>() { return {{"relative", 1e-4}}; }
template <> Bounds likelihoodGoal<double>() { return {{"error", 1e-9}, {"relative", 1e-9}}; }

template <class T> void likelihood(Report &report, Random &random, double noise)
{
    const int kind = random.integer(0, 2), p = kind == 2 ? 0 : random.integer(1, 5);
    const int q = kind == 0 ? 0 : random.integer(1, 5);
    double condition;
    const auto phi = rounded<T>(stationary(random, p, 0.8, condition));
    const auto theta = rounded<T>(someCoefficients(random, q));
    const T variance = static_cast<T>(1.5), r = static_cast<T>(noise);
    Made<T> made(KQ_ARMA_STATES(p, q), 1, 1);
    if (kind == 0) require(Api<T>::ar(&made.handle, phi.data(), p, variance, r), "ar");
    if (kind == 1) {
        require(Api<T>::arma(&made.handle, phi.data(), p, theta.data(), q, variance, r), "arma");
    }
    if (kind == 2) require(Api<T>::ma(&made.handle, theta.data(), q, variance, r), "ma");
    const std::vector<double> z = someSeries(random, 80);
    const auto gamma = armaAutocovariances(asDouble(phi), asDouble(theta), 1.5, z.size());
    const double expected = static_cast<double>(density(gamma, noise, z));
    const double error = std::abs(filtered(made, z) - expected);
    Figures figures;
    figures.add("error", error);
    figures.add("relative", error / std::abs(expected));
    static const char *const kinds[] = {"AR", "ARMA", "MA"};
    report.add(std::string(Api<T>::name) + " log-likelihood, " + kinds[kind] +
                   (noise > 0 ? " in noise" : ""),
               std::to_string(p) + "," + std::to_string(q), figures, likelihoodGoal<T>());
}

// ------------------------------------------------------------------ noise of motion

/// Integral over 0 .. dt of g(s) g(s)' by Simpson's rule; g(s): response to noise s ago
Matrix<Quad> quadrature(int order, double dt)
{
    const int panels = 4000;
    Matrix<Quad> Q = Matrix<Quad>::Zero(order, order);
    const Quad h = Quad(dt) / Quad(2 * panels);
    for (int k = 0; k <= 2 * panels; ++k) {
        const Quad s = Quad(k) * h;
        Vector<Quad> g(order);
        g(order - 1) = 1;
        for (int i = order - 2; i >= 0; --i) g(i) = g(i + 1) * s / Quad(order - 1 - i);
        const Quad weight = k == 0 || k == 2 * panels ? 1 : k % 2 == 1 ? 4 : 2;
        Q += weight * g * g.transpose();
    }
    return h / Quad(3) * Q;
}

template <class T> void motion(Report &report, int order, double step)
{
    const T dt = static_cast<T>(step);
    const Matrix<Quad> block = quadrature(order, static_cast<double>(dt));
    for (int d = 1; d <= 3; ++d) {
        const int n = order * d;
        const std::vector<T> density = rounded<T>({0.5, 3, 0.01}), noise(3, 1), variance(9, 1);
        Made<T> made(n, n, d);
        const auto build = order == 2 ? Api<T>::velocity : Api<T>::acceleration;
        require(build(&made.handle, d, dt, density.data(), noise.data(), nullptr, variance.data()),
                "motion");
        Matrix<Quad> Q = Matrix<Quad>::Zero(n, n);
        for (int k = 0; k < d; ++k) {
            Q.block(k * order, k * order, order, order) =
                Quad(density[static_cast<std::size_t>(k)]) * block;
        }
        Figures figures;
        figures.add("Q", largestOf(made.F() * made.F().transpose() - Q, Q));
        const double eps = static_cast<double>(std::numeric_limits<T>::epsilon());
        report.add(std::string(Api<T>::name) +
                       (order == 2 ? " constant velocity" : " constant acceleration"),
                   std::to_string(d), figures, {{"Q", 8 * eps}});
    }
}

template <class T> void all(Report &report, std::uint64_t seed)
{
    Random random(seed);
    for (int k = 0; k < 200; ++k) armaCovariance<T>(report, random, 0.5);
    for (int k = 0; k < 200; ++k) armaCovariance<T>(report, random, 0.8);
    for (int k = 0; k < 40; ++k) factorCovariance<T>(report, random);
    for (int k = 0; k < 30; ++k) likelihood<T>(report, random, 0);
    for (int k = 0; k < 30; ++k) likelihood<T>(report, random, 0.25);
    for (double step : {0.001, 0.1, 1.0, 60.0}) {
        motion<T>(report, 2, step);
        motion<T>(report, 3, step);
    }
}

} // namespace

int main(int argc, char **argv)
{
    const std::uint64_t seed = seedOf(argc, argv);
    Report report;
    all<float>(report, seed);
    all<double>(report, seed);
    report.print();
    return report.verdict.finish();
}
