/*
 * A process whose noise w is correlated with the noise v of the measurement before it, E w v' = S.  Of w, v tells
 * K v, K = S R^-1, and v = z - H x:
 *     x' = (A - K H) x + B u + K z + (w - K v)
 * What is left of Q may be far smaller than Q.  So the components leave the joint covariance [Q, S; S', R] one by one
 * (Goodnight, Amer. Statist. 33, 1979), in pairs of numbers: the difference is rounded at its own size.
 */
#ifndef KQ_SRC_MODEL_CORRELATED_FLOAT_H
#define KQ_SRC_MODEL_CORRELATED_FLOAT_H

#include "matrices_float.h"

/* The joint covariance in the process's memory behind A* and B*, its upper triangle in two planes; without the
   components in `swept`: what they leave of it, and in their columns K */
typedef struct {
    num *high, *low; /* width^2 each */
    const num *Q, *S;
    const sensor *s;
    uint32_t present, swept; /* bit c: component c */
    int width;               /* n + m */
} joint;

static inline int joint_index(const joint *of, int i, int j)
{
    return i < j ? i * of->width + j : j * of->width + i;
}

static inline num_pair joint_get(const joint *of, int k) { return (num_pair){of->high[k], of->low[k]}; }

static inline void joint_set(const joint *of, int k, num_pair value)
{
    of->high[k] = value.high;
    of->low[k] = value.low;
}

/* Entry i <= j of [Q, S; S', R], as given.  What is not present is 0.  So is the floor under a component without noise: it
   has none to share. */
KQ_COLD static num joint_entry(const joint *of, int i, int j)
{
    const int n = of->s->states, m = of->s->components, b = i - n, c = j - n;
    if (c < 0) return of->Q[i * n + j];
    if (!(of->present >> c & 1)) return 0;
    if (b < 0) return of->S[i * m + c];
    const num r = of->present >> b & 1 ? noise_entry(of->s, b, c) : 0;
    return b == c && r <= num_tiny ? 0 : r;
}

KQ_COLD static num joint_sigma(const joint *of, int i) { return num_root(joint_entry(of, i, i)); }

KQ_COLD static int is_swept(const joint *of, int i) { return i >= of->s->states && of->swept >> (i - of->s->states) & 1; }

/* Are the columns of the components that have not left up to `most` sigma_i sigma_j? */
KQ_COLD static int joint_is_within(const joint *of, num most)
{
    for (int j = of->s->states; j < of->width; j++) {
        for (int i = 0; i <= j && !is_swept(of, j); i++) {
            const num sigmas = joint_sigma(of, i) * joint_sigma(of, j);
            if (!is_swept(of, i) && !(num_magnitude(of->high[joint_index(of, i, j)]) <= most * sigmas)) return 0;
        }
    }
    return 1;
}

/* The component that keeps the largest share of its variance, more than `least`, or 0 */
KQ_COLD static int next_component(const joint *of, num least)
{
    int best = 0;
    for (int c = of->s->states; c < of->width; c++) {
        const num rest = of->high[joint_index(of, c, c)], variance = joint_entry(of, c, c);
        if (is_swept(of, c) || !(rest > least * variance)) continue;
        best = c;
        least = rest / variance;
    }
    return best;
}

/* Component c leaves: M_ij - M_ic M_jc / M_cc, M_ic / M_cc in its column. */
KQ_COLD static void sweep(joint *of, int c)
{
    const num_pair pivot = joint_get(of, joint_index(of, c, c));
    for (int i = 0; i < of->width; i++) {
        const int at = joint_index(of, i, c);
        if (i == c) continue;
        const num_pair gain = pair_over(joint_get(of, at), pivot);
        for (int j = i, k = joint_index(of, i, i); j < of->width; j++, k++) {
            if (j != c) joint_set(of, k, pair_less_product(joint_get(of, k), gain, joint_get(of, joint_index(of, j, c))));
        }
        joint_set(of, at, gain);
    }
    of->swept |= UINT32_C(1) << (c - of->s->states);
}

/* Every component leaves that can, of variances grown by `share`.  One whose noise is 0, or that of others, tells nothing:
   what is left of its column is rounding. */
KQ_COLD static kq_status joint_sweep(joint *of, num share)
{
    const num rounding = 2 * root_rounding(of->width), least = num_epsilon;
    of->swept = 0;
    for (int i = 0; i < of->width; i++) {
        for (int j = i; j < of->width; j++) {
            const num given = joint_entry(of, i, j);
            joint_set(of, joint_index(of, i, j), i == j ? pair_sum(given, share * given) : pair_of(given));
        }
    }
    if (!joint_is_within(of, 1 + rounding)) return KQ_ERR_NOT_SEMIDEFINITE;
    for (int c = next_component(of, least); c; c = next_component(of, least)) sweep(of, c);
    return joint_is_within(of, rounding) ? KQ_OK : KQ_ERR_NOT_SEMIDEFINITE;
}

/* What is left, rounded to the low plane: the covariance of the noise, then K */
KQ_COLD static void joint_round(const joint *of)
{
    const int n = of->s->states, m = of->s->components;
    num *rest = of->low, *K = rest + n * n;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) *rest++ = of->high[joint_index(of, i, j)];
        for (int c = 0; c < m; c++) *K++ = is_swept(of, n + c) ? of->high[joint_index(of, i, n + c)] : 0;
    }
}

/* The root in the high plane.  A row up to `rounding` of the sigma of w is 0. */
KQ_COLD static kq_status rest_root(const joint *of, num rounding)
{
    uint8_t row[KQ_SIZE_MAX];
    const int n = of->s->states;
    num *G = of->high;
    kq_status status = covariance_check(of->low, n);
    if (!status) status = root_by_rows(G, of->low, n, row);
    for (int i = 0; i < n && !status; i++) {
        const num most = rounding * joint_sigma(of, i);
        if (root_product(G, n, i, i) > most * most) continue;
        for (int k = i; k < n; k++) G[column(k) + i] = 0;
    }
    return status == KQ_ERR_NOT_FINITE ? KQ_ERR_RANGE : status;
}

/* Where the rounding of Q, S and R has left no covariance, the variances grow by a share that is rounding until it is
   one. */
KQ_COLD static kq_status joint_root(joint *of)
{
    const num rounding = root_rounding(of->width), first = rounding * rounding / 4, least = num_epsilon / 8;
    for (num share = 0;; share = share >= least ? 2 * share : share > 0 ? least : first) {
        kq_status status = joint_sweep(of, share);
        if (!status) {
            joint_round(of);
            status = rest_root(of, rounding);
        }
        if (status != KQ_ERR_NOT_SEMIDEFINITE || share > 2 * rounding) return status;
    }
}

/* out = A - K H */
KQ_COLD static void less_gain(num *out, const num *A, const num *K, const sensor *s)
{
    const int n = s->states, m = s->components;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            num rest = A[i * n + j];
            for (int c = 0; c < m; c++) rest -= K[i * m + c] * s->measurement[c * n + j];
            out[i * n + j] = rest;
        }
    }
}

KQ_COLD static kq_status correlated_check(const process *p, const num *A, const num *B, const num *Q,
                                          const sensor *s, const num *S)
{
    kq_status status = sensor_check(s);
    if (!status) status = process_check_given(p, A, B, s->components);
    if (status) return status;
    if (!Q || !S) return KQ_ERR_NULL;
    const int n = p->states, m = s->components;
    if (s->states != n) return KQ_ERR_MISMATCH;
    if (p->length < CORRELATED_LEN(n, p->controls - m, m)) return KQ_ERR_MEMORY;
    return all_finite(S, n * m) ? state_covariance_check(Q, n) : KQ_ERR_NOT_FINITE;
}

KQ_COLD kq_status T(kq_process_init_correlated)(process *p, const num *A, const num *B, const num *Q,
                                                const sensor *s, const num *S, uint32_t present)
{
    kq_status status = correlated_check(p, A, B, Q, s, S);
    if (status) return status;
    const int n = p->states, m = s->components, l = p->controls - m, width = n + m;
    num *own_A = p->memory + KQ_TRIANGLE(n), *own_B = own_A + n * n, *G = own_B + n * (l + m);
    joint of = {G, G + width * width, Q, S, s, present, 0, width};
    num *next_A = of.low; /* in the place of what is left of Q */
    const num *K = next_A + n * n;
    status = joint_root(&of);
    if (status) return status;
    less_gain(next_A, A, K, s);
    if (!all_finite(next_A, n * (n + m))) return KQ_ERR_RANGE;
    copy(p->memory, G, KQ_TRIANGLE(n));
    copy(own_A, next_A, n * n);
    for (int i = 0; i < n; i++) {
        num *control = own_B + i * (l + m);
        if (l) copy(control, B + i * l, l);
        copy(control + l, K + i * m, m);
    }
    process_set_model(p, own_A, own_B);
    return KQ_OK;
}

#endif
