/* The steady filter's model on its way into the equation, in the caller's memory; and what of it lasts: every such state
   must be measured and moved by the noise. */
#ifndef KQ_SRC_STEADY_LASTING_FLOAT_H
#define KQ_SRC_STEADY_LASTING_FLOAT_H

#include "../filter/filter.h"

typedef T(kq_steady_solution) steady_solution;

/* The caller's memory by name: square arrays are dense, roots are triangles by columns. */
typedef struct {
    num *F, *S, *L;    /* n x n */
    num *X, *Y, *Z;    /* n x n, scratch */
    num *wide;         /* n rows of up to 2n or n + m */
    num *root, *last;  /* triangles: the predicted root, and the root of the step before */
    num *spare;        /* one more */
    num *pq;           /* 2n */
    num *gain, *drive; /* n x m: K and A K R^1/2 */
    num *state;        /* of a filter */
} steady_work;

static steady_work steady_work_at(num *memory, int n, int m)
{
    steady_work w;
    num **const square[] = {&w.F, &w.S, &w.L, &w.X, &w.Y, &w.Z};
    num **const triangle[] = {&w.root, &w.last, &w.spare};
    for (int k = 0; k < 6; k++, memory += n * n) *square[k] = memory;
    for (int k = 0; k < 3; k++, memory += KQ_TRIANGLE(n)) *triangle[k] = memory;
    w.wide = memory;
    w.pq = w.wide + n * (n + (n > m ? n : m));
    w.gain = w.pq + REFLECTOR_LEN(n);
    w.drive = w.gain + n * m;
    w.state = w.drive + n * m;
    return w;
}

/* ------------------------------------------------------------------ dense matrices */

static num largest(const num *a, int count)
{
    num most = 0;
    for (int k = 0; k < count; k++) {
        const num size = num_magnitude(a[k]);
        if (!(size <= most)) most = size; /* a NaN, too */
    }
    return most;
}

static void expand(num *dense, const num *root, int n)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) dense[i * n + j] = i <= j ? root[column(j) + i] : 0;
    }
}

/* n rows of [a, b], b with c columns */
static void join(num *wide, const num *a, const num *b, int n, int c)
{
    for (int i = 0; i < n; i++) {
        copy(wide + i * (n + c), a + i * n, n);
        copy(wide + i * (n + c) + n, b + i * c, c);
    }
}

/* y <- y U^-T for each of n rows: U y' = y' */
static void divide_rows(num *y, const num *U, int n)
{
    for (int i = 0; i < n; i++, y += n) {
        for (int j = n - 1; j >= 0; j--) {
            num rest = y[j];
            for (int k = j + 1; k < n; k++) rest -= U[column(k) + j] * y[k];
            y[j] = rest / U[column(j) + j];
        }
    }
}

/* y <- U^-1 y, n x n */
static void divide_columns(num *y, const num *U, int n)
{
    for (int c = 0; c < n; c++) {
        for (int j = n - 1; j >= 0; j--) {
            num rest = y[j * n + c];
            for (int k = j + 1; k < n; k++) rest -= U[column(k) + j] * y[k * n + c];
            y[j * n + c] = rest / U[column(j) + j];
        }
    }
}

/* U U' = I + a a' */
static void root_of_one_and(num *U, const num *a, const steady_work *w, int n)
{
    for (int i = 0; i < n; i++) {
        num *row = w->wide + 2 * n * i;
        for (int j = 0; j < n; j++) row[j] = (num)(i == j);
        copy(row + n, a + i * n, n);
    }
    triangularise(U, w->wide, 2 * n, 0, n, w->pq, SHAPE_FULL);
}

/* S <- tria [S, T], dense; to `root`, too */
static void add_root(num *S, const num *T, num *root, const steady_work *w, int n)
{
    join(w->wide, S, T, n, n);
    root_of_factor(root, w->wide, n, 2 * n);
    expand(S, root, n);
}

/* ------------------------------------------------------------------ the model */

static void process_noise(num *S, const process *p)
{
    const int n = p->states;
    expand(S, p->noise_root, n);
    for (int i = 0; i < n; i++) {
        if (S[i * n + i] <= num_tiny_root) S[i * n + i] = 0;
    }
}

/* What n steps of the noise move, into S */
static void reach(num *S, const num *A, const steady_work *w, int n)
{
    copy(w->Z, S, n * n);
    for (int k = 1; k < n; k++) {
        multiply(w->Y, A, S, n, n, n);
        copy(S, w->Z, n * n);
        add_root(S, w->Y, w->spare, w, n);
    }
}

/* The rows of H in units of their noise: L L' = H'R^-1 H.  S is what the noise reaches; a component
   that is much sharper than that counts as less sharp here. */
static void information(num *L, const sensor *s, const num *S, const steady_work *w)
{
    const reading z = {s, s->noise, 0, UINT32_MAX};
    scaled buffer[KQ_SIZE_MAX];
    const int n = s->states, m = s->components;
    for (int c = 0; c < m; c++) {
        const scaled *h = scalar_row(&z, c, buffer);
        num moved = 0, noise = scalar_noise(&z, c);
        for (int j = 0; j < n; j++) {
            num part = 0;
            for (int i = 0; i <= j; i++) part += h[i] * S[i * n + j];
            moved += part * part;
        }
        if (noise < num_low_noise * moved) noise = num_low_noise * moved;
        if (noise <= num_tiny) noise = 1; /* noise-free, of what does not move */
        const num root = num_root(noise);
        for (int i = 0; i < n; i++) w->wide[i * m + c] = h[i] / root;
    }
    root_of_factor(w->spare, w->wide, n, m);
    expand(L, w->spare, n);
}

/* ------------------------------------------------------------------ what lasts */

/* v less its parts along `count` orthonormal rows, and its norm */
static num beside(num *v, const num *rows, int count, int n)
{
    for (int twice = 0; twice < 2; twice++) {
        for (int k = 0; k < count; k++) {
            const num *row = rows + k * n, along = dot(0, row, v, n);
            for (int i = 0; i < n; i++) v[i] -= along * row[i];
        }
    }
    return num_root(dot(0, v, v, n));
}

/* Puts v behind the rows if more than `least` of it is beside them.  Answers their number. */
static int extend(num *rows, int count, int n, const num *v, num least)
{
    num *row = rows + count * n;
    if (count == n) return count;
    copy(row, v, n);
    const num norm = beside(row, rows, count, n);
    if (!(norm > least)) return count;
    for (int i = 0; i < n; i++) row[i] /= norm;
    return count + 1;
}

/* Rows that span what A leads to from the columns of G, dense, in units of scale */
static int reached(num *rows, const num *A, const num *G, const num *scale, int n)
{
    const num rounding = (num)(32 * n) * num_epsilon;
    num v[KQ_SIZE_MAX], most = 0;
    int count = 0;
    for (int test = 1; test >= 0; test--) { /* how long the columns are, then the columns */
        for (int j = 0; j < n; j++) {
            for (int i = 0; i < n; i++) v[i] = G[i * n + j] / scale[i];
            const num norm = num_root(dot(0, v, v, n));
            if (test && norm > most) most = norm;
            if (!test) count = extend(rows, count, n, v, rounding * most);
        }
    }
    for (int k = 0; k < count; k++) {
        for (int i = 0; i < n; i++) {
            v[i] = 0;
            for (int j = 0; j < n; j++) v[i] += A[i * n + j] * scale[j] * rows[k * n + j];
            v[i] /= scale[i];
        }
        count = extend(rows, count, n, v, rounding * num_root(dot(0, v, v, n)));
    }
    return count;
}

/*
 * How A moves what the columns of G do not reach: Y <- V A V', V orthonormal rows beside all that
 * is reached.  Answers how many there are.  Units are the sizes of what n steps reach, in `far`.
 */
static int unreached(const num *A, const num *G, const num *far, const steady_work *w, int n)
{
    num scale[KQ_SIZE_MAX], v[KQ_SIZE_MAX];
    for (int i = 0; i < n; i++) {
        scale[i] = num_root(dot(0, far + i * n, far + i * n, n));
        if (!(scale[i] > 0)) scale[i] = 1;
    }
    const int count = reached(w->X, A, G, scale, n);
    int all = count;
    for (int i = 0; i < n; i++) { /* one of the unit vectors is that far beside fewer than n rows */
        for (int k = 0; k < n; k++) v[k] = (num)(i == k);
        all = extend(w->X, all, n, v, num_half / num_root((num)n));
    }
    for (int q = count; q < all; q++) {
        for (int r = count; r < all; r++) {
            num total = 0;
            for (int i = 0; i < n; i++) {
                for (int j = 0; j < n; j++) {
                    total += w->X[q * n + i] * A[i * n + j] * scale[j] / scale[i] * w->X[r * n + j];
                }
            }
            w->Y[(q - count) * (all - count) + r - count] = total;
        }
    }
    return all - count;
}

/* Does C^t, count x count, not go to 0?  Y <- C^t, Z is used up. */
static int lasts(const steady_work *w, int count)
{
    for (int k = 0; k < num_digits; k++) {
        const num size = largest(w->Y, count * count);
        if (size <= num_epsilon) return 0;
        if (!(size < num_huge)) return 1;
        multiply(w->Z, w->Y, w->Y, count, count, count);
        copy(w->Y, w->Z, count * count);
    }
    return 1;
}

/* Every state that lasts must be measured and moved by the noise. */
static kq_status check_lasting(const process *p, const sensor *s, const steady_work *w)
{
    const int n = p->states;
    num *A = w->F, *G = w->L, *far = w->S;
    copy(A, p->transition, n * n);
    process_noise(G, p);
    copy(far, G, n * n);
    reach(far, A, w, n);
    const int unmoved = lasts(w, unreached(A, G, far, w, n));
    information(G, s, far, w);
    copy(far, G, n * n);
    transpose(A, n);
    reach(far, A, w, n);
    if (lasts(w, unreached(A, G, far, w, n))) return KQ_ERR_NOT_DETECTABLE;
    return unmoved ? KQ_ERR_NOT_STABILISABLE : KQ_OK;
}

#endif
