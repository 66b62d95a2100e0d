/*
 * kalmanq: the sensor, what is measured of the state.
 *
 *     z[t] = H x[t] + v[t],     v ~ N(0, R)
 *
 * Init checks a sensor once; many filters may then read it.  It refers to your H, and to your R if the components are
 * correlated: do not move or change them while the sensor is in use.
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
    uint8_t states;                        /* n */
    uint8_t components;                    /* m */
    uint8_t length;                        /* words at memory */
    uint8_t measurement_seal;              /* of H (kq_sensor_check) */
    float *memory;                         /* yours; NULL for a const table */
    const float *noise;                    /* diagonal: m variances; correlated: the decorrelation, upper
                                              triangle by columns; NULL until initialised */
    const float *measurement;              /* H, m x n, yours */
    const float *covariance;               /* R, m x m, yours; NULL if it is diagonal */
    uint8_t selects[KQ_SIZE_MAX];          /* 1 + the state that is measured alone and as it is, or 0 */
    uint16_t plain;                        /* n + 256 m where R is diagonal and has noise, otherwise 0 */
    uint8_t seal;                          /* of sizes and addresses; 0: none */
    uint8_t noise_seal;                    /* of the noise */
    const struct kq_sensor_kind_f32 *kind; /* what an update does with it */
} kq_sensor_f32;

typedef struct {
    uint8_t states, components, length, measurement_seal; double *memory;
    const double *noise, *measurement, *covariance; uint8_t selects[KQ_SIZE_MAX]; uint16_t plain;
    uint8_t seal, noise_seal; const struct kq_sensor_kind_f64 *kind;
} kq_sensor_f64;

/** Declares a sensor `name` of m components for n states, with static memory; DIAGONAL: R is diagonal. */
#define KQ_SENSOR_F32(name, n, m) KQ_PRIVATE_SENSOR_WITH(float, kq_sensor_f32, name, n, m, KQ_SENSOR_LEN(m))
#define KQ_SENSOR_F64(name, n, m) KQ_PRIVATE_SENSOR_WITH(double, kq_sensor_f64, name, n, m, KQ_SENSOR_LEN(m))
#define KQ_SENSOR_DIAGONAL_F32(name, n, m) \
    KQ_PRIVATE_SENSOR_WITH(float, kq_sensor_f32, name, n, m, KQ_SENSOR_DIAGONAL_LEN(m))
#define KQ_SENSOR_DIAGONAL_F64(name, n, m) \
    KQ_PRIVATE_SENSOR_WITH(double, kq_sensor_f64, name, n, m, KQ_SENSOR_DIAGONAL_LEN(m))
#define KQ_PRIVATE_SENSOR_WITH(number, type, name, n, m, length) \
    static number name##_memory[length]; \
    static type name = {n, m, length, 0, name##_memory, NULL, NULL, NULL, {0}, 0, 0, 0, NULL}

/** What an update does with a sensor; for the tables that follow. */
extern const struct kq_sensor_kind_f32 kq_sensor_independent_f32, kq_sensor_lean_f32;
extern const struct kq_sensor_kind_f64 kq_sensor_independent_f64, kq_sensor_lean_f64;

/** The initialiser of a static const sensor with independent noises in flash, and of a lean one
 * (kq_sensor_init_lean_f32).  Nothing is checked; kalmanq design writes them.
 *   H        m x n
 *   r        m variances, at least 2^-120 (f32), 2^-400 (f64)
 * One more argument names the components that measure one state as it is (H_ck = 1, else 0), so that a step costs
 * what it costs after init: m numbers in parentheses, 1 + k for such a component, 0 for another one.  Positions at
 * states 0 and 2: KQ_SENSOR_TABLE_F32(4, 2, H, r, (1, 3)).  Without it H is dense. */
#define KQ_SENSOR_TABLE_F32(n, m, H, ...) \
    KQ_PRIVATE_SENSOR(n, m, H, (n) | (m) << 8, &kq_sensor_independent_f32, __VA_ARGS__)
#define KQ_SENSOR_TABLE_F64(n, m, H, ...) \
    KQ_PRIVATE_SENSOR(n, m, H, (n) | (m) << 8, &kq_sensor_independent_f64, __VA_ARGS__)
#define KQ_SENSOR_LEAN_TABLE_F32(n, m, H, ...) KQ_PRIVATE_SENSOR(n, m, H, 0, &kq_sensor_lean_f32, __VA_ARGS__)
#define KQ_SENSOR_LEAN_TABLE_F64(n, m, H, ...) KQ_PRIVATE_SENSOR(n, m, H, 0, &kq_sensor_lean_f64, __VA_ARGS__)
#define KQ_PRIVATE_SENSOR(n, m, H, plain, kind, ...) \
    {n, m, 0, 0, NULL, KQ_PRIVATE_GIVEN(__VA_ARGS__), H, NULL, KQ_PRIVATE_LIST(__VA_ARGS__), plain, 0, \
        0, kind}

/** Gives a sensor its sizes and memory at run time.  Then initialise it.
 *   s        written
 *   n        1..16 states
 *   m        1..16 components
 *   memory   `length` words, yours while the sensor is in use
 *   length   KQ_SENSOR_LEN(m), or KQ_SENSOR_DIAGONAL_LEN(m) for a diagonal R, or more
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY (shorter than a diagonal R needs). */
KQ_NODISCARD kq_status kq_sensor_assign_f32(kq_sensor_f32 *s, int n, int m, float *memory, size_t length);
KQ_NODISCARD kq_status kq_sensor_assign_f64(kq_sensor_f64 *s, int n, int m, double *memory, size_t length);

/** Checks the model and decorrelates R = U D U', so that the components of U^-1 z are independent.
 *   s        with sizes and memory; written
 *   H        m x n, kept by reference
 *   R        m x m, symmetric positive semi-definite, may be singular or 0; kept by reference unless diagonal.  The
 *            upper triangle is used, the lower one compared with it.
 * You may initialise a sensor again between steps; then call kq_freeze_release of a freeze (steady.h).
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SYMMETRIC, KQ_ERR_NOT_SEMIDEFINITE.
 * Accuracy: as Q in process.h.  A variance is at least 2^-120 (f32), 2^-400 (f64).  If the other components leave
 * less than 8 m eps of a variance (f32: 2^-20 for m = 2), that combination counts as noise-free.
 * Cost: about 2 m^3 multiplications, 2m square roots.  Stack: 424 words. */
KQ_NODISCARD kq_status kq_sensor_init_f32(kq_sensor_f32 *s, const float *H, const float *R);
KQ_NODISCARD kq_status kq_sensor_init_f64(kq_sensor_f64 *s, const double *H, const double *R);

/** kq_sensor_init for independent components.
 *   s, H     as in kq_sensor_init
 *   r        m variances >= 0, 0 for a noise-free component; not kept
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SEMIDEFINITE (a variance < 0). */
KQ_NODISCARD kq_status kq_sensor_init_diagonal_f32(kq_sensor_f32 *s, const float *H, const float *r);
KQ_NODISCARD kq_status kq_sensor_init_diagonal_f64(kq_sensor_f64 *s, const double *H, const double *r);

/** A lean sensor: kq_sensor_init_diagonal with 2 kB (f32), 4 kB (q31) of flash less; 5 kB with const tables.
 *   s, H, r  as in kq_sensor_init_diagonal
 * WHICH TO TAKE: lean, unless R is 0 or rows of H repeat exactly (one is a sum of multiples of others).  Then take the
 * full sensor, kq_sensor_init_diagonal, which finds what is redundant (figures: tests/ACCURACY.md).
 * An update takes a low-noise measurement (filter.h; q31: r below 2^-16 S) in up to four stages.  NIS,
 * kq_log_likelihood_last and a history have it once, with r.  KQ_EVENT_LOW_NOISE: it was taken in part, because r is 0,
 * or what was left of H P H' was rounding.  KQ_EVENT_PRECISION: H x is rounded by an eighth of sqrt(r) (f32, f64); a later
 * kq_predict may set it, too.
 * A component whose innovation variance overflows is not taken (KQ_EVENT_OVERFLOW).  Redundant measurements are not
 * found: after a noise-free one of another sensor at the same instant, r must be above 2^-32 of the earlier H P H'.
 * kq_log_likelihood, the sum of the run, leaves all its measurements out.  kq_gain, steady.h, robust.h, adaptation.h,
 * and diffuse.h while a state is unknown treat it as an ordinary sensor.  fixed_size leaves it.
 * Errors: as kq_sensor_init_diagonal.  Accuracy: as kq_update; q31: 2^-22 of S.  Cost: a stage as a component. */
KQ_NODISCARD kq_status kq_sensor_init_lean_f32(kq_sensor_f32 *s, const float *H, const float *r);
KQ_NODISCARD kq_status kq_sensor_init_lean_f64(kq_sensor_f64 *s, const double *H, const double *r);

/** Changes H and keeps the noise: for changing regressors, or a linearised measurement.
 *   s        initialised; changed
 *   H        m x n, kept by reference.  New content in the same array is a change too: call this after it.
 * A history is not affected.  A freeze knows H by its array: after new content call kq_freeze_release.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE.  Cost: m n comparisons and integer multiplications. */
KQ_NODISCARD kq_status kq_sensor_change_measurement_f32(kq_sensor_f32 *s, const float *H);
KQ_NODISCARD kq_status kq_sensor_change_measurement_f64(kq_sensor_f64 *s, const double *H);

/** As kq_process_check, for a sensor.
 *   s        its seal is written; not a const table.  Checked with its memory and H, without R and formats
 * Errors: as kq_process_check.  Cost: as kq_sensor_change_measurement. */
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
    const kq_scaled_q31 *noise;              /* m variances; correlated: KQ_TRIANGLE(m) numbers, D and U of
                                                R = U D U' (prepare.h) */
} kq_sensor_table_q31;

typedef struct {
    uint8_t states, components, correlated, measurement_seal;
    const kq_format_q31 *state_format, *measurement_format; const kq_scaled_q31 *measurement;
    const kq_scaled_q31 *noise; /* NULL until initialised */
    uint8_t selects[KQ_SIZE_MAX]; uint16_t plain; uint8_t seal, noise_seal; const struct kq_sensor_kind_q31 *kind;
} kq_sensor_q31;

/** As kq_sensor_init_f32, _diagonal and _lean, from a table.  No float.
 *   s            written; needs no memory
 *   table        read; its arrays are yours while s is in use
 *   range_error  written: KQ_NO_RANGE_ERROR, or what does not fit (KQ_ERR_RANGE); or NULL
 * Checked: as a process; variances >= 0; sum_k |H_ck| <= 16 in raw values (KQ_ERR_RANGE: c needs more bits).
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_RANGE, KQ_ERR_COEFFICIENT, KQ_ERR_TABLE (diagonal, lean: also a correlated R).
 * The diagonal init links 1 to 4 kB less than the first. */
KQ_NODISCARD kq_status kq_sensor_init_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
    kq_range_error_q31 *range_error);
KQ_NODISCARD kq_status kq_sensor_init_diagonal_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
    kq_range_error_q31 *range_error);
KQ_NODISCARD kq_status kq_sensor_init_lean_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
    kq_range_error_q31 *range_error);

/** What an update does with a sensor; for the tables that follow. */
extern const struct kq_sensor_kind_q31 kq_sensor_independent_q31, kq_sensor_lean_q31;

/** As KQ_SENSOR_TABLE_F32, KQ_SENSOR_LEAN_TABLE_F32.  Nothing is checked: let a test on the host call
 * kq_sensor_init_diagonal_q31 with the same arrays.  The optional argument names components that measure one state as
 * it is in raw values, both of one fraction; with it the results are those after init. */
#define KQ_SENSOR_TABLE_Q31(n, m, state_format, measurement_format, H, ...) \
    {n, m, 0, 0, state_format, measurement_format, H, KQ_PRIVATE_GIVEN(__VA_ARGS__), \
        KQ_PRIVATE_LIST(__VA_ARGS__), (n) | (m) << 8, 0, 0, &kq_sensor_independent_q31}
#define KQ_SENSOR_LEAN_TABLE_Q31(n, m, state_format, measurement_format, H, ...) \
    {n, m, 0, 0, state_format, measurement_format, H, KQ_PRIVATE_GIVEN(__VA_ARGS__), \
        KQ_PRIVATE_LIST(__VA_ARGS__), 0, 0, 0, &kq_sensor_lean_q31}

/** As kq_sensor_change_measurement_f32; H in raw values, checked as by init.
 *   range_error  written: KQ_NO_RANGE_ERROR; or the component that is refused, and the integer bits that its format
 *                lacks (KQ_ERR_RANGE; 0 bits: KQ_ERR_COEFFICIENT); or NULL
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_RANGE, KQ_ERR_COEFFICIENT. */
KQ_NODISCARD kq_status kq_sensor_change_measurement_q31(kq_sensor_q31 *s, const kq_scaled_q31 *H,
    kq_range_error_q31 *range_error);

/** As kq_sensor_check_f32; the noise is checked where its table has it. */
KQ_NODISCARD kq_status kq_sensor_check_q31(kq_sensor_q31 *s);

#ifdef __cplusplus
}
#endif
#endif
