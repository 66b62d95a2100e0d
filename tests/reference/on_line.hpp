// The smoothers on line behind one set of names, as api.hpp has the rest, and their owners.
#ifndef KALMANQ_TESTS_REFERENCE_ON_LINE_HPP
#define KALMANQ_TESTS_REFERENCE_ON_LINE_HPP

#include <cstddef>
#include <vector>

#include "api.hpp"
#include "library.hpp"
#include "owners.hpp"

namespace reference
{

template <class T> struct OnLine;

template <> struct OnLine<float> {
    using Lag = kq_lag_f32;
    using Point = kq_point_f32;
    static constexpr std::size_t lagLength(std::size_t n, std::size_t m, std::size_t L)
    {
        return KQ_LAG_LEN_F32(n, m, L);
    }
    static constexpr std::size_t pointLength(std::size_t n, std::size_t m)
    {
        return KQ_POINT_LEN_F32(n, m);
    }
    static constexpr auto lagAssign = kq_lag_assign_f32;
    static constexpr auto attach = kq_attach_f32;
    static constexpr auto lagSmooth = kq_lag_smooth_f32;
    static constexpr auto lagSmoothStates = kq_lag_smooth_states_f32;
    static constexpr auto lagSteps = kq_lag_steps_f32;
    static constexpr auto lagMean = kq_lag_mean_f32;
    static constexpr auto lagMeanLow = kq_lag_mean_low_f32;
    static constexpr auto lagCovariance = kq_lag_covariance_f32;
    static constexpr auto pointAssign = kq_point_assign_f32;
    static constexpr auto pointSmooth = kq_point_smooth_f32;
    static constexpr auto pointMean = kq_point_mean_f32;
    static constexpr auto pointMeanLow = kq_point_mean_low_f32;
    static constexpr auto pointCovariance = kq_point_covariance_f32;
};

template <> struct OnLine<double> {
    using Lag = kq_lag_f64;
    using Point = kq_point_f64;
    static constexpr std::size_t lagLength(std::size_t n, std::size_t m, std::size_t L)
    {
        return KQ_LAG_LEN_F64(n, m, L);
    }
    static constexpr std::size_t pointLength(std::size_t n, std::size_t m)
    {
        return KQ_POINT_LEN_F64(n, m);
    }
    static constexpr auto lagAssign = kq_lag_assign_f64;
    static constexpr auto attach = kq_attach_f64;
    static constexpr auto lagSmooth = kq_lag_smooth_f64;
    static constexpr auto lagSmoothStates = kq_lag_smooth_states_f64;
    static constexpr auto lagSteps = kq_lag_steps_f64;
    static constexpr auto lagMean = kq_lag_mean_f64;
    static constexpr auto lagMeanLow = kq_lag_mean_low_f64;
    static constexpr auto lagCovariance = kq_lag_covariance_f64;
    static constexpr auto pointAssign = kq_point_assign_f64;
    static constexpr auto pointSmooth = kq_point_smooth_f64;
    static constexpr auto pointMean = kq_point_mean_f64;
    static constexpr auto pointMeanLow = kq_point_mean_low_f64;
    static constexpr auto pointCovariance = kq_point_covariance_f64;
};

template <> struct OnLine<Q31> {
    using Lag = kq_lag_q31;
    using Point = kq_point_q31;
    static constexpr std::size_t lagLength(std::size_t n, std::size_t m, std::size_t L)
    {
        return KQ_LAG_LEN_Q31(n, m, L);
    }
    static constexpr std::size_t pointLength(std::size_t n, std::size_t m)
    {
        return KQ_POINT_LEN_Q31(n, m);
    }
    static constexpr auto lagAssign = kq_lag_assign_q31;
    static constexpr auto attach = kq_attach_q31;
    static constexpr auto lagSmooth = kq_lag_smooth_q31;
    static constexpr auto lagSmoothStates = kq_lag_smooth_states_q31;
    static constexpr auto lagSteps = kq_lag_steps_q31;
    static constexpr auto lagMean = kq_lag_mean_q31;
    static constexpr auto lagMeanLow = kq_lag_mean_low_q31;
    static constexpr auto lagCovariance = kq_lag_covariance_q31;
    static constexpr auto pointAssign = kq_point_assign_q31;
    static constexpr auto pointSmooth = kq_point_smooth_q31;
    static constexpr auto pointMean = kq_point_mean_q31;
    static constexpr auto pointMeanLow = kq_point_mean_low_q31;
    static constexpr auto pointCovariance = kq_point_covariance_q31;
};

/// Mean, its low part and covariance as three functions tell them of an object.
template <class T, class Object, class Mean, class Low, class Covariance>
Belief<Wide<T>> readAnswer(const Formats<T> &states, const Object *object, Mean mean, Low low,
                           Covariance covariance)
{
    const int n = states.count();
    Belief<Wide<T>> belief{Vector<Wide<T>>(n), {}};
    for (int i = 0; i < n; ++i) {
        belief.mean(i) = states.value(i, mean(object, i), low(object, i));
    }
    std::vector<typename kq::Api<T>::Coefficient> P(static_cast<std::size_t>(n * n));
    kq::require(covariance(object, P.data()), "covariance of an answer");
    belief.covariance = states.covariance(P, states);
    return belief;
}

template <class T> class LagOwner : NotCopied
{
    using Api = OnLine<T>;

  public:
    LagOwner(const Formats<T> &states, int m, int L)
        : states_(states),
          memory_(Api::lagLength(static_cast<std::size_t>(states.count()),
                                 static_cast<std::size_t>(m), static_cast<std::size_t>(L)))
    {
        kq::require(Api::lagAssign(&handle_, states.count(), m, L, memory_.data(), memory_.size()),
                    "lag assign");
    }

    void attach(FilterOwner<T> &filter)
    {
        kq::require(Api::attach(filter.get(), &handle_.attached), "lag attach");
    }

    int steps() const { return (int)Api::lagSteps(&handle_); }

    Belief<Wide<T>> smooth(int k)
    {
        kq::require(Api::lagSmooth(&handle_, k), "lag smooth");
        return readAnswer<T>(states_, &handle_, Api::lagMean, Api::lagMeanLow, Api::lagCovariance);
    }

    Vector<Wide<T>> smoothStates(int k)
    {
        kq::require(Api::lagSmoothStates(&handle_, k), "lag smooth states");
        Vector<Wide<T>> mean(states_.count());
        for (int i = 0; i < mean.size(); ++i) {
            mean(i) = states_.value(i, Api::lagMean(&handle_, i), Api::lagMeanLow(&handle_, i));
        }
        return mean;
    }

  private:
    const Formats<T> &states_;
    std::vector<typename kq::Api<T>::Word> memory_;
    typename Api::Lag handle_{};
};

template <class T> class PointOwner : NotCopied
{
    using Api = OnLine<T>;

  public:
    PointOwner(const Formats<T> &states, int m)
        : states_(states), memory_(Api::pointLength(static_cast<std::size_t>(states.count()),
                                                    static_cast<std::size_t>(m)))
    {
        kq::require(Api::pointAssign(&handle_, states.count(), m, memory_.data(), memory_.size()),
                    "point assign");
    }

    void attach(FilterOwner<T> &filter)
    {
        kq::require(Api::attach(filter.get(), &handle_.attached), "point attach");
    }

    Belief<Wide<T>> smooth()
    {
        kq::require(Api::pointSmooth(&handle_), "point smooth");
        return readAnswer<T>(states_, &handle_, Api::pointMean, Api::pointMeanLow,
                             Api::pointCovariance);
    }

  private:
    const Formats<T> &states_;
    std::vector<typename kq::Api<T>::Word> memory_;
    typename Api::Point handle_{};
};

} // namespace reference

#endif
