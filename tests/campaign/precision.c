/*
 * KQ_EVENT_PRECISION beside f64, in f32: precision [models [seed]].
 *   ordinary  a position and what moves it, seen by two sensors, one 1e2 to 1e4 times worse, with gaps, 3000 steps
 *   sharp     dense rows, P0 / R of 1e12, 1e13 and 1e14, A upper triangular or dense, 20 steps
 * Of each: models with a sigma off by more than 5 %, those of them without the event, events without such a sigma.
 * No ordinary model may have an event; of the sharp ones no more than a quarter may go without.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "kalmanq/kalmanq.h"

enum { MOST = 5 };

static kq_filter_f32 single;
static kq_process_f32 motion;
static kq_sensor_f32 first, second;
static kq_filter_f64 wide;
static kq_process_f64 wide_motion;
static kq_sensor_f64 wide_first, wide_second;
static float memory[4][100];
static double wide_memory[4][100];

static uint64_t state;

static double uniform(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (double)(state >> 11) * 0x1p-53;
}

static double normal(void)
{
    double sum = -6;
    for (int k = 0; k < 12; k++) sum += uniform();
    return sum;
}

typedef struct {
    int n, steps, gap, second_every;
    float A[MOST * MOST], Q[MOST * MOST], P[MOST * MOST], h[2][MOST], r[2];
} model;

typedef struct {
    int models, wrong, silent, falsely;
} tally;

static void square(float *P, const double *F, int n)
{
    for (int i = 0; i < n * n; i++) {
        double sum = 0;
        for (int k = 0; k < n; k++) sum += F[i / n * n + k] * F[i % n * n + k];
        P[i] = (float)sum;
    }
}

static model ordinary(void)
{
    model m = {.n = 1 + (int)(uniform() * 4), .steps = 3000, .gap = 2 + (int)(uniform() * 9)};
    const double dt = pow(10, -2 * uniform()), worse = pow(10, 2 + 2 * uniform());
    m.second_every = 1 + (int)(uniform() * 3);
    for (int i = 0; i < m.n; i++) {
        m.A[i * m.n + i] = 1;
        if (i + 1 < m.n) m.A[i * m.n + i + 1] = (float)dt;
        m.P[i * m.n + i] = (float)pow(10, 4 * uniform());
        m.Q[i * m.n + i] = (float)(dt * pow(10, -4 * uniform()));
    }
    m.h[0][0] = m.h[1][0] = 1;
    m.r[0] = (float)pow(10, 2 - 4 * uniform());
    m.r[1] = (float)(m.r[0] * worse * worse);
    return m;
}

static model sharp(double ratio, int dense)
{
    model m = {.n = 2 + (int)(uniform() * 4), .steps = 20, .gap = 1000};
    double F[MOST * MOST], G[MOST * MOST];
    for (int k = 0; k < m.n * m.n; k++) {
        F[k] = normal();
        G[k] = 0.1 * normal() / sqrt(ratio);
        const int up = k % m.n - k / m.n;
        m.A[k] = (float)((up == 0) + (dense ? 0.3 * normal() : up == 1 ? 0.1 : 0));
    }
    square(m.P, F, m.n);
    square(m.Q, G, m.n);
    for (int i = 0; i < m.n; i++) m.h[0][i] = m.h[1][i] = (float)normal();
    m.r[0] = m.r[1] = (float)(1 / ratio);
    return m;
}

static int begin(const model *m)
{
    static double A[MOST * MOST], Q[MOST * MOST], P[MOST * MOST], h[2][MOST], x[MOST], r[2]; /* kept by reference */
    r[0] = m->r[0], r[1] = m->r[1];
    const float zero[MOST] = {0};
    for (int k = 0; k < m->n * m->n; k++) A[k] = m->A[k], Q[k] = m->Q[k], P[k] = m->P[k];
    for (int k = 0; k < 2 * MOST; k++) h[k / MOST][k % MOST] = m->h[k / MOST][k % MOST];
    kq_filter_assign_f32(&single, m->n, memory[0], 100);
    kq_process_assign_f32(&motion, m->n, 0, memory[1], 100);
    kq_sensor_assign_f32(&first, m->n, 1, memory[2], 100);
    kq_sensor_assign_f32(&second, m->n, 1, memory[3], 100);
    kq_filter_assign_f64(&wide, m->n, wide_memory[0], 100);
    kq_process_assign_f64(&wide_motion, m->n, 0, wide_memory[1], 100);
    kq_sensor_assign_f64(&wide_first, m->n, 1, wide_memory[2], 100);
    kq_sensor_assign_f64(&wide_second, m->n, 1, wide_memory[3], 100);
    return kq_process_init_f32(&motion, m->A, NULL, m->Q) || kq_filter_init_f32(&single, zero, m->P) ||
           kq_sensor_init_f32(&first, m->h[0], m->r) || kq_sensor_init_f32(&second, m->h[1], m->r + 1) ||
           kq_process_init_f64(&wide_motion, A, NULL, Q) || kq_filter_init_f64(&wide, x, P) ||
           kq_sensor_init_f64(&wide_first, h[0], r) || kq_sensor_init_f64(&wide_second, h[1], r + 1);
}

static void study(tally *t, const model *m)
{
    const float z = 0;
    const double z_wide = 0;
    int wrong = 0;
    if (begin(m)) return;
    for (int k = 0; k < m->steps; k++) {
        if (k % m->gap != m->gap - 1) {
            kq_update_f32(&single, &first, &z);
            kq_update_f64(&wide, &wide_first, &z_wide);
        }
        if (m->second_every && k % m->second_every == 0) {
            kq_update_f32(&single, &second, &z);
            kq_update_f64(&wide, &wide_second, &z_wide);
        }
        for (int i = 0; i < m->n; i++) {
            const double share = (double)kq_sigma_f32(&single, i) / kq_sigma_f64(&wide, i);
            wrong |= !(fabs(share - 1) <= 0.05);
        }
        kq_predict_f32(&single, &motion, NULL);
        kq_predict_f64(&wide, &wide_motion, NULL);
    }
    const int told = kq_events_f32(&single) != 0;
    t->models++;
    t->wrong += wrong;
    t->silent += wrong && !told;
    t->falsely += told && !wrong;
}

static void print(const char *name, const tally *t)
{
    printf("%-16s %5d models, %4d wrong, %4d of them silent, %4d events false\n", name, t->models, t->wrong,
           t->silent, t->falsely);
}

int main(int argc, char **argv)
{
    const int models = argc > 1 ? atoi(argv[1]) : 300;
    tally plain = {0}, hard = {0};
    state = UINT64_C(88172645463325252) + UINT64_C(0x9E3779B97F4A7C15) * (argc > 2 ? strtoull(argv[2], NULL, 10) : 1);
    for (int k = 0; k < models; k++) {
        const model m = ordinary();
        study(&plain, &m);
    }
    print("ordinary", &plain);
    for (int k = 0; k < 6 * models; k++) {
        const model m = sharp(pow(10, 12 + k / 2 % 3), k % 2);
        study(&hard, &m);
    }
    print("sharp", &hard);
    const int good = !plain.falsely && !plain.silent && 4 * hard.silent <= hard.wrong;
    printf("%s\n", good ? "passed" : "FAILED");
    return !good;
}
