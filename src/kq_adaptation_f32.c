/* kalmanq in float: noise levels that are learnt. */
#include "arithmetic/f32.h"
#include "adaptation/adaptation.h"
