/* A vehicle on a winding road, its IMU and GPS receiver, and gps_imu.h.  Option: points. */
#include "gps_imu.h"
#include "simulation.h"

#include <math.h>
#include <string.h>

enum { N = GPS_IMU_STATES, STEPS = GPS_IMU_STEPS };

static const double seconds = 0.1;
static const double x0[N] = {500, -300, 10, 0.5, 0, 0}, sigma0[N] = {2, 2, 1, 0.2, 0.1, 0.01};
static record rows[STEPS];
static double truths[STEPS][N];

static void start(double x[N], noise *n)
{
    for (int i = 0; i < N; i++) x[i] = x0[i] + sigma0[i] * noise_next(n);
}

/* 0.1 s pass; what the IMU says of them. */
static void move(double x[N], int t, noise *n, float *acceleration, float *rate)
{
    const double push = 0.5 * cos(0.05 * t), turn = 0.2 * sin(0.02 * t);
    *acceleration = (float)(push + x[4] + 0.1 * noise_next(n));
    *rate = (float)(turn + x[5] + 0.01 * noise_next(n));
    x[0] += seconds * x[2] * cos(x[3]) + 1e-3 * noise_next(n);
    x[1] += seconds * x[2] * sin(x[3]) + 1e-3 * noise_next(n);
    x[2] += seconds * push;
    x[3] += seconds * turn;
    x[4] += 1e-4 * noise_next(n);
    x[5] += 1e-5 * noise_next(n);
}

static void locate(const double x[N], noise *n)
{
    float position[2];
    for (int i = 0; i < 2; i++) position[i] = (float)(x[i] + 2 * noise_next(n));
    need(gps_imu_locate(position), "gps_imu_locate");
}

static void run(noise *n)
{
    double x[N];
    float acceleration, rate, mean[N], P[N * N];
    start(x, n);
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) {
            move(x, t - 1, n, &acceleration, &rate);
            need(gps_imu_move(acceleration, rate), "gps_imu_move");
        }
        if (t % 10 == 0) locate(x, n);
        memcpy(truths[t], x, sizeof x);
        need(gps_imu_read(mean, P), "gps_imu_read");
        note(rows + t, FILTERED, x, mean, P, N);
    }
}

void simulate(uint64_t seed, int count, char **options)
{
    static const char *const names[] = {"east_m",      "north_m",     "speed_m_s",
                                        "heading_rad", "bias_a_m_s2", "bias_w_rad_s"};
    noise n = {seed};
    float from[N], mean[N], P[N * N];
    if (count > 1 || (count == 1 && strcmp(options[0], "points") != 0)) {
        refuse(options[count - 1], "points, or nothing");
    }
    for (int i = 0; i < N; i++) from[i] = (float)x0[i];
    need(gps_imu_start(from, count), "gps_imu_start");
    run(&n);
    need(gps_imu_smooth(), "gps_imu_smooth");
    for (int t = 0; t < STEPS; t++) {
        need(gps_imu_read_smoothed((size_t)t, mean, P), "gps_imu_read_smoothed");
        note(rows + t, SMOOTHED, truths[t], mean, P, N);
    }
    need_no_events(gps_imu_events());
    print_records(names, N, seconds, rows, STEPS);
}
