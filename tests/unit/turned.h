/* Every bit of an object in turn: how many does its check find? */
#ifndef KALMANQ_TESTS_TURNED_H
#define KALMANQ_TESTS_TURNED_H

#include <stdio.h>

#include "arithmetic.h"

/* Of the bytes at `at`, which are as they were afterwards.  `check` is good before and after. */
static inline int bits_found(void *at, size_t size, kq_status (*check)(void))
{
    unsigned char *bytes = at;
    int found = 0;
    TEST_ASSERT_EQUAL_INT(KQ_OK, check());
    for (size_t k = 0; k < size; k++) {
        for (int bit = 0; bit < 8; bit++) {
            bytes[k] = (unsigned char)(bytes[k] ^ 1u << bit);
            found += check() < 0;
            bytes[k] = (unsigned char)(bytes[k] ^ 1u << bit);
        }
    }
    TEST_ASSERT_EQUAL_INT(KQ_OK, check());
    return found;
}

#define BITS_FOUND(object, check) bits_found(&(object), sizeof(object), check)
#define FIELD_BITS(object, field) (8 * (int)sizeof((object).field))

/* A share that must not fall */
static inline void assert_share(const char *what, int found, size_t bytes, int least)
{
    const int all = (int)(8 * bytes), share = (int)(100L * found / all);
    char text[80];
    (void)snprintf(text, sizeof text, "%s: %d of %d bits found, %d %%", what, found, all, share);
    (void)puts(text);
    TEST_ASSERT_TRUE_MESSAGE(share >= least, text);
}

#endif
