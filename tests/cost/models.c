#include "models.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* `axes` of position and velocity under a white acceleration, the position measured */
static void make_velocity(model *M, int axes, double dt, double acceleration)
{
    const int n = 2 * axes;
    M->n = n;
    M->r = M->m = axes;
    for (int a = 0; a < axes; a++) {
        const int p = 2 * a, v = p + 1;
        M->A[p * n + p] = M->A[v * n + v] = 1;
        M->A[p * n + v] = dt;
        M->F[p * axes + a] = dt * dt / 2 * acceleration;
        M->F[v * axes + a] = dt * acceleration;
        M->H[a * n + p] = 1;
        M->P0[p] = M->P0[v] = 100;
    }
}

/* Three axes of position, velocity and the bias of the accelerometer that is integrated */
static void make_imu(model *M)
{
    const double dt = 0.01, noise = 0.05;
    M->n = 9;
    M->r = 6;
    M->m = 3;
    for (int i = 0; i < 9; i++) M->A[i * 9 + i] = 1;
    for (int a = 0; a < 3; a++) {
        const int p = a, v = 3 + a, b = 6 + a;
        M->A[p * 9 + v] = dt;
        M->A[p * 9 + b] = -dt * dt / 2;
        M->A[v * 9 + b] = -dt;
        M->F[p * 6 + a] = dt * dt / 2 * noise;
        M->F[v * 6 + a] = dt * noise;
        M->F[b * 6 + 3 + a] = 1e-6 * (1 + a);
        M->H[a * 9 + p] = 1;
        M->R[a] = 0.25 * (a + 1);
        M->P0[p] = 1e4;
        M->P0[v] = 100;
        M->P0[b] = 1e-4;
        M->state_range[p] = 32767;
        M->state_range[v] = 511;
        M->state_range[b] = 0.125;
    }
    M->measurement_range = 32767;
}

void model_make(model *M, int which)
{
    *M = (model){.name = "IMU-like"};
    if (which == 2) {
        make_imu(M);
        return;
    }
    M->name = which ? "velocity, 2-D" : "velocity";
    make_velocity(M, which + 1, which ? 0.1 : 0.01, which ? 1 : 2);
    M->measurement_range = which ? 8191 : 4095;
    for (int i = 0; i < M->n; i++) {
        M->state_range[i] = i % 2 == 0 ? M->measurement_range : which ? 63 : 255;
    }
    M->R[0] = which ? 0.04 : 0.01;
    M->R[1] = 0.09;
}

static double uniform(uint64_t *seed)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    return ((double)(*seed >> 11) + 0.5) * 0x1p-53;
}

static double normal(uint64_t *seed)
{
    double total = -6;
    for (int k = 0; k < 12; k++) total += uniform(seed);
    return total;
}

static void move(double *x, const model *M, uint64_t *seed)
{
    double next[STATES] = {0}, w[STATES];
    for (int k = 0; k < M->r; k++) w[k] = normal(seed);
    for (int i = 0; i < M->n; i++) {
        for (int k = 0; k < M->n; k++) next[i] += M->A[i * M->n + k] * x[k];
        for (int k = 0; k < M->r; k++) next[i] += M->F[i * M->r + k] * w[k];
    }
    memcpy(x, next, sizeof next);
}

void model_simulate(const model *M, double (*z)[COMPONENTS])
{
    uint64_t seed = UINT64_C(88172645463325252);
    double x[STATES];
    for (int i = 0; i < M->n; i++) x[i] = sqrt(M->P0[i]) * normal(&seed);
    for (int t = 0; t < STEPS; t++) {
        move(x, M, &seed);
        for (int c = 0; c < M->m; c++) {
            double measured = sqrt(M->R[c]) * normal(&seed);
            for (int k = 0; k < M->n; k++) measured += M->H[c * M->n + k] * x[k];
            z[t][c] = ldexp(floor(ldexp(measured, 16) + 0.5), -16);
        }
    }
}
