/* A target that passes a sensor of range and bearing, and range_bearing.h.
 * Options: iterated, extended or points; sharp: 0.1 mm and 1e-6 rad in the place of 20 mm and 0.001 rad. */
#include "range_bearing.h"
#include "simulation.h"

#include <math.h>
#include <string.h>

enum { N = 4, M = 2, STEPS = 60 };

typedef enum { ITERATED, EXTENDED, BY_POINTS } method;

typedef struct {
    method by;
    float sigma[M];
} setting;

static const double x0[N] = {-150, 20, 5, 0}, sigma0[N] = {5, 5, 1, 1};
static range_bearing_device device;
KQ_HISTORY_F32(tape, N, M, STEPS, 0); /* the process is linear and constant */
static float work[KQ_SIGMA_POINTS_LEN(N, M)];
static record rows[STEPS];
static double truths[STEPS][N];

static void start(double x[N], noise *n)
{
    for (int i = 0; i < N; i++) x[i] = x0[i] + sigma0[i] * noise_next(n);
}

/* A second with a white acceleration of 0.05 m^2/s^3 on each axis: what it does to speed and position */
static void move(double x[N], noise *n)
{
    for (int i = 0; i < 2; i++) {
        const double speed = sqrt(0.05) * noise_next(n);
        x[i] += x[2 + i] + speed / 2 + sqrt(0.05 / 12) * noise_next(n);
        x[2 + i] += speed;
    }
}

static kq_status update(const float z[M], method by)
{
    kq_filter_f32 *f = range_bearing_filter(&device);
    range_bearing_row row = {z};
    float e[M];
    if (by == ITERATED) return range_bearing_update(&device, z);
    if (by == BY_POINTS) {
        return kq_update_sigma_points_f32(f, &device.sensor, range_bearing_point_innovation, &row,
                                          KQ_SIGMA_POINTS_CUBATURE, work);
    }
    const kq_status status = range_bearing_innovation(&device, z, e);
    return status ? status : kq_update_f32(f, &device.sensor, e);
}

static void measure(const double x[N], const setting *s, noise *n)
{
    const double range = sqrt(x[0] * x[0] + x[1] * x[1]) + (double)s->sigma[0] * noise_next(n);
    const double bearing = atan2(x[1], x[0]) + (double)s->sigma[1] * noise_next(n);
    const float z[] = {(float)range, (float)remainder(bearing, 2 * 3.14159265358979323846)};
    need(update(z, s->by), "update");
}

static void run(const setting *s, noise *n)
{
    double x[N];
    start(x, n);
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) {
            move(x, n);
            need(range_bearing_predict(&device), "range_bearing_predict");
        }
        measure(x, s, n);
        memcpy(truths[t], x, sizeof x);
        note(rows + t, FILTERED, x, range_bearing_filter(&device), N);
    }
}

static setting setting_of(int count, char **options)
{
    setting s = {ITERATED, {0.02f, 0.001f}};
    for (int k = 0; k < count; k++) {
        if (strcmp(options[k], "extended") == 0) s.by = EXTENDED;
        else if (strcmp(options[k], "points") == 0) s.by = BY_POINTS;
        else if (strcmp(options[k], "sharp") == 0) s.sigma[0] = 1e-4f, s.sigma[1] = 1e-6f;
        else if (strcmp(options[k], "iterated") != 0) {
            refuse(options[k], "iterated, extended, points, sharp");
        }
    }
    return s;
}

void simulate(uint64_t seed, int count, char **options)
{
    static const char *const names[] = {"east_m", "north_m", "east_m_s", "north_m_s"};
    const setting s = setting_of(count, options);
    const float r[] = {s.sigma[0] * s.sigma[0], s.sigma[1] * s.sigma[1]};
    noise n = {seed};
    need(range_bearing_start(&device), "range_bearing_start");
    need(kq_sensor_init_diagonal_extended_f32(&device.sensor, device.H, r), "the noise");
    need(kq_attach_f32(range_bearing_filter(&device), &tape.attached), "kq_attach_f32");
    run(&s, &n);
    note_smoothed(rows, truths[0], &tape, N);
    need_no_events(range_bearing_filter(&device), &tape, 0);
    print_records(names, N, 1, rows, STEPS);
}
