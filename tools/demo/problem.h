/*
 * What a demo program is given, in doubles whatever it computes in, and how it gives up or ends.
 */
#ifndef KQ_DEMO_PROBLEM_H
#define KQ_DEMO_PROBLEM_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <kalmanq/status.h>

typedef struct {
    int n, m, ahead;
    size_t steps;
    double *A, *Q, *H, *R, *x0, *P0;
    double *x_range, *z_range;         /* for fixed point only */
    double *z;                         /* steps x m, NaN: not measured */
    uint32_t *present;                 /* steps: bit c: component c was measured */
} problem;

/* Reads the text that run.c documents, or fails. */
problem read_problem(FILE *stream);

/* One line on stderr, exit status 1. */
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2), noreturn))
#endif
void fail(const char *format, ...);

/* Fails unless the library is content; `what` says with which part of the problem. */
void check(kq_status status, const char *what);

/* The line `end` on stdout, after which all of it is written, or the program fails. */
void finish_output(void);

/* Zeroed memory, or the program fails. */
void *allocate(size_t count, size_t size);

#endif
