/*
 * The diffuse start: what is known while some of the state is not.
 *     x = x^ + S xi + D delta,     xi ~ N(0, I),  delta flat
 * D has d columns, at first those of the identity for the unknown components.  A scalar
 * measurement z = h'x + sqrt(r) v sees delta through g = D'h.  If g is 0 it is an ordinary update
 * of x^ and S.  Otherwise a reflection of D's columns makes g = (phi, 0, ..), and the measurement
 * DEFINES the first of them, delta_1 = (z - h'x^ - f'xi - sqrt(r) v) / phi with f = S'h:
 *     x^ += k e,   S <- tria [S - k f', k sqrt(r)],   k = D_1 / phi,   D loses D_1.
 * At d = 0 the filter takes over.
 *
 * What is 0 decides everything here.  Rounding leaves D + F for D.  The columns of F are taken as
 * independent, of one covariance, which goes through every step as that of x does: A F, and, since
 * what is defined, or sees nothing unknown, has h'(D + F) = 0 whatever F is, (I - k h') F; each step
 * adds its own rounding.
 * So h'D is 0 where it is within 16 standard errors of h'F.  (Bounds of each entry by itself would
 * forget what the errors have in common: for a season of 12 they double in every second step.)
 */
#ifndef KQ_SRC_DIFFUSE_UNKNOWN_H
#define KQ_SRC_DIFFUSE_UNKNOWN_H

#include "../arithmetic/arithmetic.h"

typedef T(kq_diffuse) start;

/* Unknowns: n rows of n numbers, the first d of each in use. */
typedef struct {
    num *unknown;        /* D */
    num *rounding;       /* the covariance of a column of F, n x n numbers */
    num *volume;         /* the product of all |det A| */
    num *ranges;         /* of what is unknown, where there are ranges (ranges_q31.h) */
    num *W, *pq;         /* reflectors: n rows of n + 1, 2 n */
    num *past;           /* the early instants, or NULL where there is no room for any */
    num *joined, *spare; /* of their roots: n rows of 2n + 1, 2 n */
} diffuse_memory;

static diffuse_memory diffuse_memory_of(const start *s)
{
    const int n = s->states;
    diffuse_memory v;
    v.unknown = s->memory;
    v.rounding = v.unknown + n * n * SCALED_WORDS;
    v.volume = v.rounding + n * n * SCALED_WORDS;
    v.ranges = v.volume + SCALED_WORDS;
    v.W = v.ranges + DIFFUSE_RANGE_LEN;
    v.pq = v.W + n * ROW_LEN(n + 1);
    v.joined = v.spare = v.past = 0;
    if (s->early == 0) return v;
    v.joined = v.pq + REFLECTOR_LEN(n);
    v.spare = v.joined + n * ROW_LEN(2 * n + 1);
    v.past = v.spare + 2 * n;
    return v;
}

static num *unknown_row(num *unknown, int n, int i) { return unknown + i * n * SCALED_WORDS; }

/*
 * An early instant, carried along in the coordinates of the present one:
 *     x' = mean + C xi + E zeta + B delta,     zeta ~ N(0, I), which no later measurement sees
 */
typedef struct {
    num *mean;
    num *root;    /* E */
    num *along;   /* C, n x n numbers */
    num *unknown; /* B, as D */
    num *error;   /* of each row of B */
    num *lost;    /* bit i: row i depends on a delta that the present no longer does */
} past_state;

/* The early instant of step t, one of the latest: they are kept in a ring. */
static past_state past_at(const start *s, uint32_t t)
{
    const int n = s->states;
    const uint32_t back = s->steps - t; /* 1 .. early */
    const uint32_t slot = s->next < back ? s->next + s->early - back : s->next - back;
    past_state q;
    q.mean = diffuse_memory_of(s).past + (size_t)slot * DIFFUSE_PAST_LEN((size_t)n);
    q.root = q.mean + MEAN_PLANES * n;
    q.along = q.root + ROOT_LEN(n);
    q.unknown = q.along + n * n * SCALED_WORDS;
    q.error = q.unknown + n * n * SCALED_WORDS;
    q.lost = q.error + n * SCALED_WORDS;
    return q;
}

static uint32_t lost_rows(const past_state *q) { return (uint32_t)*q->lost; }

static num *along_at(const past_state *q, int n, int i, int k)
{
    return q->along + (i * n + k) * SCALED_WORDS;
}

/* The first step that there is room for */
static uint32_t diffuse_first(const start *s)
{
    return s->steps > s->early ? s->steps - s->early : 0;
}

enum { DIFFUSE_UNUSED, DIFFUSE_WAITING, DIFFUSE_SMOOTHED, DIFFUSE_STATES };

/* Is the state still in part unknown?  A filter that is ready has taken over, or is not ours. */
static int diffuse_is_open(const start *s) { return s->unknowns && !s->filter->ready; }

/* Do the early instants count: is the tape they end on still ours? */
static int diffuse_is_recording(const start *s)
{
    return s->phase == DIFFUSE_WAITING && s->tape && s->tape->filter == s->filter;
}

/* The first of the early instants to be carried along, up to s->steps */
static uint32_t past_begin(const start *s)
{
    return diffuse_is_recording(s) ? diffuse_first(s) : s->steps;
}

#endif
