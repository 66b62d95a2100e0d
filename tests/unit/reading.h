/*
 * All that a filter of up to 3 states tells, in one object, so that two runs can be compared bit
 * for bit; and seeded noise for the measurements.
 */
#ifndef KALMANQ_TESTS_READING_H
#define KALMANQ_TESTS_READING_H

#include "arithmetic.h"

#define READING_STATES 3

typedef struct {
    num mean[READING_STATES], low[READING_STATES];
    num sigma[READING_STATES], P[READING_STATES * READING_STATES];
    num nis, last, run;
    int taken;
    unsigned events;
} reading;

/* What a smoother shows: mean, low, sigma and P. */
static inline void read_view(reading *r, const K(filter) * view, int n)
{
    memset(r, 0, sizeof *r);
    for (int i = 0; i < n; i++) {
        r->mean[i] = K(mean)(view, i);
        r->low[i] = K(mean_low)(view, i);
        r->sigma[i] = K(sigma)(view, i);
    }
    ASSERT_OK(K(covariance)(view, r->P));
}

static inline void read_filter(reading *r, const K(filter) * f, int n)
{
    read_view(r, f, n);
    r->nis = K(nis)(f);
    r->last = K(log_likelihood_last)(f);
    r->run = K(log_likelihood)(f);
    r->taken = K(taken)(f);
    r->events = K(events)(f);
}

static inline void read_smoothed(reading *r, const K(history) * h, size_t t, int n)
{
    read_view(r, SMOOTHED(h, t), n);
}

/* Two filters that must be in the very same state. */
static inline void assert_same_filter(const K(filter) * expected, const K(filter) * actual, int n,
                                      UNITY_LINE_TYPE line)
{
    reading a, b;
    read_filter(&a, expected, n);
    read_filter(&b, actual, n);
    UNITY_TEST_ASSERT(memcmp(&a, &b, sizeof a) == 0, line, "the two filters differ");
}

#define ASSERT_SAME_FILTER(expected, actual, n) assert_same_filter(expected, actual, n, __LINE__)

/* The same mean and covariance; what the last update told may differ. */
static inline void assert_same_state(const K(filter) * expected, const K(filter) * actual, int n,
                                     UNITY_LINE_TYPE line)
{
    reading a, b;
    read_filter(&a, expected, n);
    read_filter(&b, actual, n);
    UNITY_TEST_ASSERT(memcmp(&a, &b, offsetof(reading, nis)) == 0, line, "the two states differ");
}

#define ASSERT_SAME_STATE(expected, actual, n) assert_same_state(expected, actual, n, __LINE__)

/* About N(0, 1): 12 uniform numbers of 24 bits, seeded, the same on every machine. */
static inline num noise(uint32_t *seed)
{
    double sum = -6;
    for (int k = 0; k < 12; k++) {
        *seed = *seed * UINT32_C(1664525) + UINT32_C(1013904223);
        sum += (double)(*seed >> 8) / 0x1p24;
    }
    return N(sum);
}

#endif
