// A kind of random models.
#ifndef KALMANQ_TESTS_CAMPAIGN_KIND_HPP
#define KALMANQ_TESTS_CAMPAIGN_KIND_HPP

#include "../reference/random.hpp"

namespace campaign
{

/// What is given with the draw says which model: its number, or how hard it is.
template <class Drawn, class Given> struct Kind {
    const char *name;
    Drawn (*draw)(reference::Random &random, Given given);
};

} // namespace campaign

#endif
