/*
 * What f32 is compared with: the Kalman filter as one usually writes it, in float, for sizes known
 * at run time; the covariance itself is carried:
 *     predict   x <- A x,  P <- A P A' + Q
 *     update    one scalar measurement after the other, P <- P - K (P h)'
 * As good as this form gets: zeros of A and H cost nothing, P is computed in one triangle and
 * mirrored.  Nothing is checked, and nothing keeps P positive semi-definite.
 */
#ifndef KALMANQ_TEXTBOOK_FILTER_H
#define KALMANQ_TEXTBOOK_FILTER_H

enum { TEXTBOOK_STATES = 9, TEXTBOOK_COMPONENTS = 3 };

typedef struct {
    int n;
    float x[TEXTBOOK_STATES], P[TEXTBOOK_STATES * TEXTBOOK_STATES];
} textbook_filter;

typedef struct {
    int n;
    float A[TEXTBOOK_STATES * TEXTBOOK_STATES], Q[TEXTBOOK_STATES * TEXTBOOK_STATES];
} textbook_process;

typedef struct {
    int n, m;
    float H[TEXTBOOK_COMPONENTS * TEXTBOOK_STATES], R[TEXTBOOK_COMPONENTS];
} textbook_sensor;

void textbook_predict(textbook_filter *f, const textbook_process *p);
void textbook_update(textbook_filter *f, const textbook_sensor *s, const float *z);

/** Both. */
void textbook_step(textbook_filter *f, const textbook_process *p, const textbook_sensor *s,
                   const float *z);

#endif
