/* A vehicle on a winding road, its IMU and GPS receiver, and gps_imu.h.  Option: points. */
#include "gps_imu.h"
#include "simulation.h"

#include <math.h>
#include <string.h>

enum { N = 6, M = 2, STEPS = 300, FIXES = 30 };

static gps_imu_device device;
/* One step of ten has two measurements, the others have none. */
enum {
    TAPE_WORDS = KQ_HISTORY_LEN_F32(N, 0, STEPS - FIXES, STEPS) + KQ_HISTORY_LEN_F32(N, M, FIXES, 0)
};
static float tape_memory[TAPE_WORDS];
static kq_history_f32 tape;
KQ_JACOBIANS_F32(jacobians, tape, N, STEPS, STEPS); /* sigma points give each step a noise of its own */
static float work[KQ_SIGMA_POINTS_LEN(N, M)];

static const double seconds = 0.1;
static const double x0[N] = {500, -300, 10, 0.5, 0, 0}, sigma0[N] = {2, 2, 1, 0.2, 0.1, 0.01};
static record rows[STEPS];
static double truths[STEPS][N];

static void start(double x[N], noise *n)
{
    for (int i = 0; i < N; i++) x[i] = x0[i] + sigma0[i] * noise_next(n);
}

/* 0.1 s pass; what the IMU says of them. */
static void move(double x[N], int t, noise *n, float imu[2])
{
    const double push = 0.5 * cos(0.05 * t), turn = 0.2 * sin(0.02 * t);
    imu[0] = (float)(push + x[4] + 0.1 * noise_next(n));
    imu[1] = (float)(turn + x[5] + 0.01 * noise_next(n));
    x[0] += seconds * x[2] * cos(x[3]) + 1e-3 * noise_next(n);
    x[1] += seconds * x[2] * sin(x[3]) + 1e-3 * noise_next(n);
    x[2] += seconds * push;
    x[3] += seconds * turn;
    x[4] += 1e-4 * noise_next(n);
    x[5] += 1e-5 * noise_next(n);
}

static kq_status predict(const float imu[2], int by_points)
{
    gps_imu_row row = {imu};
    if (!by_points) return gps_imu_predict(&device, imu);
    return kq_predict_sigma_points_f32(gps_imu_filter(&device), &device.process, gps_imu_point_increment, &row,
                                       KQ_SIGMA_POINTS_CUBATURE, work);
}

static void locate(const double x[N], noise *n)
{
    float position[M];
    for (int i = 0; i < M; i++) position[i] = (float)(x[i] + 2 * noise_next(n));
    need(gps_imu_update(&device, position), "gps_imu_update");
}

static void run(noise *n, int by_points)
{
    double x[N];
    float imu[2];
    start(x, n);
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) {
            move(x, t - 1, n, imu);
            need(predict(imu, by_points), "predict");
        }
        if (t % 10 == 0) locate(x, n);
        memcpy(truths[t], x, sizeof x);
        note(rows + t, FILTERED, x, gps_imu_filter(&device), N);
    }
}

void simulate(uint64_t seed, int count, char **options)
{
    static const char *const names[] = {"east_m",      "north_m",     "speed_m_s",
                                        "heading_rad", "bias_a_m_s2", "bias_w_rad_s"};
    noise n = {seed};
    if (count > 1 || (count == 1 && strcmp(options[0], "points") != 0)) {
        refuse(options[count - 1], "points, or nothing");
    }
    need(gps_imu_start(&device), "gps_imu_start");
    need(kq_history_assign_f32(&tape, N, tape_memory, TAPE_WORDS), "kq_history_assign_f32");
    need(kq_attach_f32(gps_imu_filter(&device), &jacobians.attached), "kq_attach_f32");
    run(&n, count);
    note_smoothed(rows, truths[0], &tape, N);
    need_no_events(gps_imu_filter(&device), &tape, 0);
    print_records(names, N, seconds, rows, STEPS);
}
