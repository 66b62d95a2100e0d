/*
 * A run of everything that can happen between two predicts: several sensors, components missing, no
 * measurement at all, processes that take turns, controls.  For what smooths it on line, beside the
 * same run on a tape.
 */
#ifndef KALMANQ_TESTS_DRIVE_H
#define KALMANQ_TESTS_DRIVE_H

#include "reading.h"

#define STEPS 12
#define MOST 3 /* scalar measurements of one step */

PROCESS(motion, 2, 1);
PROCESS(other, 2, 1);
SENSOR(radar, 2, 2);
SENSOR(compass, 2, 1);
FILTER(track, 2);
FILTER(twin, 2);
HISTORY(tape, 2, MOST, STEPS, STEPS);

static const num A[] = {1, 0.5, -0.25, 0.75}, B[] = {0.125, 0.5};
static const num A2[] = {0.5, 0.25, 0, 1}, Q2[] = {1, 0, 0, 0};
static const num Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const num direction[] = {-1, 0.25}, variance[] = {0.125};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

static inline void begin_drive(void)
{
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    ASSERT_OK(K(process_init)(&other, A2, B, Q2));
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    ASSERT_OK(K(sensor_init)(&compass, direction, variance));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
}

/* By turns: radar; nothing; one component of the radar; radar and compass; compass twice */
static inline void measure(K(filter) * f, int step)
{
    const num z[] = {N(3 * ((step * 7) % 5 - 2)), N(0.5 * ((step * 11) % 7 - 3))};
    const int kind = step % 5;
    if (kind == 0 || kind == 3) ASSERT_OK(K(update)(f, &radar, z));
    if (kind == 2) ASSERT_OK(K(update_subset)(f, &radar, z, 2));
    for (int k = 0; k < (kind == 4 ? 2 : kind == 3); k++) ASSERT_OK(K(update)(f, &compass, z + k));
}

static inline const K(process) * process_of(int step) { return step % 3 ? &motion : &other; }

static inline const num *control_of(int step)
{
    static num u;
    u = N(0.5 * (step % 4) - 1);
    return step % 6 ? &u : NULL;
}

/* What is known of each step given all measurements up to `last`, that one's included: on the tape
 */
static inline void smooth_to(int last)
{
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(K(attach)(&twin, &tape.attached));
    for (int step = 0; step <= last; step++) {
        if (step) ASSERT_OK(K(predict)(&twin, process_of(step), control_of(step)));
        measure(&twin, step);
    }
    ASSERT_OK(K(smooth)(&tape));
}

#endif
