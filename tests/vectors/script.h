/*
 * A case while it is made: operations are appended, carried out, and what comes out of them is
 * appended too.  Host only.
 */
#ifndef KALMANQ_SCRIPT_H
#define KALMANQ_SCRIPT_H

#include <kalmanq/prepare.h>
#include <stdint.h>

/** A model and the ranges of its components, as the user of the library has them. */
typedef struct {
    int n, r, l, m;                            /* states, columns of F, controls, measurements */
    double A[16 * 16], B[16 * 16], F[16 * 16]; /* x[t+1] = A x + B u + F w, w ~ N(0, I) */
    double H[16 * 16], C[16 * 16];             /* z = H x + C v, v ~ N(0, I) */
    double x0[16], P0[16];                     /* of the prior: mean, variances */
    double state_range[16], control_range[16], measurement_range[16];
} model;

/** The true state of a simulation and its source of noise */
typedef struct {
    double x[16];
    uint64_t seed;
} truth;

/** Writes DIRECTORY/NAME.inc: begins a case, and ends it. */
void script_begin(const char *directory, const char *name, const char *title);
void script_end(void);

/** One operation: its inputs, one array after the other, then `act`. */
void script_words(const int32_t *words, int count);
void script_word(int32_t word);
void script_act(int32_t operation);

/** Parts of an operation: a number; controls of one step, u NULL for none; a measurement. */
void script_number(double value);
void script_controls(const model *M, const double *u);
void script_reading(const model *M, const double *z);
void script_state(const model *M, const double *x); /* n words of the states' formats */
void script_distribution(const model *M); /* the prior's mean and root */

/** The filter's mean, as it came out of an operation last. */
void script_mean(const model *M, double *x);

/** Formats, then process, sensor and prior of a model, into their slots. */
void script_states(const model *M);
void script_process(const model *M, int slot);
void script_sensor(const model *M, int slot);
void script_prior(const model *M);

/** Only what changes: another A, another H. */
void script_transition(const model *M, int slot);
void script_measurement(const model *M, int slot);
void script_transition_by(const model *M, int slot, int32_t operation);
void script_measurement_by(const model *M, int slot, int32_t operation);

/** Operations on the filter; u and z in physical units, u NULL for none. */
void script_history(int words);
void script_predict(const model *M, int slot, const double *u);
void script_update(const model *M, int slot, const double *z, int present);
void script_step(const model *M, const double *u, const double *z);
void script_read(void);
void script_look(const model *M, int slot, const double *z);
void script_forecast(const model *M, int steps, const double *u);
void script_smooth(int process, int what);
void script_smooth_all(int states_only);
void script_run(int process, int sensor, int steps, int32_t seed, int shift);

/** A simulation: the truth one step on, and a measurement of it. */
void truth_begin(truth *t, const model *M, uint64_t seed);
void truth_advance(truth *t, const model *M, const double *u);
void truth_measure(truth *t, const model *M, double *z);

#endif
