/*
 * track: 4 states, 2 measurements, 0 controls, in f32.
 *
 *     track_init();                           once
 *     track_update(z, TRACK_ALL);             the first sample
 *     track_step(z, TRACK_ALL);               each other one
 *     kq_mean_f32(track_filter(), TRACK_X)    what it says
 *
 *                    name   unit
 *     state 0        x      m
 *     state 1        vx     m/s
 *     state 2        y      m
 *     state 3        vy     m/s
 *     measurement 0  east   m
 *     measurement 1  north  m
 *
 * Expected on Cortex-M4F: 662 instructions a step, 12756 bytes of flash
 * and 264 of RAM beside a program without a filter, 392 of stack; means within
 * 0.0001 sigma of double's, 1e-05 in the mean square.
 */
#ifndef KALMANQ_DESIGN_TRACK_H
#define KALMANQ_DESIGN_TRACK_H

#include <stdint.h>

#include <kalmanq/kalmanq.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    TRACK_X,
    TRACK_VX,
    TRACK_Y,
    TRACK_VY,
    TRACK_STATES
};

enum {
    TRACK_Z_EAST,
    TRACK_Z_NORTH,
    TRACK_MEASUREMENTS
};

/* present: all measurements */
#define TRACK_ALL UINT32_C(0x3)

/* The declared ranges, in units: |value| <= range */
#define TRACK_X_RANGE 20000.0f
#define TRACK_VX_RANGE 200.0f
#define TRACK_Y_RANGE 20000.0f
#define TRACK_VY_RANGE 200.0f
#define TRACK_Z_EAST_RANGE 20000.0f
#define TRACK_Z_NORTH_RANGE 20000.0f

/** Before the first sample. */
kq_status track_init(void);

/** To the next sample. */
kq_status track_predict(void);

/** Takes what is present of a sample, a bit for each measurement. */
kq_status track_update(const float z[2], uint32_t present);

/** Predict and update.  Where the update is refused, the predict stands. */
kq_status track_step(const float z[2], uint32_t present);

/** For the library's readings: kq_mean_f32(track_filter(), ...), kq_sigma_f32, ... */
kq_filter_f32 *track_filter(void);

#ifdef __cplusplus
}
#endif

#endif
