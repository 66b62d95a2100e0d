#include "attitude.h"

#include <math.h>

enum { N = ATTITUDE_STATES, M = 6, STEPS = ATTITUDE_STEPS, SIGHTINGS = ATTITUDE_SIGHTINGS };

static const float seconds = 0.01f;
static const float up_of_world[] = {0, 0, 1}, field_of_world[] = {0.5f, 0, 0.866f};

/* The diagonal of a 6 x 6 matrix: 3 entries of the rotation, 3 of the bias */
#define DIAGONAL(rotation, bias)                                                                   \
    {                                                                                              \
        rotation, 0, 0, 0, 0, 0, 0, rotation, 0, 0, 0, 0, 0, 0, rotation, 0, 0, 0, 0, 0, 0, bias,  \
            0, 0, 0, 0, 0, 0, bias, 0, 0, 0, 0, 0, 0, bias                                         \
    }
/* In 10 ms: 0.3 rad/s of a gyro that is shaken, 0.0005 rad/s by which its bias drifts */
static const float Q[] = DIAGONAL(9e-6f, 2.5e-7f);
static const float P0[] = DIAGONAL(9e-2f, 9e-4f); /* 17 degrees, 0.03 rad/s */
static const float r[] = {9e-4f, 9e-4f, 9e-4f, 9e-4f, 9e-4f, 9e-4f}; /* 0.03 g, 0.03 */
static const float zero[N];

KQ_PROCESS_F32(rotation, N, 0);
KQ_SENSOR_DIAGONAL_F32(sighting, N, M);
KQ_FILTER_F32(error, N);
/* One step of ten has six measurements, the others have none. */
enum {
    TAPE_WORDS = KQ_HISTORY_LEN_F32(N, 0, STEPS - SIGHTINGS, STEPS) +
                 KQ_HISTORY_LEN_F32(N, M, SIGHTINGS, 0)
};
static float tape_memory[TAPE_WORDS];
static kq_history_f32 tape;
KQ_JACOBIANS_F32(jacobians, tape, N, STEPS, 1); /* Q is the same at every step */

static float A[N * N], H[M * N];
static attitude now;         /* what the error is beside */
static attitude left[STEPS]; /* as each step was left by a turn: what its smoothed error is beside */
static size_t step;

/* q turned by the small rotation v (rad) of the body */
static void turn(float q[4], const float v[3])
{
    const float angle = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const float s = angle > 1e-4f ? sinf(angle / 2) / angle : 0.5f, c = cosf(angle / 2);
    const float x = s * v[0], y = s * v[1], z = s * v[2];
    const float p[] = {q[0] * c - q[1] * x - q[2] * y - q[3] * z,
                       q[0] * x + q[1] * c + q[2] * z - q[3] * y,
                       q[0] * y - q[1] * z + q[2] * c + q[3] * x,
                       q[0] * z + q[1] * y - q[2] * x + q[3] * c};
    const float length = sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
    for (int i = 0; i < 4; i++) q[i] = p[i] / length;
}

/* A direction of the world in the body's axes */
static void to_body(const float q[4], const float v[3], float b[3])
{
    const float w = q[0], x = -q[1], y = -q[2], z = -q[3];
    const float t[] = {2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]),
                       2 * (x * v[1] - y * v[0])};
    b[0] = v[0] + w * t[0] + y * t[2] - z * t[1];
    b[1] = v[1] + w * t[1] + z * t[0] - x * t[2];
    b[2] = v[2] + w * t[2] + x * t[1] - y * t[0];
}

/* scale [v]x into 3 rows of a matrix of N columns: the cross product with v */
static void write_cross(float *to, const float v[3], float scale)
{
    to[1] = -scale * v[2], to[2] = scale * v[1];
    to[N] = scale * v[2], to[N + 2] = -scale * v[0];
    to[2 * N] = -scale * v[1], to[2 * N + 1] = scale * v[0];
}

/* The error turns against the body, and grows by what is wrong in the bias. */
static void write_transition(const float rate[3])
{
    for (int i = 0; i < N * N; i++) A[i] = i % (N + 1) == 0 ? 1.0f : 0.0f;
    write_cross(A, rate, -seconds);
    for (int i = 0; i < 3; i++) A[i * N + 3 + i] = -seconds;
}

/* What a direction of the world is off: three innovations e and their rows of H */
static void compare(const float of_world[3], const float seen[3], float *e, float *rows)
{
    float expected[3];
    to_body(now.quaternion, of_world, expected);
    write_cross(rows, expected, 1);
    for (int i = 0; i < 3; i++) e[i] = seen[i] - expected[i];
}

static attitude corrected(attitude a, const float by[N])
{
    turn(a.quaternion, by);
    for (int i = 0; i < 3; i++) a.bias[i] += by[3 + i];
    return a;
}

/* The error goes where it belongs, and is 0 then. */
static kq_status reset(void)
{
    float found[N], back[N];
    for (int i = 0; i < N; i++) {
        found[i] = kq_mean_f32(&error, i);
        back[i] = -found[i];
    }
    now = corrected(now, found);
    return kq_move_f32(&error, back);
}

kq_status attitude_start(void)
{
    const attitude level = {{1, 0, 0, 0}, {0, 0, 0}};
    now = level;
    step = 0;
    write_transition(zero);
    kq_status status = kq_process_init_f32(&rotation, A, NULL, Q);
    if (!status) status = kq_sensor_init_diagonal_extended_f32(&sighting, H, r);
    if (!status) status = kq_filter_init_f32(&error, zero, P0);
    if (!status) status = kq_history_assign_f32(&tape, N, tape_memory, TAPE_WORDS);
    if (!status) status = kq_attach_f32(&error, &jacobians.attached);
    return status;
}

kq_status attitude_turn(const float gyro[3])
{
    float rate[3], angle[3];
    if (step + 1 >= STEPS) return KQ_ERR_HISTORY_FULL;
    for (int i = 0; i < 3; i++) {
        rate[i] = gyro[i] - now.bias[i];
        angle[i] = rate[i] * seconds;
    }
    write_transition(rate);
    kq_status status = kq_process_change_transition_f32(&rotation, A);
    if (!status) status = kq_predict_extended_f32(&error, &rotation, zero);
    if (status) return status;
    left[step++] = now;
    turn(now.quaternion, angle);
    return KQ_OK;
}

kq_status attitude_sight(const float up[3], const float field[3])
{
    float e[M];
    compare(up_of_world, up, e, H);
    compare(field_of_world, field, e + 3, H + 3 * N);
    kq_status status = kq_sensor_change_measurement_f32(&sighting, H);
    if (!status) status = kq_update_f32(&error, &sighting, e);
    if (!status) status = reset();
    return status;
}

kq_status attitude_read(attitude *estimate, float P[N * N])
{
    *estimate = now;
    return kq_covariance_f32(&error, P);
}

kq_status attitude_smooth(void)
{
    left[step] = now;
    return kq_smooth_f32(&tape);
}

kq_status attitude_read_smoothed(size_t at, attitude *estimate, float P[N * N])
{
    float by[N];
    if (at > step) return KQ_ERR_SIZE;
    kq_filter_f32 view;
    const kq_status status = kq_smoothed_f32(&tape, at, &view);
    for (int i = 0; i < N; i++) by[i] = kq_mean_f32(&view, i);
    *estimate = corrected(left[at], by);
    return status ? status : kq_covariance_f32(&view, P);
}

unsigned attitude_events(void)
{
    kq_filter_f32 view;
    const kq_status status = kq_smoothed_f32(&tape, 0, &view);
    return kq_events_f32(&error) | (status ? 0 : kq_events_f32(&view));
}
