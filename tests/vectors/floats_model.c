#include "floats_model.h"

int model_case_of(model_case *c, const int32_t *in, size_t count)
{
    static const num scales[] = {1, 4, 10, 100, (num)0.01, SMALL, TINY, LARGE};
    if (count != 5 || in[0] < 1 || in[0] > MOST_STATES || in[1] < 1 || in[1] > MOST_COMPONENTS || in[2] < 0 || in[2] > 1 ||
        in[4] < 0 || in[4] >= (int32_t)(sizeof scales / sizeof scales[0])) {
        return 0;
    }
    *c = (model_case){(int)in[0], (int)in[1], (int)in[2], (int)in[3], scales[in[4]]};
    return 1;
}

static uint32_t seed;

num model_draw(void)
{
    seed = seed * UINT32_C(1664525) + UINT32_C(1013904223);
    return ((num)(seed >> 8) - (num)0x800000) / (num)0x800000;
}

static void scatter(num *to, num size, int count)
{
    for (int k = 0; k < count; k++) to[k] = size * model_draw();
}

/* C = F F' with a random F of `size`, n x n */
static void make_covariance(num *C, num size, int n)
{
    static num F[MOST_STATES * MOST_STATES];
    scatter(F, size, n * n);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            num sum = 0;
            for (int k = 0; k < n; k++) sum += F[i * n + k] * F[j * n + k];
            C[i * n + j] = sum;
        }
    }
}

static void make_noise(num *R, const model_case *c, int m)
{
    const num size = c->kinds & SHARP ? c->scale * (num)0x1p-20 : c->scale;
    make_covariance(R, size, m);
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < m; j++) {
            if (i == j) R[i * m + j] += size * size / 4;
            if (c->kinds & EXACT || (i != j && !(c->kinds & CORRELATED))) R[i * m + j] = 0;
        }
    }
}

void model_make(model *M, const model_case *c)
{
    const int n = M->n = c->n, m = M->m = c->m;
    M->l = c->l;
    seed = (uint32_t)(n * 64 + m * 8 + c->kinds);
    scatter(M->A, (num)1 / (num)n, n * n);
    for (int i = 0; i < n; i++) M->A[i * n + i] += (num)0.75;
    scatter(M->B, c->scale, n * c->l);
    make_covariance(M->Q, c->scale / 8, n);
    scatter(M->H, 1, m * n);
    for (int j = 0; c->kinds & EXACT && j < n; j++) M->H[(m - 1) * n + j] = M->H[j];
    make_noise(M->R, c, m);
    scatter(M->x0, c->scale, n);
    make_covariance(M->P0, c->scale * 2, n);
}
