/* The twins that an arithmetic chooses: likelihoods, and what a prior may be. */
#ifndef KQ_SRC_FILTER_TWINS_H
#define KQ_SRC_FILTER_TWINS_H

#include "../model/model.h"
#if KQ_FLOATING
#include "likelihood_float.h"
#include "prior_float.h"
#else
#include "likelihood_q31.h"
#include "prior_q31.h"
#endif

#endif
