/* kalmanq: Kalman filtering, prediction and smoothing for small systems.  All of it. */
#ifndef KALMANQ_KALMANQ_H
#define KALMANQ_KALMANQ_H

#include "adaptation.h"
#include "consistency.h"
#include "em.h"
#include "filter.h"
#include "fixed_point.h"
#include "lag.h"
#include "least_squares.h"
#include "models.h"
#include "point.h"
#include "prepare.h"
#include "process.h"
#include "robust.h"
#include "self_test.h"
#include "sensor.h"
#include "size.h"
#include "smoother.h"
#include "start.h"
#include "status.h"
#include "steady.h"
#include "version.h"

#endif
