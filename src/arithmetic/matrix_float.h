/* Dense matrices by rows, in floating point: what is solved on the way to a model or a steady state. */
#ifndef KQ_SRC_ARITHMETIC_MATRIX_FLOAT_H
#define KQ_SRC_ARITHMETIC_MATRIX_FLOAT_H

#include "scaled_float.h"

/* out = a b: r x k times k x c */
static void multiply(num *restrict out, const num *a, const num *b, int r, int k, int c)
{
    for (int i = 0; i < r; i++) {
        for (int j = 0; j < c; j++) {
            num total = 0;
            for (int l = 0; l < k; l++) total += a[i * k + l] * b[l * c + j];
            out[i * c + j] = total;
        }
    }
}

/* out = a'b, n x n */
static void multiply_transposed(num *restrict out, const num *a, const num *b, int n)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            num total = 0;
            for (int l = 0; l < n; l++) total += a[l * n + i] * b[l * n + j];
            out[i * n + j] = total;
        }
    }
}

static void transpose(num *a, int n)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) {
            const num upper = a[j * n + i];
            a[j * n + i] = a[i * n + j];
            a[i * n + j] = upper;
        }
    }
}

#endif
