/* kalmanq in float: models, the filter, the smoothers, outliers, a diffuse start, linearised predicts. */
#include "arithmetic/f32.h"
#include "model/api.h"
#include "filter/api.h"
#include "smoother/api.h"
#include "robust/api.h"
#include "diffuse/api.h"
#include "linearised/api.h"
#include "linearised/rows_float.h"
