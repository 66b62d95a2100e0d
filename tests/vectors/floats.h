/*
 * The operations of f32 and f64 (VECTOR_F32, VECTOR_F64; one text): runs of a model of given size, each of which answers a
 * digest for each quantity.  What is computed by an operation is here; that it is the same bits, vector.h.
 *   VECTOR_TOPICS          which of them there are: 1 the filter, 2 beyond it, 4 nonlinear runs
 *   VECTOR_PRINT           prints every word and the digest of every step, so that two machines can be compared by diff
 *   KQ_FALSIFY_MODEL       the model is wrong in its last bits: every operation must be found to differ
 */
#ifndef KALMANQ_FLOATS_H
#define KALMANQ_FLOATS_H

#include "floats_model.h"

#define LENGTH(memory) (sizeof memory / sizeof memory[0])

/* What every run has */
extern model M;
extern num scale; /* of states and measurements */
extern K(process) process;
extern K(sensor) sensor;
extern K(filter) filter;

/** Makes M, and gives process, sensor and filter its size. */
void make(const model_case *c);

void run_filter(const model_case *c);
void run_beyond(const model_case *c); /* on-line smoothers, steady states, robust steps, statistics, model builders */
void run_nonlinear(const model_case *c);

/** Bits that enter the digest */
void put_word(uint32_t word);
void put(num value);
void put_all(const num *values, int count);
void put_status(kq_status status);
void put_readings(const K(filter) * view, int n); /* mean, low, sigma */
K(filter) smoothed_view(const K(history) * h, size_t t); /* refused: it reads NaN */

/** The covariance with its status, and all that a filter says; P: n x n, where it is written */
void put_covariance(const K(filter) * view, int n, num *P);
void put_filter(const K(filter) * f, int n, num *P);

/** Adds the words since the last check to the digest of `quantity`, as its `step`. */
void check(const char *quantity, int step);

#endif
