// A sequence one scalar measurement after the other, and its smoother without an inverse (modified Bryson and
// Frazier; Bierman 1977).  The reference where P- may be singular: noise-free sensors, a singular Q, P0 or A.
//
// R has to be diagonal.  Which scalars are redundant (no noise, and known already) is for the caller to say: that is a
// matter of rank, and the pseudo-inverse skips them.  One that is redundant in this arithmetic too is skipped anyway.
#ifndef KALMANQ_TESTS_REFERENCE_BRYSON_FRAZIER_HPP
#define KALMANQ_TESTS_REFERENCE_BRYSON_FRAZIER_HPP

#include <cstddef>
#include <vector>

#include "textbook.hpp"

namespace reference
{

/// taken[t][k]: whether scalar measurement k of step t is taken, over the components present in
/// the order of the readings.  An empty list takes all of them.
using Taken = std::vector<std::vector<bool>>;

class BrysonFrazier
{
  public:
    explicit BrysonFrazier(const Sequence &sequence, const Taken &taken = {});

    const std::vector<Track<Quad>> &track() const { return track_; }

    std::vector<Smoothed<Quad>> smooth() const { return smoothWithoutInverse(sequence_, track_); }

    /// The covariance of each step if nothing were ever measured.
    const std::vector<Matrix<Quad>> &unmeasured() const { return unmeasured_; }

  private:
    void update(Track<Quad> &now, Step &step, const std::vector<bool> &taken);

    Sequence sequence_; // of the scalars that are taken, a reading each
    Model<Quad> model_;
    std::vector<Track<Quad>> track_;
    std::vector<Matrix<Quad>> unmeasured_;
};

} // namespace reference

#endif
