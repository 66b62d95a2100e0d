/* Every bit of an object in turn: how many does its check find? */
#ifndef KALMANQ_TESTS_TURNED_H
#define KALMANQ_TESTS_TURNED_H

#include <stddef.h>

#include "kalmanq/status.h"
#include "suite.h"

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
#define ASSERT_ALL_FOUND(object, check) TEST_ASSERT_EQUAL_INT(8 * (int)sizeof(object), BITS_FOUND(object, check))

#endif
