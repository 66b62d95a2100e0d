/*
 * The steady state of a constant model in floating point:
 *     P = A (P - P H' (H P H' + R)^-1 H P) A' + Q
 *
 * Structured doubling (Chu, Fan, Lin and Wang, Int. J. Control 77, 2004) on roots: what 2^k steps
 * do to the state is a triple of a transition F, a covariance S S' and an information L L', from
 * F = A, S = G and L L' = H'R^-1 H.  Twice as many steps are
 *     X = L'S,    U U' = I + X'X,    V V' = I + X X'
 *     S <- tria [S, F S U^-T],    L <- tria [L, F'L V^-T],    F <- F (I + S S'L L')^-1 F
 * It leads to a gain that stabilises; what F's differences cost of its digits is won back by
 * Newton's method (Hewer, IEEE Trans. Automat. Contr. 16, 1971), the steps of which are sums of
 * squares:
 *     S S' = C S S' C' + A K R K'A' + G G',    C = A (I - K H)
 * by doubling once more, S <- tria [S, C S], C <- C C.
 */
#ifndef KQ_SRC_STEADY_RICCATI_FLOAT_H
#define KQ_SRC_STEADY_RICCATI_FLOAT_H

#include "lasting_float.h"

/* ------------------------------------------------------------------ doubling */

/* Twice as many steps, of the triple F, S and L */
static void twice_as_many(const steady_work *w, int n)
{
    num *F = w->F, *X = w->X, *Y = w->Y, *Z = w->Z, *U = w->root, *V = w->spare;
    multiply_transposed(X, w->L, w->S, n);
    root_of_one_and(V, X, w, n);
    transpose(X, n);
    root_of_one_and(U, X, w, n);
    multiply_transposed(Z, w->L, F, n);
    multiply(Y, X, Z, n, n, n);
    divide_columns(Y, U, n); /* U^-1 X'L'F */
    copy(X, w->S, n * n);
    divide_rows(X, U, n); /* S U^-T */
    multiply(Z, X, Y, n, n, n);
    for (int k = 0; k < n * n; k++) Z[k] = F[k] - Z[k];
    multiply(Y, F, Z, n, n, n); /* the next F */
    multiply(Z, F, X, n, n, n);
    add_root(w->S, Z, w->root, w, n);
    copy(X, w->L, n * n);
    divide_rows(X, V, n); /* L V^-T */
    multiply_transposed(Z, F, X, n);
    add_root(w->L, Z, w->spare, w, n);
    copy(F, Y, n * n);
}

static void row_sizes(num *size, const num *S, int n)
{
    for (int i = 0; i < n; i++) size[i] = largest(S + i * n, n);
}

/* Has the largest entry of a row grown by more than a rounding? */
static int has_grown(const num *size, const num *before, int n)
{
    for (int i = 0; i < n; i++) {
        if (size[i] > num_growth * before[i]) return 1;
    }
    return 0;
}

/*
 * From one step to as many as it takes: F goes to 0 if the filter forgets where it began.  What
 * keeps it: a covariance that grows without bound, where a state is not measured, or an
 * information that does, where it is not moved.
 */
static kq_status doubling(const process *p, const sensor *s, const steady_work *w)
{
    const int n = p->states;
    num size[KQ_SIZE_MAX], before[KQ_SIZE_MAX];
    copy(w->F, p->transition, n * n);
    process_noise(w->S, p);
    reach(w->S, w->F, w, n);
    information(w->L, s, w->S, w);
    process_noise(w->S, p);
    row_sizes(size, w->S, n);
    for (int k = 0; k < num_digits; k++) {
        copy(before, size, n);
        twice_as_many(w, n);
        row_sizes(size, w->S, n);
        if (!(largest(size, n) < num_huge)) return KQ_ERR_NOT_DETECTABLE;
        const num forgets = largest(w->F, n * n);
        if (forgets <= num_epsilon) return KQ_OK;
        if (!(forgets < num_huge) || !(largest(w->L, n * n) < num_huge)) break;
    }
    return has_grown(size, before, n) ? KQ_ERR_NOT_DETECTABLE : KQ_ERR_NOT_STABILISABLE;
}

/* ------------------------------------------------------------------ Newton's method */

/* B = A K with the noise of e: B <- B R^1/2, n x m */
static void gain_noise(num *B, const sensor *s, int n)
{
    const reading z = {s, s->noise, 0, UINT32_MAX};
    const int m = s->components;
    for (int i = 0; i < n; i++, B += m) {
        for (int j = 1; j < m && sensor_is_correlated(s); j++) {
            for (int c = 0; c < j; c++) B[j] -= B[c] * s->noise[column(j) + c];
        }
        for (int j = 0; j < m; j++) {
            const num r = scalar_noise(&z, j);
            B[j] = r > num_tiny ? B[j] * num_root(r) : 0;
        }
    }
}

/* The gain of a predicted root; f becomes the updated state. */
static void take_gain(filter *f, const sensor *s, const num *root, num *K)
{
    copy(filter_root(f), root, KQ_TRIANGLE(f->states));
    update_root_by(f, s, K);
}

/* F = A (I - K H), and the noise of a step with that gain to S */
static void close_loop(const process *p, const sensor *s, const steady_work *w)
{
    const int n = p->states, m = s->components;
    num *B = w->drive;
    multiply(B, p->transition, w->gain, n, n, m);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            num total = p->transition[i * n + j];
            for (int c = 0; c < m; c++) total -= B[i * m + c] * s->measurement[c * n + j];
            w->F[i * n + j] = total;
        }
    }
    gain_noise(B, s, n);
    process_noise(w->S, p);
    join(w->wide, w->S, B, n, m);
    root_of_factor(w->root, w->wide, n, n + m);
    expand(w->S, w->root, n);
}

/* Where the covariance with that gain goes to */
static kq_status settle_root(const steady_work *w, int n)
{
    for (int k = 0; k < num_digits; k++) {
        const num size = largest(w->F, n * n);
        if (size <= num_epsilon) return KQ_OK;
        if (!(size < num_huge)) break;
        multiply(w->Y, w->F, w->S, n, n, n);
        add_root(w->S, w->Y, w->root, w, n);
        multiply(w->Y, w->F, w->F, n, n, n);
        copy(w->F, w->Y, n * n);
    }
    return KQ_ERR_NO_CONVERGENCE;
}

/* How far apart two roots are, in units of their rows */
static num root_change(const num *a, const num *b, int n)
{
    num most = 0;
    for (int i = 0; i < n; i++) {
        num norm = 0, change = 0;
        for (int j = i; j < n; j++) {
            const num d = a[column(j) + i] - b[column(j) + i];
            norm += a[column(j) + i] * a[column(j) + i];
            change += d * d;
        }
        if (norm > 0 && change > most * most * norm) most = num_root(change / norm);
    }
    return most;
}

/* From the root of doubling to the root of the equation.  Each step squares what is wrong, down to what
   rounding makes of it: from there on it no longer falls. */
static kq_status refine(const process *p, const sensor *s, const steady_work *w, filter *f)
{
    const int n = p->states;
    num change = 1;
    for (int k = 0; k < num_refinements; k++) {
        const num before = change;
        copy(w->last, w->root, KQ_TRIANGLE(n));
        take_gain(f, s, w->root, w->gain);
        close_loop(p, s, w);
        const kq_status status = settle_root(w, n);
        if (status) return status;
        change = root_change(w->root, w->last, n);
        if (change <= (num)n * num_epsilon) return KQ_OK;
        if (change < num_unsettled && change >= num_half * before) return KQ_OK;
    }
    return KQ_ERR_NO_CONVERGENCE;
}

/* ------------------------------------------------------------------ what comes of it */

/* G = P A' (P-)^-1 = (S Theta11) S-^-1, by rows; a column of S- without a pivot is 0, and so is
   what it would be divided into. */
static void smoother_gain(num *G, const process *p, const filter *f, const num *predicted,
                          const steady_work *w)
{
    const int n = p->states;
    num *S = w->S, *X = w->X;
    expand(S, filter_root(f), n);
    multiply(w->Y, p->transition, S, n, n, n);
    expand(w->L, predicted, n);
    for (int j = 0; j < n; j++) { /* X = S-^-1 A S */
        for (int i = n - 1; i >= 0; i--) {
            num rest = w->Y[i * n + j];
            for (int k = i + 1; k < n; k++) rest -= w->L[i * n + k] * X[k * n + j];
            X[i * n + j] = w->L[i * n + i] > 0 ? rest / w->L[i * n + i] : 0;
        }
    }
    transpose(X, n);
    multiply(G, S, X, n, n, n); /* S Theta11 */
    for (int i = 0; i < n; i++, G += n) {
        for (int j = 0; j < n; j++) { /* G S- = S Theta11 */
            num rest = G[j];
            for (int k = 0; k < j; k++) rest -= G[k] * w->L[k * n + j];
            G[j] = w->L[j * n + j] > 0 ? rest / w->L[j * n + j] : 0;
        }
    }
}

static kq_status steady_solve_check(const process *p, const sensor *s, const num *memory,
                                    size_t length, const steady_solution *out)
{
    kq_status status = process_check(p);
    if (!status) status = sensor_check(s);
    if (status) return status;
    if (!memory || !out) return KQ_ERR_NULL;
    if (p->states != s->states) return KQ_ERR_MISMATCH;
    return length < (size_t)STEADY_SOLVE_LEN(p->states, s->components) ? KQ_ERR_MEMORY : KQ_OK;
}

kq_status T(kq_steady_solve)(const process *p, const sensor *s, num *memory, size_t length,
                             const steady_solution *out)
{
    filter f;
    kq_status status = steady_solve_check(p, s, memory, length, out);
    if (status) return status;
    const int n = p->states, m = s->components;
    const steady_work w = steady_work_at(memory, n, m);
    for (int k = 0; k < MEAN_PLANES * n; k++) w.state[k] = 0; /* an update that overflows looks at the mean */
    status = T(kq_filter_assign)(&f, n, w.state, (size_t)FILTER_LEN(n));
    if (!status) status = check_lasting(p, s, &w);
    if (!status) status = doubling(p, s, &w);
    if (!status) status = refine(p, s, &w, &f);
    if (status) return status;
    take_gain(&f, s, w.root, w.gain);
    if (out->predicted) root_square(out->predicted, w.root, n);
    if (out->filtered) root_square(out->filtered, filter_root(&f), n);
    if (out->gain) copy(out->gain, w.gain, n * m);
    if (out->smoother_gain) smoother_gain(out->smoother_gain, p, &f, w.root, &w);
    return KQ_OK;
}

#endif
