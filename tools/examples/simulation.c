#include "simulation.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* 53 bits in 0 .. 1, never 0: SplitMix64 (Steele, Lea and Flood 2014) */
static double uniform(noise *n)
{
    uint64_t z = n->state += UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    z ^= z >> 31;
    return ((double)(z >> 11) + 0.5) * 0x1p-53;
}

double noise_next(noise *n) /* Box and Muller 1958 */
{
    const double radius = sqrt(-2 * log(uniform(n)));
    return radius * cos(2 * 3.14159265358979323846 * uniform(n));
}

void need(kq_status status, const char *what)
{
    if (status == KQ_OK) return;
    fprintf(stderr, "%s: %s\n", what, kq_status_text(status));
    exit(1);
}

void need_no_events(const kq_filter_f32 *f, const kq_history_f32 *tape, unsigned usual)
{
    kq_filter_f32 view;
    need(kq_smoothed_f32(tape, 0, &view), "kq_smoothed_f32");
    const unsigned events = (kq_events_f32(f) | kq_events_f32(&view)) & ~usual;
    if (events == 0) return;
    fprintf(stderr, "the filter has the events %u (status.h)\n", events);
    exit(1);
}

void refuse(const char *word, const char *wanted)
{
    fprintf(stderr, "what is \"%s\"?  Wanted: %s\n", word, wanted);
    exit(2);
}

/* The lower root of the correlations of P, and sigma; 0 where there is none */
static int factor(const float *P, int n, double L[QUANTITIES_MAX][QUANTITIES_MAX], double *sigma)
{
    for (int i = 0; i < n; i++) sigma[i] = sqrt((double)P[i * n + i]);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double left = (double)P[i * n + j] / (sigma[i] * sigma[j]);
            for (int k = 0; k < j; k++) left -= L[i][k] * L[j][k];
            if (i == j && !(left > 0)) return 0;
            L[i][j] = i == j ? sqrt(left) : left / L[j][j];
        }
    }
    return 1;
}

double nees_of(const float *P, const double *e, int n)
{
    double L[QUANTITIES_MAX][QUANTITIES_MAX], sigma[QUANTITIES_MAX], y[QUANTITIES_MAX], sum = 0;
    if (!factor(P, n, L, sigma)) {
        fprintf(stderr, "a covariance is not positive definite\n");
        exit(1);
    }
    for (int i = 0; i < n; i++) {
        y[i] = e[i] / sigma[i];
        for (int k = 0; k < i; k++) y[i] -= L[i][k] * y[k];
        y[i] /= L[i][i];
        sum += y[i] * y[i];
    }
    return sum / n;
}

void note(record *row, int kind, const double *truth, const kq_filter_f32 *f, int n)
{
    float P[QUANTITIES_MAX * QUANTITIES_MAX];
    double e[QUANTITIES_MAX];
    need(kq_covariance_f32(f, P), "kq_covariance_f32");
    for (int i = 0; i < n; i++) {
        row->truth[i] = truth[i];
        row->mean[kind][i] = (double)kq_mean_f32(f, i);
        row->sigma[kind][i] = sqrt((double)P[i * n + i]);
        e[i] = truth[i] - row->mean[kind][i];
    }
    row->nees[kind] = nees_of(P, e, n);
}

void note_smoothed(record *rows, const double *truths, kq_history_f32 *tape, int n)
{
    need(kq_smooth_f32(tape), "kq_smooth_f32");
    for (size_t t = 0; t < kq_history_steps_f32(tape); t++) {
        kq_filter_f32 view;
        need(kq_smoothed_f32(tape, t, &view), "kq_smoothed_f32");
        note(rows + t, SMOOTHED, truths + t * (size_t)n, &view, n);
    }
}

static void print_titles(const char *const *names, int count)
{
    printf("step,time");
    for (int i = 0; i < count; i++) {
        const char *name = names[i];
        printf(",%s_truth,%s_filtered,%s_filtered_sigma,%s_smoothed,%s_smoothed_sigma", name, name,
               name, name, name);
    }
    printf(",nees_filtered,nees_smoothed\n");
}

void print_records(const char *const *names, int count, double seconds, const record *rows,
                   int steps)
{
    print_titles(names, count);
    for (int t = 0; t < steps; t++) {
        const record *row = rows + t;
        printf("%d,%.9g", t, t * seconds);
        for (int i = 0; i < count; i++) {
            printf(",%.9g", row->truth[i]);
            for (int k = 0; k < 2; k++) printf(",%.9g,%.9g", row->mean[k][i], row->sigma[k][i]);
        }
        printf(",%.9g,%.9g\n", row->nees[FILTERED], row->nees[SMOOTHED]);
    }
}
