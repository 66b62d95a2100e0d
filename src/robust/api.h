/* The public functions of updates and steps against outliers and jumps. */
#ifndef KQ_SRC_ROBUST_API_H
#define KQ_SRC_ROBUST_API_H

#include "gate.h"
#include "robust.h"
#include "student.h"

#endif
