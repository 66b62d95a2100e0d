#include "continuous.h"

#include "dense.h"

/* All that a step is made of: terms of the series, power[k] and noise[k], then A, Q and S before each doubling */
typedef struct {
    int n, square, terms;
    double *power, *noise, *doubled, *spare;
} tape;

size_t kq_steps_work(int n, int terms, int64_t doublings)
{
    return (size_t)(n * n) * (size_t)(2 * (terms + 1) + 3 * (doublings + 1) + 7);
}

static tape tape_of(double *work, int n, int terms, int64_t doublings)
{
    tape made = {.n = n, .square = n * n, .power = work};
    made.noise = made.power + (terms + 1) * made.square;
    made.doubled = made.noise + (terms + 1) * made.square;
    made.spare = made.doubled + 3 * (doublings + 1) * made.square;
    return made;
}

static int is_clear(const double *a, int count)
{
    for (int i = 0; i < count; i++) {
        if (a[i] != 0) return 0;
    }
    return 1;
}

/* power[k] = F power[k - 1] h / k, noise[k] = (F noise[k - 1] + its transpose) h / (k + 1), and their sums */
static void series(tape *p, int terms, const double *F, const double *Qc, double h)
{
    const int n = p->n, square = p->square;
    double *A = p->doubled, *Q = A + square, *S = Q + square, *x = p->spare;
    clear(p->power, square);
    for (int i = 0; i < n; i++) p->power[i * n + i] = 1;
    for (int i = 0; i < square; i++) p->noise[i] = Qc[i] * h;
    copied(A, p->power, square);
    copied(Q, p->noise, square);
    for (int i = 0; i < square; i++) S[i] = p->power[i] * h;
    for (p->terms = 0; p->terms < terms; p->terms++) {
        const int k = p->terms + 1;
        double *power = p->power + k * square, *noise = p->noise + k * square;
        product(x, F, power - square, n, n, n);
        for (int i = 0; i < square; i++) power[i] = x[i] * (h / k);
        product(x, F, noise - square, n, n, n);
        for (int i = 0; i < square; i++) noise[i] = (x[i] + x[i % n * n + i / n]) * (h / (k + 1));
        if (is_clear(power, square) && is_clear(noise, square)) break;
        add(A, 1, power, square);
        add(Q, 1, noise, square);
        add(S, h / (k + 1), power, square);
    }
}

/* From A, Q and S to those of twice the step, which follow them */
static void twice(const tape *p, double *A)
{
    const int n = p->n, square = p->square;
    const double *Q = A + square, *S = Q + square;
    double *next = A + 3 * square, *x = p->spare;
    product(next, A, A, n, n, n);
    product(x, A, Q, n, n, n);
    copied(next + square, Q, square);
    add_by_transposed(next + square, x, A, n, n, n);
    copied(next + 2 * square, S, square);
    add_product(next + 2 * square, A, S, n, n, n);
}

static void step(tape *p, int terms, const double *F, const double *Qc, double h, int64_t doublings)
{
    series(p, terms, F, Qc, h);
    for (int64_t k = 0; k < doublings; k++) twice(p, p->doubled + 3 * k * p->square);
}

void kq_steps(size_t count, int n, int terms, const double *F, const double *Qc, const double *h, const int64_t *doublings,
              double *A, double *Q, double *S, double *work)
{
    const size_t square = (size_t)(n * n);
    for (size_t k = 0; k < count; k++) {
        tape p = tape_of(work, n, terms, doublings[k]);
        step(&p, terms, F, Qc, h[k], doublings[k]);
        const double *last = p.doubled + 3 * (size_t)doublings[k] * square;
        copied(A + k * square, last, (int)square);
        copied(Q + k * square, last + square, (int)square);
        copied(S + k * square, last + 2 * square, (int)square);
        symmetrise(Q + k * square, n);
    }
}

/* by: slopes to A, Q and S of twice the step, which become those to A, Q and S */
static void twice_back(const tape *p, const double *A, double *by)
{
    const int n = p->n, square = p->square;
    const double *Q = A + square, *S = Q + square;
    double *by_A = by, *by_Q = by + square, *by_S = by_Q + square, *made = by_S + square, *x = p->spare;
    by_transposed(made, by_A, A, n, n, n);
    add_of_transposed(made, A, by_A, n, n, n);
    product(x, by_Q, A, n, n, n); /* 2 by_Q A Q: Q and by_Q are symmetric */
    add_product(made, x, Q, n, n, n);
    add_product(made, x, Q, n, n, n);
    add_by_transposed(made, by_S, S, n, n, n);
    copied(by_A, made, square);
    add_of_transposed(by_Q, A, x, n, n, n);
    of_transposed(made, A, by_S, n, n, n);
    add(by_S, 1, made, square);
}

/* From slopes to the sums of the series to those to F and Qc */
static void series_back(const tape *p, const double *F, double h, const double *by, double *by_F, double *by_Qc)
{
    const int n = p->n, square = p->square;
    const double *by_A = by, *by_Q = by + square, *by_S = by_Q + square;
    double *power = (double *)by_S + square, *noise = power + square, *x = p->spare;
    clear(power, 2 * square);
    for (int k = p->terms; k > 0; k--) {
        add(power, 1, by_A, square);
        add(power, h / (k + 1), by_S, square);
        add(noise, 1, by_Q, square);
        for (int i = 0; i < square; i++) power[i] *= h / k;
        for (int i = 0; i < square; i++) noise[i] *= h / (k + 1);
        add_by_transposed(by_F, power, p->power + (k - 1) * square, n, n, n);
        add_by_transposed(by_F, noise, p->noise + (k - 1) * square, n, n, n);
        add_by_transposed(by_F, noise, p->noise + (k - 1) * square, n, n, n);
        of_transposed(x, F, power, n, n, n);
        copied(power, x, square);
        of_transposed(x, F, noise, n, n, n);
        for (int i = 0; i < square; i++) noise[i] = x[i] + x[i % n * n + i / n];
    }
    add(noise, 1, by_Q, square);
    add(by_Qc, h, noise, square);
}

void kq_steps_back(size_t count, int n, int terms, const double *F, const double *Qc, const double *h, const int64_t *doublings,
                   const double *by_A, const double *by_Q, const double *by_S, double *by_F, double *by_Qc, double *work)
{
    const size_t square = (size_t)(n * n);
    for (size_t k = 0; k < count; k++) {
        tape p = tape_of(work, n, terms, doublings[k]);
        double *by = p.spare + square;
        step(&p, terms, F, Qc, h[k], doublings[k]);
        copied(by, by_A + k * square, (int)square);
        copied(by + square, by_Q + k * square, (int)square);
        copied(by + 2 * square, by_S + k * square, (int)square);
        for (int64_t d = doublings[k] - 1; d >= 0; d--) twice_back(&p, p.doubled + 3 * (size_t)d * square, by);
        series_back(&p, F, h[k], by, by_F, by_Qc);
    }
}
