/*
 * Digests of an arithmetic's answers, one for each quantity of each case ("block"), compared with expected.inc; of
 * nonlinear runs, which are another program (nonlinear.c, KQ_BITS_NONLINEAR), with expected_nonlinear.inc.  Where a
 * block differs, the digests of its steps are printed.
 *   KQ_BITS_WORDS     prints every word and the digest of every step, so that two machines can be compared by diff
 *   KQ_BITS_WRITE     prints the digests, for regenerate.sh
 *   KQ_BITS_FILTER    filter and smoother alone, where flash has no room for the rest
 *   KQ_BITS_FALSIFY   the model is wrong in its last bits: every case must be found to differ
 */
#ifndef KALMANQ_BITS_DIGEST_H
#define KALMANQ_BITS_DIGEST_H

#include "number.h"

#ifdef KQ_BITS_FALSIFY
enum { FALSIFIED = 1 };
#else
enum { FALSIFIED = 0 };
#endif

/** A case, of which at least one digest must differ where the model is falsified. */
void digest_begin(const char *name);
void digest_end(void);

/** Bits that enter the digest */
void put_word(uint32_t word);
void put(num value);
void put_all(const num *values, int count);
void put_status(kq_status status);
void put_readings(const K(filter) * view, int n); /* mean, low, sigma */

/** The covariance with its status, and all that a filter says; P: n x n, where it is written */
void put_covariance(const K(filter) * view, int n, num *P);
void put_filter(const K(filter) * f, int n, num *P);

/** Adds the words since the last check to the block of `quantity`, as its `step`. */
void check(const char *quantity, int step);

/** Prints the outcome; returns whether it is bad.  Where not all is digested, the rest of the
    expected digests is left over. */
int digest_report(int is_all);

/** A number that is wrong by two or three of its last bits where models are falsified */
num digest_falsify(num value);

#endif
