#include "gps_imu.h"

#include <math.h>

enum { EAST, NORTH, SPEED, HEADING, ACCELEROMETER, GYRO, N = GPS_IMU_STATES };
enum { M = 2, STEPS = GPS_IMU_STEPS, FIXES = GPS_IMU_FIXES };

static const float seconds = 0.1f;

/* sigmas: in 0.1 s 1 mm, 0.1 m/s^2 and 0.01 rad/s of the IMU, 1e-4 m/s^2 and 1e-5 rad/s of its biases */
static const float Q[N * N] = {[EAST * N + EAST] = 1e-6f,
                               [NORTH * N + NORTH] = 1e-6f,
                               [SPEED * N + SPEED] = 1e-4f,
                               [HEADING * N + HEADING] = 1e-6f,
                               [ACCELEROMETER * N + ACCELEROMETER] = 1e-8f,
                               [GYRO * N + GYRO] = 1e-10f};
static const float P0[N * N] = {[EAST * N + EAST] = 4,
                                [NORTH * N + NORTH] = 4,
                                [SPEED * N + SPEED] = 1,
                                [HEADING * N + HEADING] = 0.04f,
                                [ACCELEROMETER * N + ACCELEROMETER] = 0.01f,
                                [GYRO * N + GYRO] = 1e-4f};
static const float H[M * N] = {[EAST] = 1, [N + NORTH] = 1};
static const float r[] = {4, 4}; /* 2 m */

KQ_PROCESS_F32(motion, N, 0);
KQ_SENSOR_DIAGONAL_F32(receiver, N, M);
KQ_FILTER_F32(vehicle, N);
/* One step of ten has two measurements, the others have none. */
enum {
    TAPE_WORDS = KQ_HISTORY_LEN_F32(N, 0, STEPS - FIXES, STEPS) + KQ_HISTORY_LEN_F32(N, M, FIXES, 0)
};
static float tape_memory[TAPE_WORDS];
static kq_history_f32 tape;
KQ_JACOBIANS_F32(jacobians, tape, N, STEPS, STEPS); /* sigma points give each step a noise of its own */

static float A[N * N];
static float work[KQ_SIGMA_POINTS_LEN(N, M)];
static int is_by_points;

typedef struct {
    float acceleration, rate;
} imu;

/* f(x) - x */
static void increment(void *context, const float *x, float *d)
{
    const imu *reading = context;
    d[EAST] = seconds * x[SPEED] * cosf(x[HEADING]);
    d[NORTH] = seconds * x[SPEED] * sinf(x[HEADING]);
    d[SPEED] = seconds * (reading->acceleration - x[ACCELEROMETER]);
    d[HEADING] = seconds * (reading->rate - x[GYRO]);
    d[ACCELEROMETER] = 0;
    d[GYRO] = 0;
}

/* df/dx */
static void write_jacobian(const float *x)
{
    const float s = sinf(x[HEADING]), c = cosf(x[HEADING]);
    for (int i = 0; i < N * N; i++) A[i] = i % (N + 1) == 0 ? 1.0f : 0.0f;
    A[EAST * N + SPEED] = seconds * c;
    A[EAST * N + HEADING] = -seconds * x[SPEED] * s;
    A[NORTH * N + SPEED] = seconds * s;
    A[NORTH * N + HEADING] = seconds * x[SPEED] * c;
    A[SPEED * N + ACCELEROMETER] = -seconds;
    A[HEADING * N + GYRO] = -seconds;
}

kq_status gps_imu_start(const float x0[N], int by_points)
{
    is_by_points = by_points;
    write_jacobian(x0);
    kq_status status = kq_process_init_f32(&motion, A, NULL, Q);
    if (!status) status = kq_sensor_init_diagonal_f32(&receiver, H, r);
    if (!status) status = kq_filter_init_f32(&vehicle, x0, P0);
    if (!status) status = kq_history_assign_f32(&tape, N, tape_memory, TAPE_WORDS);
    if (!status) status = kq_attach_f32(&vehicle, &jacobians.attached);
    return status;
}

kq_status gps_imu_move(float acceleration, float rate)
{
    imu reading = {acceleration, rate};
    float x[N], d[N];
    if (is_by_points) {
        return kq_predict_sigma_points_f32(&vehicle, &motion, increment, &reading, KQ_SIGMA_POINTS_CUBATURE,
                                     work);
    }
    for (int i = 0; i < N; i++) x[i] = kq_mean_f32(&vehicle, i);
    increment(&reading, x, d);
    write_jacobian(x);
    kq_status status = kq_process_change_transition_f32(&motion, A);
    if (!status) status = kq_predict_extended_f32(&vehicle, &motion, d);
    return status;
}

kq_status gps_imu_locate(const float position[M])
{
    return kq_update_f32(&vehicle, &receiver, position);
}

kq_status gps_imu_read(float mean[N], float P[N * N])
{
    for (int i = 0; i < N; i++) mean[i] = kq_mean_f32(&vehicle, i);
    return kq_covariance_f32(&vehicle, P);
}

kq_status gps_imu_smooth(void) { return kq_smooth_f32(&tape); }

kq_status gps_imu_read_smoothed(size_t step, float mean[N], float P[N * N])
{
    kq_filter_f32 view;
    const kq_status status = kq_smoothed_f32(&tape, step, &view);
    for (int i = 0; i < N; i++) mean[i] = kq_mean_f32(&view, i);
    return status ? status : kq_covariance_f32(&view, P);
}

unsigned gps_imu_events(void)
{
    kq_filter_f32 view;
    const kq_status status = kq_smoothed_f32(&tape, 0, &view);
    return kq_events_f32(&vehicle) | (status ? 0 : kq_events_f32(&view));
}
