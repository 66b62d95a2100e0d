/*
 * kalmanq: Kalman filtering, prediction and smoothing for small systems.  Includes all headers but generic.h and
 * sized.hpp.
 *
 * Every name ends in _f32 (float), _f64 (double) or _q31 (fixed point); one comment describes all three.  The table
 * in src/README.md says which function is in which arithmetic.  Thresholds, studies and sources of the methods are in
 * tests/ACCURACY.md.
 *
 *     status.h          statuses and events
 *     process.h         A, B, Q: how the state moves
 *     sensor.h          H, R: what is measured
 *     filter.h          the state: predict, update, step, readings, forecast; sharing and interrupts
 *     smoother.h        a history of a filter, and every past state given all measurements
 *     size.h            how large things are, and what memory they need
 *     fixed_point.h     q31: raw values in a format of your choice, mantissas with exponents
 *     prepare.h         q31: tables made from doubles
 * Attached to a filter while it runs
 *     lag.h             the state k steps ago, at every measurement; measurements that come late
 *     instant.h         one chosen instant, ever better known
 *     diffuse.h         states of which nothing is known at the start
 *     adaptation.h      noises whose size is learnt
 *     steady.h          a constant model: a gain made beforehand, a filter that freezes its gain
 * Nonlinear models
 *     extended.h        linearised by your Jacobians
 *     sigma_points.h    linearised by sigma points; iteration (f32, f64)
 * More
 *     robust.h          outliers and jumps
 *     least_squares.h   no process; forgetting of old data
 *     consistency.h     is the model right?  Tests of the last innovations
 *     em.h              Q, R, A, H and the start estimated from recordings (f32, f64)
 *     self_test.h       does this build compute as it should?
 *     lengths.h         sizes and lengths as functions, for bindings of other languages
 *     version.h         which release this is
 *     generic.h         names without a suffix
 *     sized.hpp         C++: sizes as template parameters (f32, f64)
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
