/*
 * The sensor: what one scalar measurement of it is.
 *
 * A correlated R = U D U', U unit upper triangular, is decorrelated by M = U^-1: the
 * components of M z have independent noises D_c.  M's strict upper part and, on its diagonal,
 * D are packed as one triangle, `noise`; for independent components it is their variances.
 */
#ifndef KQ_SRC_MODEL_SENSOR_H
#define KQ_SRC_MODEL_SENSOR_H

#include "twins.h"

typedef struct T(kq_sensor_kind) sensor_kind;
struct T(kq_loss); /* kalmanq/robust.h */

KQ_INLINE kq_status sensor_check(const sensor *s)
{
    if (!s) return KQ_ERR_NULL;
    return s->noise ? KQ_OK : KQ_ERR_NOT_READY;
}

/* Does row h take one state alone, as it is?  1 + that state, or 0 */
KQ_COLD static int selected_state(const scaled *h, int n)
{
    int selected = 0;
    for (int k = 0; k < n; k++) {
        if (scaled_is_zero(h[k])) continue;
        if (selected || !scaled_is_unit(h[k])) return 0;
        selected = k + 1;
    }
    return selected;
}

KQ_COLD static void sensor_set_measurement(sensor *s, const scaled *H)
{
    const int n = s->states;
    for (int c = 0; c < s->components; c++) s->selects[c] = (uint8_t)selected_state(H + c * n, n);
    s->measurement = H;
    s->seal = 0;
}

/* Unit upper triangular U -> U^-1, in place; the diagonal is left alone. */
KQ_COLD static void invert_unit(scaled *U, int m)
{
    for (int j = 1; j < m; j++) {
        for (int i = 0; i < j; i++) {
            scaled total = U[column(j) + i];
            for (int k = i + 1; k < j; k++) {
                total = scaled_plus(total, scaled_times(U[column(k) + i], U[column(j) + k]));
            }
            U[column(j) + i] = scaled_negative(total);
        }
    }
}

/* A measurement on its way into a filter */
typedef struct {
    const sensor *sensor;
    const scaled *noise; /* the sensor's, or that of the components present alone */
    const num *z;
    uint32_t present; /* bit c: component c was measured */
} reading;

/* What is done for a sensor, by reference, from its init: a program does not link what its sensors do
   not need.  The first is the whole of an update that has been checked; the other functions are of
   correlated components alone. */
struct T(kq_sensor_kind) {
    kq_status (*take)(filter *f, const sensor *s, const num *z, uint32_t present);
    /* What has rounding done to a reading that a step of compile-time sizes has taken?  NULL where nobody looks. */
    void (*watch)(filter *f, const sensor *s);
    const scaled *(*row)(const reading *z, int c, scaled *buffer);
    void (*row_sizes)(const reading *z, int c, scaled *sizes);
    scaled (*innovation)(const filter *f, const reading *z, int c);
    uint8_t plain;             /* do the steps of compile-time sizes take it? */
    uint8_t takes_innovations; /* is it the beginning of an innovation_kind? */
};

extern const sensor_kind T(kq_sensor_independent), T(kq_sensor_lean), T(kq_sensor_correlated);

/* An update that has been checked, by a robust loss or by NULL */
typedef void checked_update(filter *f, const sensor *s, const num *z, uint32_t present, struct T(kq_loss) *loss);

/* The kind of a sensor that takes innovations (linearised/innovation.h) */
typedef struct {
    sensor_kind kind;
    const sensor_kind *base; /* what its updates do with a measurement */
    /* Sets the mean aside, has `update` take e, and moves the mean.  KQ_ERR_RECORDING: nothing has changed. */
    kq_status (*around)(filter *f, const sensor *s, const num *e, uint32_t present, checked_update *update,
                        struct T(kq_loss) *loss);
} innovation_kind;

extern const innovation_kind T(kq_sensor_correlated_extended);

KQ_INLINE int takes_innovations(const sensor *s) { return s->kind->takes_innovations; }

static const innovation_kind *innovation_kind_of(const sensor *s) { return (const innovation_kind *)s->kind; }

/* What is done with a measurement, or with an innovation once the mean is set aside */
static const sensor_kind *base_kind(const sensor *s)
{
    return takes_innovations(s) ? innovation_kind_of(s)->base : s->kind;
}

/* What the steps of compile-time sizes look at: is it of that kind, and no component free of noise? */
KQ_COLD static void sensor_set_plain(sensor *s)
{
    int plain = s->kind->plain;
    for (int c = 0; plain && c < s->components; c++) plain = noise_is_ordinary(s->noise[c]);
    s->plain = (uint16_t)(plain ? s->states | s->components << 8 : 0);
}

/* How it is taken.  GENERAL: as the library has it.  PLAIN, by the steps of compile-time sizes: nothing sharp came
   before the update, and there is no history.  BARE: no likelihood is kept either. */
enum { MODE_GENERAL, MODE_PLAIN, MODE_BARE };

/* The noise of one scalar measurement: decorrelated component c */
static inline scaled scalar_noise(const reading *z, int c)
{
    return sensor_is_correlated(z->sensor) ? z->noise[column(c) + c] : z->noise[c];
}

/* The row of H of decorrelated component c, built in `buffer` (n) */
KQ_COLD static const scaled *correlated_row(const reading *z, int c, scaled *buffer)
{
    const sensor *s = z->sensor;
    const int n = s->states;
    const scaled *row = s->measurement + c * n;
    for (int k = 0; k < n; k++) buffer[k] = row[k];
    for (int j = c + 1; j < s->components; j++) {
        if (!(z->present >> j & 1)) continue;
        for (int k = 0; k < n; k++) {
            const scaled part = scaled_times(z->noise[column(j) + c], s->measurement[j * n + k]);
            buffer[k] = scaled_plus(buffer[k], part);
        }
    }
    return buffer;
}

/* The sizes of the terms of that row, added up */
KQ_COLD static void correlated_row_sizes(const reading *z, int c, scaled *sizes)
{
    const sensor *s = z->sensor;
    const int n = s->states;
    for (int k = 0; k < n; k++) sizes[k] = scaled_magnitude(s->measurement[c * n + k]);
    for (int j = c + 1; j < s->components; j++) {
        if (!(z->present >> j & 1)) continue;
        for (int k = 0; k < n; k++) {
            const scaled part = scaled_times(z->noise[column(j) + c], s->measurement[j * n + k]);
            sizes[k] = scaled_plus(sizes[k], scaled_magnitude(part));
        }
    }
}

/* Row c of H, in place for independent components */
static const scaled *scalar_row(const reading *z, int c, scaled *buffer)
{
    const sensor *s = z->sensor;
    if (sensor_is_correlated(s)) return s->kind->row(z, c, buffer);
    return s->measurement + c * s->states;
}

#endif
