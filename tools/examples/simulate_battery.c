/* A cell that is discharged in pulses, its voltmeter, and battery.h. */
#include "battery.h"
#include "simulation.h"

#include <math.h>
#include <string.h>

enum { N = BATTERY_STATES, STEPS = BATTERY_STEPS };

static const double seconds = 10;
static record rows[STEPS];
static double truths[STEPS][N];

static double current_at(int t) { return t % 40 < 30 ? 2 * (1 + sin(0.1 * t)) : 0; }

static void start(double x[N], noise *n)
{
    x[0] = 0.8 + 0.1 * noise_next(n);
    x[1] = 0.01 * noise_next(n);
}

static void move(double x[N], double current, noise *n)
{
    const double decay = exp(-seconds / 60);
    x[0] += -seconds * current / 9000 + 1e-5 * noise_next(n);
    x[1] = decay * x[1] + (1 - decay) * 0.02 * current + 1e-4 * noise_next(n);
}

static double voltage_of(const double x[N], double current, noise *n)
{
    const double s = x[0], ocv = 3.3 + 0.9 * s - 0.15 * exp(-20 * s) + 0.1 * sin(6 * s);
    return ocv - x[1] - 0.03 * current + 0.01 * noise_next(n);
}

static void run(noise *n)
{
    double x[N];
    float mean[N], P[N * N];
    start(x, n);
    for (int t = 0; t < STEPS; t++) {
        const float current = (float)current_at(t);
        if (t > 0) {
            move(x, current_at(t - 1), n);
            need(battery_discharge((float)current_at(t - 1)), "battery_discharge");
        }
        need(battery_measure((float)voltage_of(x, current_at(t), n), current), "battery_measure");
        memcpy(truths[t], x, sizeof x);
        need(battery_read(mean, P), "battery_read");
        note(rows + t, FILTERED, x, mean, P, N);
    }
}

void simulate(uint64_t seed, int count, char **options)
{
    static const char *const names[] = {"charge", "polarisation_V"};
    noise n = {seed};
    float mean[N], P[N * N];
    if (count > 0) refuse(options[0], "no option");
    need(battery_start(), "battery_start");
    run(&n);
    need(battery_smooth(), "battery_smooth");
    for (int t = 0; t < STEPS; t++) {
        need(battery_read_smoothed((size_t)t, mean, P), "battery_read_smoothed");
        note(rows + t, SMOOTHED, truths[t], mean, P, N);
    }
    need_no_events(battery_events());
    print_records(names, N, seconds, rows, STEPS);
}
