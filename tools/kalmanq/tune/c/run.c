#include "run.h"

#include <math.h>

enum { M = 16, N = 16 };
#define LOG_2_PI 1.8378770664093453

static tune_run request;
static double e[M], S[M * M]; /* of the row at work: innovations and their covariance */

tune_run *tune_request(void) { return &request; }

unsigned tune_present(const tune_run *of, int row, int by)
{
    unsigned made = 0;
    for (int j = 0; j < of->m; j++) {
        const int k = row * of->m + j, has_come = !of->latest || row + of->late[k] <= by;
        made |= (has_come && of->z[k] == of->z[k] ? 1u : 0u) << j;
    }
    return made;
}

int tune_first(const tune_run *of, int t)
{
    for (int s = t > of->latest ? t - of->latest : 0; s < t; s++)
        if (tune_present(of, s, t) != tune_present(of, s, t - 1)) return s;
    return t;
}

void tune_total(const tune_run *of)
{
    *of->total = 0;
    for (int t = 0; t < of->rows; t++) *of->total += of->log_likelihood[t];
}

void tune_expect(const tune_run *of, const tune_state *before, int row)
{
    const int n = of->n, m = of->m;
    double H[M * N], R[M * M];
    tune_explain(before->x, of->z + row * m, of->u + row * of->l, of->clock[3 * row + 2], of->R, e, H, R);
    for (int j = 0; j < m; j++) {
        double row_of[N];
        for (int a = 0; a < n; a++) {
            row_of[a] = 0;
            for (int b = 0; b < n; b++) row_of[a] += before->P[a * n + b] * H[j * n + b];
        }
        for (int i = 0; i < m; i++) {
            S[i * m + j] = R[i * m + j];
            for (int a = 0; a < n; a++) S[i * m + j] += H[i * n + a] * row_of[a];
        }
    }
}

/* Of what was taken: NIS by S = L L', and the logarithm of the determinant of S */
static double scored(int m, unsigned taken, double *logarithm)
{
    double L[M * M], y[M], nis = 0;
    int some[M], count = 0;
    for (int j = 0; j < m; j++)
        if (taken >> j & 1u) some[count++] = j;
    *logarithm = 0;
    for (int i = 0; i < count; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = S[some[i] * m + some[j]];
            for (int k = 0; k < j; k++) sum -= L[i * M + k] * L[j * M + k];
            L[i * M + j] = i == j ? sqrt(sum) : sum / L[j * M + j];
        }
        double sum = e[some[i]];
        for (int k = 0; k < i; k++) sum -= L[i * M + k] * y[k];
        y[i] = sum / L[i * M + i];
        nis += y[i] * y[i];
        *logarithm += 2 * log(L[i * M + i]);
    }
    return nis;
}

void tune_judge(const tune_run *of, int row, unsigned present, unsigned taken)
{
    const int m = of->m;
    int count = 0;
    double logarithm = 0;
    for (int j = 0; j < m; j++) count += (int)(taken >> j & 1u);
    const double nis = scored(m, taken, &logarithm);
    of->log_likelihood[row] = taken ? -(nis + logarithm + count * LOG_2_PI) / 2 : 0;
    if (!of->mean) return;
    for (int j = 0; j < m; j++) {
        of->innovation[row * m + j] = present >> j & 1u ? e[j] : (double)NAN;
        of->innovation_sigma[row * m + j] = sqrt(S[j * m + j]);
    }
    of->nis[row] = taken ? nis : (double)NAN;
    of->taken[row] = count;
}

/* J P J' */
static double variance_of(const double *P, const double *J, int n)
{
    double sum = 0;
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++) sum += J[a] * P[a * n + b] * J[b];
    return sum;
}

void tune_tell(const tune_run *of, const tune_state *of_row, const double *u, double t, int row, double *mean, double *sigma, double *expected)
{
    const int m = of->m;
    double zero[M] = {0}, own[M], H[M * N], R[M * M], J[N * N];
    const int is_nominal = tune_by_errors(of_row->x, J);
    for (int i = 0; i < of->c; i++) {
        mean[row * of->c + i] = of_row->x[i];
        sigma[row * of->c + i] = sqrt(is_nominal ? variance_of(of_row->P, J + i * of->n, of->n) : of_row->P[i * of->n + i]);
    }
    if (!expected) return;
    tune_explain(of_row->x, zero, u, t, of->R, own, H, R);
    for (int j = 0; j < m; j++) expected[row * m + j] = -own[j];
}
