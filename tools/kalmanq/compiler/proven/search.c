/*
 * Runs a compiled filter beside an exact one on the host.
 *
 *     search LIMIT               every covariance that the filter can come to, whatever samples are missing
 *     run ROWS LONGEST PRINTS ENDS WANDERS    one record with gaps, of what is drawn and damped, or, from a seed that is
 *         not 0, of measurements and controls at the ENDS of their ranges, or not damped: errors of means; the words that
 *         come of it
 *
 * subject.h has the filter, its model and the type exact (search.py writes it).  The exact filter has numbers of two
 * doubles, 106 bits; compiled without contraction it is the same on every host.
 */
#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "subject.h"

enum { ENTRIES = N * (N + 1) / 2 };

/* ------------------------------------------------------------------ numbers of two doubles */

static exact sum_of(double a, double b)
{
    const double s = a + b, t = s - a;
    return (exact){s, (a - (s - t)) + (b - t)};
}

static exact product_of(double a, double b)
{
    const double p = a * b, c = 134217729.0 * a, d = 134217729.0 * b;
    const double ah = c - (c - a), al = a - ah, bh = d - (d - b), bl = b - bh;
    return (exact){p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}

static exact add(exact a, exact b)
{
    exact s = sum_of(a.high, b.high);
    const exact t = sum_of(a.low, b.low);
    s = sum_of(s.high, s.low + t.high);
    return sum_of(s.high, s.low + t.low);
}

static exact negative(exact a)
{
    return (exact){-a.high, -a.low};
}

static exact subtract(exact a, exact b)
{
    return add(a, negative(b));
}

static exact multiply(exact a, exact b)
{
    const exact p = product_of(a.high, b.high);
    return sum_of(p.high, p.low + (a.high * b.low + a.low * b.high));
}

static exact divide(exact a, exact b)
{
    const double q = a.high / b.high;
    const exact rest = subtract(a, multiply(b, (exact){q, 0}));
    const double r = rest.high / b.high;
    return add((exact){q, 0}, (exact){r, (rest.high - r * b.high + rest.low) / b.high});
}

static bool is_zero(exact a)
{
    return a.high == 0;
}

/* ------------------------------------------------------------------ the exact filter */

typedef struct {
    exact x[N], P[ENTRIES];
} reference;

static int at(int i, int j)
{
    return i <= j ? i * N - i * (i - 1) / 2 + j - i : at(j, i);
}

static void reference_start(reference *f)
{
    for (int i = 0; i < N; i++) f->x[i] = model_x0[i];
    for (int i = 0; i < N; i++) {
        for (int j = i; j < N; j++) f->P[at(i, j)] = (IS_GAIN ? model_settled : model_P0)[i * N + j];
    }
}

static void predict_mean(reference *f, const exact *u)
{
    exact x[N];
    for (int i = 0; i < N; i++) {
        x[i] = (exact){0, 0};
        for (int k = 0; k < N; k++) x[i] = add(x[i], multiply(model_A[i * N + k], f->x[k]));
        for (int k = 0; k < L; k++) x[i] = add(x[i], multiply(model_B[i * L + k], u[k]));
    }
    memcpy(f->x, x, sizeof x);
}

static void predict_covariance(reference *f)
{
    exact T[N * N], P[ENTRIES];
    if (IS_GAIN) return;
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            exact s = {0, 0};
            for (int k = 0; k < N; k++) {
                if (!is_zero(model_A[i * N + k])) s = add(s, multiply(model_A[i * N + k], f->P[at(k, j)]));
            }
            T[i * N + j] = s;
        }
    }
    for (int i = 0; i < N; i++) {
        for (int j = i; j < N; j++) {
            exact s = model_Q[i * N + j];
            for (int k = 0; k < N; k++) {
                if (!is_zero(model_A[j * N + k])) s = add(s, multiply(T[i * N + k], model_A[j * N + k]));
            }
            P[at(i, j)] = s;
        }
    }
    memcpy(f->P, P, sizeof P);
}

/* What the longest declared gap leaves of the start */
static void cap_covariance(reference *f)
{
    for (int i = 0; i < N; i++) {
        for (int j = i; j < N; j++) f->P[at(i, j)] = model_cap[i * N + j];
    }
}

static void take(reference *f, int j, exact z)
{
    exact row[N], s = model_R[j], y = z;
    for (int i = 0; i < N; i++) {
        row[i] = (exact){0, 0};
        for (int k = 0; k < N; k++) {
            if (!is_zero(model_H[j * N + k])) row[i] = add(row[i], multiply(f->P[at(i, k)], model_H[j * N + k]));
        }
    }
    for (int i = 0; i < N; i++) {
        s = add(s, multiply(model_H[j * N + i], row[i]));
        y = subtract(y, multiply(model_H[j * N + i], f->x[i]));
    }
    for (int i = 0; i < N; i++) {
        const exact k = divide(row[i], s);
        f->x[i] = add(f->x[i], multiply(k, y));
        for (int l = i; l < N; l++) f->P[at(i, l)] = subtract(f->P[at(i, l)], multiply(k, row[l]));
    }
}

/* All at once, by the constant gain */
static void take_by_gain(reference *f, const exact *z)
{
    exact y[M];
    for (int j = 0; j < M; j++) {
        y[j] = z[j];
        for (int i = 0; i < N; i++) y[j] = subtract(y[j], multiply(model_H[j * N + i], f->x[i]));
    }
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < M; j++) f->x[i] = add(f->x[i], multiply(model_gain[i * M + j], y[j]));
    }
}

static void take_all(reference *f, const exact *z)
{
    if (IS_GAIN) {
        take_by_gain(f, z);
        return;
    }
    for (int j = 0; j < M; j++) take(f, j, z[j]);
}

/* ------------------------------------------------------------------ judging */

typedef struct {
    double error, merged, pivot;
    long bad; /* not positive definite, or other words in two calls than in one */
} verdict;

static double sigma(const reference *f, int i)
{
    return f->P[at(i, i)].high > 0 ? sqrt(f->P[at(i, i)].high) : 0;
}

static double error_of(const double *P, const reference *f)
{
    double worst = 0;
    for (int i = 0; i < N; i++) {
        for (int j = i; j < N; j++) {
            const double scale = sigma(f, i) * sigma(f, j);
            const double e = fabs(subtract((exact){P[at(i, j)], 0}, f->P[at(i, j)]).high);
            const double error = scale > 0 ? e / scale : e > 0;
            if (!(error <= worst)) worst = error;
        }
    }
    return worst;
}

/* The least pivot of P in units of the reference's sigmas; a state known for ever has none. */
static double pivot_of(const double *P, const reference *f)
{
    double C[N * N], least = 1;
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            const double scale = sigma(f, i) * sigma(f, j);
            C[i * N + j] = scale > 0 ? P[at(i, j)] / scale : i == j;
        }
    }
    for (int k = 0; k < N; k++) {
        const double pivot = C[k * N + k];
        if (!(pivot >= least)) least = pivot;
        if (!(pivot > 0)) return least;
        for (int i = k + 1; i < N; i++) {
            for (int j = k + 1; j < N; j++) C[i * N + j] -= C[i * N + k] * C[k * N + j] / pivot;
        }
    }
    return least;
}

static void judge(verdict *v, const subject *f, const reference *exactly)
{
    double P[ENTRIES];
    subject_covariance(f, P);
    const double error = error_of(P, exactly), pivot = pivot_of(P, exactly);
    if (!(error <= v->error)) v->error = error;
    if (!(pivot >= v->pivot)) v->pivot = pivot;
    v->bad += !(pivot > 0);
}

/* ------------------------------------------------------------------ the lines' values */

static long long least[PROBES + 1], greatest[PROBES + 1];

void probe(int line, long long value)
{
    if (value < least[line]) least[line] = value;
    if (value > greatest[line]) greatest[line] = value;
}

static void forget_values(void)
{
    for (int line = 0; line < PROBES; line++) least[line] = LLONG_MAX, greatest[line] = LLONG_MIN;
}

/* ------------------------------------------------------------------ the search */

typedef struct {
    subject f;
    reference exactly;
} node;

static node *nodes;
static long *table, count, limit, slots;

static size_t place(const subject *f)
{
    const unsigned char *bytes = (const unsigned char *)f;
    unsigned long long hash = 1469598103934665603ull;
    for (size_t i = 0; i < sizeof *f; i++) hash = (hash ^ bytes[i]) * 1099511628211ull;
    return (size_t)((hash ^ hash >> 32) % (unsigned long long)slots);
}

/* What was met before is not followed again; its error is that of the way that has led there now, too. */
static void meet(verdict *v, const subject *f, const reference *exactly)
{
    judge(v, f, exactly);
    size_t k = place(f);
    for (; table[k] >= 0; k = (k + 1) % (size_t)slots) {
        if (!memcmp(&nodes[table[k]].f, f, sizeof *f)) {
            double P[ENTRIES];
            for (int e = 0; e < ENTRIES; e++) P[e] = nodes[table[k]].exactly.P[e].high;
            const double apart = error_of(P, exactly);
            if (!(apart <= v->merged)) v->merged = apart;
            return;
        }
    }
    if (count == limit) return;
    nodes[count].f = *f;
    nodes[count].exactly = *exactly;
    table[k] = count++;
}

/* A row of which this is present */
static void follow(verdict *v, const node *from, unsigned present)
{
    static const exact nothing[N + M + L];
    node to = *from;
    if (present == 0) subject_predict(&to.f);
    else subject_take(&to.f, present);
    if (!subject_is_beyond(&to.f)) predict_covariance(&to.exactly);
    else if (subject_is_too_soon(&from->f)) cap_covariance(&to.exactly);
    for (int j = 0; j < M; j++) {
        if (present >> j & 1 && !subject_refused(&to.f)) take(&to.exactly, j, nothing[0]);
    }
    subject_forget(&to.f);
    meet(v, &to.f, &to.exactly);
}

/* A row in two calls comes to the same words as a step. */
static bool is_one(const subject *f)
{
    subject once = *f, twice = *f;
    subject_take(&once, FULL);
    subject_predict(&twice);
    subject_update(&twice);
    return subject_refused(&once) || subject_refused(&twice) || !memcmp(&once, &twice, sizeof once);
}

static int search(long most)
{
    verdict v = {0, 0, 1, 0};
    node first;
    memset(&first, 0, sizeof first);
    limit = most, slots = 2 * most + 7;
    nodes = malloc(sizeof *nodes * (size_t)limit);
    table = malloc(sizeof *table * (size_t)slots);
    if (!nodes || !table) return 1;
    for (long i = 0; i < slots; i++) table[i] = -1;
    forget_values();
    subject_start(&first.f);
    reference_start(&first.exactly);
    meet(&v, &first.f, &first.exactly);
    static const exact nothing[M];
    node begun = first;
    subject_update(&begun.f);
    take_all(&begun.exactly, nothing);
    meet(&v, &begun.f, &begun.exactly);
    long next = 0;
    for (; next < count && count < limit; next++) {
        const node from = nodes[next];
        v.bad += !is_one(&from.f);
        for (unsigned present = 0; present < FULL; present += HAS_SUBSETS ? 1 : FULL) follow(&v, &from, present);
        follow(&v, &from, FULL);
    }
    printf("{\"closed\": %s, \"count\": %ld, ", next == count ? "true" : "false", count);
    printf("\"error\": %.3e, \"merged\": %.3e, ", v.error, v.merged);
    printf("\"pivot\": %.3e, \"bad\": %ld, \"ranges\": [", v.pivot, v.bad);
    for (int line = 0; line < PROBES; line++) {
        printf("%s[%lld, %lld]", line ? ", " : "", (long long)least[line], (long long)greatest[line]);
    }
    printf("]}\n");
    return 0;
}

/* ------------------------------------------------------------------ a record */

static unsigned long long state = 1;

/* -1 to 1 (Knuth's multiplier) */
static double uniform(void)
{
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(long long)(state >> 11) / 4503599627370496.0 - 1;
}

/* Near normal, of variance 1: the sum of 12 uniform numbers */
static double normal(void)
{
    double s = 0;
    for (int i = 0; i < 12; i++) s += uniform();
    return s / 2;
}

typedef struct {
    double worst, last, covariance;
} track;

static void compare(track *t, const subject *f, const reference *exactly, bool is_late)
{
    for (int i = 0; i < N; i++) {
        exact x;
        subject_mean(f, i, &x.high, &x.low);
        const double e = fabs(subtract(x, exactly->x[i]).high);
        const double error = sigma(exactly, i) > 0 ? e / sigma(exactly, i) : 0;
        if (!(error <= t->worst)) t->worst = error;
        if (is_late && !(error <= t->last)) t->last = error;
    }
    double P[ENTRIES];
    subject_covariance(f, P);
    const double error = IS_GAIN ? 0 : error_of(P, exactly);
    if (!(error <= t->covariance)) t->covariance = error;
}

static double within(double value, double most)
{
    return value > most ? most : value < -most ? -most : value;
}

static int wanders;       /* a seed: no damping */
static double largest[M]; /* |measurement| without noise, of a record that is not made smaller */

/* What is measured moves as the model does, but damped, so that it stays in reach. */
static void move(double *truth, const exact *u)
{
    double x[N], w[N];
    for (int i = 0; i < N; i++) w[i] = normal();
    for (int i = 0; i < N; i++) {
        x[i] = 0;
        for (int k = 0; k < N; k++) {
            x[i] += damped[wanders > 0] * model_A[i * N + k].high * truth[k] + root_of_Q[i * N + k] * w[k];
        }
        for (int k = 0; k < L; k++) x[i] += model_B[i * L + k].high * u[k].high;
    }
    memcpy(truth, x, sizeof x);
}

static void begin(double *truth)
{
    for (int i = 0; i < N; i++) truth[i] = model_x0[i].high + sqrt(model_P0[i * N + i].high) * normal();
}

static double seen(const double *truth, int j)
{
    double value = 0;
    for (int i = 0; i < N; i++) value += model_H[j * N + i].high * truth[i];
    return value;
}

/* An end of a range, the same one for some rows */
static double end_of(double most, double *side)
{
    if (uniform() > 0.5) *side = -*side;
    return *side * most;
}

/* By what a record is made smaller to be within the ranges */
static double shrinking(long rows)
{
    static const exact nothing[L + 1];
    double truth[N], share = 1;
    begin(truth);
    for (long row = 0; row < rows; row++) {
        move(truth, nothing);
        for (int j = 0; j < M; j++) {
            const double value = fabs(seen(truth, j));
            if (value * share > 0.8 * most_of[j]) share = 0.8 * most_of[j] / value;
        }
    }
    return share;
}

static void measure(reference *f, const double *truth, double share, double *sides, unsigned present, subject_word *z)
{
    exact values[M];
    for (int j = 0; j < M; j++) {
        const double free = seen(truth, j);
        const double value = sides ? end_of(most_of[j], &sides[j]) : share * free + sqrt(model_R[j].high) * normal();
        if (fabs(free) > largest[j]) largest[j] = fabs(free);
        z[j] = subject_measured(j, within(value, most_of[j]));
        values[j] = (exact){subject_value(j, z[j]), 0};
    }
    if (present == FULL) {
        take_all(f, values);
        return;
    }
    for (int j = 0; j < M; j++) {
        if (present >> j & 1) take(f, j, values[j]);
    }
}

/* Gaps are of 1 to LONGEST rows; none at the end. */
static bool begins_gap(long row, long rows, int longest, int measured)
{
    return longest && measured >= LEAST_RUN && row + longest + (rows < 800 ? rows / 4 : 200) < rows && uniform() > 0.6;
}

/* Of a row of a gap */
static unsigned some(void)
{
    return HAS_SUBSETS ? (unsigned)((uniform() + 1) / 2 * FULL) % FULL : 0;
}

static void print_row(unsigned present, const subject_word *u, const subject_word *z, const subject *f)
{
    printf("%u |", present);
    for (int k = 0; k < L; k++) subject_print_word(u[k]);
    printf(" |");
    for (int j = 0; j < M; j++) subject_print_word(z[j]);
    printf(" |");
    subject_print(f);
    printf("\n");
}

/* Of a record that wanders: by what its own numbers are made smaller */
static double shrunk(void)
{
    double share = 1;
    for (int j = 0; j < M; j++) {
        if (share * largest[j] > 0.8 * most_of[j]) share = 0.8 * most_of[j] / largest[j];
    }
    return share;
}

static int run(long rows, int longest, bool prints, int ends, double share)
{
    subject f;
    reference exactly;
    track t = {0, 0, 0};
    int missing = 0, measured = 0;
    double truth[N], sides[M + L];
    for (int k = 0; k < M + L; k++) sides[k] = 1;
    state = ends ? (unsigned)ends : wanders ? (unsigned)wanders : 1; /* the same numbers once more */
    begin(truth);
    memset(&f, 0, sizeof f);
    subject_begin(&f);
    reference_start(&exactly);
    for (long row = 0; row < rows; row++) {
        subject_word z[M + 1] = {0}, u[L + 1] = {0};
        exact u_of[L + 1], push[L + 1];
        for (int k = 0; k < L; k++) {
            const double given = ends ? end_of(control_of[k], &sides[M + k]) : control_of[k] * uniform();
            u[k] = subject_control(k, wanders ? share * given : given);
            u_of[k] = (exact){subject_control_value(k, u[k]), 0};
            push[k] = wanders ? (exact){given, 0} : u_of[k];
        }
        if (row > 0) move(truth, push);
        if (!missing && row > 0 && begins_gap(row, rows, longest, row > 30 ? measured : LEAST_RUN - 1)) {
            missing = 1 + (int)((uniform() + 1) / 2 * longest) % longest;
        }
        const unsigned present = missing > 0 ? some() : FULL;
        missing -= missing > 0;
        measured = present == FULL ? measured + 1 : 0;
        if (row > 0) {
            predict_mean(&exactly, u_of);
            predict_covariance(&exactly);
        }
        if (present) measure(&exactly, truth, share, ends ? sides : NULL, present, z);
        if (row == 0) subject_update_by(&f, z);
        else if (present == 0) subject_predict_by(&f, u);
        else subject_step_by(&f, u, z, present);
        compare(&t, &f, &exactly, row >= rows - 100);
        if (prints) print_row(present, u, z, &f);
    }
    if (wanders && share == 1 && shrunk() < 1) return run(rows, longest, prints, ends, shrunk());
    printf("{\"worst\": %.3e, \"last\": %.3e, \"covariance\": %.3e, \"refused\": %d}\n", t.worst, t.last, t.covariance,
           subject_refused(&f) || subject_is_beyond(&f));
    return 0;
}

int main(int count_of_words, char **words)
{
    if (count_of_words == 3 && !strcmp(words[1], "search")) return search(atol(words[2]));
    if (count_of_words == 7 && !strcmp(words[1], "run")) {
        const int ends = atoi(words[5]);
        wanders = atoi(words[6]);
        return run(atol(words[2]), atoi(words[3]), atoi(words[4]), ends, ends || wanders ? 1 : shrinking(atol(words[2])));
    }
    return 2;
}
