// What is counted of the models of a kind, and what it must fulfil: results that are wrong, and what the events say of
// them.  A line of the tally is of one arithmetic and of one view, or of another part of the results.
//
//     tally["q31 run"].add({isWrong, isTold, hasEvent});              a model
//     {"q31 run", &Counts::falsely, 3, "q31 run", &Counts::told}      of the events a third may be false
#ifndef KALMANQ_TESTS_CAMPAIGN_CLAIMS_HPP
#define KALMANQ_TESTS_CAMPAIGN_CLAIMS_HPP

#include <cstdio>
#include <map>
#include <string>
#include <vector>

namespace campaign
{

/// Of a model: is a result wrong; does the event that is studied say so; does any
struct Outcry {
    bool isWrong, isTold, hasEvent;
};

struct Counts {
    int judged = 0, refused = 0, told = 0, falsely = 0, wrong = 0, silent = 0;

    void add(const Outcry &of)
    {
        ++judged;
        told += of.isTold;
        falsely += of.isTold && !of.isWrong;
        wrong += of.isWrong;
        silent += of.isWrong && !of.hasEvent;
    }
};

/// times * part <= whole + slack: of what a line counts and of what another one does
struct Claim {
    std::string line;
    int Counts::*part;
    int times = 1;
    std::string other = "";
    int Counts::*whole = nullptr; // 0
    int slack = 0;
};

class Tally
{
  public:
    Counts &operator[](const std::string &line) { return lines_[line]; }

    void print() const
    {
        for (const auto &[line, c] : lines_) {
            std::printf("%-24s %5d judged, %3d refused, %4d with the event, %4d of them falsely, %4d wrong, %4d of them silent\n",
                        line.c_str(), c.judged, c.refused, c.told, c.falsely, c.wrong, c.silent);
        }
    }

    /// Prints what does not hold.
    bool fulfils(const std::vector<Claim> &claims)
    {
        bool good = true;
        for (const Claim &claim : claims) {
            for (const std::string &line : {claim.line, claim.other}) {
                if (line.empty() || lines_.count(line)) continue;
                std::printf("FAILED  %s: nothing was judged\n", line.c_str());
                good = false;
            }
            const int part = lines_[claim.line].*claim.part, whole = claim.whole ? lines_[claim.other].*claim.whole : 0;
            if (claim.times * part <= whole + claim.slack) continue;
            std::printf("FAILED  %s: %d, %d times that may be %d %s\n", claim.line.c_str(), part, claim.times, whole + claim.slack,
                        claim.other.c_str());
            good = false;
        }
        std::printf("%s\n", good ? "passed" : "FAILED");
        return good;
    }

  private:
    std::map<std::string, Counts> lines_;
};

} // namespace campaign

#endif
