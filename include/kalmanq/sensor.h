/*
 * kalmanq: the sensor, what is measured of the state.
 *
 *     z[t] = H x[t] + v[t],     v ~ N(0, R)
 *
 * Prepared and checked once, only read afterwards, shared by as many filters as you like.  It
 * refers to the caller's H (and to R, where the components are correlated), which must stay
 * as they are for as long as the sensor is used.
 */
#ifndef KALMANQ_SENSOR_H
#define KALMANQ_SENSOR_H

#include "fixed_point.h"
#include "size.h"
#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Words of memory of a sensor with m components: with any R, and with a diagonal one. */
#define KQ_SENSOR_LEN(m) KQ_TRIANGLE(m)
#define KQ_SENSOR_DIAGONAL_LEN(m) (m)

/* The fields are the library's (see process.h). */
typedef struct {
    uint8_t states;               /* n */
    uint8_t components;           /* m */
    uint8_t length;               /* words at memory */
    uint8_t measurement_seal;     /* of H (kq_sensor_check) */
    float *memory;                /* the caller's; NULL for a const table */
    const float *noise;           /* diagonal: m variances; correlated: the decorrelation,
                                     upper triangle by columns; NULL until initialised */
    const float *measurement;     /* H, m x n, the caller's */
    const float *covariance;      /* R, m x m, the caller's; NULL where it is diagonal */
    uint8_t selects[KQ_SIZE_MAX]; /* 1 + the state that is measured alone and as it is, or 0 */
    uint16_t plain;               /* n + 256 m where R is diagonal and has noise, otherwise 0 */
    uint8_t seal;                 /* of sizes and addresses; 0: none */
    uint8_t noise_seal;           /* of the noise */
    const struct kq_sensor_kind_f32 *kind; /* what an update does with it */
} kq_sensor_f32;

typedef struct {
    uint8_t states;
    uint8_t components;
    uint8_t length;
    uint8_t measurement_seal;
    double *memory;
    const double *noise;
    const double *measurement;
    const double *covariance;
    uint8_t selects[KQ_SIZE_MAX];
    uint16_t plain;
    uint8_t seal;
    uint8_t noise_seal;
    const struct kq_sensor_kind_f64 *kind;
} kq_sensor_f64;

/** A sensor `name` of m components for n states with its storage, in static memory. */
#define KQ_SENSOR_F32(name, n, m)                                                                  \
    static float name##_memory[KQ_SENSOR_LEN(m)];                                                  \
    static kq_sensor_f32 name = {                                                                  \
        n, m, KQ_SENSOR_LEN(m), 0, name##_memory, NULL, NULL, NULL, {0}, 0, 0, 0, NULL}
#define KQ_SENSOR_F64(name, n, m)                                                                  \
    static double name##_memory[KQ_SENSOR_LEN(m)];                                                 \
    static kq_sensor_f64 name = {                                                                  \
        n, m, KQ_SENSOR_LEN(m), 0, name##_memory, NULL, NULL, NULL, {0}, 0, 0, 0, NULL}

/** What an update does with a sensor; for the tables that follow. */
extern const struct kq_sensor_kind_f32 kq_sensor_independent_f32, kq_sensor_lean_f32;
extern const struct kq_sensor_kind_f64 kq_sensor_independent_f64, kq_sensor_lean_f64;

/**
 * A sensor with independent noises as a constant, in flash (KQ_PROCESS_TABLE), and a lean one
 * (kq_sensor_init_lean_f32):
 *   H        m x n
 *   r        m variances, at least 2^-120 (f32), 2^-400 (f64)
 * One more argument may name the components that measure one state as it is (H_ck = 1, and 0 elsewhere),
 * and a step then costs what it costs by init: m numbers in parentheses, 1 + k for such a component and 0 for
 * any other.  For positions at states 0 and 2:
 *
 *     KQ_SENSOR_TABLE_F32(4, 2, H, r, (1, 3));
 *
 * Without it H is taken for dense.  kalmanq design writes it.  Nothing of a table is checked.
 */
#define KQ_SENSOR_TABLE_F32(n, m, H, ...)                                                          \
    KQ_PRIVATE_SENSOR(n, m, H, (n) | (m) << 8, &kq_sensor_independent_f32, __VA_ARGS__)
#define KQ_SENSOR_TABLE_F64(n, m, H, ...)                                                          \
    KQ_PRIVATE_SENSOR(n, m, H, (n) | (m) << 8, &kq_sensor_independent_f64, __VA_ARGS__)
#define KQ_SENSOR_LEAN_TABLE_F32(n, m, H, ...)                                                     \
    KQ_PRIVATE_SENSOR(n, m, H, 0, &kq_sensor_lean_f32, __VA_ARGS__)
#define KQ_SENSOR_LEAN_TABLE_F64(n, m, H, ...)                                                     \
    KQ_PRIVATE_SENSOR(n, m, H, 0, &kq_sensor_lean_f64, __VA_ARGS__)
#define KQ_PRIVATE_SENSOR(n, m, H, plain, kind, ...)                                               \
    {                                                                                              \
        n, m, 0, 0, NULL, KQ_PRIVATE_GIVEN(__VA_ARGS__), H, NULL, KQ_PRIVATE_LIST(__VA_ARGS__),       \
            plain, 0, 0, kind                                                                      \
    }

/** The same with the memory of a diagonal R only. */
#define KQ_SENSOR_DIAGONAL_F32(name, n, m)                                                         \
    static float name##_memory[KQ_SENSOR_DIAGONAL_LEN(m)];                                         \
    static kq_sensor_f32 name = {                                                                  \
        n, m, KQ_SENSOR_DIAGONAL_LEN(m), 0, name##_memory, NULL, NULL, NULL, {0}, 0, 0, 0, NULL}
#define KQ_SENSOR_DIAGONAL_F64(name, n, m)                                                         \
    static double name##_memory[KQ_SENSOR_DIAGONAL_LEN(m)];                                        \
    static kq_sensor_f64 name = {                                                                  \
        n, m, KQ_SENSOR_DIAGONAL_LEN(m), 0, name##_memory, NULL, NULL, NULL, {0}, 0, 0, 0, NULL}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   s        written
 *   n, m     1..16
 *   memory   KQ_SENSOR_LEN(m) words, or KQ_SENSOR_DIAGONAL_LEN(m) if only
 *            kq_sensor_init_diagonal will be called
 *   length   words at memory
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY (shorter than a diagonal R needs).
 */
KQ_NODISCARD kq_status kq_sensor_assign_f32(kq_sensor_f32 *s, int n, int m, float *memory, size_t length);
KQ_NODISCARD kq_status kq_sensor_assign_f64(kq_sensor_f64 *s, int n, int m, double *memory, size_t length);

/**
 * z = H x + v,  v ~ N(0, R), components correlated or not.
 *   s        read: sizes, memory.  Written: the rest.
 *   H        m x n, kept by reference
 *   R        m x m, symmetric positive semi-definite, may be singular or 0; both triangles are
 *            compared, the upper one is used; kept by reference unless it is diagonal
 * A correlated R is decorrelated once, here: R = U D U', U unit upper triangular, and the
 * components of U^-1 z are independent.  May be called again with another model, between steps too; a
 * settling is to be told of that by kq_freeze_release (steady.h).
 * Cost: about 2 m^3 multiplications, 2m square roots; stack: 424 words.
 * Accuracy: as Q in process.h.  A variance is at least 2^-120 (f32) or 2^-400 (f64).  What the other
 * components leave of one counts as none below 8 m eps of it (f32: 2^-20 for two): such a combination is
 * free of noise then.
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SYMMETRIC,
 * KQ_ERR_NOT_SEMIDEFINITE.
 */
KQ_NODISCARD kq_status kq_sensor_init_f32(kq_sensor_f32 *s, const float *H, const float *R);
KQ_NODISCARD kq_status kq_sensor_init_f64(kq_sensor_f64 *s, const double *H, const double *R);

/**
 * The same for independent components.
 *   r        m variances, each >= 0, 0 for a noise-free component; not kept
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SEMIDEFINITE
 * (a negative variance).
 */
KQ_NODISCARD kq_status kq_sensor_init_diagonal_f32(kq_sensor_f32 *s, const float *H, const float *r);
KQ_NODISCARD kq_status kq_sensor_init_diagonal_f64(kq_sensor_f64 *s, const double *H, const double *r);

/**
 * The same for a program without flash to spare: the careful path for low-noise measurements is not linked
 * (2 kB f32, 4 kB q31; kq_update in filter.h), nor what sums the log-likelihood.
 * S = H P H' + r.  A component with r < 2^-16 S (f32; q31: 2^-16 or 2^-17) or 2^-48 S (f64), or without
 * noise, is taken coarsely: r is raised to 2^-15 S (f64: 2^-47 S), and KQ_EVENT_LOW_NOISE is set.  NIS, the
 * likelihood and a history have the raised noise: what was done.  So after an outage of any length each
 * measurement lowers the sigma of H x by at least 2^7 (f64: 2^23), until r is no longer raised.  Observed on
 * chains of 1 to 4 integrators, outages of up to 1e5 steps: its sigmas are at most 4 n measurements (f64: n)
 * behind those by an ordinary sensor.
 * For P0 below 2^16 r (2^48 r), in the units of z, and without outages nothing is raised.
 * An innovation variance that overflows is not taken (KQ_EVENT_OVERFLOW).  In q31 a state that
 * a component leads out of its word is held there before the next component (KQ_EVENT_SATURATED).  Rounding
 * is not looked for: after a noise-free measurement of another sensor at the same instant, r must be above
 * 2^-32 of what H P H' was before that one.
 * Accuracy: as kq_update, q31: 2^-22 of S.  kq_log_likelihood knows nothing of its measurements.
 * Elsewhere it is an ordinary sensor: to robust.h, adaptation.h, diffuse.h while a state is unknown, which
 * take what is sharp with care; to kq_gain and steady.h, whose gain has it taken.  The functions for known
 * sizes (src/fixed_size/) leave it to those here.
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SEMIDEFINITE.
 */
KQ_NODISCARD kq_status kq_sensor_init_lean_f32(kq_sensor_f32 *s, const float *H, const float *r);
KQ_NODISCARD kq_status kq_sensor_init_lean_f64(kq_sensor_f64 *s, const double *H, const double *r);

/**
 * Another H with the noise as it is: a regression with changing regressors, or a linearised
 * measurement.  The same array with new content counts as another H.
 *   s        initialised before
 *   H        m x n, kept by reference
 * Recorded history is not touched by it: a sensor may change at every step (smoother.h).  A freeze
 * knows H by its array: it is to be told of new content there by kq_freeze_release (steady.h).
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE.
 */
KQ_NODISCARD kq_status kq_sensor_change_measurement_f32(kq_sensor_f32 *s, const float *H);
KQ_NODISCARD kq_status kq_sensor_change_measurement_f64(kq_sensor_f64 *s, const double *H);

/**
 * Has memory damaged s?  As kq_process_check: the first call after an init or a change keeps seals.
 *   s        read, with its memory and H; its seals are written
 * One turned bit is always found in s (but in bytes that are not used), in its memory and in H.  R and the formats are not looked at.
 * Cost: as kq_sensor_change_measurement.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_TABLE (s is damaged: initialise it again).
 */
KQ_NODISCARD kq_status kq_sensor_check_f32(kq_sensor_f32 *s);
KQ_NODISCARD kq_status kq_sensor_check_f64(kq_sensor_f64 *s);

/* ------------------------------------------------------------------ q31 */

/** A sensor as a table (process.h, fixed_point.h). */
typedef struct {
    int32_t states;                          /* n: 1..16 */
    int32_t components;                      /* m: 1..16 */
    int32_t correlated;                      /* 0: R is diagonal, 1: it is not */
    const kq_format_q31 *state_format;       /* n */
    const kq_format_q31 *measurement_format; /* m */
    const kq_scaled_q31 *measurement;        /* H, m x n */
    const kq_scaled_q31 *noise;              /* m variances; correlated: KQ_TRIANGLE(m) numbers, D
                                                and U of R = U D U' (prepare.h) */
} kq_sensor_table_q31;

/* The fields are the library's. */
typedef struct {
    uint8_t states;
    uint8_t components;
    uint8_t correlated;
    uint8_t measurement_seal;
    const kq_format_q31 *state_format;
    const kq_format_q31 *measurement_format;
    const kq_scaled_q31 *measurement;
    const kq_scaled_q31 *noise; /* NULL until initialised */
    uint8_t selects[KQ_SIZE_MAX];
    uint16_t plain;
    uint8_t seal;
    uint8_t noise_seal;
    const struct kq_sensor_kind_q31 *kind;
} kq_sensor_q31;

/**
 * Checks a table and takes it into use: its arrays are kept by reference.  No float code.
 *   s        written; needs no memory of its own
 *   range_error   written: KQ_NO_RANGE_ERROR, or what does not fit where that is refused (KQ_ERR_RANGE); or NULL
 * Checked: as a process; variances >= 0; sum_k |H_ck| <= 16 in words: if not, measurement c
 * needs more integer bits.
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_RANGE, KQ_ERR_COEFFICIENT, KQ_ERR_TABLE.
 */
KQ_NODISCARD kq_status kq_sensor_init_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
                             kq_range_error_q31 *range_error);

/**
 * The same for a table whose R is diagonal, and for no other (KQ_ERR_TABLE): what takes a correlated R
 * apart is not linked, 1 to 4 kB.
 */
KQ_NODISCARD kq_status kq_sensor_init_diagonal_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
                                      kq_range_error_q31 *range_error);

/**
 * As kq_sensor_init_lean_f32, for a table whose R is diagonal (KQ_ERR_TABLE).  The errors of
 * kq_sensor_init_q31.
 */
KQ_NODISCARD kq_status kq_sensor_init_lean_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
                                  kq_range_error_q31 *range_error);

/** What an update does with a sensor; for the tables that follow. */
extern const struct kq_sensor_kind_q31 kq_sensor_independent_q31, kq_sensor_lean_q31;

/**
 * A sensor with independent noises as a constant, in flash, that is not checked where it runs
 * (KQ_PROCESS_TABLE_Q31), and a lean one: kq_sensor_init_diagonal_q31 must accept the same arrays.  One more
 * argument may name the components that measure one state as it is in raw values, both of one fraction
 * (KQ_SENSOR_TABLE_F32).  With it the raw values are those by init.
 */
#define KQ_SENSOR_TABLE_Q31(n, m, state_format, measurement_format, H, ...)                        \
    {                                                                                              \
        n, m, 0, 0, state_format, measurement_format, H, KQ_PRIVATE_GIVEN(__VA_ARGS__),               \
            KQ_PRIVATE_LIST(__VA_ARGS__), (n) | (m) << 8, 0, 0, &kq_sensor_independent_q31         \
    }
#define KQ_SENSOR_LEAN_TABLE_Q31(n, m, state_format, measurement_format, H, ...)                   \
    {                                                                                              \
        n, m, 0, 0, state_format, measurement_format, H, KQ_PRIVATE_GIVEN(__VA_ARGS__),               \
            KQ_PRIVATE_LIST(__VA_ARGS__), 0, 0, 0, &kq_sensor_lean_q31                             \
    }

/**
 * As kq_sensor_change_measurement_f32; H in words, checked as by init.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_RANGE, KQ_ERR_COEFFICIENT.
 */
KQ_NODISCARD kq_status kq_sensor_change_measurement_q31(kq_sensor_q31 *s, const kq_scaled_q31 *H,
    kq_range_error_q31 *range_error);

/** As kq_sensor_check_f32; the noise is where its table has it. */
KQ_NODISCARD kq_status kq_sensor_check_q31(kq_sensor_q31 *s);

#ifdef __cplusplus
}
#endif
#endif
