// Quadruple precision as a class (link with -lquadmath), and the functions that differ between the
// number types of the reference.
//
// __float128 itself cannot be given to a template of standard C++ that finds sqrt and abs by the
// namespace of their argument, as Eigen's do: a built-in type has none.
#ifndef KALMANQ_TESTS_REFERENCE_QUAD_HPP
#define KALMANQ_TESTS_REFERENCE_QUAD_HPP

#include <quadmath.h>

#include <cmath>
#include <limits>
#include <type_traits>

namespace reference
{

class Quad
{
  public:
    Quad() : value_(0) {}
    template <class Number, class = std::enable_if_t<std::is_arithmetic<Number>::value>>
    Quad(Number value) : value_(static_cast<__float128>(value))
    {
    }

    static Quad of(__float128 value)
    {
        Quad result;
        result.value_ = value;
        return result;
    }
    __float128 value() const { return value_; }

    template <class Number, class = std::enable_if_t<std::is_arithmetic<Number>::value>>
    explicit operator Number() const
    {
        return static_cast<Number>(value_);
    }

    Quad operator-() const { return of(-value_); }
    Quad &operator+=(const Quad &other) { return *this = of(value_ + other.value_); }
    Quad &operator-=(const Quad &other) { return *this = of(value_ - other.value_); }
    Quad &operator*=(const Quad &other) { return *this = of(value_ * other.value_); }
    Quad &operator/=(const Quad &other) { return *this = of(value_ / other.value_); }

    friend Quad operator+(Quad a, const Quad &b) { return a += b; }
    friend Quad operator-(Quad a, const Quad &b) { return a -= b; }
    friend Quad operator*(Quad a, const Quad &b) { return a *= b; }
    friend Quad operator/(Quad a, const Quad &b) { return a /= b; }
    friend bool operator==(const Quad &a, const Quad &b) { return a.value_ == b.value_; }
    friend bool operator!=(const Quad &a, const Quad &b) { return a.value_ != b.value_; }
    friend bool operator<(const Quad &a, const Quad &b) { return a.value_ < b.value_; }
    friend bool operator>(const Quad &a, const Quad &b) { return a.value_ > b.value_; }
    friend bool operator<=(const Quad &a, const Quad &b) { return a.value_ <= b.value_; }
    friend bool operator>=(const Quad &a, const Quad &b) { return a.value_ >= b.value_; }

    friend Quad sqrt(const Quad &x) { return of(sqrtq(x.value_)); }
    friend Quad abs(const Quad &x) { return of(fabsq(x.value_)); }
    friend Quad log(const Quad &x) { return of(logq(x.value_)); }
    friend bool isfinite(const Quad &x) { return finiteq(x.value_) != 0; }

  private:
    __float128 value_;
};

template <class Real> Real logarithm(const Real &x)
{
    using std::log;
    return log(x);
}

template <class Real> Real squareRoot(const Real &x)
{
    using std::sqrt;
    return sqrt(x);
}

/// Two doubles and a rest: a literal in quadruple precision needs a suffix of one compiler.
template <class Real> Real pi()
{
    return (Real(1.2246467991473532e-16) + Real(-2.9947698097183397e-33)) +
           Real(3.141592653589793116);
}

} // namespace reference

namespace std
{

/// The epsilon, and the smallest number, which Eigen asks for.
template <> struct numeric_limits<reference::Quad> : numeric_limits<double> {
    static reference::Quad min() { return reference::Quad::of(ldexpq(1, -16382)); }
    static reference::Quad epsilon() { return reference::Quad::of(ldexpq(1, -112)); }
};

} // namespace std

#endif
