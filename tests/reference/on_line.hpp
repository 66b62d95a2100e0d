// The smoothers on line behind one set of names, as api.hpp has the rest, and their owners.
#ifndef KALMANQ_TESTS_REFERENCE_ON_LINE_HPP
#define KALMANQ_TESTS_REFERENCE_ON_LINE_HPP

#include <cstddef>
#include <vector>

#include "api.hpp"
#include "library.hpp"
#include "owners.hpp"
#include "readings.hpp"

namespace reference
{

template <class T> class LagOwner : NotCopied
{
    using Api = kq::Api<T>;

  public:
    LagOwner(const Formats<T> &states, int m, int L, bool takesWhatIsLate = false)
        : states_(states),
          memory_(Api::length(KQ_OBJECT_LAG, states.count(), m, static_cast<std::size_t>(L)))
    {
        const auto assign = takesWhatIsLate ? Api::delay_assign : Api::lag_assign;
        kq::require(assign(&handle_, states.count(), m, L, memory_.data(), memory_.size()), "lag assign");
    }

    void attach(FilterOwner<T> &filter)
    {
        kq::require(Api::attach(filter.get(), &handle_.attached), "lag attach");
    }

    int steps() const { return (int)Api::lag_steps(&handle_); }

    typename Api::Filter view(int k)
    {
        typename Api::Filter view;
        kq::require(Api::lagged(&handle_, k, &view), "lagged");
        return view;
    }

    Belief<Wide<T>> smooth(int k) { return readView(states_, view(k)); }

    Vector<Wide<T>> smoothStates(int k)
    {
        typename Api::Filter view;
        kq::require(Api::lagged_states(&handle_, k, &view), "lagged states");
        return readViewMean(states_, view);
    }

  private:
    const Formats<T> &states_;
    std::vector<typename Api::Word> memory_;
    typename Api::Lag handle_{};
};

template <class T> class InstantOwner : NotCopied
{
    using Api = kq::Api<T>;

  public:
    InstantOwner(const Formats<T> &states, int m)
        : states_(states), memory_(Api::length(KQ_OBJECT_INSTANT, states.count(), m))
    {
        kq::require(Api::instant_assign(&handle_, states.count(), m, memory_.data(), memory_.size()),
                    "instant assign");
    }

    void attach(FilterOwner<T> &filter)
    {
        kq::require(Api::attach(filter.get(), &handle_.attached), "instant attach");
    }

    Belief<Wide<T>> smooth()
    {
        typename Api::Filter view;
        kq::require(Api::instant_smooth(&handle_, &view), "instant smooth");
        return readView(states_, view);
    }

  private:
    const Formats<T> &states_;
    std::vector<typename Api::Word> memory_;
    typename Api::Instant handle_{};
};

} // namespace reference

#endif
