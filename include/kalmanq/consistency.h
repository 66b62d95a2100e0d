/*
 * kalmanq: is the filter consistent with its measurements?  Statistics over the last W updates.
 *
 *     NIS         sum of e' S^-1 e: chi-square with a degree of freedom for each scalar taken
 *     innovation  nu_c = e_c / sqrt(S_cc): N(0, 1), and white
 *
 * How to read them.
 *   - Mean NIS per degree of freedom above its bounds: the filter is too sure (Q or R too small, wrong
 *     model).  Below: not sure enough.
 *   - Correlation of nu from one update to the next above its bound: the gain is too low (Q too small against
 *     R), or the model lacks something.  Below: the gain is too high.  Look at this before the mean.
 *   - Mean of nu outside its bound, correlation within: a bias that no state takes up, or states that return
 *     too slowly.  A state that can take up a sensor's bias hides it; a second sensor shows it.
 *
 *     kq_consistency_watch_f32(&window, &track, &radar, z, UINT32_MAX);
 *     kq_update_f32(&track, &radar, z);
 *     kq_consistency_record_f32(&window, &track);
 *     ... and every now and then
 *     kq_consistency_nis_f32(&window, 1.96f, &nis, &low, &high);
 *     kq_consistency_innovation_f32(&window, 0, 1.96f, &mean, &mean_bound, &correlation, &correlation_bound);
 *
 * One object watches one sensor, or sensors that share a meaning of their components.  Sums are formed when you read
 * them: the window is exact, and nothing drifts.
 */
#ifndef KALMANQ_CONSISTENCY_H
#define KALMANQ_CONSISTENCY_H

#include "filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Length of the memory, in words, for m components and a window of W updates. */
#define KQ_CONSISTENCY_LEN_F32(m, window) (((kq_length)(window) + 1) * ((kq_length)(m) + 2))
#define KQ_CONSISTENCY_LEN_F64(m, window) (((kq_length)(window) + 1) * ((kq_length)(m) + 2))
#define KQ_CONSISTENCY_LEN_Q31(m, window) (((kq_length)(window) + 1) * ((kq_length)(m) + 3))

/** Largest W. */
#define KQ_WINDOW_MAX 32766

/* The fields are the library's (see process.h). */
typedef struct {
    uint8_t components, watched; /* m; is an update on its way in the entry `next`? */
    int16_t window, count; /* W; updates in the window */
    int16_t next; /* of the W + 1 entries, the one to be written next */
    float *memory; /* the caller's: entries of NIS, number taken, m innovations */
} kq_consistency_f32;
typedef struct {
    uint8_t components, watched; int16_t window, count, next; double *memory;
} kq_consistency_f64;
typedef struct {
    uint8_t components, watched; int16_t window, count, next;
    int32_t *memory; /* a NIS is two words, innovations are Q7.24 */
} kq_consistency_q31;

/** Declares an empty object `name` for m components and a window of W updates with its static memory. */
#define KQ_CONSISTENCY_F32(name, m, window) \
    static float name##_memory[KQ_CONSISTENCY_LEN_F32(m, window)]; \
    static kq_consistency_f32 name = {m, 0, window, 0, 0, name##_memory}
#define KQ_CONSISTENCY_F64(name, m, window) \
    static double name##_memory[KQ_CONSISTENCY_LEN_F64(m, window)]; \
    static kq_consistency_f64 name = {m, 0, window, 0, 0, name##_memory}
#define KQ_CONSISTENCY_Q31(name, m, window) \
    static int32_t name##_memory[KQ_CONSISTENCY_LEN_Q31(m, window)]; \
    static kq_consistency_q31 name = {m, 0, window, 0, 0, name##_memory}

/** Sets sizes and memory at run time.
 *   c        written
 *   m        1..16 components
 *   window   W: 1 .. KQ_WINDOW_MAX updates
 *   memory   `length` words, yours while in use
 *   length   KQ_CONSISTENCY_LEN_<T>(m, W) or more
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY. */
KQ_NODISCARD kq_status kq_consistency_assign_f32(kq_consistency_f32 *c, int m, size_t window, float *memory,
    size_t length);
KQ_NODISCARD kq_status kq_consistency_assign_f64(kq_consistency_f64 *c, int m, size_t window, double *memory,
    size_t length);
KQ_NODISCARD kq_status kq_consistency_assign_q31(kq_consistency_q31 *c, int m, size_t window, int32_t *memory,
    size_t length);

/** Empties the window.
 *   c        changed
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (no memory). */
KQ_NODISCARD kq_status kq_consistency_clear_f32(kq_consistency_f32 *c);
KQ_NODISCARD kq_status kq_consistency_clear_f64(kq_consistency_f64 *c);
KQ_NODISCARD kq_status kq_consistency_clear_q31(kq_consistency_q31 *c);

/** Notes nu of every component that is present.  Call it between kq_predict and kq_update; do not use kq_step.
 *   c        written
 *   f        read
 *   s        of n states and m components; read
 *   z, present   as for kq_update_subset; UINT32_MAX for kq_update
 * A component counts as missing if its S_cc counts as 0 (KQ_EVENT_REDUNDANT) or its nu is beyond 2^48 (f64:
 * 2^180); q31's nu is held at +-128.
 * Cost: n^2/2 + 2n multiplications, one root and one division a component.  Stack: n words.
 * Errors of kq_update_subset; KQ_ERR_MISMATCH also where the sensor does not have m components. */
KQ_NODISCARD kq_status kq_consistency_watch_f32(kq_consistency_f32 *c, const kq_filter_f32 *f,
    const kq_sensor_f32 *s, const float *z, uint32_t present);
KQ_NODISCARD kq_status kq_consistency_watch_f64(kq_consistency_f64 *c, const kq_filter_f64 *f,
    const kq_sensor_f64 *s, const double *z, uint32_t present);
KQ_NODISCARD kq_status kq_consistency_watch_q31(kq_consistency_q31 *c, const kq_filter_q31 *f,
    const kq_sensor_q31 *s, const int32_t *z, uint32_t present);

/** Records the watched update, with kq_nis and kq_taken; the oldest leaves the window.  Call it after it.
 *   c        written
 *   f        read
 * An update that took nothing is not recorded.  A gate that rejects makes a filter look more consistent.
 * Cost: a copy of a few words; with a frozen kq_freeze attached n (n + 1) / 2 comparisons.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (f; nothing watched since the last record; or the last step was frozen). */
KQ_NODISCARD kq_status kq_consistency_record_f32(kq_consistency_f32 *c, const kq_filter_f32 *f);
KQ_NODISCARD kq_status kq_consistency_record_f64(kq_consistency_f64 *c, const kq_filter_f64 *f);
KQ_NODISCARD kq_status kq_consistency_record_q31(kq_consistency_q31 *c, const kq_filter_q31 *f);

/** Updates in the window, 0 .. W.
 *   c        read; 0 for NULL */
size_t kq_consistency_count_f32(const kq_consistency_f32 *c);
size_t kq_consistency_count_f64(const kq_consistency_f64 *c);
size_t kq_consistency_count_q31(const kq_consistency_q31 *c);

/** The mean NIS per degree of freedom, 1 but for chance, and its bounds.
 *   c        read
 *   q        >= 0: normal quantile, 1.96 for 95 %, 2.576 for 99 %
 *   nis      written: the sum of NIS / d, d scalar measurements taken
 *   low      written: the lower bound by Wilson and Hilferty, (1 - a - q sqrt(a))^3, a = 2 / (9 d); >= 0
 *   high     written: the upper bound, + in place of the second -
 * Accuracy: the coverage is within 0.001 of its level for d >= 10, within 0.003 for d >= 5.
 * q31: q and results are Q39.24.  Cost: W additions.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (empty), KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (q < 0). */
KQ_NODISCARD kq_status kq_consistency_nis_f32(const kq_consistency_f32 *c, float q, float *nis, float *low,
    float *high);
KQ_NODISCARD kq_status kq_consistency_nis_f64(const kq_consistency_f64 *c, double q, double *nis, double *low,
    double *high);
KQ_NODISCARD kq_status kq_consistency_nis_q31(const kq_consistency_q31 *c, int64_t q, int64_t *nis,
    int64_t *low, int64_t *high);

/** Mean and lag-one correlation of nu of one component.
 *   c        read
 *   component   0 .. m-1
 *   q        as above
 *   mean     written: 0 but for chance
 *   mean_bound  written: q / sqrt(k), k the number of nu in the window
 *   correlation   written: sum nu_t nu_t-1 / sum nu_t^2, 0 but for chance, over complete pairs
 *   correlation_bound   written: q sqrt(pairs) / k, good for large k; from k = 20 on a little too wide
 * q31: q and results are Q39.24; squares are summed in steps of 2^-24, so that the correlation of nu below 2^-8 is
 * rounding, within -1 .. 1.  Cost: 3 W multiplications.
 * KQ_ERR_NULL, KQ_ERR_SIZE (component), KQ_ERR_NOT_READY (no nu of it), KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (q). */
KQ_NODISCARD kq_status kq_consistency_innovation_f32(const kq_consistency_f32 *c, int component, float q,
    float *mean, float *mean_bound, float *correlation, float *correlation_bound);
KQ_NODISCARD kq_status kq_consistency_innovation_f64(const kq_consistency_f64 *c, int component, double q,
    double *mean, double *mean_bound, double *correlation, double *correlation_bound);
KQ_NODISCARD kq_status kq_consistency_innovation_q31(const kq_consistency_q31 *c, int component, int64_t q,
    int64_t *mean, int64_t *mean_bound, int64_t *correlation, int64_t *correlation_bound);

#ifdef __cplusplus
}
#endif
#endif
