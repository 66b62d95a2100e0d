/*
 * A process whose noise w is correlated with the noise v of the measurement before it, E w v' = S.  Of w, v tells
 * K v, K = S R^-1, and v = z - H x:
 *     x' = (A - K H) x + B u + K z + (w - K v)
 * The upper triangular root of the joint covariance has all of it, and nothing is taken away from Q:
 *     [Q, S; S', R] = [G, C; 0, D] [G, C; 0, D]',    K = C D^-1,    Q - K S' = G G'
 */
#ifndef KQ_SRC_MODEL_CORRELATED_FLOAT_H
#define KQ_SRC_MODEL_CORRELATED_FLOAT_H

#include "matrices_float.h"

/* The parts of the process's memory behind G: what it refers to, and scratch */
typedef struct {
    num *A, *B;
    num *joint, *root; /* (n + m)^2, upper triangle; its root */
} correlated_work;

KQ_COLD static correlated_work correlated_work_at(num *memory, int n, int controls, int m)
{
    correlated_work w;
    w.A = memory + KQ_TRIANGLE(n);
    w.B = w.A + n * n;
    w.joint = w.B + n * controls;
    w.root = w.joint + (n + m) * (n + m);
    return w;
}

/* What is not present is 0, and so is the floor under a component without noise, which has none to share. */
KQ_COLD static void joint_covariance(num *joint, const num *Q, const sensor *s, const num *S, uint32_t present)
{
    const int n = s->states, m = s->components, width = n + m;
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++) joint[i * width + j] = Q[i * n + j];
        for (int c = 0; c < m; c++) joint[i * width + n + c] = present >> c & 1 ? S[i * m + c] : 0;
    }
    for (int b = 0; b < m; b++) {
        for (int c = b; c < m; c++) {
            const num r = present >> b & present >> c & 1 ? noise_entry(s, b, c) : 0;
            joint[(n + b) * width + n + c] = b == c && r <= num_tiny ? 0 : r;
        }
    }
}

/* K D = C.  A component whose noise is 0, or that of others, adds nothing. */
KQ_COLD static void joint_gain(num *K, const num *root, int n, int m)
{
    for (int c = 0; c < m; c++) {
        const num *D = root + column(n + c) + n;
        for (int i = 0; i < n; i++) {
            num rest = D[i - n];
            for (int b = 0; b < c; b++) rest -= K[i * m + b] * D[b];
            K[i * m + c] = D[c] > 0 ? rest / D[c] : 0;
        }
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
    uint8_t row[2 * KQ_SIZE_MAX];
    kq_status status = correlated_check(p, A, B, Q, s, S);
    if (status) return status;
    const int n = p->states, m = s->components, l = p->controls - m;
    const correlated_work w = correlated_work_at(p->memory, n, l + m, m);
    joint_covariance(w.joint, Q, s, S, present);
    status = root_by_rows(w.root, w.joint, n + m, row);
    if (status) return status;
    num *K = w.joint, *next_A = K + n * m; /* it is not needed any more */
    joint_gain(K, w.root, n, m);
    less_gain(next_A, A, K, s);
    if (!all_finite(K, n * (m + n))) return KQ_ERR_RANGE;
    copy(p->memory, w.root, KQ_TRIANGLE(n));
    copy(w.A, next_A, n * n);
    for (int i = 0; i < n; i++) {
        num *control = w.B + i * (l + m);
        if (l) copy(control, B + i * l, l);
        copy(control + l, K + i * m, m);
    }
    process_set_model(p, w.A, w.B);
    return KQ_OK;
}

#endif
