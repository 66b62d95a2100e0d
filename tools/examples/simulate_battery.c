/* A cell that is discharged in pulses, its voltmeter, and battery.h. */
#include "battery.h"
#include "simulation.h"

#include <math.h>
#include <string.h>

enum { N = 2, STEPS = 200 };

static battery_device device;
KQ_HISTORY_F32(tape, N, 1, STEPS, 0); /* the process is linear and constant */

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
    float before = 0;
    start(x, n);
    for (int t = 0; t < STEPS; t++) {
        const float current = (float)current_at(t);
        if (t > 0) {
            move(x, current_at(t - 1), n);
            need(battery_predict(&device, &before), "battery_predict");
        }
        const float voltage = (float)voltage_of(x, current_at(t), n);
        need(battery_update(&device, &voltage, &current), "battery_update");
        before = current;
        memcpy(truths[t], x, sizeof x);
        note(rows + t, FILTERED, x, battery_filter(&device), N);
    }
}

void simulate(uint64_t seed, int count, char **options)
{
    static const char *const names[] = {"charge", "polarisation_V"};
    noise n = {seed};
    if (count > 0) refuse(options[0], "no option");
    need(battery_start(&device), "battery_start");
    need(kq_attach_f32(battery_filter(&device), &tape.attached), "kq_attach_f32");
    run(&n);
    note_smoothed(rows, truths[0], &tape, N);
    need_no_events(battery_filter(&device), &tape, 0);
    print_records(names, N, seconds, rows, STEPS);
}
