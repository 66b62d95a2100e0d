/*
 * kalmanq: Kalman filtering, prediction and smoothing for small systems.  All of it; and the index.
 *
 * Every name ends in _f32 (float), _f64 (double) or _q31 (fixed point); each header has one comment for
 * the three.  Not every function is in every arithmetic: src/README.md has the table.
 *
 * What everyone needs
 *     status.h          what a call answers; the events that a filter remembers
 *     process.h         A, B, Q: how the state moves
 *     sensor.h          H, R: what is measured of it
 *     filter.h          the state: predict, update, step, readings, forecast; sharing and interrupts
 *     smoother.h        a history that is attached to a filter, and what it says of every past state
 *     size.h            how large things are, and what memory they take
 *
 * For q31, too
 *     fixed_point.h     words in a format of your choice, mantissas with exponents
 *     prepare.h         tables made from doubles
 *
 * While a filter runs (each is attached to it)
 *     lag.h             the state k steps ago, at every new measurement
 *     instant.h         one chosen instant, ever better known
 *     diffuse.h           components of which nothing is known at first
 *     adaptation.h      noises whose shape is known and not their size
 *     steady.h          a constant model: gains made beforehand; a filter that settles
 *
 * Nonlinear models
 *     extended.h        linearised by Jacobians of yours
 *     sigma_points.h    linearised by sigma points; iteration (f32, f64)
 *
 * Updates and steps of another kind
 *     robust.h          outliers and jumps
 *     least_squares.h   no process at all; old data that fade
 *
 * Models, and are they right?
 *     consistency.h     the innovations of the last updates, judged
 *     em.h              Q, R, A, H and the start estimated from records (f32, f64)
 *
 * And
 *     self_test.h       does this build compute as it should?
 *     lengths.h         sizes and lengths as functions, for bindings of other languages
 *     version.h         which release this is
 *     generic.h         names without a suffix (not included by this header)
 */
#ifndef KALMANQ_KALMANQ_H
#define KALMANQ_KALMANQ_H

#include "status.h"
#include "process.h"
#include "sensor.h"
#include "filter.h"
#include "smoother.h"
#include "size.h"

#include "fixed_point.h"
#include "prepare.h"

#include "instant.h"
#include "lag.h"
#include "diffuse.h"
#include "adaptation.h"
#include "steady.h"

#include "robust.h"
#include "least_squares.h"
#include "extended.h"
#include "sigma_points.h"

#include "consistency.h"
#include "em.h"

#include "lengths.h"
#include "self_test.h"
#include "version.h"

#endif
