#include "memory.h"

#include <stdint.h>

#define PAGE 65536u

extern unsigned char __heap_base;
static unsigned char *next;

void *tune_mark(void)
{
    if (!next) next = &__heap_base;
    return next;
}

void tune_release(void *mark) { next = mark; }

void *tune_take(size_t size)
{
    unsigned char *first = (unsigned char *)(((uintptr_t)tune_mark() + 15) & ~(uintptr_t)15);
    const uintptr_t there = (uintptr_t)__builtin_wasm_memory_size(0) * PAGE;
    if (size > UINT32_MAX - PAGE - (uintptr_t)first) return NULL;
    const uintptr_t end = (uintptr_t)first + size;
    if (end > there && __builtin_wasm_memory_grow(0, (end - there + PAGE - 1) / PAGE) == SIZE_MAX) return NULL;
    next = first + size;
    return first;
}

void *memcpy(void *restrict to, const void *restrict from, size_t size)
{
    unsigned char *a = to;
    const unsigned char *b = from;
    while (size--) *a++ = *b++;
    return to;
}

void *memset(void *to, int byte, size_t size)
{
    unsigned char *a = to;
    while (size--) *a++ = (unsigned char)byte;
    return to;
}
