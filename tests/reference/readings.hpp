// What the library says of a state, in physical units and in a type that holds it exactly.
#ifndef KALMANQ_TESTS_REFERENCE_READINGS_HPP
#define KALMANQ_TESTS_REFERENCE_READINGS_HPP

#include <cstddef>
#include <vector>

#include "formats.hpp"
#include "owners.hpp"
#include "textbook.hpp"

namespace reference
{

/// Mean (the whole word) and covariance of a filter.
template <class T> Belief<Wide<T>> read(const FilterOwner<T> &filter)
{
    using Api = kq::Api<T>;
    const Formats<T> &states = filter.states();
    const int n = states.count();
    Belief<Wide<T>> belief{Vector<Wide<T>>(n), {}};
    for (int i = 0; i < n; ++i) {
        belief.mean(i) = states.value(i, Api::mean(filter.get(), i), Api::mean_low(filter.get(), i));
    }
    std::vector<typename Api::Coefficient> P(static_cast<std::size_t>(n * n));
    kq::require(Api::covariance(filter.get(), P.data()), "covariance");
    belief.covariance = states.covariance(P, states);
    return belief;
}

/// The standard deviations as the library reports them.
template <class T> Vector<Wide<T>> readSigma(const FilterOwner<T> &filter)
{
    Vector<Wide<T>> sigma(filter.states().count());
    for (int i = 0; i < sigma.size(); ++i) {
        sigma(i) = filter.states().value(i, kq::Api<T>::sigma(filter.get(), i));
    }
    return sigma;
}

/// What a smoother shows: the means alone, and all of it.
template <class T>
Vector<Wide<T>> readViewMean(const Formats<T> &states, const typename kq::Api<T>::Filter &view)
{
    using Api = kq::Api<T>;
    Vector<Wide<T>> mean(states.count());
    for (int i = 0; i < mean.size(); ++i) {
        mean(i) = states.value(i, Api::mean(&view, i), Api::mean_low(&view, i));
    }
    return mean;
}

template <class T>
Belief<Wide<T>> readView(const Formats<T> &states, const typename kq::Api<T>::Filter &view)
{
    const auto n = static_cast<std::size_t>(states.count());
    std::vector<typename kq::Api<T>::Coefficient> P(n * n);
    kq::require(kq::Api<T>::covariance(&view, P.data()), "covariance of a view");
    return {readViewMean(states, view), states.covariance(P, states)};
}

template <class T>
typename kq::Api<T>::Filter viewSmoothed(const HistoryOwner<T> &history, std::size_t t)
{
    typename kq::Api<T>::Filter view;
    kq::require(kq::Api<T>::smoothed(history.get(), t, &view), "smoothed");
    return view;
}

/// The means of step t given all measurements.
template <class T> Vector<Wide<T>> readSmoothedMean(const HistoryOwner<T> &history, std::size_t t)
{
    return readViewMean(history.states(), viewSmoothed(history, t));
}

template <class T> Belief<Wide<T>> readSmoothed(const HistoryOwner<T> &history, std::size_t t)
{
    return readView(history.states(), viewSmoothed(history, t));
}

/// One step backwards, to step t, with all that it gives; `process` NULL: the one recorded.
template <class T>
Smoothed<Wide<T>> smoothStep(HistoryOwner<T> &history, const typename kq::Api<T>::Process *process,
                             std::size_t t)
{
    using Api = kq::Api<T>;
    const Formats<T> &states = history.states();
    const auto n = static_cast<std::size_t>(states.count());
    std::vector<typename Api::Coefficient> lagOne(n * n), mean(n), covariance(n * n);
    const typename Api::Extras extras{lagOne.data(), mean.data(), covariance.data()};
    kq::require(Api::smooth_step(history.get(), process, &extras), "smooth step");
    return {readSmoothed(history, t), states.covariance(lagOne, states), states.vector(mean),
            states.covariance(covariance, states)};
}

} // namespace reference

#endif
