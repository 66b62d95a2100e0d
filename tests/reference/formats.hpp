// Numbers of a sequence made into the library's and back, in physical units on this side.
//
//     const Formats<T> states(n, sequence.range);
//     states.words(x)              what predict, update and init take
//     states.covariance(P, states) what kq_covariance gave, as a matrix
//
// For float and double there is nothing to it.  In q31 a component has a format, made from its
// declared range, and everything comes in units of the last bits.
#ifndef KALMANQ_TESTS_REFERENCE_FORMATS_HPP
#define KALMANQ_TESTS_REFERENCE_FORMATS_HPP

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "api.hpp"
#include "textbook.hpp"

namespace reference
{

using kq::Q31;

/// By rows, as the library takes it; exact, because every number of a sequence is a float.
template <class T> std::vector<T> flattened(const Matrix<double> &M)
{
    std::vector<T> values;
    for (Index i = 0; i < M.rows(); ++i) {
        for (Index j = 0; j < M.cols(); ++j) {
            values.push_back(static_cast<T>(M(i, j)));
        }
    }
    return values;
}

template <class T>
Matrix<double> unflattened(const std::vector<T> &values, Index rows, Index columns)
{
    Matrix<double> M(rows, columns);
    for (Index k = 0; k < rows * columns; ++k) {
        M(k / columns, k % columns) = static_cast<double>(values[static_cast<std::size_t>(k)]);
    }
    return M;
}

/// The formats of the components of one vector.
template <class T> class Formats
{
  public:
    /// Holds every number of this arithmetic exactly.
    using Wide = double;

    /// The ranges are those of q31, and not needed here.
    Formats(Index count, const Vector<double> & /*ranges*/) : count_(count) {}

    int count() const { return static_cast<int>(count_); }

    /// A vector, or several of them as columns, one after the other.
    std::vector<T> words(const Matrix<double> &columns) const
    {
        return flattened<T>(columns.transpose());
    }

    /// The nearest word
    T word(int /*component*/, double x) const { return static_cast<T>(x); }
    Wide value(int /*component*/, T word, T low = 0) const
    {
        return static_cast<Wide>(word) + static_cast<Wide>(low);
    }

    /// The vector that is given as words, but for the rounding to a word: what is nearest to
    /// `exact` of all that these words can stand for.
    Vector<Wide> values(const std::vector<T> &words, const Vector<Quad> & /*exact*/) const
    {
        return vector(words);
    }

    /// The matrix of a covariance of these components and `others`.
    Matrix<Wide> covariance(const std::vector<T> &P, const Formats &others) const
    {
        return unflattened(P, count_, others.count_);
    }

    /// The matrix that makes these components of `others`, as a gain does.
    Matrix<Wide> map(const std::vector<T> &M, const Formats &others) const
    {
        return unflattened(M, count_, others.count_);
    }

    /// A vector that is given in the same number type as matrices are.
    Vector<Wide> vector(const std::vector<T> &x) const { return unflattened(x, count_, 1); }

    /// Of a number without a unit, and of a NIS or log-likelihood.
    static Wide number(T x) { return static_cast<Wide>(x); }
    static Wide score(T x) { return static_cast<Wide>(x); }

  private:
    Index count_;
};

template <> class Formats<Q31>
{
  public:
    /// A mean has 56 bits.
    using Wide = long double;

    Formats(Index count, const Vector<double> &ranges)
    {
        if (ranges.size() != count) throw std::runtime_error("a sequence without ranges");
        for (Index i = 0; i < count; ++i) {
            kq_format_q31 format;
            kq::require(kq_format_prepare_q31(&format, KQ_FRACTION_BEST_Q31, ranges(i), nullptr), "format prepare");
            formats_.push_back(format);
        }
    }

    int count() const { return static_cast<int>(formats_.size()); }
    const kq_format_q31 *data() const { return formats_.data(); }
    /// NULL where there are no components.
    const kq_format_q31 *dataOrNull() const { return formats_.empty() ? nullptr : formats_.data(); }

    /// Refuses what is not on the grid of its format: no arithmetic is to see other data than the
    /// reference.
    std::vector<std::int32_t> words(const Matrix<double> &columns) const
    {
        std::vector<std::int32_t> all;
        for (Index k = 0; k < columns.cols() && columns.rows() > 0; ++k) {
            const Vector<double> x = columns.col(k);
            std::vector<std::int32_t> words(formats_.size());
            kq::require(
                kq_vector_prepare_q31(words.data(), x.data(), count(), formats_.data(), nullptr),
                "vector prepare");
            for (int i = 0; i < count(); ++i) {
                const std::int32_t word = words[static_cast<std::size_t>(i)];
                if (value(i, word) != static_cast<Wide>(x(i))) {
                    throw std::runtime_error("a number that is not on the grid of its format");
                }
                all.push_back(word);
            }
        }
        return all;
    }

    std::int32_t word(int component, double x) const
    {
        return static_cast<std::int32_t>(std::llround(std::ldexp(x, fraction(component))));
    }

    Wide value(int component, std::int32_t word, std::int32_t low = 0) const
    {
        const Wide whole = static_cast<Wide>(word) + std::ldexp(static_cast<Wide>(low), -24);
        return std::ldexp(whole, -fraction(component));
    }

    Vector<Wide> values(const std::vector<std::int32_t> &words, const Vector<Quad> &exact) const
    {
        Vector<Wide> result(count());
        for (int i = 0; i < count(); ++i) {
            const Wide word = value(i, words[static_cast<std::size_t>(i)]);
            const Wide half = std::ldexp(0.5L, -fraction(i));
            result(i) = std::clamp(static_cast<Wide>(exact(i)), word - half, word + half);
        }
        return result;
    }

    Matrix<Wide> covariance(const std::vector<kq_scaled_q31> &P, const Formats &others) const
    {
        return matrix(P, others, -1);
    }

    Matrix<Wide> map(const std::vector<kq_scaled_q31> &M, const Formats &others) const
    {
        return matrix(M, others, 1);
    }

    Vector<Wide> vector(const std::vector<kq_scaled_q31> &x) const
    {
        Vector<Wide> result(count());
        for (int i = 0; i < count(); ++i) {
            result(i) = std::ldexp(number(x[static_cast<std::size_t>(i)]), -fraction(i));
        }
        return result;
    }

    static Wide number(const kq_scaled_q31 &x)
    {
        return std::ldexp(static_cast<Wide>(x.mantissa), x.exponent);
    }
    static Wide score(std::int64_t x) { return std::ldexp(static_cast<Wide>(x), -24); }

  private:
    int fraction(int component) const
    {
        return formats_[static_cast<std::size_t>(component)].fraction;
    }

    /// Entries in units of a row's last bit times a column's to the power of -sign.
    Matrix<Wide> matrix(const std::vector<kq_scaled_q31> &entries, const Formats &columns,
                        int sign) const
    {
        Matrix<Wide> M(count(), columns.count());
        for (int i = 0; i < count(); ++i) {
            for (int j = 0; j < columns.count(); ++j) {
                const Wide entry = number(entries[static_cast<std::size_t>(i * M.cols() + j)]);
                M(i, j) = std::ldexp(entry, sign * columns.fraction(j) - fraction(i));
            }
        }
        return M;
    }

    std::vector<kq_format_q31> formats_;
};

/// What the results of arithmetic T are read into.
template <class T> using Wide = typename Formats<T>::Wide;

} // namespace reference

#endif
