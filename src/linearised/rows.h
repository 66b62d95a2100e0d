/* What predicts by sigma points share with linearised ones, compiled once for a program. */
#ifndef KQ_SRC_LINEARISED_ROWS_H
#define KQ_SRC_LINEARISED_ROWS_H

#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/scaled.h"
#include "../model/types.h"

/* May p linearised predict f?  All that can be said before its increment is known. */
kq_status T(kq_predict_check)(const filter *f, const process *p);

/* Are they ready, and s for f? */
kq_status T(kq_update_check)(const filter *f, const sensor *s);

/* root <- tria [rows, G], G the root of p's noise, in floating point.  rows: n x n, not kept; pq: 2 n.  Answers
   how far it reaches. */
extent T(kq_root_of_rows)(num *root, num *rows, const process *p, num *pq);

/* Ends a predict, the root being predicted: x <- x + d, and what is not representable is held.  Answers the
   events, which have been told. */
unsigned T(kq_predict_end)(filter *f, const num *d, extent of_root);

/* The update by a sensor whose rows are S'h, its components independent, and the innovation e, in floating point:
   that of a state of mean 0 and root I, by which S is multiplied.  own: FILTER_LEN(n) words, of that state */
kq_status T(kq_update_by_rows)(filter *f, const sensor *s, const num *e, num *own);

#endif
