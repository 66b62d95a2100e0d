/*
 * A run of everything that can happen between two predicts: several sensors, components missing, no
 * measurement at all, processes that take turns, controls.  For what smooths it on line, beside the
 * same run on a tape.
 */
#ifndef KALMANQ_TESTS_DRIVE_H
#define KALMANQ_TESTS_DRIVE_H

#include "models.h"

#define STEPS 14
#define MOST 3 /* scalar measurements of one step */

static process_model motion, other;
static sensor_model radar, compass;
static prior_model prior;
S_FILTER(track, 2);
S_FILTER(twin, 2);
S_HISTORY(tape, 2, MOST, STEPS, STEPS);

static const num range[] = {100, 100, 100}, drive_range[] = {5}, measured_range[] = {200, 100, 100};
static const num A[] = {1, 0.5, -0.25, 0.75}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num A2[] = {0.5, 0.25, 0, 1}, Q2[] = {1, 0, 0, 0};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const num direction[] = {-1, 0.25}, variance[] = {0.125};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

static inline void begin_drive(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_process(&other, 2, 1, range, drive_range, A2, B, Q2);
    put_sensor(&radar, 2, 2, range, measured_range, H, R);
    put_sensor(&compass, 2, 1, range, measured_range, direction, variance);
    put_prior(&prior, 2, range, x0, P0);
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
}

/* By turns: radar; nothing; one component of the radar; radar and compass; compass twice */
static inline void measure(S(filter) *f, int step)
{
    const num z[] = {N(3 * ((step * 7) % 5 - 2)), N(0.5 * ((step * 11) % 7 - 3))};
    const int turn = step % 5;
    if (turn == 0 || turn == 3) ASSERT_OK(S(update)(f, &radar.sensor, measured(&radar.sensor, z)));
    if (turn == 2) ASSERT_OK(S(update_subset)(f, &radar.sensor, measured(&radar.sensor, z), 2));
    for (int k = 0; k < (turn == 4 ? 2 : turn == 3); k++) {
        ASSERT_OK(S(update)(f, &compass.sensor, measured(&compass.sensor, z + k)));
    }
}

static inline const S(process) *process_of(int step) { return step % 3 ? &motion.process : &other.process; }

static inline const word *control_of(int step)
{
    static num u;
    u = N(0.5 * (step % 4) - 1);
    return step % 6 ? driven(&motion.process, &u, 1) : NULL;
}

/* The step with the number `step`, but for its last predict */
static inline void drive(S(filter) *f, int step)
{
    if (step) ASSERT_OK(S(predict)(f, process_of(step), control_of(step)));
    measure(f, step);
}

#endif
