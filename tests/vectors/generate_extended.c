/*
 * Golden vectors of nonlinear models: a vehicle with drag in a plane, ranged from two beacons; and a battery by its
 * voltage.  f, h and their Jacobians are of double, at the filter's mean, of + - * / and sqrt alone: the same bits
 * wherever they are made.  What they give is in the case.
 */
#include "generate.h"

#include <math.h>
#include <string.h>

/* One nonlinear model: `linear` has noises, prior and formats; A, H, d and h are made at x. */
typedef struct {
    model *linear;
    void (*f)(const double *x, double *d, double *A); /* d = f(x) - x */
    void (*h)(const double *x, double *z, double *H);
} nonlinear;

/* ------------------------------------------------------------------ ranges of a vehicle with drag */

enum { AXES = 2 };

static model ranging_linear = {.C = {0.05, 0, -0.02, 0.04},
                               .x0 = {-20, 3, 12, -2},
                               .P0 = {25, 4, 25, 4},
                               .state_range = {1023, 63, 1023, 63},
                               .measurement_range = {255, 255}};
static const double dt = 0.25, beacon[2][2] = {{0, 0}, {30, -4}};

/* v <- v - v^3 / (4 + v^2) dt, then the kinematics */
static void move_vehicle(const double *x, double *d, double *A)
{
    memset(A, 0, 16 * sizeof *A);
    for (int a = 0; a < AXES; a++) {
        const double v = x[2 * a + 1], below = 4 + v * v, drag = dt * v * v * v / below;
        const double slope = 1 - dt * v * v * (12 + v * v) / (below * below);
        d[2 * a] = dt * (v - drag);
        d[2 * a + 1] = -drag;
        A[10 * a] = 1;
        A[10 * a + 1] = dt * slope;
        A[10 * a + 5] = slope;
    }
}

static void range_vehicle(const double *x, double *z, double *H)
{
    memset(H, 0, 8 * sizeof *H);
    for (int c = 0; c < 2; c++) {
        const double east = x[0] - beacon[c][0], north = x[2] - beacon[c][1];
        z[c] = sqrt(east * east + north * north);
        H[4 * c] = east / z[c];
        H[4 * c + 2] = north / z[c];
    }
}

static const nonlinear ranging = {&ranging_linear, move_vehicle, range_vehicle};

/* ------------------------------------------------------------------ a battery by its voltage */

/* Charge 0 .. 1 and the voltage over R1 C1; the open circuit's is a polynomial of the charge. */
static model battery_linear = {.n = 2,
                               .r = 2,
                               .m = 1,
                               .F = {1e-4, 0, 0, 1e-3},
                               .C = {2e-3},
                               .x0 = {0.7, 0},
                               .P0 = {0.04, 1e-4},
                               .state_range = {7, 7},
                               .measurement_range = {63}};

static void discharge(const double *x, double *d, double *A)
{
    d[0] = -0.01;
    d[1] = -0.05 * x[1] + 0.004;
    A[0] = 1;
    A[1] = A[2] = 0;
    A[3] = 0.95;
}

static void voltage(const double *x, double *z, double *H)
{
    const double q = x[0];
    z[0] = 3.2 + q * (1.1 + q * (-1.4 + q * 1.2)) - x[1];
    H[0] = 1.1 + q * (-2.8 + q * 3.6);
    H[1] = -1;
}

static const nonlinear battery = {&battery_linear, discharge, voltage};

/* ------------------------------------------------------------------ steps */

static void put_predict(const nonlinear *N)
{
    double x[16], d[16];
    script_mean(N->linear, x);
    N->f(x, d, N->linear->A);
    script_transition_by(N->linear, 0, VECTOR_PROCESS_JACOBIAN);
    script_word(0);
    script_state(N->linear, d);
    script_act(VECTOR_PREDICT_EXTENDED);
}

static void put_update(const nonlinear *N, const double *z, int kind, int present, double k)
{
    double x[16], e[16];
    script_mean(N->linear, x);
    N->h(x, e, N->linear->H);
    for (int c = 0; c < N->linear->m; c++) e[c] = z[c] - e[c];
    script_measurement_by(N->linear, 0, VECTOR_SENSOR_JACOBIAN);
    script_word(0);
    script_word(kind);
    script_word(present);
    script_number(k);
    script_reading(N->linear, e);
    script_act(VECTOR_UPDATE_EXTENDED);
}

/* z = h(x) + v, of the truth */
static void measure(const nonlinear *N, truth *t, double *z)
{
    double H[16 * 16], v[16];
    memset(N->linear->H, 0, sizeof N->linear->H);
    truth_measure(t, N->linear, v);
    N->h(t->x, z, H);
    for (int c = 0; c < N->linear->m; c++) z[c] += v[c];
}

static void advance(const nonlinear *N, truth *t)
{
    double d[16], A[16 * 16];
    N->f(t->x, d, A);
    memset(N->linear->A, 0, sizeof N->linear->A);
    for (int i = 0; i < N->linear->n; i++) {
        N->linear->A[i * (N->linear->n + 1)] = 1;
        t->x[i] += d[i];
    }
    truth_advance(t, N->linear, NULL);
}

static void put_move(const nonlinear *N, const double *d)
{
    script_state(N->linear, d);
    script_act(VECTOR_MOVE);
}

static void begin_run(const nonlinear *N, truth *t, double *z, uint64_t seed)
{
    script_prior(N->linear);
    truth_begin(t, N->linear, seed);
    measure(N, t, z);
}

/* Of both models; what robust.h has of updates, moves, a component missing; all of it smoothed */
static void put_run(const nonlinear *N, int steps)
{
    static const double k_of[] = {0, 0, 1.5, 4}, back[16] = {0.5, -0.25, 0.125, 1};
    double z[16];
    truth t;
    begin_run(N, &t, z, 301);
    script_words((const int32_t[]){1200, 600, 16}, 3);
    script_act(VECTOR_EXTENDED_HISTORY);
    script_words((const int32_t[]){2, 2, 0}, 3); /* 99 % */
    script_act(VECTOR_GATE);
    for (int k = 0; k < steps; k++) {
        const int kind = k % 7 < 4 ? k % 7 : VECTOR_LINEARISED;
        if (k) {
            put_predict(N);
            advance(N, &t);
            measure(N, &t, z);
        }
        if (k == 3) z[0] += 2;
        put_update(N, z, kind, k % 7 == 5 ? 1 : k % 7 == 6 ? 0 : ALL_COMPONENTS, k_of[kind]);
        if (k == 4) put_move(N, back);
    }
    for (int k = steps; k-- > 0;) script_smooth(-1, k % 3 ? 0 : 15);
}

/* A jump, a steep Jacobian, an increment to the word's end */
static void put_beyond(const nonlinear *N)
{
    double z[16];
    truth t;
    const int n = N->linear->n;
    begin_run(N, &t, z, 302);
    z[0] += 10;
    put_update(N, z, VECTOR_LINEARISED_JUMP, ALL_COMPONENTS, 9);
    script_words((const int32_t[]){2000, 120, 2}, 3);
    script_act(VECTOR_EXTENDED_HISTORY);
    put_predict(N);
    for (int i = 0; i < n; i++) N->linear->A[i * (n + 1)] = 40 - i;
    script_transition(N->linear, 0);
    script_transition_by(N->linear, 0, VECTOR_PROCESS_JACOBIAN);
    script_predict(N->linear, 0, NULL); /* not by a Jacobian */
    const int32_t far[] = {0, INT32_MAX, -INT32_MAX, 0, 0}, none[] = {0, INT32_MIN, 0, 0, 0};
    script_words(far, 1 + n);
    script_act(VECTOR_PREDICT_EXTENDED);
    script_words(none, 1 + n);
    script_act(VECTOR_PREDICT_EXTENDED);
    script_words((const int32_t[]){0, 0, ALL_COMPONENTS, 0, 0, INT32_MAX, INT32_MAX}, 5 + N->linear->m);
    script_act(VECTOR_UPDATE_EXTENDED);
    script_smooth_all(0);
    script_words((const int32_t[]){2000, 120, 2}, 3);
    script_act(VECTOR_EXTENDED_HISTORY);
    for (int k = 0; k < 3; k++) { /* no room for the third */
        script_words(far, 1 + n);
        script_act(VECTOR_PREDICT_EXTENDED);
    }
    script_smooth_all(0);
    script_act(VECTOR_CLEAR);
    N->linear->H[0] = 90;
    script_measurement_by(N->linear, 0, VECTOR_SENSOR_JACOBIAN);
}

/* A plain tape refuses; a lag and a point take linearised predicts. */
static void put_on_line(const nonlinear *N, int is_point)
{
    double z[16];
    truth t;
    begin_run(N, &t, z, 303);
    script_words((const int32_t[]){N->linear->m, 3}, is_point ? 1 : 2);
    script_act(is_point ? VECTOR_POINT : VECTOR_LAG);
    for (int k = 0; k < 5; k++) {
        put_update(N, z, VECTOR_LINEARISED, ALL_COMPONENTS, 0);
        put_predict(N);
        advance(N, &t);
        measure(N, &t, z);
        if (!is_point) script_words((const int32_t[]){k < 3 ? k : 3, 0}, 2);
        script_act(is_point ? VECTOR_POINT_SMOOTH : VECTOR_LAG_SMOOTH);
    }
    script_prior(N->linear);
    script_history(2000);
    put_predict(N);
}

static void begin_model(const nonlinear *N)
{
    double zero[16] = {0}, z[16];
    N->f(zero, z, N->linear->A);
    N->h(N->linear->x0, z, N->linear->H);
    put_model(N->linear);
}

void case_extended(void)
{
    make_kinematic(&ranging_linear, AXES, 2, dt, 0.3);
    begin_case("extended", "nonlinear models, linearised at the mean");
    begin_model(&ranging);
    put_run(&ranging, 13);
    put_beyond(&ranging);
    begin_model(&battery);
    put_run(&battery, 9);
    put_on_line(&battery, 0);
    put_on_line(&battery, 1);
    script_end();
}
