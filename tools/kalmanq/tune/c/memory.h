/* Memory of a WebAssembly module that has no C library. */
#ifndef KQ_TUNE_MEMORY_H
#define KQ_TUNE_MEMORY_H

#include <stddef.h>

/* Bytes that stay until tune_release of what was before; NULL: there are no more. */
void *tune_take(size_t size);
void *tune_mark(void);
void tune_release(void *mark);

void *memcpy(void *restrict to, const void *restrict from, size_t size);
void *memset(void *to, int byte, size_t size);

#endif
