/*
 * The steady state of a constant model in floating point:
 *     P = A (P - P H' (H P H' + R)^-1 H P) A' + Q
 *
 * Structured doubling (Chu, Fan, Lin and Wang, Int. J. Control 77, 2004) on roots: what 2^k steps
 * do to the state is a triple of a transition F, a covariance S S' and an information L L', from
 * F = A, S = G and L L' = H'R^-1 H.  Twice as many steps are
 *     X = L'S,    U U' = I + X'X,    V V' = I + X X'
 *     S <- tria [S, F S U^-T],    L <- tria [L, F'L V^-T],    F <- F (I + S S'L L')^-1 F
 * It leads to a gain that stabilises; what F's differences cost of its digits is won back by
 * Newton's method (Hewer, IEEE Trans. Automat. Contr. 16, 1971), the steps of which are sums of
 * squares:
 *     S S' = C S S' C' + A K R K'A' + G G',    C = A (I - K H)
 * by doubling once more, S <- tria [S, C S], C <- C C.
 */
#ifndef KQ_SRC_STEADY_RICCATI_FLOAT_H
#define KQ_SRC_STEADY_RICCATI_FLOAT_H

#include "../filter/filter.h"

typedef T(kq_steady_solution) steady_solution;

/* The caller's memory by name: square arrays are dense, roots are triangles by columns. */
typedef struct {
    num *F, *S, *L;    /* n x n */
    num *X, *Y, *Z;    /* n x n, scratch */
    num *wide;         /* n rows of up to 2n or n + m */
    num *root, *last;  /* triangles: the predicted root, and that of the step before */
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
    w.gain = w.pq + 2 * n;
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

/* ------------------------------------------------------------------ doubling */

/* Twice as many steps, of the triple F, S and L */
static void twice_as_many(const steady_work *w, int n)
{
    num *F = w->F, *X = w->X, *Y = w->Y, *Z = w->Z, *U = w->root, *V = w->spare;
    multiply_transposed(X, w->L, w->S, n);
    root_of_one_and(V, X, w, n);
    transpose(X, n);
    root_of_one_and(U, X, w, n);
    multiply_transposed(Z, w->L, F, n);
    multiply(Y, X, Z, n, n, n);
    divide_columns(Y, U, n); /* U^-1 X'L'F */
    copy(X, w->S, n * n);
    divide_rows(X, U, n); /* S U^-T */
    multiply(Z, X, Y, n, n, n);
    for (int k = 0; k < n * n; k++) Z[k] = F[k] - Z[k];
    multiply(Y, F, Z, n, n, n); /* the next F */
    multiply(Z, F, X, n, n, n);
    add_root(w->S, Z, w->root, w, n);
    copy(X, w->L, n * n);
    divide_rows(X, V, n); /* L V^-T */
    multiply_transposed(Z, F, X, n);
    add_root(w->L, Z, w->spare, w, n);
    copy(F, Y, n * n);
}

static void row_sizes(num *size, const num *S, int n)
{
    for (int i = 0; i < n; i++) size[i] = largest(S + i * n, n);
}

/* Has the largest entry of a row grown by more than a rounding? */
static int has_grown(const num *size, const num *before, int n)
{
    for (int i = 0; i < n; i++) {
        if (size[i] > num_growth * before[i]) return 1;
    }
    return 0;
}

/*
 * From one step to as many as it takes: F goes to 0 if the filter forgets where it began.  What
 * keeps it: a covariance that grows without bound, where a state is not measured, or an
 * information that does, where it is not moved.
 */
static kq_status doubling(const process *p, const sensor *s, const steady_work *w)
{
    const int n = p->states;
    num size[KQ_SIZE_MAX], before[KQ_SIZE_MAX];
    copy(w->F, p->transition, n * n);
    process_noise(w->S, p);
    reach(w->S, w->F, w, n);
    information(w->L, s, w->S, w);
    process_noise(w->S, p);
    row_sizes(size, w->S, n);
    for (int k = 0; k < num_digits; k++) {
        copy(before, size, n);
        twice_as_many(w, n);
        row_sizes(size, w->S, n);
        if (!(largest(size, n) < num_huge)) return KQ_ERR_NOT_DETECTABLE;
        const num forgets = largest(w->F, n * n);
        if (forgets <= num_epsilon) return KQ_OK;
        if (!(forgets < num_huge) || !(largest(w->L, n * n) < num_huge)) break;
    }
    return has_grown(size, before, n) ? KQ_ERR_NOT_DETECTABLE : KQ_ERR_NOT_STABILISABLE;
}

/* ------------------------------------------------------------------ Newton's method */

/* B = A K with the noise of e: B <- B R^1/2, n x m */
static void gain_noise(num *B, const sensor *s, int n)
{
    const reading z = {s, s->noise, 0, UINT32_MAX};
    const int m = s->components;
    for (int i = 0; i < n; i++, B += m) {
        for (int j = 1; j < m && sensor_is_correlated(s); j++) {
            for (int c = 0; c < j; c++) B[j] -= B[c] * s->noise[column(j) + c];
        }
        for (int j = 0; j < m; j++) {
            const num r = scalar_noise(&z, j);
            B[j] = r > num_tiny ? B[j] * num_root(r) : 0;
        }
    }
}

/* The gain of a predicted root; f becomes the updated state. */
static void take_gain(filter *f, const sensor *s, const num *root, num *K)
{
    copy(filter_root(f), root, KQ_TRIANGLE(f->states));
    update_root_by(f, s, K);
}

/* F = A (I - K H), and the noise of a step with that gain to S */
static void close_loop(const process *p, const sensor *s, const steady_work *w)
{
    const int n = p->states, m = s->components;
    num *B = w->drive;
    multiply(B, p->transition, w->gain, n, n, m);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            num total = p->transition[i * n + j];
            for (int c = 0; c < m; c++) total -= B[i * m + c] * s->measurement[c * n + j];
            w->F[i * n + j] = total;
        }
    }
    gain_noise(B, s, n);
    process_noise(w->S, p);
    join(w->wide, w->S, B, n, m);
    root_of_factor(w->root, w->wide, n, n + m);
    expand(w->S, w->root, n);
}

/* Where the covariance with that gain goes to */
static kq_status settle_root(const steady_work *w, int n)
{
    for (int k = 0; k < num_digits; k++) {
        const num size = largest(w->F, n * n);
        if (size <= num_epsilon) return KQ_OK;
        if (!(size < num_huge)) break;
        multiply(w->Y, w->F, w->S, n, n, n);
        add_root(w->S, w->Y, w->root, w, n);
        multiply(w->Y, w->F, w->F, n, n, n);
        copy(w->F, w->Y, n * n);
    }
    return KQ_ERR_NO_CONVERGENCE;
}

/* How far apart two roots are, in units of their rows */
static num root_change(const num *a, const num *b, int n)
{
    num most = 0;
    for (int i = 0; i < n; i++) {
        num norm = 0, change = 0;
        for (int j = i; j < n; j++) {
            const num d = a[column(j) + i] - b[column(j) + i];
            norm += a[column(j) + i] * a[column(j) + i];
            change += d * d;
        }
        if (norm > 0 && change > most * most * norm) most = num_root(change / norm);
    }
    return most;
}

/* From the root of doubling to that of the equation.  Each step squares what is wrong, down to what
   rounding makes of it: from there on it no longer falls. */
static kq_status refine(const process *p, const sensor *s, const steady_work *w, filter *f)
{
    const int n = p->states;
    num change = 1;
    for (int k = 0; k < num_refinements; k++) {
        const num before = change;
        copy(w->last, w->root, KQ_TRIANGLE(n));
        take_gain(f, s, w->root, w->gain);
        close_loop(p, s, w);
        const kq_status status = settle_root(w, n);
        if (status) return status;
        change = root_change(w->root, w->last, n);
        if (change <= (num)n * num_epsilon) return KQ_OK;
        if (change < num_unsettled && change >= num_half * before) return KQ_OK;
    }
    return KQ_ERR_NO_CONVERGENCE;
}

/* ------------------------------------------------------------------ what comes of it */

/* G = P A' (P-)^-1 = (S Theta11) S-^-1, by rows; a column of S- without a pivot is 0, and so is
   what it would be divided into. */
static void smoother_gain(num *G, const process *p, const filter *f, const num *predicted,
                          const steady_work *w)
{
    const int n = p->states;
    num *S = w->S, *X = w->X;
    expand(S, filter_root(f), n);
    multiply(w->Y, p->transition, S, n, n, n);
    expand(w->L, predicted, n);
    for (int j = 0; j < n; j++) { /* X = S-^-1 A S */
        for (int i = n - 1; i >= 0; i--) {
            num rest = w->Y[i * n + j];
            for (int k = i + 1; k < n; k++) rest -= w->L[i * n + k] * X[k * n + j];
            X[i * n + j] = w->L[i * n + i] > 0 ? rest / w->L[i * n + i] : 0;
        }
    }
    transpose(X, n);
    multiply(G, S, X, n, n, n); /* S Theta11 */
    for (int i = 0; i < n; i++, G += n) {
        for (int j = 0; j < n; j++) { /* G S- = S Theta11 */
            num rest = G[j];
            for (int k = 0; k < j; k++) rest -= G[k] * w->L[k * n + j];
            G[j] = w->L[j * n + j] > 0 ? rest / w->L[j * n + j] : 0;
        }
    }
}

static kq_status steady_solve_check(const process *p, const sensor *s, const num *memory,
                                    size_t length, const steady_solution *out)
{
    kq_status status = process_check(p);
    if (!status) status = sensor_check(s);
    if (status) return status;
    if (!memory || !out) return KQ_ERR_NULL;
    if (p->states != s->states) return KQ_ERR_MISMATCH;
    return length < (size_t)STEADY_SOLVE_LEN(p->states, s->components) ? KQ_ERR_MEMORY : KQ_OK;
}

kq_status T(kq_steady_solve)(const process *p, const sensor *s, num *memory, size_t length,
                             const steady_solution *out)
{
    filter f;
    kq_status status = steady_solve_check(p, s, memory, length, out);
    if (status) return status;
    const int n = p->states, m = s->components;
    const steady_work w = steady_work_at(memory, n, m);
    for (int k = 0; k < MEAN_PLANES * n; k++) w.state[k] = 0; /* an update that overflows looks at the mean */
    status = T(kq_filter_assign)(&f, n, w.state, (size_t)FILTER_LEN(n));
    if (!status) status = check_lasting(p, s, &w);
    if (!status) status = doubling(p, s, &w);
    if (!status) status = refine(p, s, &w, &f);
    if (status) return status;
    take_gain(&f, s, w.root, w.gain);
    if (out->predicted) root_square(out->predicted, w.root, n);
    if (out->filtered) root_square(out->filtered, filter_root(&f), n);
    if (out->gain) copy(out->gain, w.gain, n * m);
    if (out->smoother_gain) smoother_gain(out->smoother_gain, p, &f, w.root, &w);
    return KQ_OK;
}

#endif
