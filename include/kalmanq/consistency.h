/*
 * kalmanq: is the filter consistent with its measurements?  Statistics over the last W updates.
 *
 *     NIS         sum of e' S^-1 e over the window: chi-square with as many degrees of freedom as
 *                 scalar measurements were taken, if the model is right
 *     innovation  nu_c = e_c / sqrt(S_cc): N(0, 1), and white
 *
 * A mean NIS per degree of freedom above its bounds says that the filter trusts itself too much (Q
 * or R too small, or the model is wrong), below them that it trusts itself too little.  A
 * correlation of nu from one update to the next outside of its bound says that the model lacks
 * something or that the gain is wrong (above: too low, Q too small beside R; below: too high).
 *
 * A mean of nu outside of its bound says that innovations lean to one side for longer than the
 * model has it: a bias that no state takes up, or states that move more slowly back to the truth
 * than they should.  It does not tell the two apart.  A level with Q / R = 0.25 whose only sensor
 * has a bias of one sigma takes that up: 4 to 6 % of windows are outside of 95 % bounds, as without
 * it; Q ten times too small puts 50 to 56 % of them outside, with no bias at all.  A second sensor
 * shows the bias of the first (two sensors of a level, one sigma, W = 50 and 200: 81 to 87 and 100
 * % of windows).  So look at the correlation first, and at the mean where that is within its bound.
 *
 *     kq_consistency_watch_f32(&window, &track, &radar, z);
 *     kq_update_f32(&track, &radar, z);
 *     kq_consistency_record_f32(&window, &track);
 *     ... and every now and then
 *     kq_consistency_nis_f32(&window, 1.96f, &nis, &low, &high);
 *     kq_consistency_innovation_f32(&window, 0, 1.96f, &mean, &mean_bound,
 *                                   &correlation, &correlation_bound);
 *
 * One object watches the updates by one sensor (or by sensors that share a meaning of their
 * components).  The last W updates are kept and summed when they are asked for: the window is exact
 * and nothing drifts.
 *
 * Sources: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation
 * (2001), 5.4; Mehra, On the identification of variances and adaptive Kalman filtering, IEEE Trans.
 * AC-15 (1970); Wilson and Hilferty, The distribution of chi-square, PNAS 17 (1931).
 */
#ifndef KALMANQ_CONSISTENCY_H
#define KALMANQ_CONSISTENCY_H

#include "filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Words of memory for a window of W updates by m components. */
#define KQ_CONSISTENCY_LEN_F32(m, window) (((kq_length)(window) + 1) * ((kq_length)(m) + 2))
#define KQ_CONSISTENCY_LEN_F64(m, window) (((kq_length)(window) + 1) * ((kq_length)(m) + 2))
#define KQ_CONSISTENCY_LEN_Q31(m, window) (((kq_length)(window) + 1) * ((kq_length)(m) + 3))

/** Largest W. */
#define KQ_WINDOW_MAX 32766

/* The fields are the library's (see process.h). */
typedef struct {
    uint8_t components; /* m */
    uint8_t watched;    /* is an update on its way in the entry `next`? */
    int16_t window;     /* W */
    int16_t count;      /* updates in the window */
    int16_t next;       /* of the W + 1 entries, the one to be written next */
    float *memory;      /* the caller's: entries of NIS, number taken, m innovations */
} kq_consistency_f32;

typedef struct {
    uint8_t components;
    uint8_t watched;
    int16_t window;
    int16_t count;
    int16_t next;
    double *memory;
} kq_consistency_f64;

typedef struct {
    uint8_t components;
    uint8_t watched;
    int16_t window;
    int16_t count;
    int16_t next;
    int32_t *memory; /* a NIS is two words, innovations are Q7.24 */
} kq_consistency_q31;

/** An object `name` for m components and a window of W updates with its storage, in static
    memory, empty. */
#define KQ_CONSISTENCY_F32(name, m, window)                                                        \
    static float name##_memory[KQ_CONSISTENCY_LEN_F32(m, window)];                                 \
    static kq_consistency_f32 name = {m, 0, window, 0, 0, name##_memory}
#define KQ_CONSISTENCY_F64(name, m, window)                                                        \
    static double name##_memory[KQ_CONSISTENCY_LEN_F64(m, window)];                                \
    static kq_consistency_f64 name = {m, 0, window, 0, 0, name##_memory}
#define KQ_CONSISTENCY_Q31(name, m, window)                                                        \
    static int32_t name##_memory[KQ_CONSISTENCY_LEN_Q31(m, window)];                               \
    static kq_consistency_q31 name = {m, 0, window, 0, 0, name##_memory}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time); empties it.
 *   c        written
 *   m        1..16
 *   window   W: 1..KQ_WINDOW_MAX
 *   length   words at memory: KQ_CONSISTENCY_LEN_<T>(m, W)
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 */
KQ_NODISCARD kq_status kq_consistency_assign_f32(kq_consistency_f32 *c, int m, size_t window, float *memory,
                                    size_t length);
KQ_NODISCARD kq_status kq_consistency_assign_f64(kq_consistency_f64 *c, int m, size_t window, double *memory,
                                    size_t length);
KQ_NODISCARD kq_status kq_consistency_assign_q31(kq_consistency_q31 *c, int m, size_t window, int32_t *memory,
                                    size_t length);

/** Forgets all updates.  KQ_ERR_NULL, KQ_ERR_NOT_READY (no memory assigned). */
KQ_NODISCARD kq_status kq_consistency_clear_f32(kq_consistency_f32 *c);
KQ_NODISCARD kq_status kq_consistency_clear_f64(kq_consistency_f64 *c);
KQ_NODISCARD kq_status kq_consistency_clear_q31(kq_consistency_q31 *c);

/**
 * Just before an update: notes nu of every component that is present.  The filter is only read.  It is
 * the predicted state that z is compared with: call kq_predict and kq_update, kq_step leaves no place
 * between them.
 *   z, present   as given to kq_update_subset; present = UINT32_MAX for kq_update
 * A component whose S_cc is at the floor (filter.h), or whose nu is not representable, counts as
 * missing; q31: nu is held at +-128.
 * Cost: n^2/2 + 2n multiplications, one root and one division a component.
 * Stack: n words.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH (also: the sensor has not m components),
 * KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (z), as kq_update_subset.
 */
KQ_NODISCARD kq_status kq_consistency_watch_f32(kq_consistency_f32 *c, const kq_filter_f32 *f,
                                   const kq_sensor_f32 *s, const float *z, uint32_t present);
KQ_NODISCARD kq_status kq_consistency_watch_f64(kq_consistency_f64 *c, const kq_filter_f64 *f,
                                   const kq_sensor_f64 *s, const double *z, uint32_t present);
KQ_NODISCARD kq_status kq_consistency_watch_q31(kq_consistency_q31 *c, const kq_filter_q31 *f,
                                   const kq_sensor_q31 *s, const int32_t *z, uint32_t present);

/**
 * Just after it: the update enters the window with kq_nis and kq_taken, the oldest one leaves it.
 * An update that took nothing does not enter.  (A gate that rejects what is unlikely makes a filter
 * look more consistent than it is: the statistics are of what was taken.)
 * Cost: a few words copied; with a settled kq_freeze attached, n (n + 1) / 2 comparisons.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (filter; nothing was watched since the last record; or the last step
 * was one of a settled kq_freeze, steady.h: it moves the mean alone, and kq_nis is that of a step long
 * ago.  kq_freeze_release, or kq_predict and kq_update in the place of kq_step, judge again).
 */
KQ_NODISCARD kq_status kq_consistency_record_f32(kq_consistency_f32 *c, const kq_filter_f32 *f);
KQ_NODISCARD kq_status kq_consistency_record_f64(kq_consistency_f64 *c, const kq_filter_f64 *f);
KQ_NODISCARD kq_status kq_consistency_record_q31(kq_consistency_q31 *c, const kq_filter_q31 *f);

/** Updates in the window, 0 .. W.  0 where c is NULL. */
size_t kq_consistency_count_f32(const kq_consistency_f32 *c);
size_t kq_consistency_count_f64(const kq_consistency_f64 *c);
size_t kq_consistency_count_q31(const kq_consistency_q31 *c);

/**
 * The mean NIS per degree of freedom: 1 but for chance, and the bounds of chance.
 *   q           >= 0: normal quantile of the interval, 1.96 for 95 %, 2.576 for 99 %
 *   nis         sum of NIS / d, written; d: scalar measurements taken in the window
 *   low, high   two-sided bounds, written: quantiles of chi-square, d degrees of freedom, over d
 * Bounds by Wilson and Hilferty: (1 - a -+ q sqrt(a))^3, a = 2 / (9 d), not below 0.  Their error,
 * relative, larger of both, at d = 10, 20, 50, 100, 1000 for 95 %: 8e-3, 2e-3, 3e-4, 8e-5, 2e-6;
 * for 99 %: 3e-2, 7e-3, 2e-3, 4e-4, 9e-6 (and the arithmetic's rounding).  The coverage is within
 * 0.001 of the level from d = 10 on, within 0.003 from d = 5 on.
 * q31: q and all results Q39.24.
 * Cost: W additions.  KQ_ERR_NULL, KQ_ERR_NOT_READY (the window is empty), KQ_ERR_NOT_FINITE,
 * KQ_ERR_RANGE (q < 0).
 */
KQ_NODISCARD kq_status kq_consistency_nis_f32(const kq_consistency_f32 *c, float q, float *nis, float *low,
                                 float *high);
KQ_NODISCARD kq_status kq_consistency_nis_f64(const kq_consistency_f64 *c, double q, double *nis, double *low,
                                 double *high);
KQ_NODISCARD kq_status kq_consistency_nis_q31(const kq_consistency_q31 *c, int64_t q, int64_t *nis, int64_t *low,
                                 int64_t *high);

/**
 * Mean and whiteness of the normalised innovations nu of one component.
 *   component     0 .. m-1
 *   q             as above
 *   mean          of nu, written: 0 but for chance
 *   mean_bound    q / sqrt(k), k the number of nu in the window, written: the mean is within
 *                 +- mean_bound with the probability that belongs to q
 *   correlation   lag one: sum nu_t nu_t-1 / sum nu_t^2, written: 0 but for chance, -1 .. 1, and
 *                 whatever the size of nu; pairs with one missing do not count
 *   correlation_bound   q sqrt(pairs) / k, written: the correlation is within it with that
 *                 probability for large k; for k from 20 on a little more often (W = 50 and 200,
 *                 half of each component missing, 95 %: 3.4 to 5.6 % of windows outside)
 * q31: q and all results Q39.24.
 * Cost: 3 W multiplications.  KQ_ERR_NULL, KQ_ERR_SIZE (component), KQ_ERR_NOT_READY (no nu of it
 * in the window), KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (q).
 */
KQ_NODISCARD kq_status kq_consistency_innovation_f32(const kq_consistency_f32 *c, int component, float q,
                                        float *mean, float *mean_bound, float *correlation,
                                        float *correlation_bound);
KQ_NODISCARD kq_status kq_consistency_innovation_f64(const kq_consistency_f64 *c, int component, double q,
                                        double *mean, double *mean_bound, double *correlation,
                                        double *correlation_bound);
KQ_NODISCARD kq_status kq_consistency_innovation_q31(const kq_consistency_q31 *c, int component, int64_t q,
                                        int64_t *mean, int64_t *mean_bound, int64_t *correlation,
                                        int64_t *correlation_bound);

#ifdef __cplusplus
}
#endif
#endif
