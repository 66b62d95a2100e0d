/*
 * What measurements of x[t + 1] = A x[t] determine of x, by exact arithmetic: the rank of the rows
 * h A^t of a model in integers, modulo the prime 2^31 - 1.  (A rank that the prime hides is as
 * likely as one in 2^31.)
 */
#ifndef KALMANQ_TESTS_EXACT_RANK_H
#define KALMANQ_TESTS_EXACT_RANK_H

#include <stdint.h>

#include "kalmanq/kalmanq.h"

enum { RANK_MAX = KQ_SIZE_MAX };

typedef struct {
    int rank, lead[RANK_MAX];         /* of each row, its first entry, a 1 */
    uint32_t row[RANK_MAX][RANK_MAX];
} row_space;

typedef struct {
    int n;
    row_space seen;                   /* the measurements, as functions of x[0] */
    uint32_t now[RANK_MAX][RANK_MAX]; /* x[t], as a function of x[0]: A^t */
} exact_start;

static const uint32_t prime = UINT32_C(0x7fffffff);

static inline uint32_t residue(int a) { return a < 0 ? prime - (uint32_t)-a : (uint32_t)a; }

static inline uint32_t residue_add(uint32_t total, uint32_t a, uint32_t b)
{
    return (uint32_t)((total + (uint64_t)a * b) % prime);
}

/* a^(prime - 2) */
static inline uint32_t residue_inverse(uint32_t a)
{
    uint32_t power = 1;
    for (uint32_t bits = prime - 2; bits; bits >>= 1) {
        if (bits & 1) power = residue_add(0, power, a);
        a = residue_add(0, a, a);
    }
    return power;
}

/* Is v outside of s?  Then it becomes a row of it. */
static inline int row_space_add(row_space *s, const uint32_t *v, int n)
{
    uint32_t rest[RANK_MAX];
    for (int k = 0; k < n; k++) rest[k] = v[k];
    for (int r = 0; r < s->rank; r++) {
        const uint32_t factor = prime - rest[s->lead[r]];
        for (int k = 0; k < n; k++) rest[k] = residue_add(rest[k], factor, s->row[r][k]);
    }
    int lead = 0;
    while (lead < n && rest[lead] == 0) lead++;
    if (lead == n) return 0;
    const uint32_t inverse = residue_inverse(rest[lead]);
    for (int k = 0; k < n; k++) s->row[s->rank][k] = residue_add(0, inverse, rest[k]);
    s->lead[s->rank++] = lead;
    return 1;
}

static inline void exact_begin(exact_start *e, int n)
{
    static const exact_start none;
    *e = none;
    e->n = n;
    for (int i = 0; i < n; i++) e->now[i][i] = 1;
}

/* A measurement h'x */
static inline void exact_update(exact_start *e, const int *h)
{
    uint32_t row[RANK_MAX] = {0};
    for (int i = 0; i < e->n; i++) {
        for (int k = 0; k < e->n; k++) row[k] = residue_add(row[k], residue(h[i]), e->now[i][k]);
    }
    (void)row_space_add(&e->seen, row, e->n);
}

static inline void exact_predict(exact_start *e, const int *A)
{
    uint32_t next[RANK_MAX][RANK_MAX] = {{0}};
    for (int i = 0; i < e->n; i++) {
        for (int k = 0; k < e->n; k++) {
            const uint32_t a = residue(A[i * e->n + k]);
            for (int j = 0; j < e->n; j++) next[i][j] = residue_add(next[i][j], a, e->now[k][j]);
        }
    }
    for (int i = 0; i < e->n; i++) {
        for (int j = 0; j < e->n; j++) e->now[i][j] = next[i][j];
    }
}

static inline int exact_is_determined(const exact_start *e, int i)
{
    row_space s = e->seen;
    return !row_space_add(&s, e->now[i], e->n);
}

/* The dimensions of x[t] that are not determined */
static inline int exact_count(const exact_start *e)
{
    row_space s = e->seen;
    for (int i = 0; i < e->n; i++) (void)row_space_add(&s, e->now[i], e->n);
    return s.rank - e->seen.rank;
}

#endif
