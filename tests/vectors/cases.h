/* The recorded results of an arithmetic as constant arrays. */
#ifndef KALMANQ_CASES_H
#define KALMANQ_CASES_H

#include <stddef.h>
#include <stdint.h>

typedef struct {
    const char *name;
    const int32_t *words;
    size_t count;
} vector_case;

extern const vector_case vector_cases[];
extern const int vector_case_count;

#endif
