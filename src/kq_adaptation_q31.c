/* kalmanq in fixed point: noise levels that are learnt. */
#include "arithmetic/q31.h"
#include "adaptation/adaptation.h"
