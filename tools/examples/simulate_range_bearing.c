/* A target that passes a sensor of range and bearing, and range_bearing.h.
 * Options: extended, iterated or points; sharp: 0.1 mm and 1e-6 rad in the place of 0.5 m and 0.02 rad. */
#include "range_bearing.h"
#include "simulation.h"

#include <math.h>
#include <string.h>

enum { N = RANGE_BEARING_STATES, M = 2, STEPS = RANGE_BEARING_STEPS };

static const double x0[N] = {-20, -150, 0, 5}, sigma0[N] = {5, 5, 1, 1};
static record rows[STEPS];
static double truths[STEPS][N];

typedef struct {
    track_method method;
    float sigma[M];
} setting;

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

static void measure(const double x[N], const setting *s, noise *n)
{
    const double range = sqrt(x[0] * x[0] + x[1] * x[1]) + (double)s->sigma[0] * noise_next(n);
    const double bearing = atan2(x[1], x[0]) + (double)s->sigma[1] * noise_next(n);
    const float z[] = {(float)range, (float)remainder(bearing, 2 * 3.14159265358979323846)};
    need(track_measure(z), "track_measure");
}

static void run(const setting *s, noise *n)
{
    double x[N];
    float mean[N], P[N * N];
    start(x, n);
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) {
            move(x, n);
            need(track_move(), "track_move");
        }
        measure(x, s, n);
        memcpy(truths[t], x, sizeof x);
        need(track_read(mean, P), "track_read");
        note(rows + t, FILTERED, x, mean, P, N);
    }
}

static setting setting_of(int count, char **options)
{
    setting s = {TRACK_EXTENDED, {0.5f, 0.02f}};
    for (int k = 0; k < count; k++) {
        if (strcmp(options[k], "iterated") == 0) s.method = TRACK_ITERATED;
        else if (strcmp(options[k], "points") == 0) s.method = TRACK_BY_POINTS;
        else if (strcmp(options[k], "sharp") == 0) s.sigma[0] = 1e-4f, s.sigma[1] = 1e-6f;
        else if (strcmp(options[k], "extended") != 0) {
            refuse(options[k], "extended, iterated, points, sharp");
        }
    }
    return s;
}

void simulate(uint64_t seed, int count, char **options)
{
    static const char *const names[] = {"east_m", "north_m", "east_m_s", "north_m_s"};
    const setting s = setting_of(count, options);
    noise n = {seed};
    float from[N], mean[N], P[N * N];
    for (int i = 0; i < N; i++) from[i] = (float)x0[i];
    need(track_start(from, s.sigma, s.method), "track_start");
    run(&s, &n);
    need(track_smooth(), "track_smooth");
    for (int t = 0; t < STEPS; t++) {
        need(track_read_smoothed((size_t)t, mean, P), "track_read_smoothed");
        note(rows + t, SMOOTHED, truths[t], mean, P, N);
    }
    need_no_events(track_events());
    print_records(names, N, 1, rows, STEPS);
}
