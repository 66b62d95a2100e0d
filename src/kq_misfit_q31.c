/* A misfit of formats in words. */
#include "messages/misfit_q31.h"
