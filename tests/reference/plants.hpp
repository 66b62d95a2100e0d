// Plants that are simulated for as long as a test asks, and their measurements.
#ifndef KALMANQ_TESTS_REFERENCE_PLANTS_HPP
#define KALMANQ_TESTS_REFERENCE_PLANTS_HPP

#include <cmath>
#include <cstdint>
#include <string>

#include "decompositions.hpp"
#include "random.hpp"

namespace reference
{

/// Far beyond what a plant reaches, of states and measurements
constexpr double plantRange = 1 << 20;

struct Plant {
    std::string name;
    Matrix<double> A, F, H, R;
    double lost = 0;      // share of the scalar measurements that are missing
    double grid = 0x1p-9; // of measurements
    double wild = 0;      // share of the measurements whose noise is 10 times as large
    double bias = 0;      // of the first component, in sigmas of its noise

    Index states() const { return A.rows(); }
    Index components() const { return H.rows(); }
};

/// The plant's state, from 0 on, and its measurements
class Simulation
{
  public:
    Simulation(const Plant &plant, std::uint64_t seed)
        : plant_(plant), random_(seed), noise_(choleskyRoot(plant.R).value()),
          x_(Vector<double>::Zero(plant.states()))
    {
    }

    void advance() { x_ = plant_.A * x_ + plant_.F * normals(random_, plant_.F.cols()); }

    Vector<double> measure()
    {
        const double size = plant_.wild > 0 && random_.chance(plant_.wild) ? 10 : 1;
        Vector<double> z = plant_.H * x_;
        z(0) += plant_.bias * noise_(0, 0);
        z += size * noise_ * normals(random_, plant_.components());
        return z.unaryExpr(
            [this](double entry) { return std::round(entry / plant_.grid) * plant_.grid; });
    }

    std::uint32_t present()
    {
        std::uint32_t mask = 0;
        for (Index c = 0; c < plant_.components(); ++c) {
            if (plant_.lost == 0 || !random_.chance(plant_.lost)) mask |= UINT32_C(1) << c;
        }
        return mask;
    }

  private:
    Plant plant_;
    Random random_;
    Matrix<double> noise_;
    Vector<double> x_;
};

} // namespace reference

#endif
