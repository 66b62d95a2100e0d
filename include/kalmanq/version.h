/* kalmanq: version of the library. */
#ifndef KALMANQ_VERSION_H
#define KALMANQ_VERSION_H

#define KQ_VERSION_MAJOR 1
#define KQ_VERSION_MINOR 0
#define KQ_VERSION_PATCH 0

/** One number that grows with every release, for `#if KQ_VERSION >= ...`. */
#define KQ_VERSION (KQ_VERSION_MAJOR * 10000 + KQ_VERSION_MINOR * 100 + KQ_VERSION_PATCH)
#define KQ_VERSION_STRING "1.0.0"

#endif
