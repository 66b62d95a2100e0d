/* Models of any size, made with + * / of the arithmetic itself: the same bits on every machine. */
#ifndef KALMANQ_BITS_MODEL_H
#define KALMANQ_BITS_MODEL_H

#include "number.h"

enum { MOST_STATES = 16, MOST_COMPONENTS = 4 };

/* What is special about a case */
enum {
    CORRELATED = 1, /* R is full */
    EXACT = 2,      /* R = 0, and the last row of H is the first one again */
    SHARP = 4       /* R is 2^-40 of what it would be */
};

typedef struct {
    const char *name;
    int n, m, l;
    int kinds;
    num scale; /* of states and measurements */
} model_case;

typedef struct {
    int n, m, l;
    num A[MOST_STATES * MOST_STATES], B[MOST_STATES], Q[MOST_STATES * MOST_STATES];
    num H[MOST_COMPONENTS * MOST_STATES], R[MOST_COMPONENTS * MOST_COMPONENTS];
    num x0[MOST_STATES], P0[MOST_STATES * MOST_STATES];
} model;

/** The model of a case, and the sequence of draws from its beginning */
void model_make(model *M, const model_case *c);

/** A signed number below 1 of 24 bits, from a fixed sequence */
num model_draw(void);

#endif
