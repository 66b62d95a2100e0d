#include "q16_filter.h"

/* A sum of products, Q32.32, as Q16.16 */
static int32_t rounded(int64_t sum) { return (int32_t)((sum + 32768) >> 16); }

static int64_t product(int32_t a, int32_t b) { return (int64_t)a * b; }

/* a / b, b > 0, rounded to nearest */
static int32_t quotient(int32_t a, int32_t b)
{
    const int64_t half = a < 0 ? -(b / 2) : b / 2;
    return (int32_t)(((int64_t)a * 65536 + half) / b);
}

/* out = sum over k of row_k times row k of P */
static void combine(int32_t *out, const int32_t *row, const int32_t *P, int n)
{
    int64_t sum[Q16_STATES] = {0};
    for (int k = 0; k < n; k++) {
        if (row[k] == 0) continue;
        for (int j = 0; j < n; j++) sum[j] += product(row[k], P[k * n + j]);
    }
    for (int j = 0; j < n; j++) out[j] = rounded(sum[j]);
}

static int64_t dot(const int32_t *row, const int32_t *x, int n)
{
    int64_t sum = 0;
    for (int k = 0; k < n; k++) {
        if (row[k]) sum += product(row[k], x[k]);
    }
    return sum;
}

void q16_predict(q16_filter *f, const q16_process *p)
{
    int32_t x[Q16_STATES], T[Q16_STATES * Q16_STATES];
    const int n = f->n;
    for (int i = 0; i < n; i++) x[i] = rounded(dot(p->A + i * n, f->x, n));
    for (int i = 0; i < n; i++) combine(T + i * n, p->A + i * n, f->P, n);
    for (int i = 0; i < n; i++) {
        f->x[i] = x[i];
        for (int j = i; j < n; j++) {
            f->P[i * n + j] = f->P[j * n + i] =
                rounded(dot(p->A + j * n, T + i * n, n)) + p->Q[i * n + j];
        }
    }
}

static void update_scalar(q16_filter *f, const int32_t *h, int32_t r, int32_t z)
{
    int32_t F[Q16_STATES], K[Q16_STATES];
    const int n = f->n;
    combine(F, h, f->P, n);
    const int32_t s = rounded(dot(h, F, n)) + r, e = z - rounded(dot(h, f->x, n));
    if (s <= 0) return;
    for (int i = 0; i < n; i++) K[i] = quotient(F[i], s);
    for (int i = 0; i < n; i++) {
        f->x[i] += rounded(product(K[i], e));
        for (int j = i; j < n; j++) {
            f->P[i * n + j] -= rounded(product(K[i], F[j]));
            f->P[j * n + i] = f->P[i * n + j];
        }
    }
}

void q16_update(q16_filter *f, const q16_sensor *s, const int32_t *z)
{
    for (int c = 0; c < s->m; c++) update_scalar(f, s->H + c * s->n, s->R[c], z[c]);
}

void q16_step(q16_filter *f, const q16_process *p, const q16_sensor *s, const int32_t *z)
{
    q16_predict(f, p);
    q16_update(f, s, z);
}
