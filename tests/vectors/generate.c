/*
 * Writes the golden vectors: generate DIRECTORY.  regenerate.sh builds and runs it.
 *
 * Models and data are made with + - * / of double in a fixed order (compile without fused
 * multiply-add), so the files are the same wherever they are made.
 */
#include "generate.h"

#include <stdio.h>
#include <string.h>

enum { EVERYTHING = VECTOR_COVARIANCE | VECTOR_LAG_ONE | VECTOR_NOISE | VECTOR_READING_NOISE };

static const char *directory;

void begin_case(const char *name, const char *title) { script_begin(directory, name, title); }

static void fill(double *to, double value, int count)
{
    for (int k = 0; k < count; k++) to[k] = value;
}

static void identity(double *A, int n)
{
    for (int i = 0; i < n; i++) A[i * n + i] = 1;
}

/* Signed numbers below `size`, of a fixed sequence */
static void scatter(double *to, double size, int count, uint32_t seed)
{
    for (int k = 0; k < count; k++) {
        seed = seed * UINT32_C(1664525) + UINT32_C(1013904223);
        to[k] = size * ((double)(seed >> 8) * 0x1p-23 - 1);
    }
}

static void begin(const char *name, const char *title, const model *M)
{
    script_begin(directory, name, title);
    script_states(M);
    script_process(M, 0);
    script_sensor(M, 0);
    script_prior(M);
}

/* The smoother, step by step; everything at every `often`-th step */
static void smooth_steps(int steps, int often)
{
    for (int t = steps; t-- > 0;) script_smooth(-1, t % often == 0 ? EVERYTHING : 0);
}

void make_kinematic(model *M, int axes, int order, double dt, double noise)
{
    const int n = axes * order;
    M->n = n;
    M->r = M->m = axes;
    for (int a = 0; a < axes; a++) {
        for (int i = 0; i < order; i++) {
            double power = 1;
            for (int j = i; j < order; j++) {
                M->A[(a * order + i) * n + a * order + j] = power;
                power *= dt / (j - i + 1);
            }
            M->F[(a * order + i) * axes + a] = power * noise;
        }
        M->H[a * n + a * order] = 1;
    }
}

/* ------------------------------------------------------------------ ordinary models */

static double control_at(int t) { return 0.25 * (t % 7 - 3); }

/* A measurement and a control that are out of range are refused; what is refused changes nothing */
static void put_refused(void)
{
    script_words((const int32_t[]){0, ALL_COMPONENTS, INT32_MAX}, 3);
    script_act(VECTOR_UPDATE);
    script_words((const int32_t[]){0, ALL_COMPONENTS, INT32_MIN}, 3);
    script_act(VECTOR_UPDATE);
    script_words((const int32_t[]){0, 1, INT32_MIN}, 3);
    script_act(VECTOR_PREDICT);
    script_smooth_all(0);
}

/* A history that fills up: an event, and no smoothing */
static void put_full_history(const model *M)
{
    const double z = 1.5;
    script_prior(M);
    script_history(40);
    for (int t = 0; t < 6; t++) script_step(M, NULL, &z);
    script_smooth_all(0);
    script_act(VECTOR_CLEAR);
}

static void case_level(void)
{
    static model M = {.n = 1,
                      .r = 1,
                      .l = 1,
                      .m = 1,
                      .A = {0.95},
                      .B = {0.5},
                      .F = {0.1},
                      .H = {1},
                      .C = {1},
                      .P0 = {100},
                      .state_range = {1023},
                      .control_range = {1},
                      .measurement_range = {1000}};
    enum { STEPS = 24 };
    truth t;
    double z[16], plan[4] = {0.5, -0.25, 0, 1};
    begin("level", "n = 1 with a control; calls that are refused, a history that fills up", &M);
    script_history(VECTOR_HISTORY_WORDS);
    truth_begin(&t, &M, 11);
    for (int k = 0; k < STEPS; k++) {
        const double u = control_at(k);
        truth_measure(&t, &M, z);
        if (k % 8 == 0) script_look(&M, 0, z);
        script_update(&M, 0, z, ALL_COMPONENTS);
        if (k % 8 == 0) script_read();
        if (k + 1 == STEPS) break;
        script_predict(&M, 0, k % 5 == 4 ? NULL : &u);
        truth_advance(&t, &M, k % 5 == 4 ? NULL : &u);
    }
    script_forecast(&M, 4, plan);
    script_forecast(&M, 0, NULL);
    smooth_steps(STEPS, 1);
    put_refused();
    put_full_history(&M);
    script_prior(&M);
    script_run(0, 0, 2000, 12345, 9);
    script_read();
    script_end();
}

static void case_velocity(void)
{
    static model M = {
        .C = {0.1}, .P0 = {100, 100}, .state_range = {4095, 255}, .measurement_range = {4095}};
    enum { STEPS = 40 };
    truth t;
    double z[16];
    make_kinematic(&M, 1, 2, 0.01, 2);
    begin("velocity", "n = 2, constant velocity, measurements that are missing", &M);
    script_history(VECTOR_HISTORY_WORDS);
    truth_begin(&t, &M, 22);
    for (int k = 0; k < STEPS; k++) {
        truth_measure(&t, &M, z);
        if (k == 5) script_look(&M, 0, z);
        if (k % 4 == 2) script_update(&M, 0, z, 0);
        else if (k % 9 != 7) script_update(&M, 0, z, k % 2 ? 1 : ALL_COMPONENTS);
        if (k % 10 == 0) script_read();
        if (k + 1 == STEPS) break;
        script_predict(&M, 0, NULL);
        truth_advance(&t, &M, NULL);
    }
    script_forecast(&M, 100, NULL);
    smooth_steps(STEPS, 2);
    script_prior(&M);
    script_run(0, 0, 2000, 777, 14);
    script_end();
}

static void case_acceleration(void)
{
    static model M = {.l = 2,
                      .B = {0.0005, 0, 0.01, 0, 0, -0.02},
                      .C = {0.1},
                      .x0 = {100, -5, 0.5},
                      .P0 = {100, 100, 10},
                      .state_range = {65535, 2047, 63},
                      .control_range = {10, 30},
                      .measurement_range = {65535}};
    enum { STEPS = 20 };
    truth t;
    double z[16];
    make_kinematic(&M, 1, 3, 0.05, 1);
    begin("acceleration", "n = 3, constant acceleration, two controls, update and predict at once",
          &M);
    script_history(VECTOR_HISTORY_WORDS);
    truth_begin(&t, &M, 33);
    for (int k = 1; k < STEPS; k++) {
        const double u[2] = {control_at(k), -control_at(3 * k)};
        truth_advance(&t, &M, u);
        truth_measure(&t, &M, z);
        script_step(&M, u, z);
        if (k % 6 == 0) script_look(&M, 0, z);
    }
    script_read();
    script_smooth_all(0);
    script_prior(&M);
    script_run(0, 0, 1000, 31415, 18);
    script_end();
}

static void case_plane(void)
{
    static model M = {.C = {0.2, 0, 0, 0.3},
                      .P0 = {100, 100, 100, 100},
                      .state_range = {8191, 63, 8191, 63},
                      .measurement_range = {8191, 8191}};
    enum { STEPS = 18 };
    truth t;
    double z[16];
    make_kinematic(&M, 2, 2, 0.1, 1);
    begin("plane", "n = 4, m = 2, a position in the plane, one coordinate missing at times", &M);
    script_history(VECTOR_HISTORY_WORDS);
    truth_begin(&t, &M, 44);
    for (int k = 0; k < STEPS; k++) {
        truth_measure(&t, &M, z);
        if (k % 8 == 4) script_look(&M, 0, z);
        script_update(&M, 0, z, k % 3 == 2 ? k % 4 : ALL_COMPONENTS);
        if (k + 1 == STEPS) break;
        script_predict(&M, 0, NULL);
        truth_advance(&t, &M, NULL);
    }
    script_read();
    script_forecast(&M, 10, NULL);
    smooth_steps(STEPS, 4);
    script_prior(&M);
    script_run(0, 0, 1000, 2718, 15);
    script_end();
}

/* A with rows of absolute sum `gain` */
static void scatter_transition(model *M, double gain, uint32_t seed)
{
    const int n = M->n;
    scatter(M->A, 0.3, n * n, seed);
    for (int i = 0; i < n; i++) {
        double total = 0;
        M->A[i * n + i] += 0.5;
        for (int k = 0; k < n; k++)
            total += M->A[i * n + k] < 0 ? -M->A[i * n + k] : M->A[i * n + k];
        for (int k = 0; k < n; k++) M->A[i * n + k] *= gain / total;
    }
}

static void case_dense(void)
{
    static model M = {.n = 6, .r = 6, .m = 3, .C = {0.3, 0, 0, 0.2, 0.4, 0, -0.3, 0.1, 0.5}};
    enum { STEPS = 18 };
    truth t;
    double z[16];
    scatter_transition(&M, 1.25, 5);
    scatter(M.F, 0.3, 36, 6);
    scatter(M.H, 1, 18, 7);
    fill(M.P0, 10, 6);
    fill(M.state_range, 255, 6);
    fill(M.measurement_range, 1023, 3);
    begin("dense", "n = 6 and m = 3, everything dense, correlated noise, all subsets", &M);
    script_history(VECTOR_HISTORY_WORDS);
    truth_begin(&t, &M, 55);
    for (int k = 0; k < STEPS; k++) {
        truth_measure(&t, &M, z);
        if (k % 7 == 3) script_look(&M, 0, z);
        script_update(&M, 0, z, k % 2 ? k / 2 % 8 : ALL_COMPONENTS);
        if (k + 1 == STEPS) break;
        script_predict(&M, 0, NULL);
        truth_advance(&t, &M, NULL);
    }
    script_read();
    script_forecast(&M, 3, NULL);
    smooth_steps(STEPS, 6);
    script_prior(&M);
    script_run(0, 0, 500, 1618, 10);
    script_end();
}

/* Three axes of position, velocity and the bias of the accelerometer that is integrated */
static void make_imu(model *M)
{
    const double dt = 0.01;
    M->n = 9;
    M->r = 6;
    M->l = M->m = 3;
    identity(M->A, 9);
    for (int a = 0; a < 3; a++) {
        const int p = a, v = 3 + a, b = 6 + a;
        M->A[p * 9 + v] = dt;
        M->A[p * 9 + b] = -dt * dt / 2;
        M->A[v * 9 + b] = -dt;
        M->B[p * 3 + a] = dt * dt / 2;
        M->B[v * 3 + a] = dt;
        M->F[p * 6 + a] = dt * dt / 2 * 0.05;
        M->F[v * 6 + a] = dt * 0.05;
        M->F[b * 6 + 3 + a] = 1e-6 * (1 + a);
        M->H[a * 9 + p] = 1;
        M->C[a * 3 + a] = 0.5 + 0.25 * a;
        M->P0[p] = 1e4;
        M->P0[v] = 100;
        M->P0[b] = 1e-4;
        M->state_range[p] = M->measurement_range[a] = 32767;
        M->state_range[v] = 511;
        M->state_range[b] = 0.125;
        M->control_range[a] = 40;
    }
}

static void case_imu(void)
{
    static model M;
    enum { STEPS = 14 };
    truth t;
    double z[16];
    make_imu(&M);
    begin("imu", "n = 9, position, velocity and accelerometer bias of three axes", &M);
    script_history(VECTOR_HISTORY_WORDS);
    truth_begin(&t, &M, 66);
    for (int k = 0; k < STEPS; k++) {
        const double u[3] = {control_at(k), 9.81, -3 * control_at(k + 2)};
        truth_measure(&t, &M, z);
        if (k == 6) script_look(&M, 0, z);
        if (k % 2 == 0) script_update(&M, 0, z, k == 4 ? 5 : ALL_COMPONENTS);
        if (k + 1 == STEPS) break;
        script_predict(&M, 0, u);
        truth_advance(&t, &M, u);
    }
    script_read();
    smooth_steps(STEPS, 6);
    script_prior(&M);
    script_run(0, 0, 500, 9, 15);
    script_end();
}

static void case_sixteen(void)
{
    static model M = {.n = 16, .r = 3, .m = 4};
    enum { STEPS = 5 };
    truth t;
    double z[16];
    scatter_transition(&M, 1, 9);
    scatter(M.F, 0.5, 48, 10);
    scatter(M.H, 1, 64, 11);
    scatter(M.C, 0.2, 16, 12);
    for (int c = 0; c < 4; c++) {
        for (int k = c + 1; k < 4; k++) M.C[c * 4 + k] = 0;
    }
    fill(M.P0, 4, 16);
    fill(M.state_range, 127, 16);
    fill(M.measurement_range, 511, 4);
    begin("sixteen", "n = 16, m = 4, the largest number of states", &M);
    script_history(VECTOR_HISTORY_WORDS);
    truth_begin(&t, &M, 77);
    for (int k = 0; k < STEPS; k++) {
        truth_measure(&t, &M, z);
        if (k == 2) script_look(&M, 0, z);
        script_update(&M, 0, z, k == 3 ? 11 : ALL_COMPONENTS);
        if (k + 1 == STEPS) break;
        script_predict(&M, 0, NULL);
        truth_advance(&t, &M, NULL);
    }
    smooth_steps(STEPS, 3);
    script_prior(&M);
    script_run(0, 0, 100, 4, 11);
    script_end();
}

/* ------------------------------------------------------------------ hard models */

static void follow(const model *M, int steps, uint64_t seed)
{
    truth t;
    double z[16];
    script_history(VECTOR_HISTORY_WORDS);
    truth_begin(&t, M, seed);
    for (int k = 0; k < steps; k++) {
        truth_measure(&t, M, z);
        if (k < 2) script_look(M, 0, z);
        script_update(M, 0, z, ALL_COMPONENTS);
        if (k + 1 == steps) break;
        script_predict(M, 0, NULL);
        truth_advance(&t, M, NULL);
    }
    script_read();
    smooth_steps(steps, 2);
}

void put_model(const model *M)
{
    script_states(M);
    script_process(M, 0);
    script_sensor(M, 0);
    script_prior(M);
}

static void case_sharp(void)
{
    static model M = {
        .C = {3.16e-5}, .P0 = {1e6, 1e6}, .state_range = {8191, 8191}, .measurement_range = {8191}};
    static model sum = {.n = 3,
                        .r = 1,
                        .m = 2,
                        .A = {0.95, 0.1, 0, 0, 0.95, 0.1, 0, 0, 0.95},
                        .F = {0, 0, 1e-4},
                        .H = {1, 1, 1, 0.5, -1, 1},
                        .C = {3.16e-5, 0, 0, 3.16e-5},
                        .P0 = {1e6, 1e6, 1e6},
                        .state_range = {16383, 16383, 16383},
                        .measurement_range = {65535, 65535}};
    make_kinematic(&M, 1, 2, 0.01, 1e-2);
    begin("sharp", "noise 1e-15 of the prior variance, taken in stages", &M);
    follow(&M, 8, 88);
    put_model(&sum);
    follow(&sum, 8, 89);
    script_end();
}

static void case_singular(void)
{
    static model still = {.n = 2,
                          .r = 0,
                          .m = 1,
                          .A = {1, 0.01, 0, 1},
                          .H = {1, 0},
                          .C = {1},
                          .P0 = {1e4, 100},
                          .state_range = {65535, 63},
                          .measurement_range = {65535}};
    static model twins = {.n = 2,
                          .r = 1,
                          .m = 2,
                          .A = {1, 0.5, 0, 0.9},
                          .F = {0.5, 1},
                          .H = {1, 0, 1, 0},
                          .P0 = {25, 4},
                          .state_range = {1023, 255},
                          .measurement_range = {1023, 1023}};
    static model sums = {.n = 2,
                         .r = 1,
                         .m = 2,
                         .A = {1, 0.5, 0, 0.9},
                         .F = {0.5, 1},
                         .H = {1, 1, 1, 1},
                         .P0 = {25, 4},
                         .state_range = {1023, 255},
                         .measurement_range = {1023, 1023}};
    static model known = {.n = 2,
                          .r = 1,
                          .m = 1,
                          .A = {1, 1, 0, 1},
                          .F = {0, 0.5},
                          .H = {0, 1},
                          .C = {0.5},
                          .x0 = {7, -3},
                          .state_range = {1023, 255},
                          .measurement_range = {255}};
    begin("singular",
          "no process noise; twin sensors without noise, of a state and of a sum; a prior "
          "without variance",
          &still);
    follow(&still, 12, 91);
    script_run(0, 0, 500, 5, 15);
    put_model(&twins);
    follow(&twins, 6, 92);
    put_model(&sums);
    follow(&sums, 6, 94);
    script_act(VECTOR_CLEAR);
    put_model(&known);
    follow(&known, 10, 93);
    script_end();
}

/* A measurement so far off that NIS is held at its end */
static void put_outlier(const model *M)
{
    const double far = -90, near = -89.5;
    put_model(M);
    script_update(M, 0, &far, ALL_COMPONENTS);
    script_read();
    script_predict(M, 0, NULL);
    script_update(M, 0, &near, ALL_COMPONENTS);
    script_read();
}

/* Predictions take the state to the end of its word; measurements bring it back. */
static void case_saturated(void)
{
    static model M = {.n = 2,
                      .r = 1,
                      .m = 1,
                      .A = {1, 1, 0, 1},
                      .F = {0.5, 1},
                      .H = {1, 0},
                      .C = {0.5},
                      .x0 = {60, 20},
                      .P0 = {4, 4},
                      .state_range = {100, 100},
                      .measurement_range = {100}};
    begin("saturated", "a state that leaves its word and comes back; a NIS beyond its range", &M);
    script_history(VECTOR_HISTORY_WORDS);
    script_forecast(&M, 8, NULL);
    for (int k = 0; k < 8; k++) {
        if (k == 6) script_act(VECTOR_CLEAR);
        script_predict(&M, 0, NULL);
    }
    script_read();
    for (int k = 0; k < 8; k++) {
        const double z = k < 4 ? -90 + k : 0.5 * k;
        script_look(&M, 0, &z);
        script_update(&M, 0, &z, ALL_COMPONENTS);
        if (k == 3) script_act(VECTOR_CLEAR);
        if (k < 7) script_predict(&M, 0, NULL);
    }
    script_read();
    smooth_steps(16, 2);
    M.C[0] = 1e-6;
    fill(M.P0, 1e-14, 2);
    put_outlier(&M);
    script_end();
}

/* ------------------------------------------------------------------ models that change */

/* Two step lengths and two sensors by turns, on one history */
static void put_turns(const model *slow, const model *fast)
{
    truth t;
    double z[16];
    script_history(VECTOR_HISTORY_WORDS);
    truth_begin(&t, slow, 101);
    for (int k = 0; k < 16; k++) {
        const model *M = k % 5 > 2 ? fast : slow;
        const int slot = M == fast;
        truth_measure(&t, M, z);
        if (k % 6 != 3) script_update(M, slot, z, ALL_COMPONENTS);
        if (k == 15) break;
        script_predict(M, slot, NULL);
        truth_advance(&t, M, NULL);
    }
    smooth_steps(16, 2);
}

/* Another A before every predict, and the history told of it: newest first */
static void put_transitions(model *M)
{
    double z[16];
    truth t;
    script_prior(M);
    script_history(VECTOR_HISTORY_WORDS);
    truth_begin(&t, M, 102);
    for (int k = 0; k < 6; k++) {
        truth_measure(&t, M, z);
        script_update(M, 0, z, ALL_COMPONENTS);
        M->A[1] = 0.05 * (k + 1);
        script_transition(M, 0);
        script_predict(M, 0, NULL);
        truth_advance(&t, M, NULL);
    }
    script_smooth(-1, EVERYTHING);
    for (int k = 6; k-- > 0;) {
        M->A[1] = 0.05 * (k + 1);
        script_transition(M, 0);
        script_smooth(0, EVERYTHING);
    }
}

/* Another H at every update; the smoother for the means alone */
static void put_measurements(model *M)
{
    double z[16];
    truth t;
    script_prior(M);
    script_history(VECTOR_HISTORY_WORDS);
    truth_begin(&t, M, 103);
    for (int k = 0; k < 10; k++) {
        M->H[1] = 0.3 * (k % 4) - 0.4;
        script_measurement(M, 0);
        truth_measure(&t, M, z);
        script_update(M, 0, z, ALL_COMPONENTS);
        if (k == 9) break;
        script_predict(M, 0, NULL);
        truth_advance(&t, M, NULL);
    }
    script_smooth_all(1);
}

static void case_changing(void)
{
    static model slow = {
        .C = {0.1}, .P0 = {100, 100}, .state_range = {4095, 255}, .measurement_range = {4095}};
    static model fast = {.state_range = {4095, 255}};
    make_kinematic(&slow, 1, 2, 0.1, 2);
    make_kinematic(&fast, 1, 2, 0.02, 2);
    fast.m = 2;
    memcpy(fast.H, (const double[]){0, 1, 1, -0.5}, 4 * sizeof(double));
    memcpy(fast.C, (const double[]){0.4, 0, -0.3, 0.2}, 4 * sizeof(double));
    fill(fast.measurement_range, 8191, 2);
    script_begin(directory, "changing",
                 "processes and sensors by turns, another A and another H at every step");
    script_states(&slow);
    script_process(&slow, 0);
    script_process(&fast, 1);
    script_sensor(&slow, 0);
    script_sensor(&fast, 1);
    script_prior(&slow);
    put_turns(&slow, &fast);
    put_transitions(&slow);
    put_measurements(&slow);
    script_end();
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: generate DIRECTORY\n");
        return 2;
    }
    directory = argv[1];
    case_level();
    case_velocity();
    case_acceleration();
    case_plane();
    case_dense();
    case_imu();
    case_sixteen();
    case_sharp();
    case_singular();
    case_saturated();
    case_changing();
    case_on_line();
    case_robust();
    case_start();
    case_adaptation();
    case_statistics();
    case_steady();
    case_extended();
    return 0;
}
