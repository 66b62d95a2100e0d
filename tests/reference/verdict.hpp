// Counts the checks of a test program, prints the failing ones and the final line.
#ifndef KALMANQ_TESTS_REFERENCE_VERDICT_HPP
#define KALMANQ_TESTS_REFERENCE_VERDICT_HPP

#include <algorithm>
#include <cstdio>
#include <string>

namespace reference
{

class Verdict
{
  public:
    /// One check; `what` is printed where it fails.
    void expect(bool good, const std::string &what)
    {
        ++(good ? passed_ : failed_);
        if (!good) {
            std::printf("FAILED  %s\n", what.c_str());
        }
    }

    /// The same for a figure that has to stay at or below a limit; a NaN fails.
    void expectAtMost(double figure, double limit, const std::string &what)
    {
        char text[64];
        std::snprintf(text, sizeof text, ": %.3g, limit %.3g", figure, limit);
        expect(figure <= limit, what + text);
    }

    void expectAtLeast(double figure, double limit, const std::string &what)
    {
        char text[64];
        std::snprintf(text, sizeof text, ": %.3g, at least %.3g", figure, limit);
        expect(figure >= limit, what + text);
    }

    /// A goal that rounding puts out of reach here: the figure may pass it, up to `limit`, and
    /// is printed where it does.
    void expectGoal(double figure, double goal, double limit, const std::string &what)
    {
        if (figure > goal && figure <= limit) {
            std::printf("beyond  %s: %.3g, goal %.3g, limit %.3g\n", what.c_str(), figure, goal,
                        limit);
        }
        expectAtMost(figure, std::max(goal, limit), what);
    }

    /// Prints the last line; the value that main returns.
    int finish() const
    {
        std::printf("%d passed, %d failed\n", passed_, failed_);
        return failed_ == 0 ? 0 : 1;
    }

  private:
    int passed_ = 0, failed_ = 0;
};

} // namespace reference

#endif
