/* A Jacobian beside central differences, in float: for functions whose values are about 1. */
#ifndef JACOBIAN_H
#define JACOBIAN_H

#include <math.h>
#include <stdio.h>

enum { ARGUMENTS_MAX = 6, VALUES_MAX = 6 };

typedef void function(const float *x, float *y);

/* Of J (rows x n) at x the entries that are off, each of them told */
static int faults_of(function *f, const float *x, int n, const float *J, int rows, const char *name)
{
    const float h = 1.0f / 128, near = 2e-3f;
    float at[ARGUMENTS_MAX], above[VALUES_MAX], below[VALUES_MAX];
    int faults = 0;
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++) at[i] = x[i];
        at[j] = x[j] + h;
        f(at, above);
        at[j] = x[j] - h;
        f(at, below);
        for (int i = 0; i < rows; i++) {
            const float slope = (above[i] - below[i]) / (2 * h);
            if (fabsf(slope - J[i * n + j]) <= near) continue;
            printf("%s[%d][%d] is %g, should be %g\n", name, i, j, (double)J[i * n + j],
                   (double)slope);
            faults++;
        }
    }
    return faults;
}

#endif
