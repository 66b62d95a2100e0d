/* What is taken of <string.h>, where there is no C library: tune.c has it. */
#ifndef KQ_NATIVE_WASM_STRING_H
#define KQ_NATIVE_WASM_STRING_H

#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t size);
void *memmove(void *to, const void *from, size_t size);
void *memset(void *to, int byte, size_t size);
int memcmp(const void *a, const void *b, size_t size);

#endif
