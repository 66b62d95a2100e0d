/* The model of the suites that show what decides conditions, and a filter, a recording and others for it */
#ifndef KALMANQ_TESTS_CONDITIONS_H
#define KALMANQ_TESTS_CONDITIONS_H

#include "models.h"
#include "unchanged.h"

enum { STEPS = 4 };

static process_model motion, other;
static sensor_model radar, coupled, lean;
static prior_model prior;
S_FILTER(track, 2);
S_FILTER(twin, 2);
S_HISTORY(tape, 2, 2, STEPS, STEPS);
S_DIFFUSE(start, 2, 0);
S_JACOBIANS(kept, tape, 2, 2, 2);

static const num range[] = {100, 100}, drive_range[] = {5}, measured_range[] = {100, 100};
static const num A[] = {1, 0.5, 0, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1}, r[] = {0.5, 1};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1}, z_value[] = {3, 1};
static word z[2], u[1];

static inline void begin_conditions(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_process(&other, 2, 0, range, NULL, A, NULL, Q);
    put_independent(&radar, 2, 2, range, measured_range, H, r);
    put_sensor(&coupled, 2, 2, range, measured_range, H, R);
    put_independent(&lean, 2, 2, range, measured_range, H, r);
    ASSERT_OK(init_lean(&lean, r));
    put_prior(&prior, 2, range, x0, P0);
    ASSERT_OK(S(filter_assign)(&track, 2, track_memory, COUNT(track_memory)));
    ASSERT_OK(S(filter_assign)(&twin, 2, twin_memory, COUNT(twin_memory)));
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(S(diffuse_assign)(&start, 2, 0, start_memory, COUNT(start_memory)));
    memcpy(z, measured(&radar.sensor, z_value), sizeof z);
    memset(u, 0, sizeof u);
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(motion.process), WATCH(radar.sensor), WATCH(tape);
}

#endif
