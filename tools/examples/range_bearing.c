#include "range_bearing.h"

#include <math.h>

enum { EAST, NORTH, EAST_SPEED, NORTH_SPEED, N = RANGE_BEARING_STATES };
enum { M = 2, STEPS = RANGE_BEARING_STEPS, ITERATIONS = 4 };

static const float pi = 3.14159265f;

/* White accelerations of 0.05 m^2/s^3 on each axis for 1 s */
static const float A[] = {1, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1};
static const float Q[] = {0.05f / 3, 0, 0.025f, 0, 0, 0.05f / 3, 0, 0.025f,
                          0.025f,    0, 0.05f,  0, 0, 0.025f,    0, 0.05f};
static const float P0[] = {25, 0, 0, 0, 0, 25, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

KQ_PROCESS_F32(motion, N, 0);
KQ_SENSOR_DIAGONAL_F32(radar, N, M);
KQ_FILTER_F32(target, N);
KQ_FILTER_F32(trial, N);
KQ_HISTORY_F32(tape, N, M, STEPS, 0);

static float H[M * N];
static float work[KQ_SIGMA_POINTS_LEN(N, M)];
static track_method how;

/* z - h(x), for sigma points, too */
static void innovation(void *context, const float *x, float *e)
{
    const float *z = context;
    e[0] = z[0] - sqrtf(x[EAST] * x[EAST] + x[NORTH] * x[NORTH]);
    e[1] = z[1] - atan2f(x[NORTH], x[EAST]);
    if (e[1] > pi) e[1] -= 2 * pi;
    if (e[1] < -pi) e[1] += 2 * pi;
}

/* dh/dx */
static void write_jacobian(const float *x)
{
    const float square = x[EAST] * x[EAST] + x[NORTH] * x[NORTH], range = sqrtf(square);
    H[EAST] = x[EAST] / range;
    H[NORTH] = x[NORTH] / range;
    H[N + EAST] = -x[NORTH] / square;
    H[N + NORTH] = x[EAST] / square;
}

/* `to`, a copy of the target, is updated by h linearised at c:  e = z - h(c) - H (x - c) */
static kq_status update_at(const float c[N], kq_filter_f32 *to, float z[M])
{
    float e[M];
    innovation(z, c, e);
    write_jacobian(c);
    for (int i = 0; i < N; i++) {
        const float from_c = kq_mean_f32(to, i) - c[i] + kq_mean_low_f32(to, i);
        for (int j = 0; j < M; j++) e[j] -= H[j * N + i] * from_c;
    }
    kq_status status = kq_sensor_change_measurement_f32(&radar, H);
    if (!status) status = kq_update_f32(to, &radar, e);
    return status;
}

static void read_mean(const kq_filter_f32 *f, float x[N])
{
    for (int i = 0; i < N; i++) x[i] = kq_mean_f32(f, i);
}

/* Linearised where the update before comes out; of 1 iteration, where it begins */
static kq_status update(float z[M], int iterations)
{
    kq_status status = KQ_OK;
    float c[N];
    read_mean(&target, c);
    for (int k = 1; k < iterations && !status; k++) {
        status = kq_filter_copy_f32(&trial, &target);
        if (!status) status = update_at(c, &trial, z);
        read_mean(&trial, c);
    }
    return status ? status : update_at(c, &target, z);
}

kq_status track_start(const float x0[N], const float sigma[M], track_method method)
{
    const float r[] = {sigma[0] * sigma[0], sigma[1] * sigma[1]};
    how = method;
    write_jacobian(x0);
    kq_status status = kq_process_init_f32(&motion, A, NULL, Q);
    if (!status) status = kq_sensor_init_diagonal_extended_f32(&radar, H, r);
    if (!status) status = kq_filter_init_f32(&target, x0, P0);
    if (!status) status = kq_detach_f32(&tape.attached);
    if (!status) status = kq_attach_f32(&target, &tape.attached);
    return status;
}

kq_status track_move(void) { return kq_predict_f32(&target, &motion, NULL); }

kq_status track_measure(const float z[M])
{
    float given[] = {z[0], z[1]};
    if (how == TRACK_BY_POINTS) {
        return kq_update_sigma_points_f32(&target, &radar, innovation, given, KQ_SIGMA_POINTS_CUBATURE, work);
    }
    return update(given, how == TRACK_ITERATED ? ITERATIONS : 1);
}

kq_status track_read(float mean[N], float P[N * N])
{
    read_mean(&target, mean);
    return kq_covariance_f32(&target, P);
}

kq_status track_smooth(void) { return kq_smooth_f32(&tape); }

kq_status track_read_smoothed(size_t step, float mean[N], float P[N * N])
{
    kq_filter_f32 view;
    const kq_status status = kq_smoothed_f32(&tape, step, &view);
    for (int i = 0; i < N; i++) mean[i] = kq_mean_f32(&view, i);
    return status ? status : kq_covariance_f32(&view, P);
}

unsigned track_events(void)
{
    kq_filter_f32 view;
    const kq_status status = kq_smoothed_f32(&tape, 0, &view);
    return kq_events_f32(&target) | (status ? 0 : kq_events_f32(&view));
}
