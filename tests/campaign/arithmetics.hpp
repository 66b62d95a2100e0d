// One model through every arithmetic, and the command line of the programs that do so.
//
//     PROGRAM [-v] [--OPTION] [models [seed [first]]]      or --model SEED:NUMBER
#ifndef KALMANQ_TESTS_CAMPAIGN_ARITHMETICS_HPP
#define KALMANQ_TESTS_CAMPAIGN_ARITHMETICS_HPP

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

#include "judge.hpp"

namespace campaign
{

/// A model as an arithmetic holds it, and the textbook on that
struct Held {
    const Sequence &sequence;
    const Inputs &inputs;
    const Exact &exact;
    const Vec words; // q31's
};

/// judge(T(), held) for f64 and f32
template <class Judge> void judgeFloats(const Sequence &sequence, const Inputs &inputs, const Exact &exact, const Judge &judge)
{
    judge(double(), Held{sequence, inputs, exact, Vec()});
    judge(float(), Held{sequence, inputs, exact, Vec()});
}

/// The same for q31; false where no format holds the exact states
template <class Judge> bool judgeWords(const Model &model, const Exact &exact, const Judge &judge)
{
    if (!hasFormats(declaredRange(model, exact))) return false;
    const Sequence sequence = withRanges(model, exact);
    reference::Library<Q31> library(sequence);
    const Inputs inputs = heldByWords(sequence, library);
    judge(Q31(), Held{sequence, inputs, run(inputs), wordsOf(library)});
    return true;
}

struct Options {
    std::uint64_t models, seed = 1, first = 0;
    bool isVerbose = false;
    std::string option; // one that begins with --

    Options(int argc, char **argv, std::uint64_t most) : models(most)
    {
        std::uint64_t *const numbers[] = {&models, &seed, &first};
        int given = 0;
        for (int k = 1; k < argc; ++k) {
            if (std::strcmp(argv[k], "-v") == 0) isVerbose = true;
            else if (std::strcmp(argv[k], "--model") == 0 && k + 1 < argc) one(argv[++k]);
            else if (argv[k][0] == '-') option = argv[k];
            else if (given < 3) *numbers[given++] = std::strtoull(argv[k], nullptr, 10);
        }
    }

    /// each(number, SEED:NUMBER)
    template <class Each> void forEach(const Each &each) const
    {
        for (std::uint64_t k = first; k < first + models; ++k) each(k, std::to_string(seed) + ":" + std::to_string(k));
    }

  private:
    void one(const char *text)
    {
        char *rest = nullptr;
        seed = std::strtoull(text, &rest, 10);
        first = *rest ? std::strtoull(rest + 1, nullptr, 10) : 0;
        models = 1;
    }
};

} // namespace campaign

#endif
