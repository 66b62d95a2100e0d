// The figures of many sequences, in groups: each compared with its bound, and a table at the end.
#ifndef KALMANQ_TESTS_REFERENCE_REPORT_HPP
#define KALMANQ_TESTS_REFERENCE_REPORT_HPP

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "verdict.hpp"

namespace reference
{

/// The greater one; a NaN is greater than anything.
inline double worse(double a, double b)
{
    return std::isnan(a) || std::isnan(b) ? NAN : std::max(a, b);
}

/// Named figures in the order of their first mention.
template <class Value> class Named
{
  public:
    Value &operator[](const std::string &name)
    {
        for (auto &entry : entries_) {
            if (entry.first == name) return entry.second;
        }
        entries_.emplace_back(name, Value{});
        return entries_.back().second;
    }
    auto begin() const { return entries_.begin(); }
    auto end() const { return entries_.end(); }

  private:
    std::vector<std::pair<std::string, Value>> entries_;
};

/// The worst of each figure over one sequence.
class Figures
{
  public:
    void add(const std::string &name, double value) { worst_[name] = worse(worst_[name], value); }
    auto begin() const { return worst_.begin(); }
    auto end() const { return worst_.end(); }

  private:
    Named<double> worst_;
};

using Bounds = std::map<std::string, double>;

class Report
{
  public:
    Verdict verdict;

    /// The figures of one sequence.  Those without a bound are only shown.
    void add(const std::string &group, const std::string &sequence, const Figures &figures,
             const Bounds &bounds)
    {
        for (const auto &[name, value] : figures) {
            groups_[group][name].push_back(value);
            const auto bound = bounds.find(name);
            if (bound == bounds.end()) continue;
            verdict.expectAtMost(value, bound->second, group + ", " + sequence + ": " + name);
        }
    }

    /// Over the sequences of each group, of each figure: the worst, and the median.  A figure that
    /// never was above 0 is left out.
    void print() const
    {
        for (const auto &[group, figures] : groups_) {
            std::printf("%s, %zu sequences, worst (median)\n ", group.c_str(),
                        figures.begin()->second.size());
            for (const auto &[name, values] : figures) {
                if (worst(values) <= 0) continue;
                std::printf("  %s %.1e (%.0e)", name.c_str(), worst(values), median(values));
            }
            std::printf("\n");
        }
    }

  private:
    static double worst(const std::vector<double> &values)
    {
        double result = 0;
        for (double value : values) result = worse(result, value);
        return result;
    }

    static double median(std::vector<double> values)
    {
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        return *middle;
    }

    Named<Named<std::vector<double>>> groups_;
};

} // namespace reference

#endif
