/* A body that turns about all axes, its sensors, and attitude.h. */
#include "attitude.h"
#include "simulation.h"

#include <math.h>
#include <string.h>

enum { N = 6, M = 6, NUMBERS = 7, STEPS = 1000, SIGHTINGS = 100 };

static const double seconds = 0.01, degrees = 57.29577951308232;
static const double up_of_world[] = {0, 0, 1}, field_of_world[] = {0.5, 0, 0.866};

typedef struct {
    double q[4], bias[3];
} truth;

static attitude_device device, smoothed;
/* One step of ten has six measurements, the others have none. */
enum {
    TAPE_WORDS = KQ_HISTORY_LEN_F32(N, 0, STEPS - SIGHTINGS, STEPS) +
                 KQ_HISTORY_LEN_F32(N, M, SIGHTINGS, 0)
};
static float tape_memory[TAPE_WORDS];
static kq_history_f32 tape;
KQ_JACOBIANS_F32(jacobians, tape, N, STEPS, 1); /* Q is the same at every step */
static float left[STEPS][NUMBERS]; /* as a predict found each step: what its smoothed error is beside */
static record rows[STEPS];
static truth truths[STEPS];

static void multiply(const double a[4], const double b[4], double c[4])
{
    c[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    c[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    c[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    c[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

static void turn(double q[4], const double v[3])
{
    const double angle = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const double s = angle > 0 ? sin(angle / 2) / angle : 0;
    const double by[] = {cos(angle / 2), s * v[0], s * v[1], s * v[2]};
    const double from[] = {q[0], q[1], q[2], q[3]};
    multiply(from, by, q);
}

/* conjugate(q) v q */
static void to_body(const double q[4], const double v[3], double b[3])
{
    const double back[] = {q[0], -q[1], -q[2], -q[3]}, pure[] = {0, v[0], v[1], v[2]};
    double half[4], whole[4];
    multiply(back, pure, half);
    multiply(half, q, whole);
    for (int i = 0; i < 3; i++) b[i] = whole[1 + i];
}

static void rate_at(int t, double rate[3])
{
    rate[0] = 0.5 * sin(0.03 * t);
    rate[1] = 0.4 * cos(0.02 * t);
    rate[2] = 0.3;
}

static truth start(noise *n)
{
    truth at = {{1, 0, 0, 0}, {0, 0, 0}};
    double tilt[3];
    for (int i = 0; i < 3; i++) tilt[i] = 0.3 * noise_next(n);
    for (int i = 0; i < 3; i++) at.bias[i] = 0.03 * noise_next(n);
    turn(at.q, tilt);
    return at;
}

/* What the gyro says of 10 ms; they pass. */
static void move(truth *at, int t, noise *n, float gyro[3])
{
    double rate[3], angle[3];
    rate_at(t, rate);
    for (int i = 0; i < 3; i++) {
        gyro[i] = (float)(rate[i] + at->bias[i] + 0.3 * noise_next(n));
        angle[i] = rate[i] * seconds;
        at->bias[i] += 0.0005 * noise_next(n);
    }
    turn(at->q, angle);
}

static void see(const truth *at, noise *n, float up[3], float field[3])
{
    double u[3], f[3];
    to_body(at->q, up_of_world, u);
    to_body(at->q, field_of_world, f);
    for (int i = 0; i < 3; i++) up[i] = (float)(u[i] + 0.03 * noise_next(n));
    for (int i = 0; i < 3; i++) field[i] = (float)(f[i] + 0.03 * noise_next(n));
}

/* Roll, pitch and yaw in degrees */
static void angles_of(const double q[4], double angles[3])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    angles[0] = degrees * atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y));
    angles[1] = degrees * asin(2 * (w * y - z * x));
    angles[2] = degrees * atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

/* sigma of roll, pitch and yaw, whose rates are those of the body's axes times J */
static void sigmas_of(const double angles[3], const float *P, double sigma[3])
{
    const double roll = angles[0] / degrees, pitch = angles[1] / degrees;
    const double s = sin(roll), c = cos(roll);
    const double J[3][3] = {
        {1, s * tan(pitch), c * tan(pitch)}, {0, c, -s}, {0, s / cos(pitch), c / cos(pitch)}};
    for (int i = 0; i < 3; i++) {
        double variance = 0;
        for (int k = 0; k < 3; k++) {
            for (int l = 0; l < 3; l++) variance += J[i][k] * (double)P[k * N + l] * J[i][l];
        }
        sigma[i] = degrees * sqrt(variance);
    }
}

/* The rotation of the body and the bias that lead from the estimate to the truth */
static void error_of(const truth *at, const double q[4], const float bias[3], double e[N])
{
    const double back[] = {q[0], -q[1], -q[2], -q[3]};
    double d[4];
    multiply(back, at->q, d);
    for (int i = 0; i < 3; i++) {
        e[i] = (d[0] < 0 ? -2 : 2) * d[1 + i];
        e[3 + i] = at->bias[i] - (double)bias[i];
    }
}

static void note_attitude(int t, int kind, attitude_device *f)
{
    record *row = rows + t;
    float P[N * N];
    double q[4], e[N], angles[3];
    need(kq_covariance_f32(attitude_filter(f), P), "kq_covariance_f32");
    for (int i = 0; i < 4; i++) q[i] = (double)f->x[i];
    angles_of(truths[t].q, row->truth);
    angles_of(q, angles);
    sigmas_of(angles, P, row->sigma[kind]);
    for (int i = 0; i < 3; i++) { /* as near to the truth as an angle can be */
        row->mean[kind][i] = row->truth[i] + remainder(angles[i] - row->truth[i], 360);
        row->truth[3 + i] = truths[t].bias[i];
        row->mean[kind][3 + i] = (double)f->x[4 + i];
        row->sigma[kind][3 + i] = sqrt((double)P[(3 + i) * (N + 1)]);
    }
    error_of(truths + t, q, f->x + 4, e);
    row->nees[kind] = nees_of(P, e, N);
}

static void run(noise *n)
{
    float gyro[3], up[3], field[3];
    truth at = start(n);
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) {
            move(&at, t - 1, n, gyro);
            need(attitude_predict(&device, gyro), "attitude_predict");
        }
        if (t % 10 == 0) {
            see(&at, n, up, field);
            need(attitude_update_accelerometer(&device, up), "attitude_update_accelerometer");
            need(attitude_update_magnetometer(&device, field), "attitude_update_magnetometer");
        }
        truths[t] = at;
        memcpy(left[t], device.x, sizeof left[t]);
        note_attitude(t, FILTERED, &device);
    }
}

/* What a step was left with, and its smoothed error */
static void show(int t)
{
    kq_filter_f32 view;
    memcpy(smoothed.x, left[t], sizeof left[t]);
    need(kq_smoothed_f32(&tape, (size_t)t, &view), "kq_smoothed_f32");
    need(kq_filter_copy_f32(attitude_filter(&smoothed), &view), "kq_filter_copy_f32");
    need(attitude_reset(&smoothed), "attitude_reset");
    note_attitude(t, SMOOTHED, &smoothed);
}

void simulate(uint64_t seed, int count, char **options)
{
    static const char *const names[] = {"roll_deg",     "pitch_deg",    "yaw_deg",
                                        "bias_x_rad_s", "bias_y_rad_s", "bias_z_rad_s"};
    noise n = {seed};
    if (count > 0) refuse(options[0], "no option");
    need(attitude_start(&device), "attitude_start");
    need(attitude_start(&smoothed), "attitude_start");
    need(kq_history_assign_f32(&tape, N, tape_memory, TAPE_WORDS), "kq_history_assign_f32");
    need(kq_attach_f32(attitude_filter(&device), &jacobians.attached), "kq_attach_f32");
    run(&n);
    need(kq_smooth_f32(&tape), "kq_smooth_f32");
    for (int t = 0; t < STEPS; t++) show(t);
    /* Of a body that is level the accelerometer's z says next to nothing, and x and y say it. */
    need_no_events(attitude_filter(&device), &tape, KQ_EVENT_PRECISION);
    print_records(names, N, seconds, rows, STEPS);
}
