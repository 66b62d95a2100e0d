/*
 * What the simulations of the examples share: noise from a seed, and what was true beside what was estimated, as
 * CSV.  Nothing of it goes into firmware.
 */
#ifndef SIMULATION_H
#define SIMULATION_H

#include <kalmanq/extended.h>
#include <stdint.h>

/** A run with the noise of `seed`.
 *   options   `count` words of the command line behind the seed
 * Prints the CSV; ends the program where anything is refused. */
void simulate(uint64_t seed, int count, char **options);

/** Normal numbers, mean 0 and variance 1.  Any state is a seed. */
typedef struct {
    uint64_t state;
} noise;

double noise_next(noise *n);

enum { QUANTITIES_MAX = 6 };
enum { FILTERED, SMOOTHED };

/** A step: what was true and what was estimated of each quantity, and e' P^-1 e / n of the states' errors e. */
typedef struct {
    double truth[QUANTITIES_MAX];
    double mean[2][QUANTITIES_MAX], sigma[2][QUANTITIES_MAX];
    double nees[2];
} record;

/** Ends the program with exit status 1 and a line that says what went wrong, if anything did.
 *   f, tape  the filter at the end of the run, and its smoothed history
 *   usual    KQ_EVENT_... that are as they should be */
void need(kq_status status, const char *what);
void need_no_events(const kq_filter_f32 *f, const kq_history_f32 *tape, unsigned usual);

/** Ends the program with exit status 2: `word` is none of the command line's. */
void refuse(const char *word, const char *wanted);

/** e' P^-1 e / n.
 *   P        n x n, a covariance
 *   e        n
 * Ends the program where P is not positive definite. */
double nees_of(const float *P, const double *e, int n);

/** A row of quantities that are the states.
 *   kind     FILTERED or SMOOTHED
 *   truth    n, written to the row with mean, sigma and NEES
 *   f        the filter, or a view of a smoothed step */
void note(record *row, int kind, const double *truth, const kq_filter_f32 *f, int n);

/** Smooths what is recorded, and notes all its steps.
 *   truths   n of each step */
void note_smoothed(record *rows, const double *truths, kq_history_f32 *tape, int n);

/** All rows: step, time, then five columns of each quantity: NAME_truth, _filtered, _filtered_sigma, _smoothed,
 * _smoothed_sigma; nees_filtered, nees_smoothed.
 *   names    `count` of them, with their units */
void print_records(const char *const *names, int count, double seconds, const record *rows,
                   int steps);

#endif
