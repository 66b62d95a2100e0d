/* The twins that an arithmetic chooses.  An instance has included its own; an editor that looks at a header by
   itself sees float. */
#ifndef KQ_SRC_ARITHMETIC_TWINS_H
#define KQ_SRC_ARITHMETIC_TWINS_H

#ifndef T
#include "f32.h"
#endif
#if KQ_FLOATING
#include "scaled_float.h"
#include "rows_float.h"
#include "mending_float.h"
#include "mean_float.h"
#include "saturate_float.h"
#include "rotor_float.h"
#include "reflector_float.h"
#include "coordinates_float.h"
#include "maps_float.h"
#include "gains_float.h"
#include "scores_float.h"
#else
#include "scaled_q31.h"
#include "rows_q31.h"
#include "mending_q31.h"
#include "mean_q31.h"
#include "saturate_q31.h"
#include "rotor_q31.h"
#include "reflector_q31.h"
#include "coordinates_q31.h"
#include "maps_q31.h"
#include "gains_q31.h"
#include "scores_q31.h"
#endif

#endif
