/* A recording through the C of a compiled model, as the page of `kalmanq tune` asks for it: equations.js writes a tune_run word
   by word, and has the names of its fields in this order. */
#ifndef KQ_TUNE_RUN_H
#define KQ_TUNE_RUN_H

#include <stdint.h>

/* Each field is 32 bits.  Matrices are row-major; n states, m measurements, c numbers that the filter carries. */
typedef struct {
    int32_t n, m, c, l, rows;
    int32_t smooth; /* 0, 1 */
    int32_t ahead;  /* rows of the forecast */
    int32_t latest; /* rows that a measurement comes late at most; 0: all in time */
    const int32_t *late;    /* rows x m: how many rows later it comes; read where latest is above 0 */
    const double *R;        /* m x m; where R is a function: factors of what it answers */
    const double *z, *u;    /* rows x m, NaN: missing; rows x l, from a row to the next */
    const double *clock;    /* rows x 3: t of the row before, the step between them, t of the row */
    const double *step;     /* of the forecast */
    /* Results.  mean NULL: the total alone.  What is not to be had is NaN. */
    double *mean, *sigma, *expected; /* rows x c, rows x c, rows x m: h of the mean */
    double *innovation, *innovation_sigma, *nis, *log_likelihood, *taken;
    double *smoothed, *smoothed_sigma, *smoothed_expected;
    double *forecast, *forecast_sigma; /* ahead x c */
    double *total;
    int32_t events;
} tune_run;

tune_run *tune_request(void);

/* What a filter of one arithmetic answers, in double */
typedef struct {
    double x[16]; /* its mean */
    double P[16 * 16];
} tune_state;

/* Innovations, h and R of all measurements at a mean; the model's formulas */
void tune_explain(const double *x, const double *z, const double *u, double t, const double *scale, double *e, double *H, double *R);

/* J, c x n: of nominal numbers by their errors.  0: the numbers are the states. */
int tune_by_errors(const double *x, double *J);

/* Bits of the measurements of a row that have come by another one */
unsigned tune_present(const tune_run *of, int row, int by);
/* The first row of which something comes at row t, or t */
int tune_first(const tune_run *of, int t);
/* The log-likelihood of all rows */
void tune_total(const tune_run *of);
/* Before the update of a row: what it will be judged by */
void tune_expect(const tune_run *of, const tune_state *before, int row);
/* After it */
void tune_judge(const tune_run *of, int row, unsigned present, unsigned taken);
/* A row of means, sigmas and h */
void tune_tell(const tune_run *of, const tune_state *of_row, const double *u, double t, int row, double *mean, double *sigma, double *expected);

#endif
