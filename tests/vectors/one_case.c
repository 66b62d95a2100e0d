/* One case, VECTOR_CASE, where there is no room for all of them. */
#include "cases.h"
#include "flash.h"

#define TEXT_OF(text) #text
#define TEXT(text) TEXT_OF(text)

/* clang-format off */
static const int32_t words[] FLASH = {
#include TEXT(cases/VECTOR_CASE.inc)
};
/* clang-format on */

const vector_case vector_cases[] = {
    {TEXT(VECTOR_CASE), words, sizeof words / sizeof words[0]},
};

const int vector_case_count = 1;
