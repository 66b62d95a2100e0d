/*
 * A refused call leaves every object and every output array byte for byte as it was.
 *
 * A test lists what must stay with WATCH, and makes the call inside ASSERT_REFUSED, or inside
 * ASSERT_OK_UNCHANGED for a call that only reads.
 */
#ifndef KALMANQ_TESTS_UNCHANGED_H
#define KALMANQ_TESTS_UNCHANGED_H

#include "arithmetic.h"

#define WATCHED_OBJECTS 32
#ifndef WATCHED_BYTES
#define WATCHED_BYTES 4096
#endif

static struct {
    const void *at;
    size_t size;
} watched[WATCHED_OBJECTS];

static size_t watched_count;
static unsigned char watched_bytes[WATCHED_BYTES];

static inline void watch_nothing(void) { watched_count = 0; }

static inline void watch(const void *at, size_t size)
{
    TEST_ASSERT_TRUE_MESSAGE(watched_count < WATCHED_OBJECTS, "too many objects to watch");
    watched[watched_count].at = at;
    watched[watched_count].size = size;
    watched_count++;
}

#define WATCH(object) watch(&(object), sizeof(object))

static inline void watched_store(void)
{
    size_t used = 0;
    for (size_t k = 0; k < watched_count; k++) {
        TEST_ASSERT_TRUE_MESSAGE(used + watched[k].size <= WATCHED_BYTES, "too much to watch");
        memcpy(watched_bytes + used, watched[k].at, watched[k].size);
        used += watched[k].size;
    }
}

/* What nobody wrote may be compared, too. */
#if defined(__clang__)
__attribute__((no_sanitize("memory")))
#endif
static int same_bytes(const unsigned char *a, const unsigned char *b, size_t count)
{
    size_t k = 0;
    while (k < count && a[k] == b[k]) k++;
    return k == count;
}

static inline void watched_assert_unchanged(UNITY_LINE_TYPE line)
{
    size_t used = 0;
    for (size_t k = 0; k < watched_count; k++) {
        const int same = same_bytes(watched_bytes + used, watched[k].at, watched[k].size);
        UNITY_TEST_ASSERT(same, line, description() ? description() : "the call changed an object that it had to leave alone");
        used += watched[k].size;
    }
}

static inline void assert_unchanged(kq_status expected, kq_status actual, UNITY_LINE_TYPE line)
{
    UNITY_TEST_ASSERT_EQUAL_INT(expected, actual, line, description() ? description() : kq_status_text(actual));
    watched_assert_unchanged(line);
}

#define ASSERT_REFUSED(status, call)                                                               \
    do {                                                                                           \
        watched_store();                                                                           \
        assert_unchanged(status, call, __LINE__);                                                  \
    } while (0)

/* The same as long as `field` has another value */
#define ASSERT_REFUSED_WITH(field, value, status, call)                                            \
    do {                                                                                           \
        unsigned char its_value[sizeof(field)];                                                    \
        memcpy(its_value, &(field), sizeof its_value);                                             \
        (field) = (value);                                                                         \
        ASSERT_REFUSED(status, call);                                                              \
        memcpy(&(field), its_value, sizeof its_value);                                             \
    } while (0)

#define ASSERT_OK_UNCHANGED(call) ASSERT_REFUSED(KQ_OK, call)

/* An object that was never given its sizes and memory. */
#define ASSERT_REFUSED_SIZE_OR_MEMORY(call)                                                        \
    do {                                                                                           \
        watched_store();                                                                           \
        const kq_status refused_with = call;                                                       \
        assert_unchanged(refused_with == KQ_ERR_SIZE ? KQ_ERR_SIZE : KQ_ERR_MEMORY, refused_with,  \
                         __LINE__);                                                                \
    } while (0)

/* ------------------------------------------------- numbers and covariances that are refused */

typedef kq_status attempt(void);

/* Every entry of `a` in turn NaN, infinity and -infinity: `call`, which reads it, refuses. */
static inline void assert_entries_must_be_finite(num *a, int count, attempt *call)
{
    static const num bad[] = {(num)NAN, (num)INFINITY, -(num)INFINITY};
    for (int k = 0; k < count; k++) {
        const num good = a[k];
        for (int b = 0; b < COUNT(bad); b++) {
            a[k] = bad[b];
            ASSERT_REFUSED(KQ_ERR_NOT_FINITE, call());
        }
        a[k] = good;
    }
    ASSERT_OK(call());
}

static inline void put_covariance(num *C, double c00, double c01, double c10, double c11)
{
    C[0] = N(c00);
    C[1] = N(c01);
    C[2] = N(c10);
    C[3] = N(c11);
}

/* C: 2 x 2, read by `call`. */
static inline void assert_covariance_must_be_symmetric(num *C, attempt *call)
{
    put_covariance(C, 2, 1, 0.5, 2);
    ASSERT_REFUSED(KQ_ERR_NOT_SYMMETRIC, call());
    put_covariance(C, 2, 0.5, -0.5, 2);
    ASSERT_REFUSED(KQ_ERR_NOT_SYMMETRIC, call());
    put_covariance(C, 2, 1, 1 + 100 * EPS, 2);
    ASSERT_REFUSED(KQ_ERR_NOT_SYMMETRIC, call());
    put_covariance(C, 0x1p20, 0.5, 0.25, 0x1p-20);
    ASSERT_REFUSED(KQ_ERR_NOT_SYMMETRIC, call());
}

static inline void assert_covariance_must_be_semidefinite(num *C, attempt *call)
{
    static const double bad[][3] = {
        {1, 2, 1},
        {-1, 0, 1},
        {1, 0, -1},
        {-1, 0, -1},
        {0, 1, 1},
        {1, 1, 0},
        {0, 1, 0},
        {1, 1 + 100 * EPS, 1},
        {1, -1 - 100 * EPS, 1},
        {0x1p20, 1.25, 0x1p-20},
    };
    for (int k = 0; k < COUNT(bad); k++) {
        put_covariance(C, bad[k][0], bad[k][1], bad[k][1], bad[k][2]);
        ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, call());
    }
}

static inline void assert_covariance_may_be_singular_or_rounded(num *C, attempt *call)
{
    static const double good[][4] = {
        {0, 0, 0, 0},       {1, 0, 0, 0},       {0, 0, 0, 1},
        {4, 2, 2, 1},       {1, -1, -1, 1},     {1, 1 + EPS, 1 + EPS, 1},
        {1, 1, 1 + EPS, 1}, {1, 1 + EPS, 1, 1}, {0x1p20, 1 + EPS, 1, 0x1p-20},
    };
    for (int k = 0; k < COUNT(good); k++) {
        put_covariance(C, good[k][0], good[k][1], good[k][2], good[k][3]);
        ASSERT_OK(call());
    }
}

static inline void assert_covariance_is_checked(num *C, attempt *call)
{
    put_covariance(C, 2, 0.5, 0.5, 1);
    assert_entries_must_be_finite(C, 4, call);
    assert_covariance_must_be_symmetric(C, call);
    assert_covariance_must_be_semidefinite(C, call);
    assert_covariance_may_be_singular_or_rounded(C, call);
}

#endif
