// Quadruple precision that Eigen can compute with (link with -lquadmath), and the functions that
// differ between the number types of the reference.
//
// __float128 itself cannot be given to Eigen in standard C++: Eigen finds sqrt and abs by the
// namespace of their argument, and a built-in type has none.
#ifndef KALMANQ_TESTS_REFERENCE_QUAD_HPP
#define KALMANQ_TESTS_REFERENCE_QUAD_HPP

#include <quadmath.h>

#include <Eigen/Dense>
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

template <class Real> Real magnitude(const Real &x)
{
    using std::abs;
    return abs(x);
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

/// Eigen asks here for the smallest number (its Householder code) and for the epsilon.
template <> struct numeric_limits<reference::Quad> : numeric_limits<double> {
    static reference::Quad min() { return reference::Quad::of(ldexpq(1, -16382)); }
    static reference::Quad epsilon() { return reference::Quad::of(ldexpq(1, -112)); }
};

} // namespace std

namespace Eigen
{

template <> struct NumTraits<reference::Quad> : GenericNumTraits<reference::Quad> {
    using Quad = reference::Quad;
    using Real = Quad;
    using NonInteger = Quad;
    using Nested = Quad;
    using Literal = Quad;
    enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 0 };
    enum { ReadCost = 2, AddCost = 40, MulCost = 40 };
    static Quad epsilon() { return Quad::of(ldexpq(1, -112)); }
    static Quad dummy_precision() { return Quad::of(ldexpq(1, -100)); }
    static Quad lowest() { return -highest(); }
    static Quad highest() { return Quad::of(ldexpq(2 - ldexpq(1, -112), 16383)); }
    static Quad infinity() { return Quad(std::numeric_limits<double>::infinity()); }
    static Quad quiet_NaN() { return Quad(std::numeric_limits<double>::quiet_NaN()); }
    static int digits10() { return 33; }
};

} // namespace Eigen

#endif
