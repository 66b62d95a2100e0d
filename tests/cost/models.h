/* The models of the comparison, and data for them. */
#ifndef KALMANQ_COST_MODELS_H
#define KALMANQ_COST_MODELS_H

enum { STATES = 9, COMPONENTS = 3, STEPS = 2000, MODELS = 3 };

typedef struct {
    const char *name;
    int n, r, m;
    double A[STATES * STATES], F[STATES * STATES]; /* x[t+1] = A x + F w, w ~ N(0, I) */
    double H[COMPONENTS * STATES], R[COMPONENTS];  /* z = H x + v, v ~ N(0, diag R) */
    double P0[STATES];                             /* x[0] ~ N(0, diag P0) */
    double state_range[STATES], measurement_range;
} model;

/** Model `which` of MODELS. */
void model_make(model *M, int which);

/** STEPS measurements, multiples of 2^-16, so that every filter gets the same numbers. */
void model_simulate(const model *M, double (*z)[COMPONENTS]);

#endif
