// The random models of the campaign: a row for each kind, and each model from its seed and number alone.
#ifndef KALMANQ_TESTS_CAMPAIGN_KINDS_HPP
#define KALMANQ_TESTS_CAMPAIGN_KINDS_HPP

#include <cstdint>
#include <stdexcept>
#include <string>

#include "kind.hpp"
#include "low_noise.hpp"
#include "model.hpp"
#include "plants.hpp"
#include "spread.hpp"
#include "whole.hpp"

namespace campaign
{

const Kind<Model, std::uint64_t> kinds[] = {
    {"hard", [](Random &random, std::uint64_t) { return hardModel(random, 1); }},
    {"narrow", [](Random &random, std::uint64_t) { return hardModel(random, 0x1p-12); }}, // true states close to x0
    {"noise_free", [](Random &random, std::uint64_t) { return wholeModel(random, 0.7); }},
    {"noisy", [](Random &random, std::uint64_t) { return wholeModel(random, 0); }},
    {"mixed", [](Random &random, std::uint64_t number) { return number % 3 == 2 ? wholeModel(random, 0.7) : hardModel(random, 1); }},
    {"ordinary", [](Random &random, std::uint64_t) { return plantModel(random); }},
    {"low_noise", [](Random &random, std::uint64_t) { return lowNoiseModel(random); }},
    {"spread", [](Random &random, std::uint64_t number) { return spreadModel(random, number); }},
};

inline Model drawn(const std::string &kind, std::uint64_t seed, std::uint64_t number)
{
    Random random(seed * 1000003U + number);
    for (const auto &one : kinds) {
        if (kind == one.name) return one.draw(random, number);
    }
    throw std::invalid_argument("no kind of models: " + kind);
}

} // namespace campaign

#endif
