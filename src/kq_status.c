/* The statuses in words. */
#include "messages/status.h"
