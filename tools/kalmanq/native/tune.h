/* A whole recording in one call, as the page of `kalmanq tune` asks for it: numbers in double, in and out, and in between
   those of one arithmetic.  The page writes a kq_tune word by word: engine.js has the names of its fields in this order. */
#ifndef KQ_NATIVE_TUNE_H
#define KQ_NATIVE_TUNE_H

#include "sequences.h"
#include "../tune/c/memory.h"

typedef enum { TUNE_F32, TUNE_F64, TUNE_Q31 } tune_arithmetic;
/* What was refused: engine.js says it in words. */
typedef enum {
    TUNE_NOTHING, TUNE_MEMORY, TUNE_FORMATS, TUNE_PROCESS, TUNE_SENSOR, TUNE_PRIOR, TUNE_MEASUREMENTS, TUNE_CONTROLS,
    TUNE_RUN, TUNE_SMOOTHER, TUNE_LAG, TUNE_LATE
} tune_part;

/* Each field is 32 bits.  Matrices are row-major. */
typedef struct {
    int32_t arithmetic;
    int32_t n, m, l, rows;
    int32_t processes; /* (A, B, Q) that follow each other in A, B, Q; the first is of the forecast */
    int32_t factor;    /* columns of G; 0: Q */
    uint32_t unknown;  /* states of which nothing is known at first */
    const void *loss;         /* &kq_loss_NAME_T of the arithmetic; NULL: none */
    int32_t level, run;       /* of a gate; -1: of another loss */
    int32_t losses;    /* how many: of gates, one for each sensor */
    int32_t smooth;    /* 0, 1 */
    int32_t only;      /* the state that is wanted smoothed; -1: all */
    int32_t lag;       /* rows; -1: none */
    int32_t ahead;     /* rows of the forecast */
    int32_t latest;    /* rows that a measurement comes late at most; 0: all in time */
    const double *A, *B, *Q, *G, *H, *R, *x0, *P0;
    const double *d;         /* m; NULL: 0 */
    const double *parameter; /* of a loss */
    const uint32_t *measured; /* by each loss: bits of z */
    const double *range;     /* n + m + l, of q31 */
    const int32_t *fraction; /* n + m + l, of q31 */
    const int32_t *which;    /* rows: the process before each; NULL: the first */
    const int32_t *late;     /* rows x m: how many rows later it comes; read where latest is above 0 */
    const double *z, *u;     /* rows x m, NaN: missing; rows x l, from a row to the next, or NULL */
    /* Results.  mean NULL: the total alone.  What is not to be had is NaN. */
    double *mean, *sigma, *innovation, *innovation_sigma, *nis, *log_likelihood, *taken;
    double *smoothed, *smoothed_sigma, *lagged, *lagged_sigma;
    double *forecast, *forecast_sigma;   /* ahead x n */
    double *total;                       /* log-likelihood of all rows; NULL: what is smoothed alone */
    int32_t events;
    /* Of a refusal */
    int32_t part, row, quantity, component, bits;
} kq_tune;

/* Where the page writes what it asks for */
kq_tune *tune_request(void);

kq_status tune_run(void);

/* The limit of a NIS with m degrees of freedom */
double tune_limit(int m, int level);

#endif
