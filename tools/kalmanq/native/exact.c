#include "exact.h"

#include <string.h>

static long double dot(int n, const long double *a, const long double *b)
{
    long double sum = 0;
    for (int k = 0; k < n; k++) sum += a[k] * b[k];
    return sum;
}

/* x = A x + B u, P = A P A' + Q */
static void predict(const kq_exact *e, const long double *u, long double *x, long double *P)
{
    const int n = e->n;
    long double *mean = e->work, *AP = e->work + n;
    for (int i = 0; i < n; i++) {
        mean[i] = dot(n, e->A + i * n, x) + dot(e->l, e->B + i * e->l, u);
        for (int j = 0; j < n; j++) AP[i * n + j] = dot(n, e->A + i * n, P + j * n); /* P is symmetric */
    }
    memcpy(x, mean, sizeof *x * (size_t)n);
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) P[i * n + j] = P[j * n + i] = dot(n, AP + i * n, e->A + j * n) + e->Q[i * n + j];
}

/* The variance that an innovation y, known to `spread` before, is taken with */
static long double weighed(const kq_exact *e, long double y, long double spread, long double r)
{
    long double made = r;
    for (int step = 0; step < e->steps; step++) {
        const long double share = made / (spread + made);
        made = (r * e->nu + y * share * (y * share) + spread * share) / (e->nu + 1);
    }
    return made;
}

/* P = (I - k h) P (I - k h)' + k r k' */
static void take(const kq_exact *e, int component, long double z, long double *x, long double *P)
{
    const int n = e->n;
    const long double *h = e->H + component * n;
    long double *row = e->work, *k = row + n, *left = k + n;
    for (int i = 0; i < n; i++) row[i] = dot(n, h, P + i * n);
    const long double y = z - dot(n, h, x), spread = dot(n, h, row), r = weighed(e, y, spread, e->R[component]);
    for (int i = 0; i < n; i++) k[i] = row[i] / (spread + r);
    for (int i = 0; i < n; i++) {
        x[i] += k[i] * y;
        for (int j = 0; j < n; j++) P[i * n + j] -= k[i] * row[j];
        left[i] = dot(n, h, P + i * n);
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) P[i * n + j] += (k[i] * r - left[i]) * k[j];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) P[i * n + j] = P[j * n + i] = (P[i * n + j] + P[j * n + i]) / 2;
}

void kq_exact_run(const kq_exact *e, size_t rows, const uint8_t *predicts, const uint32_t *taken, const long double *u,
                  const long double *z, long double *means, long double *covariances)
{
    const size_t n = (size_t)e->n, m = (size_t)e->m, l = (size_t)e->l;
    for (size_t t = 0; t < rows; t++) {
        long double *x = means + t * n, *P = covariances + t * n * n;
        if (t) {
            memcpy(x, x - n, sizeof *x * n);
            memcpy(P, P - n * n, sizeof *P * n * n);
        }
        if (predicts[t]) predict(e, u + t * l, x, P);
        for (int j = 0; j < e->m; j++)
            if (taken[t] >> j & 1) take(e, j, z[t * m + (size_t)j], x, P);
    }
}

static double product(int n, const double *a, const double *b)
{
    double sum = 0;
    for (int k = 0; k < n; k++) sum += a[k] * b[k];
    return sum;
}

static void push(const kq_path *p, const double *off, const double *pushed, double *u)
{
    for (int k = 0; k < p->l; k++) {
        const double wanted = p->holds[k] + (pushed[k] - product(p->n, p->eased + k * p->n, off)) * p->push[k], most = p->most[k];
        u[k] = (float)(wanted < -most ? -most : wanted > most ? most : wanted) + p->constant[k];
    }
}

void kq_path_run(const kq_path *p, size_t rows, const uint8_t *moves, const double *w, const double *pushed, double *x, double *u)
{
    const int n = p->n, r = p->r, l = p->l;
    double *off = p->work, *drawn = off + n, *next = x;
    for (size_t t = 0; t < rows; t++, next += n, u += l) {
        for (int i = 0; i < n; i++) off[i] = p->now[i] - p->rests[i];
        push(p, off, pushed + t * (size_t)l, u);
        for (int k = 0; k < r; k++) drawn[k] = w[t * (size_t)r + (size_t)k] - product(n, p->back + k * n, off);
        for (int i = 0; i < n; i++) {
            const double moved = product(n, p->A + i * n, p->now) + product(r, p->noise + i * r, drawn) + product(l, p->B + i * l, u);
            next[i] = moves[t] ? moved : p->now[i];
        }
        memcpy(p->now, next, sizeof *next * (size_t)n);
    }
}
