/*
 * kalmanq: the process, how the state moves from one step to the next.
 *
 *     x[t+1] = A x[t] + B u[t] + w[t],     w ~ N(0, Q),     Q = G G'
 *
 * A process is prepared and checked once and is only read afterwards: many filters may share
 * it.  It refers to the caller's A and B, which must stay as they are for as long as the
 * process is used (constants may stay in flash), and keeps the root G of Q in its memory.  An A
 * that is written anew is told by kq_process_change_transition: without it the process still
 * looks for the old A's zeros, and no history and no freeze sees the change.
 *
 * All matrices are dense and row-major: entry (i, j) of an r x c matrix M is M[i * c + j].
 */
#ifndef KALMANQ_PROCESS_H
#define KALMANQ_PROCESS_H

#include "fixed_point.h"
#include "size.h"
#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Words of memory of a process with n states. */
#define KQ_PROCESS_LEN(n) KQ_TRIANGLE(n)

/* The fields are the library's, to be declared by the macros below and read by no one else.
   They are in the open so that a prepared process can be a const table in flash. */
typedef struct {
    uint8_t states;             /* n */
    uint8_t controls;           /* l */
    uint16_t length;            /* words at memory */
    float *memory;              /* the caller's; NULL for a const table */
    const float *noise_root;    /* G, upper triangle by columns; NULL until initialised */
    const float *transition;    /* A, n x n, the caller's */
    const float *control;       /* B, n x l, the caller's, or NULL */
    uint8_t first[KQ_SIZE_MAX]; /* first[i]: all of A's rows >= i are 0 left of it */
    uint8_t plain;              /* n, 128 more where A is upper triangular, 64 more where an A_ii < 1/2
                                   (a const table: maybe); 0: not initialised */
    uint8_t seal;         /* of sizes and addresses (kq_process_check); 0: none */
    uint32_t fingerprint; /* of A and G: what a history and a freeze know the process by */
} kq_process_f32;

typedef struct {
    uint8_t states;
    uint8_t controls;
    uint16_t length;
    double *memory;
    const double *noise_root;
    const double *transition;
    const double *control;
    uint8_t first[KQ_SIZE_MAX];
    uint8_t plain;
    uint8_t seal;
    uint32_t fingerprint;
} kq_process_f64;

/** A process `name` of n states and l controls (0: none) with its storage, at file or block
    scope, in static memory. */
#define KQ_PROCESS_F32(name, n, l)                                                                 \
    static float name##_memory[KQ_PROCESS_LEN(n)];                                                 \
    static kq_process_f32 name = {n, l, KQ_PROCESS_LEN(n), name##_memory, NULL, NULL, NULL, {0}, 0, 0, 0}
#define KQ_PROCESS_F64(name, n, l)                                                                 \
    static double name##_memory[KQ_PROCESS_LEN(n)];                                                \
    static kq_process_f64 name = {n, l, KQ_PROCESS_LEN(n), name##_memory, NULL, NULL, NULL, {0}, 0, 0, 0}

/**
 * A process as a constant, in flash: what stands behind the = of a static const kq_process_<T>.
 *   A, B     as for kq_process_init
 *   G        the root of Q = G G', upper triangle by columns (G_11, G_12, G_22, G_13, ...),
 *            n (n + 1) / 2 numbers, on its diagonal at least 2^-60 (f32), 2^-200 (f64).  By hand, or
 *            from the memory of a process that a program on the host has initialised with Q.
 *
 *     static const float A[] = {1, 0.01f, 0, 1}, G[] = {1e-4f, 5e-4f, 0.1f};
 *     static const kq_process_f32 motion = KQ_PROCESS_TABLE(2, 0, A, NULL, G);
 *
 * One more argument may say where A is 0, and a step then costs what it costs by init: n numbers in
 * parentheses, number i for the column left of which all rows from i on are 0.  For an upper triangular A of
 * three states that is
 *
 *     KQ_PROCESS_TABLE(3, 0, A, NULL, G, (0, 1, 2));
 *
 * Without it A is taken for dense.  A number too small costs time; one too large leaves out coefficients.
 * kalmanq design writes them.  Nothing of a table is checked, and no history and no freeze sees that one
 * table was assigned over another.
 */
#define KQ_PROCESS_TABLE(n, l, A, B, ...)                                                          \
    {                                                                                              \
        n, l, 0, NULL, KQ_PRIVATE_GIVEN(__VA_ARGS__), A, B, KQ_PRIVATE_LIST(__VA_ARGS__),          \
            (n) + 64, 0, 0                                                                         \
    }

/**
 * Gives a process its sizes and its memory where they are known at run time only (the macros
 * above do the same at compile time).  It still has to be initialised.
 *   p        written
 *   n, l     1..16, 0..16
 *   memory   KQ_PROCESS_LEN(n) words or more, uninitialised; the process keeps the pointer
 *   length   words at memory
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY (length too short).
 */
KQ_NODISCARD kq_status kq_process_assign_f32(kq_process_f32 *p, int n, int l, float *memory, size_t length);
KQ_NODISCARD kq_status kq_process_assign_f64(kq_process_f64 *p, int n, int l, double *memory, size_t length);

/**
 * x[t+1] = A x[t] + B u[t] + w,  w ~ N(0, Q).  Checks the model and factors Q = G G'.
 *   p        read: sizes, memory.  Written: the rest.
 *   A        n x n, kept by reference
 *   B        n x l, kept by reference; ignored if l = 0
 *   Q        n x n, symmetric positive semi-definite, may be singular or 0; both triangles are
 *            compared, the upper one is used; not kept
 * May be called again with another model, between steps too.  A history that refers to p is then
 * no longer smoothed by it (smoother.h); a freeze begins again (steady.h).
 * Cost: about 2 n^3 multiplications, 2n square roots; stack: 424 words.
 * Accuracy: G is exact for a Q perturbed by a few n eps sqrt(Q_ii Q_jj).  Where the other
 * states explain a variance up to 8 n eps of itself, the rest counts as 0: give the factor
 * (below) if that rest matters.  G_ii is at least 2^-60 (f32) or 2^-200 (f64): a standard
 * deviation below that is noise to the arithmetic.
 * KQ_ERR_SIZE and KQ_ERR_MEMORY also stand for a p that was never given its sizes and memory.
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SYMMETRIC,
 * KQ_ERR_NOT_SEMIDEFINITE, KQ_ERR_RANGE (a variance above 2^120 in f32, 2^1000 in f64).
 */
KQ_NODISCARD kq_status kq_process_init_f32(kq_process_f32 *p, const float *A, const float *B, const float *Q);
KQ_NODISCARD kq_status kq_process_init_f64(kq_process_f64 *p, const double *A, const double *B, const double *Q);

/**
 * The same model with Q = F F' given by a factor: exact where Q is singular, and more accurate
 * where its entries span many decades.
 *   F        n x r, any shape and rank; not kept
 *   r        0..16 columns (0: no noise; F may be NULL then)
 * Cost: n^2 r multiplications and n square roots; stack: 424 words.
 * Errors as kq_process_init, without the two of Q.
 */
KQ_NODISCARD kq_status kq_process_init_factor_f32(kq_process_f32 *p, const float *A, const float *B,
                                     const float *F, int r);
KQ_NODISCARD kq_status kq_process_init_factor_f64(kq_process_f64 *p, const double *A, const double *B,
                                     const double *F, int r);

/**
 * The same model with Q = G G' given by its root, which has been made beforehand, say on the host:
 * what makes roots is not linked, 1 to 2 kB.
 *   G        upper triangular, diagonal >= 0, packed by columns: g_00, g_01, g_11, g_02, ...
 *            (KQ_TRIANGLE(n)); not kept.  In NumPy: U = cholesky(Q[::-1, ::-1])[::-1, ::-1], then
 *            G = U.T[tril_indices(n)]
 * Cost: n^3 / 6 multiplications.  Accuracy: G's, but for G_ii below 2^-60 (f32) or 2^-200 (f64).
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SEMIDEFINITE (a diagonal entry
 * below 0), KQ_ERR_RANGE (a variance above 2^120 in f32, 2^1000 in f64).
 */
KQ_NODISCARD kq_status kq_process_init_root_f32(kq_process_f32 *p, const float *A, const float *B,
                                   const float *G);
KQ_NODISCARD kq_status kq_process_init_root_f64(kq_process_f64 *p, const double *A, const double *B,
                                   const double *G);

/**
 * Another A with the noise as it is: for a step length that varies, or a linearised model.  A
 * history that recorded a predict by the old one is no longer smoothed by p (smoother.h); a freeze
 * begins again (steady.h).
 *   p        initialised before
 *   A        n x n, kept by reference.  The same array with new content counts as another A:
 *            call this after every change of it.
 * Cost: n^2 comparisons, 1.5 n^2 integer multiplications.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE.
 */
KQ_NODISCARD kq_status kq_process_change_transition_f32(kq_process_f32 *p, const float *A);
KQ_NODISCARD kq_status kq_process_change_transition_f64(kq_process_f64 *p, const double *A);

/**
 * Has memory damaged p?  The first call after an init or a change keeps seals in p, later calls compare.
 * Call it once when p is prepared, then as often as you like.
 *   p        read, with A and the root G of Q; its seal is written.  Not a const table: flash has its own checks.
 * One turned bit is always found in p (but in bytes that are not used), in G and in A (in A and G already by the first call).  Of a table and of a
 * process of kq_process_scale_noise it is found in p alone.  B and the formats are not looked at.
 * Sizes and addresses are compared before any address is followed.
 * Cost: as kq_process_change_transition.  Linked only if it is called; a step does nothing for it.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_TABLE (p is damaged: initialise it again).
 */
KQ_NODISCARD kq_status kq_process_check_f32(kq_process_f32 *p);
KQ_NODISCARD kq_status kq_process_check_f64(kq_process_f64 *p);

/* ------------------------------------------------------------------ q31 */

/** A process as a table, const and in flash if you like; prepare.h fills in the arrays, or a
    tool writes them (fixed_point.h: the units). */
typedef struct {
    int32_t states;                      /* n: 1..16 */
    int32_t controls;                    /* l: 0..16 */
    const kq_format_q31 *state_format;   /* n */
    const kq_format_q31 *control_format; /* l, NULL if l = 0 */
    const kq_scaled_q31 *transition;     /* A, n x n */
    const kq_scaled_q31 *control;        /* B, n x l, NULL if l = 0 */
    const int32_t *noise_root;           /* G, KQ_ROOT_LEN_Q31(n) words */
} kq_process_table_q31;

/* The fields are the library's. */
typedef struct {
    uint8_t states;
    uint8_t controls;
    uint8_t first[KQ_SIZE_MAX];
    uint8_t plain;
    uint8_t seal;
    uint32_t fingerprint;
    const kq_format_q31 *state_format;
    const kq_format_q31 *control_format;
    const kq_scaled_q31 *transition;
    const kq_scaled_q31 *control;
    const int32_t *noise_root; /* NULL until initialised */
} kq_process_q31;

/**
 * Checks a table and takes it into use: its arrays are kept by reference.  No float code.
 *   p        written; needs no memory of its own
 *   range_error   written: KQ_NO_RANGE_ERROR, or what does not fit where that is refused (KQ_ERR_RANGE); or NULL
 * What is checked, so that nothing can overflow afterwards, whatever the data:
 *     sizes, pointers, fractions and ranges; coefficients as fixed_point.h says;
 *     row norms of G at most 2^30, its pivots >= 0;
 *     sum_k |A_ik| + sum_k |B_ik| <= 16 in words: if not, state i needs more integer bits, at
 *     least as many as the range_error says (KQ_ERR_RANGE);  |A_ii| <= 16, which no format could help
 *     (KQ_ERR_COEFFICIENT).
 * Cost: n^2 + n l additions.
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_RANGE, KQ_ERR_COEFFICIENT, KQ_ERR_TABLE.
 */
KQ_NODISCARD kq_status kq_process_init_q31(kq_process_q31 *p, const kq_process_table_q31 *table,
                              kq_range_error_q31 *range_error);

/**
 * A process as a constant, in flash, that is not checked where it runs: what stands behind the = of a
 * static const kq_process_q31.  The arguments are the fields of a kq_process_table_q31 of the same
 * arrays, which kq_process_init_q31 must accept: let a test on the host call it.  What it refuses may
 * overflow here unseen.
 *   l, control_format, B    0, NULL, NULL where there is no control
 * One more argument may say where A is 0 (KQ_PROCESS_TABLE).  With it the raw values are those by init.
 */
#define KQ_PROCESS_TABLE_Q31(n, l, state_format, control_format, A, B, ...)                        \
    {                                                                                              \
        n, l, KQ_PRIVATE_LIST(__VA_ARGS__), n, 0, 0, state_format, control_format, A, B,           \
            KQ_PRIVATE_GIVEN(__VA_ARGS__)                                                          \
    }

/**
 * As kq_process_change_transition_f32; A in words, checked as by init.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_RANGE, KQ_ERR_COEFFICIENT.
 */
KQ_NODISCARD kq_status kq_process_change_transition_q31(kq_process_q31 *p, const kq_scaled_q31 *A,
    kq_range_error_q31 *range_error);

/** As kq_process_check_f32. */
KQ_NODISCARD kq_status kq_process_check_q31(kq_process_q31 *p);

#ifdef __cplusplus
}
#endif
#endif
