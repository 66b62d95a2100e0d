// The models of a kind through every arithmetic, and the command line of the programs that do so.
//
//     PROGRAM [-v] [WHAT] [models [seed [first]]]      or --model SEED:NUMBER
#ifndef KALMANQ_TESTS_CAMPAIGN_ARITHMETICS_HPP
#define KALMANQ_TESTS_CAMPAIGN_ARITHMETICS_HPP

#include <cctype>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string>

#include "judge.hpp"
#include "kinds.hpp"

namespace campaign
{

/// A model as an arithmetic holds it, and the textbook on that
struct Held {
    const std::string &id; // SEED:NUMBER
    const Model &model;
    const Sequence &sequence;
    const Inputs &inputs;
    const Exact &exact;
    const Vec words;   // q31's
    bool areFloatsResolved; // by __float128: what the model measures, in floats
};

/// judge(T(), held) of a model for f64, f32 and, where a format holds the exact states, q31; answers whether one does.
template <class Judge> bool through(const std::string &id, const Model &model, const Judge &judge, bool withFloats = true)
{
    const Inputs inputs = heldByFloats(model.sequence);
    const Exact exact = run(inputs);
    const bool areFloatsResolved = isResolved(inputs, exact);
    if (withFloats) judge(double(), Held{id, model, model.sequence, inputs, exact, Vec(), areFloatsResolved});
    if (withFloats) judge(float(), Held{id, model, model.sequence, inputs, exact, Vec(), areFloatsResolved});
    if (!hasFormats(declaredRange(model, exact))) return false;
    const Sequence sequence = withRanges(model, exact);
    reference::Library<Q31> library(sequence);
    const Inputs words = heldByWords(sequence, library);
    judge(Q31(), Held{id, model, sequence, words, run(words), wordsOf(library), areFloatsResolved});
    return true;
}

/// Models; those with states that no format of q31 holds; those that threw
struct Through {
    int models = 0, withoutFormat = 0, notRun = 0;
};

struct Options {
    std::uint64_t models, seed = 1, first = 0;
    bool isVerbose = false;
    std::string what; // the word among them

    Options(int argc, char **argv, std::uint64_t most) : models(most)
    {
        std::uint64_t *const numbers[] = {&models, &seed, &first};
        int given = 0;
        for (int k = 1; k < argc; ++k) {
            if (std::strcmp(argv[k], "-v") == 0) isVerbose = true;
            else if (std::strcmp(argv[k], "--model") == 0 && k + 1 < argc) one(argv[++k]);
            else if (std::isalpha(static_cast<unsigned char>(argv[k][0])) && what.empty()) what = argv[k];
            else if (given < 3) *numbers[given++] = std::strtoull(argv[k], nullptr, 10);
        }
    }

    /// judge(T(), held) of the models of a kind: how many are judged
    template <class Judge> Through through(const std::string &kind, const Judge &judge, bool withFloats = true) const
    {
        Through all;
        for (std::uint64_t k = first; k < first + models; ++k) {
            const std::string id = std::to_string(seed) + ":" + std::to_string(k);
            const Model model = drawn(kind, seed, k);
            ++all.models;
            try {
                all.withoutFormat += !campaign::through(id, model, judge, withFloats);
            } catch (const std::exception &error) {
                std::printf("%s not run: %s; %s\n", id.c_str(), error.what(), model.text.c_str());
                ++all.notRun;
            }
            std::fflush(stdout);
        }
        return all;
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
