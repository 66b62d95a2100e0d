// The posterior mean of a track (tracks.hpp) for who knows how noise, outliers and jumps are drawn.
#ifndef KALMANQ_TESTS_REFERENCE_EXACT_TRACKS_HPP
#define KALMANQ_TESTS_REFERENCE_EXACT_TRACKS_HPP

#include "tracks.hpp"

namespace reference
{

/// The posterior mean: a mixture of Kalman filters (Rao and Blackwell), each of which has drawn
/// from what the world may have done, given the measurement; exact as their number grows.
class Exact
{
  public:
    Exact(const Motion &m, const World &world, std::size_t count, std::uint64_t seed)
        : m_(m), world_(world), count_(count), random_(seed)
    {
    }

    Series filtered(const Series &z)
    {
        Series x;
        Particle first;
        for (int i = 0; i < m_.n; ++i) first.P[std::size_t(i * m_.n + i)] = 1;
        particles_.assign(count_, first);
        for (std::size_t t = 0; t < z.size(); ++t) x.push_back(step(z[t], t > 0));
        return x;
    }

  private:
    struct Particle {
        Three x{};
        Nine P{};
        double weight = 1;
    };

    double step(double z, bool moves)
    {
        double total = 0, mean = 0, square = 0;
        for (Particle &p : particles_) {
            take(p, z, moves);
            total += p.weight;
            mean += p.weight * p.x[0];
            square += p.weight * p.weight;
        }
        mean /= total;
        for (Particle &p : particles_) p.weight *= double(count_) / total;
        if (total * total < 0.5 * double(count_) * square) resample();
        return mean;
    }

    /// What may have happened is drawn with its probability given z.
    void take(Particle &p, double z, bool moves)
    {
        std::array<Particle, 16> after;
        std::array<double, 16> likelihood{};
        std::size_t count = 0;
        double total = 0;
        const int jumps = moves && world_.jumps.share > 0 ? 2 : 1;
        const int noises = world_.freedom ? 8 : world_.outliers.share > 0 ? 2 : 1;
        for (int j = 0; j < jumps; ++j) {
            const Particle predicted = moves ? moved(p, j ? world_.jumps.times : 1) : p;
            const double weight =
                jumps == 1 ? 1 : j ? world_.jumps.share : 1 - world_.jumps.share;
            for (int k = 0; k < noises; ++k, ++count) {
                double r = 1, share = 1;
                if (world_.freedom) r = drawMeasurementVariance(random_, world_), share = 0.125;
                else if (noises == 2) {
                    r = k ? world_.outliers.times * world_.outliers.times : 1;
                    share = k ? world_.outliers.share : 1 - world_.outliers.share;
                }
                after[count] = predicted;
                likelihood[count] = weight * share * updated(after[count], z, r);
                total += likelihood[count];
            }
        }
        double at = random_.uniform() * total;
        std::size_t k = 0;
        while (k + 1 < count && (at -= likelihood[k]) > 0) ++k;
        const double weight = p.weight * total;
        p = after[k];
        p.weight = weight;
    }

    Particle moved(const Particle &p, double scale) const
    {
        Particle out = p;
        const auto n = std::size_t(m_.n);
        out.x = times(m_.A, p.x, m_.n);
        Nine AP{};
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j < n; ++j) {
                for (std::size_t k = 0; k < n; ++k) {
                    AP[i * n + j] += m_.A[i * n + k] * p.P[k * n + j];
                }
            }
        }
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j < n; ++j) {
                out.P[i * n + j] = scale * scale * m_.Q[i * n + j];
                for (std::size_t k = 0; k < n; ++k) {
                    out.P[i * n + j] += AP[i * n + k] * m_.A[j * n + k];
                }
            }
        }
        return out;
    }

    double updated(Particle &p, double z, double r) const
    {
        const auto n = std::size_t(m_.n);
        const double s = p.P[0] + r, e = z - p.x[0];
        const Nine P = p.P;
        for (std::size_t i = 0; i < n; ++i) {
            p.x[i] += P[i * n] * e / s;
            for (std::size_t j = 0; j < n; ++j) p.P[i * n + j] -= P[i * n] * P[j * n] / s;
        }
        return std::exp(-0.5 * e * e / s) / std::sqrt(s) + 1e-300;
    }

    void resample()
    {
        std::vector<Particle> kept;
        double sum = 0, at = random_.uniform();
        for (const Particle &p : particles_) {
            for (sum += p.weight; at < sum && kept.size() < count_; at += 1) kept.push_back(p);
        }
        while (kept.size() < count_) kept.push_back(particles_.back());
        for (Particle &p : kept) p.weight = 1;
        particles_ = std::move(kept);
    }

    Motion m_;
    World world_;
    std::size_t count_;
    Random random_;
    std::vector<Particle> particles_;
};

} // namespace reference

#endif
