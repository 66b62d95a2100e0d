/*
 * A process of a model in continuous time, x' = F x + B u + w, over a step dt: with X = F h, h = dt 2^-s,
 *     A = exp X = I + X a_0,    B dt a_0 (u stays as it is),    Q = sum over i of C_i C_i'
 *     a_i = sum over k >= i of k! / ((k - i)! (k + i + 1)!) X^k,    C_i = sqrt((2i + 1) h) a_i L,    L L' = Qc
 * The columns of C_i are the Legendre coefficients of exp(F t) L over the step, so that Q is never formed and no
 * row of its root is rounded by more than its own length: h^3/3 beside h, or h^9/9.  Where F is nilpotent the sums end.
 * Then s times from h to 2h:
 *     S <- tria [S + E S, S],    B <- 2 B + E B,    E <- 2 E + E E,    E = A - I
 * With A in the place of E what is slow would lose its bits beside 1, and each doubling would double that.
 */
#ifndef KQ_SRC_MODEL_CONTINUOUS_FLOAT_H
#define KQ_SRC_MODEL_CONTINUOUS_FLOAT_H

#include "matrices_float.h"

enum { FLOW_HALVINGS = 64 };

/* The parts of the memory: what the process refers to, what these are to become, and scratch */
typedef struct {
    num *A, *B;
    num *next_A, *next_B, *S; /* next_A without its ones, until the end */
    num *lead, *power; /* X^i L sqrt(h), and what a sum multiplies: n x n */
    num *wide;  /* n x 2n */
} continuous_work;

KQ_COLD static continuous_work continuous_work_at(num *memory, int n, int l)
{
    continuous_work w;
    w.A = memory;
    w.B = w.A + n * n;
    w.next_A = w.B + n * l;
    w.next_B = w.next_A + n * n;
    w.S = w.next_B + n * l;
    w.lead = w.S + KQ_TRIANGLE(n);
    w.power = w.lead + n * n;
    w.wide = w.power + n * n;
    return w;
}

/* M <- h F M, M being n x c.  Rates are mostly 0. */
KQ_COLD static void flow_once(num *M, const num *F, num h, int n, int c)
{
    num old[KQ_SIZE_MAX];
    for (int j = 0; j < c; j++) {
        const num *rate = F;
        for (int k = 0; k < n; k++) old[k] = M[k * c + j];
        for (int i = 0; i < n; i++) {
            num total = 0;
            for (int k = 0; k < n; k++, rate++) {
                if (*rate != 0) total += *rate * old[k];
            }
            M[i * c + j] = h * total;
        }
    }
}

/* out += a M.  Does it still count? */
KQ_COLD static int flow_add(num *out, const num *M, num a, int count)
{
    int counts = 0;
    for (int k = 0; k < count; k++) {
        const num term = a * M[k];
        out[k] += term;
        if (num_magnitude(term) > num_epsilon / 16 * num_magnitude(out[k])) counts = 1;
    }
    return counts;
}

/* out = a_i times what M was that is X^i of now, n x c.  M is used up.  A chain of n states is n terms long before
   rounding ends the sum. */
KQ_COLD static void flow_sum(num *out, num *M, const num *F, num h, int i, int n, int c)
{
    num a = 1;
    for (int k = i + 1; k <= 2 * i + 1; k++) a /= (num)k;
    for (int k = 0; k < n * c; k++) out[k] = 0;
    for (int k = i; k < n + FLOW_TERMS; k++) {
        if (!flow_add(out, M, a, n * c) && k >= n) return;
        a *= (num)(k + 1) / (num)((k + 1 - i) * (k + i + 2));
        flow_once(M, F, h, n, c);
    }
}

/*
 * s, so that the growth of |F| h, which no choice of units changes, is 1/2 at most: that of n times |F|, n times over.
 * 0 where |F|^n is 0.  Only exponents are looked at.
 */
KQ_COLD static int flow_halvings(const num *F, num dt, int n)
{
    num v[KQ_SIZE_MAX], next[KQ_SIZE_MAX], product = 1;
    int32_t exponent = 0, before = 0, step = 0;
    for (int i = 0; i < n; i++) v[i] = 1;
    for (int k = 0; k < 2 * n; k++) {
        num most = 0;
        if (k == n) before = exponent;
        for (int i = 0; i < n; i++) {
            next[i] = 0;
            for (int j = 0; j < n; j++) next[i] += num_magnitude(F[i * n + j]) * v[j];
            if (next[i] > most) most = next[i];
        }
        if (most <= num_tiny) return 0;
        if (!num_is_finite(most)) return FLOW_HALVINGS + 1;
        product = num_split(product * most, &exponent);
        for (int i = 0; i < n; i++) v[i] = next[i] / most;
    }
    (void)num_split(dt, &step);
    int halvings = 0;
    for (int32_t growth = exponent - before + n * (step + 1); growth > 0; growth -= n) halvings++;
    return halvings;
}

/* S <- tria [S, C], C being the last c columns of wide; does C count in S S'?  What is left of a state, given those
   behind it, may be far less than its sigma, down to what rounds that. */
KQ_COLD static int flow_join(num *S, num *wide, int n, int c)
{
    int counts = 0;
    const int width = n + c;
    const num least = num_epsilon / 64;
    for (int i = 0; i < n; i++) {
        num *row = wide + i * width;
        for (int j = 0; j < n; j++) row[j] = j < i ? 0 : S[column(j) + i];
        const num added = dot(0, row + n, row + n, c) / least;
        if (added > row[i] * row[i] && added > least * dot(0, row, row, n)) counts = 1;
    }
    if (counts) root_of_factor(S, wide, n, width);
    return counts;
}

/* The columns of L that are not 0, times a, as n rows; L: upper triangular, by columns.  Answers how many. */
KQ_COLD static int flow_columns(num *M, const num *L, num a, int n)
{
    int count = 0, c = 0;
    for (int j = 0; j < n; j++) count += L[column(j) + j] != 0;
    for (int j = 0; j < n; j++) {
        const num *l = L + column(j);
        if (l[j] == 0) continue;
        for (int i = 0; i < n; i++) M[i * count + c] = i > j ? 0 : a * l[i];
        c++;
    }
    return count;
}

/* S of Q over h */
KQ_COLD static void flow_noise(const continuous_work *w, const num *F, const num *L, num h, int n)
{
    num *C = w->next_A; /* not needed before */
    const int c = flow_columns(w->lead, L, num_root(h), n), width = n + c;
    for (int k = 0; k < KQ_TRIANGLE(n); k++) w->S[k] = 0;
    for (int i = 0; i < n + FLOW_TERMS; i++) {
        const num root = num_root((num)(2 * i + 1));
        copy(w->power, w->lead, n * c);
        flow_sum(C, w->power, F, h, i, n, c);
        for (int r = 0; r < n; r++) {
            for (int j = 0; j < c; j++) w->wide[r * width + n + j] = root * C[r * c + j];
        }
        if (!flow_join(w->S, w->wide, n, c)) return;
        flow_once(w->lead, F, h, n, c);
    }
}

/* next_A and next_B over h */
KQ_COLD static void flow_step(const continuous_work *w, const num *F, const num *B, num h, int n, int l)
{
    num *average = w->wide;
    for (int k = 0; k < n * n; k++) w->power[k] = 0;
    for (int k = 0; k < n; k++) w->power[k * (n + 1)] = 1;
    flow_sum(average, w->power, F, h, 0, n, n);
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < l; c++) {
            num drive = 0;
            for (int k = 0; k < n; k++) drive += average[i * n + k] * B[k * l + c];
            w->next_B[i * l + c] = h * drive;
        }
    }
    flow_once(average, F, h, n, n);
    copy(w->next_A, average, n * n);
}

/* M <- 2 M + E M, n x c */
KQ_COLD static void flow_product(num *M, const num *E, int n, int c)
{
    num old[KQ_SIZE_MAX];
    for (int j = 0; j < c; j++) {
        for (int k = 0; k < n; k++) old[k] = M[k * c + j];
        for (int i = 0; i < n; i++) M[i * c + j] = dot(2 * old[i], E + i * n, old, n);
    }
}

/* From h to 2 h */
KQ_COLD static void flow_double(const continuous_work *w, int n, int l)
{
    for (int i = 0; i < n; i++) {
        num *row = w->wide + i * 2 * n;
        for (int j = 0; j < n; j++) {
            row[n + j] = dot(i > j ? 0 : w->S[column(j) + i], w->next_A + i * n, w->S + column(j), j + 1);
        }
    }
    flow_join(w->S, w->wide, n, n);
    flow_product(w->next_B, w->next_A, n, l);
    copy(w->wide, w->next_A, n * n);
    flow_product(w->next_A, w->wide, n, n);
}

KQ_COLD static kq_status continuous_check(const process *p, const num *F, const num *B, const num *Qc, num dt,
                                          const num *memory, size_t length)
{
    const kq_status status = process_check_model(p, F, B);
    if (status) return status;
    if (!Qc || !memory) return KQ_ERR_NULL;
    if (length < CONTINUOUS_LEN(p->states, p->controls)) return KQ_ERR_MEMORY;
    if (!num_is_finite(dt)) return KQ_ERR_NOT_FINITE;
    return dt > num_tiny ? state_covariance_check(Qc, p->states) : KQ_ERR_RANGE;
}

KQ_COLD kq_status T(kq_process_init_continuous)(process *p, const num *F, const num *B, const num *Qc, num dt,
                                                num *memory, size_t length)
{
    num L[KQ_TRIANGLE(KQ_SIZE_MAX)];
    kq_status status = continuous_check(p, F, B, Qc, dt, memory, length);
    if (status) return status;
    const int n = p->states, l = p->controls, halvings = flow_halvings(F, dt, n);
    const continuous_work w = continuous_work_at(memory, n, l);
    if (halvings > FLOW_HALVINGS) return KQ_ERR_RANGE;
    status = root_or_refuse(L, Qc, n);
    if (status) return status;
    num h = dt;
    for (int k = 0; k < halvings; k++) h *= num_half;
    flow_noise(&w, F, L, h, n);
    flow_step(&w, F, B, h, n, l);
    for (int k = 0; k < halvings; k++) flow_double(&w, n, l);
    for (int i = 0; i < n; i++) w.next_A[i * (n + 1)] += 1;
    if (!all_finite(w.next_A, n * n) || !all_finite(w.next_B, n * l)) return KQ_ERR_RANGE;
    status = root_check(w.S, n);
    if (status) return status == KQ_ERR_NOT_FINITE ? KQ_ERR_RANGE : status;
    copy(w.A, w.next_A, n * (n + l));
    copy(p->memory, w.S, KQ_TRIANGLE(n));
    process_set_model(p, w.A, w.B);
    return KQ_OK;
}

#endif
