#include "textbook_filter.h"

/* out = sum over k of row_k times row k of P */
static void combine(float *restrict out, const float *row, const float *P, int n)
{
    for (int j = 0; j < n; j++) out[j] = 0;
    for (int k = 0; k < n; k++) {
        if (row[k] == 0) continue;
        for (int j = 0; j < n; j++) out[j] += row[k] * P[k * n + j];
    }
}

static float dot(const float *row, const float *x, int n)
{
    float sum = 0;
    for (int k = 0; k < n; k++) {
        if (row[k] != 0) sum += row[k] * x[k];
    }
    return sum;
}

void textbook_predict(textbook_filter *f, const textbook_process *p)
{
    float x[TEXTBOOK_STATES], T[TEXTBOOK_STATES * TEXTBOOK_STATES];
    const int n = f->n;
    for (int i = 0; i < n; i++) x[i] = dot(p->A + i * n, f->x, n);
    for (int i = 0; i < n; i++) combine(T + i * n, p->A + i * n, f->P, n);
    for (int i = 0; i < n; i++) {
        f->x[i] = x[i];
        for (int j = i; j < n; j++) {
            f->P[i * n + j] = f->P[j * n + i] = dot(p->A + j * n, T + i * n, n) + p->Q[i * n + j];
        }
    }
}

static void update_scalar(textbook_filter *f, const float *h, float r, float z)
{
    float F[TEXTBOOK_STATES];
    const int n = f->n;
    combine(F, h, f->P, n);
    const float over_s = 1 / (dot(h, F, n) + r), e = z - dot(h, f->x, n);
    for (int i = 0; i < n; i++) {
        const float k = F[i] * over_s;
        f->x[i] += k * e;
        for (int j = i; j < n; j++) {
            f->P[i * n + j] -= k * F[j];
            f->P[j * n + i] = f->P[i * n + j];
        }
    }
}

void textbook_update(textbook_filter *f, const textbook_sensor *s, const float *z)
{
    for (int c = 0; c < s->m; c++) update_scalar(f, s->H + c * s->n, s->R[c], z[c]);
}

void textbook_step(textbook_filter *f, const textbook_process *p, const textbook_sensor *s,
                   const float *z)
{
    textbook_predict(f, p);
    textbook_update(f, s, z);
}
