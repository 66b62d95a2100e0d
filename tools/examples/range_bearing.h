/*
 * The track of a target that passes 20 m from a sensor of range and bearing, every second.
 *
 *     x = (east, north, and their speeds), of the sensor: m, m/s; it moves straight on, but for white accelerations
 *     z = (range, bearing): m, rad from east to north, -pi .. pi
 *
 * The motion is linear: it takes the plain kq_predict, and an ordinary history records it.  The bearing's innovation
 * is wrapped.  Where the sensor is sharp beside what was known the update is iterated, or its sigma says far less
 * than the error (sigma_points.h); sigma points are the third way.
 */
#ifndef RANGE_BEARING_H
#define RANGE_BEARING_H

#include <kalmanq/sigma_points.h>

enum {
    RANGE_BEARING_STATES = 4,
    RANGE_BEARING_STEPS = 60 /* that the tape has room for */
};

typedef enum { TRACK_EXTENDED, TRACK_ITERATED, TRACK_BY_POINTS } track_method;

/** x0 is known to 5 m and 1 m/s (1 sigma).
 *   sigma    of a range in m and a bearing in rad */
kq_status track_start(const float x0[RANGE_BEARING_STATES], const float sigma[2],
                      track_method method);

/** A second has passed. */
kq_status track_move(void);

/** A range and a bearing.  KQ_ERR_NOT_FINITE: the mean is the sensor's own place, where no bearing is. */
kq_status track_measure(const float z[2]);

/** The state now: its mean and its covariance, row by row. */
kq_status track_read(float mean[RANGE_BEARING_STATES], float P[RANGE_BEARING_STATES * RANGE_BEARING_STATES]);

/** Ends the recording; then each step of it, 0 the start, given all measurements. */
kq_status track_smooth(void);
kq_status track_read_smoothed(size_t step, float mean[RANGE_BEARING_STATES],
                                 float P[RANGE_BEARING_STATES * RANGE_BEARING_STATES]);

/** KQ_EVENT_... of the run and of the smoother: 0 is as it should be. */
unsigned track_events(void);

#endif
