/*
 * kalmanq: the process, how the state moves from one step to the next.
 *
 *     x[t+1] = A x[t] + B u[t] + w[t],     w ~ N(0, Q),     Q = G G'
 *
 * Init checks a process once; many filters may then read it.  It keeps the root G of Q in its memory and refers to
 * your A and B: do not move or change them while the process is in use (constants may stay in flash). If you write a
 * new A, call kq_process_change_transition, even if it is in the same array.  Without it a step leaves out what was
 * zero in the old A, and no history or freeze sees the change.
 *
 * All matrices are dense and row-major: entry (i, j) of an r x c matrix M is M[i * c + j].
 */
#ifndef KALMANQ_PROCESS_H
#define KALMANQ_PROCESS_H

#include "fixed_point.h"
#include "sensor.h"
#include "size.h"
#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Words of memory of a process with n states. */
#define KQ_PROCESS_LEN(n) KQ_TRIANGLE(n)

/* The fields are the library's: declare them with the macros and do not use them.  They are public so that a
   process can be a const table in flash. */
typedef struct {
    uint8_t states;             /* n */
    uint8_t controls;           /* l */
    uint16_t length;            /* words at memory */
    float *memory;              /* yours; NULL for a const table */
    const float *noise_root;    /* G, upper triangle by columns; NULL until initialised */
    const float *transition;    /* A, n x n, yours */
    const float *control;       /* B, n x l, yours, or NULL */
    uint8_t first[KQ_SIZE_MAX]; /* first[i]: all of A's rows >= i are 0 left of it */
    uint8_t plain;              /* n, 128 more where A is upper triangular, 64 more where an A_ii < 1/2
                                   (a const table: maybe); 0: not initialised */
    uint8_t seal;               /* of sizes and addresses (kq_process_check); 0: none */
    uint32_t fingerprint;       /* of A and G: what a history and a freeze know the process by */
} kq_process_f32;

typedef struct {
    uint8_t states, controls; uint16_t length; double *memory; const double *noise_root, *transition, *control;
    uint8_t first[KQ_SIZE_MAX]; uint8_t plain, seal; uint32_t fingerprint;
} kq_process_f64;

/** Declares a process `name` of n states and l controls (0: none) with its memory, static. */
#define KQ_PROCESS_F32(name, n, l) \
    static float name##_memory[KQ_PROCESS_LEN(n)]; \
    static kq_process_f32 name = {n, l, KQ_PROCESS_LEN(n), name##_memory, NULL, NULL, NULL, {0}, 0, 0, 0}
#define KQ_PROCESS_F64(name, n, l) \
    static double name##_memory[KQ_PROCESS_LEN(n)]; \
    static kq_process_f64 name = {n, l, KQ_PROCESS_LEN(n), name##_memory, NULL, NULL, NULL, {0}, 0, 0, 0}

/** The initialiser of a static const kq_process_<T> in flash, unchecked; kalmanq design writes it.
 *   A, B     as for kq_process_init
 *   G        the root of Q = G G': n (n + 1) / 2 numbers, upper triangle by columns (G_11, G_12, G_22, ...).  Its
 *            diagonal is at least 2^-60 (f32), 2^-200 (f64).
 *
 *     static const float A[] = {1, 0.01f, 0, 1}, G[] = {1e-4f, 5e-4f, 0.1f};
 *     static const kq_process_f32 motion = KQ_PROCESS_TABLE(2, 0, A, NULL, G);
 *
 * One more argument tells where A is 0, so that a step costs what it costs after init: n numbers in parentheses. All
 * rows from i on are 0 left of column number i.  (0, 1, 2) is an upper triangular A of three states.  A number too
 * small costs time; one too large leaves out coefficients.  Without it A is dense.  No history and no freeze sees
 * that you assign one table over another. */
#define KQ_PROCESS_TABLE(n, l, A, B, ...) \
    {n, l, 0, NULL, KQ_PRIVATE_GIVEN(__VA_ARGS__), A, B, KQ_PRIVATE_LIST(__VA_ARGS__), (n) + 64, 0, 0}

/** Gives a process its sizes and memory at run time.  Then initialise it.
 *   p        written
 *   n        1..16 states
 *   l        0..16 controls
 *   memory   `length` words, yours while the process is in use
 *   length   KQ_PROCESS_LEN(n) or more
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY (length). */
KQ_NODISCARD kq_status kq_process_assign_f32(kq_process_f32 *p, int n, int l, float *memory, size_t length);
KQ_NODISCARD kq_status kq_process_assign_f64(kq_process_f64 *p, int n, int l, double *memory, size_t length);

/** Checks the model and factors Q = G G'.
 *   p        with sizes and memory; written
 *   A        n x n, kept by reference
 *   B        n x l, kept by reference; ignored if l = 0
 *   Q        n x n, symmetric positive semi-definite, may be singular or 0; not kept.  The upper triangle is used,
 *            the lower one compared with it.
 * You may initialise a process again between steps: a history that refers to it then refuses to smooth (smoother.h),
 * and a freeze begins again (steady.h).
 * KQ_ERR_NULL, KQ_ERR_SIZE and KQ_ERR_MEMORY (also: p has no sizes or memory), KQ_ERR_NOT_FINITE,
 * KQ_ERR_NOT_SYMMETRIC, KQ_ERR_NOT_SEMIDEFINITE, KQ_ERR_RANGE (a variance above 2^120 in f32, 2^1000 in f64).
 * Accuracy: G is exact for a Q perturbed by a few n eps sqrt(Q_ii Q_jj).  What the other states leave of a variance
 * counts as 0 below 8 n eps of it: give a factor if it matters.  G_ii >= 2^-60 (f32), 2^-200 (f64).
 * Cost: about 2 n^3 multiplications, 2n square roots.  Stack: 424 words. */
KQ_NODISCARD kq_status kq_process_init_f32(kq_process_f32 *p, const float *A, const float *B, const float *Q);
KQ_NODISCARD kq_status kq_process_init_f64(kq_process_f64 *p, const double *A, const double *B, const double *Q);

/** kq_process_init with Q = F F' given by a factor: more accurate if Q is singular or spans many decades.
 *   p, A, B  as in kq_process_init
 *   F        n x r, any rank; not kept
 *   r        0..16 columns.  0: no noise, F may be NULL.
 * Errors: as kq_process_init without KQ_ERR_NOT_SYMMETRIC and KQ_ERR_NOT_SEMIDEFINITE.
 * Cost: n^2 r multiplications, n square roots.  Stack: 424 words. */
KQ_NODISCARD kq_status kq_process_init_factor_f32(kq_process_f32 *p, const float *A, const float *B,
    const float *F, int r);
KQ_NODISCARD kq_status kq_process_init_factor_f64(kq_process_f64 *p, const double *A, const double *B,
    const double *F, int r);

/** kq_process_init with Q = G G' given by its root, made on the host, say.  Links 1 to 2 kB less.
 *   p, A, B  as in kq_process_init
 *   G        upper triangular, diagonal >= 0, KQ_TRIANGLE(n) numbers by columns: g_00, g_01, g_11, g_02, ...; not
 *            kept.  NumPy: U = cholesky(Q[::-1, ::-1])[::-1, ::-1]; G = U.T[tril_indices(n)]
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SEMIDEFINITE (a negative diagonal),
 * KQ_ERR_RANGE (as kq_process_init).
 * Cost: n^3 / 6 multiplications.  Accuracy: G is exact, but G_ii >= 2^-60 (f32), 2^-200 (f64). */
KQ_NODISCARD kq_status kq_process_init_root_f32(kq_process_f32 *p, const float *A, const float *B, const float *G);
KQ_NODISCARD kq_status kq_process_init_root_f64(kq_process_f64 *p, const double *A, const double *B, const double *G);

/** Words of memory of a process in continuous time with n states and l controls. */
#define KQ_CONTINUOUS_LEN(n, l) \
    ((size_t)(n) * (6 * (size_t)(n) + 2 * (size_t)(l)) + (size_t)KQ_TRIANGLE((size_t)(n)))

/** A process of a model in continuous time, x' = F x + B u + w, over a step dt, exact: A = exp(F dt), the control
 *  held over the step, Q what w of spectral density Qc adds up to.  Call it again when dt changes.
 *   p        with sizes and memory; written
 *   F        n x n; not kept
 *   B        n x l; not kept; ignored if l = 0
 *   Qc       n x n, symmetric positive semi-definite: unit^2 / time; not kept
 *   dt       the step, above 2^-120 (f32), 2^-400 (f64), in the unit of time that F has
 *   memory   `length` numbers, yours while in use: p refers to the A and B that it begins with, which the next call
 *            writes anew.  After an error they and p are what they were.
 *   length   KQ_CONTINUOUS_LEN(n, l) or more
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SYMMETRIC, KQ_ERR_NOT_SEMIDEFINITE,
 * KQ_ERR_RANGE (dt; A, B or a sigma beyond what is representable).
 * Accuracy: 10 eps, of A, of B and of Q_ij in units of sqrt(Q_ii Q_jj), and twice what an F that is off by eps
 * makes.  Of G_ii in Q = G G', 4 n eps sqrt(Q_ii), where Qc is diagonal; G_ii >= 2^-60 (f32), 2^-200 (f64).  An oscillator without damping: |F| dt eps.
 * Cost: 10, 38, 305 thousand instructions at n = 2, 4, 9 (M4F, f32); 6 n^3 multiplications more for each doubling of
 * |F| dt above 1/2.  Stack: 1000 bytes (n = 9: 1440). */
KQ_NODISCARD kq_status kq_process_init_continuous_f32(kq_process_f32 *p, const float *F, const float *B,
    const float *Qc, float dt, float *memory, size_t length);
KQ_NODISCARD kq_status kq_process_init_continuous_f64(kq_process_f64 *p, const double *F, const double *B,
    const double *Qc, double dt, double *memory, size_t length);

/** Words of memory of a process whose noise is correlated with a sensor's: n states, B n x l, m components. */
#define KQ_CORRELATED_LEN(n, l, m) \
    (KQ_TRIANGLE((size_t)(n)) + (size_t)(n) * ((size_t)(n) + (size_t)(l) + (size_t)(m)) + \
        2 * ((size_t)(n) + (size_t)(m)) * ((size_t)(n) + (size_t)(m)))

/** A process whose noise is correlated with the noise of the measurement before the predict, E w[t] v[t]' = S:
 *
 *     A* = A - K H,   B* = [B, K],   Q* = Q - K S',   K = S R^-1,   controls (u[t]; z[t])
 *
 * Exact: its noise is independent of v[t], so every filter and smoother takes it as any other process.
 *
 *     static float memory[KQ_CORRELATED_LEN(2, 1, 1)];                2 states, 1 control, 1 component
 *     kq_process_assign_f32(&motion, 2, 1 + 1, memory, KQ_CORRELATED_LEN(2, 1, 1));
 *     kq_process_init_correlated_f32(&motion, A, B, Q, &ranger, S, UINT32_MAX);
 *     ...
 *     kq_update_f32(&cart, &ranger, z);
 *     kq_predict_f32(&cart, &motion, both);                           both: u, then the z of that update
 *
 *   p        n states, l + m controls, KQ_CORRELATED_LEN(n, l, m) words of memory; written.  The memory begins with
 *            the root of Q*, then A*, n x n, and B*, n x (l + m), for you to read
 *   A, B, Q  as for kq_process_init; B n x l, ignored if l = 0.  Not kept; not in p's memory
 *   s        n states, m components, of any kind: its H and R are used
 *   S        n x m; not kept.  [Q, S; S', R] is positive semi-definite, may be singular
 *   present  bit c: the update took component c.  UINT32_MAX: all.  0: p is A, [B, 0] and Q
 * A component that is missing, or that a gate rejects, tells nothing of w.  The predict after it takes the process of
 * that `present`; z then needs a finite number in its place, which is not used.  Steps without measurements, as in
 * kq_forecast, take present = 0.  A history keeps a pointer to each process: have one for each `present`, or smooth
 * while the filter runs (lag.h).  E w[t] v[t+1]' = S is another model.
 * After an error p, A*, B* and the root are what they were.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (s), KQ_ERR_SIZE (p has fewer than m controls), KQ_ERR_MEMORY, KQ_ERR_MISMATCH (s has
 * other states), KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SYMMETRIC, KQ_ERR_NOT_SEMIDEFINITE (Q; Q, S and R together),
 * KQ_ERR_RANGE (Q as in kq_process_init; A* or B* overflows).
 * Accuracy: Q* is rounded at its own size, also where it is 1e-7 of Q, and its root is as accurate as after
 * kq_process_init.  Q* follows Q, S and R as you give them: if they are rounded, it is known to a few eps Q.  Where their
 * rounding has left no covariance, their variances grow by a few eps until there is one.  Of R, what the other components
 * leave of a variance counts as 0 below eps of it.  The mean is rounded at the size of
 * A* x and K z: in f32, where a state is far larger than its sigma, move it by kq_predict_extended (extended.h) with
 * this process, d = (A - I) x + B u + K e, where kq_innovation after the update gives e = z - H x.
 * Cost: 3, 11, 52 thousand instructions at n = 2, 4, 9 and m = 1, 2, 3 (M4F, f32); up to 15 times that where rounding has
 * left no covariance.  Stack: 400 bytes. */
KQ_NODISCARD kq_status kq_process_init_correlated_f32(kq_process_f32 *p, const float *A, const float *B,
    const float *Q, const kq_sensor_f32 *s, const float *S, uint32_t present);
KQ_NODISCARD kq_status kq_process_init_correlated_f64(kq_process_f64 *p, const double *A, const double *B,
    const double *Q, const kq_sensor_f64 *s, const double *S, uint32_t present);

/** Changes A and keeps the noise: for a step length that varies, or a linearised model.
 *   p        initialised; changed
 *   A        n x n, kept by reference.  New content in the same array is a change too: call this after it.
 * A history that recorded a predict by the old A refuses to smooth (smoother.h).  A freeze begins again.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE.  Cost: n^2 comparisons, 1.5 n^2 integer multiplications. */
KQ_NODISCARD kq_status kq_process_change_transition_f32(kq_process_f32 *p, const float *A);
KQ_NODISCARD kq_status kq_process_change_transition_f64(kq_process_f64 *p, const double *A);

/** Checks whether memory errors have damaged p, A or G.  The first call after an init or change keeps seals, which
 * later calls compare.
 *   p        its seal is written; not a const table
 * One turned bit is always found in the used bytes of p, in G and in A. In p alone if p was assigned from a table or
 * made by kq_process_scale_noise.  B and formats are not checked.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_TABLE (damaged: initialise it again).
 * Cost: as kq_process_change_transition. */
KQ_NODISCARD kq_status kq_process_check_f32(kq_process_f32 *p);
KQ_NODISCARD kq_status kq_process_check_f64(kq_process_f64 *p);

/* ------------------------------------------------------------------ q31 */

/** A process as a table, in flash if you like.  prepare.h makes its arrays; fixed_point.h has the units. */
typedef struct {
    int32_t states;                      /* n: 1..16 */
    int32_t controls;                    /* l: 0..16 */
    const kq_format_q31 *state_format;   /* n */
    const kq_format_q31 *control_format; /* l, NULL if l = 0 */
    const kq_scaled_q31 *transition;     /* A, n x n */
    const kq_scaled_q31 *control;        /* B, n x l, NULL if l = 0 */
    const int32_t *noise_root;           /* G, KQ_ROOT_LEN_Q31(n) words */
} kq_process_table_q31;

typedef struct {
    uint8_t states, controls; uint8_t first[KQ_SIZE_MAX]; uint8_t plain, seal; uint32_t fingerprint;
    const kq_format_q31 *state_format, *control_format; const kq_scaled_q31 *transition, *control;
    const int32_t *noise_root; /* NULL until initialised */
} kq_process_q31;

/** Checks a table and keeps its arrays by reference, so that no later call overflows.  No float code.
 *   p            written; needs no memory
 *   table        read; its arrays are yours while p is in use
 *   range_error  written: KQ_NO_RANGE_ERROR, or what does not fit (KQ_ERR_RANGE); or NULL
 * Checked: sizes, pointers, fractions, ranges; coefficients (fixed_point.h). Row norms of G at most 2^30, its
 * diagonal >= 0; sum_k |A_ik| + sum_k |B_ik| <= 16 in raw values (KQ_ERR_RANGE: state i needs at least so many more
 * integer bits). |A_ii| <= 16 (KQ_ERR_COEFFICIENT: no format helps).
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_RANGE, KQ_ERR_COEFFICIENT, KQ_ERR_TABLE.  Cost: n^2 + n l additions. */
KQ_NODISCARD kq_status kq_process_init_q31(kq_process_q31 *p, const kq_process_table_q31 *table,
    kq_range_error_q31 *range_error);

/** The initialiser of a static const kq_process_q31 in flash, unchecked: a sum may overflow.  Let a test on the host
 * call kq_process_init_q31 with the same arrays.
 *   n, l, ...  the fields of a kq_process_table_q31.  l = 0: NULL for control_format and B
 * One more argument tells where A is 0 (KQ_PROCESS_TABLE).  With it the results are those after init. */
#define KQ_PROCESS_TABLE_Q31(n, l, state_format, control_format, A, B, ...) \
    {n, l, KQ_PRIVATE_LIST(__VA_ARGS__), n, 0, 0, state_format, control_format, A, B, \
        KQ_PRIVATE_GIVEN(__VA_ARGS__)}

/** As kq_process_change_transition_f32; A in raw values, checked as by init.
 *   range_error  written: KQ_NO_RANGE_ERROR; or the row that is refused, and the integer bits that its state lacks
 *                (KQ_ERR_RANGE; 0 bits: KQ_ERR_COEFFICIENT); or NULL
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_RANGE, KQ_ERR_COEFFICIENT. */
KQ_NODISCARD kq_status kq_process_change_transition_q31(kq_process_q31 *p, const kq_scaled_q31 *A,
    kq_range_error_q31 *range_error);

/** As kq_process_check_f32. */
KQ_NODISCARD kq_status kq_process_check_q31(kq_process_q31 *p);

#ifdef __cplusplus
}
#endif
#endif
