/*
 * kalmanq: the scales of Q and R, learnt while the filter runs.
 *
 * You know the shapes of Q and R, not their sizes: the noises are q Q and r R.  An adaptation carries q and r (1 at
 * first), runs the filter with them, and moves them after every update by recursive maximum likelihood.
 *
 *     kq_adaptation_init_f32(&tuner, &motion, &ranger, &rule);
 *     kq_attach_f32(&track, &tuner.attached);
 *     ... kq_predict_f32(&track, &motion, NULL);        with q Q
 *         kq_update_f32(&track, &ranger, z);            with r R; q and r then move
 *
 * An update changes a scale by a factor of at most 1 + step, within its limits.  M is the memory, in updates.  A
 * normalised innovation counts within -4 .. 4: an outlier has bounded weight.  If you know one scale, let only the
 * other adapt (rule.scales): it is found sooner.
 *
 * What to expect: M = 200 finds scales that are off by 4 within 400 to 1100 updates (tests/README.md, "Scales of the
 * noises").  A larger M spreads less.
 *   - Q far above R: only q + r shows.  Let only q adapt.  Q far below R: q is learnt slowly.
 *   - Outliers raise r and q; a jump raises q.  A model that is wrong otherwise (missing state, bias, coloured noise) bends both scales.
 *
 * Learning begins with the first whole update after n scalar measurements.  Updates with another process or sensor,
 * robust updates and kq_forget move the filter, not the adaptation: the scales suffer.
 */
#ifndef KALMANQ_ADAPTATION_H
#define KALMANQ_ADAPTATION_H

#include "filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Length of an adaptation's memory, in words (q31: numbers; besides a root).  Bytes at n, m = 2, 1; 4, 2; 9, 3: 56,
 * 188, 720 in f32; 100, 320, 1224 in q31 with the root. */
#define KQ_ADAPTATION_LEN_F32(n, m) (KQ_ADAPTATION_LEN_Q31(n, m) + (m) * (m) + KQ_PROCESS_LEN(n))
#define KQ_ADAPTATION_LEN_F64(n, m) KQ_ADAPTATION_LEN_F32(n, m)
#define KQ_ADAPTATION_LEN_Q31(n, m) (((n) + (m) + 1) * (n) + (m) + KQ_SENSOR_LEN(m))

/** The limits of M. */
#define KQ_ADAPTATION_MEMORY_MIN 10
#define KQ_ADAPTATION_MEMORY_MAX 100000

/** Which scales are learnt; the other stays 1. */
typedef enum {
    KQ_ADAPT_BOTH, KQ_ADAPT_PROCESS, KQ_ADAPT_SENSOR, KQ_ADAPT_IS_INT = INT_MAX
} kq_adapted;

/** The rule.  To begin with: {KQ_ADAPT_BOTH, 500, 0.1f, 1e-3f, 1e3f, 1e-3f, 1e3f}. */
typedef struct {
    kq_adapted scales;
    int32_t memory;                    /* M, in updates: 10 .. 100000 */
    float step;                        /* 0 < step <= 1 */
    float process_least, process_most; /* 0 < least <= 1 <= most: the limits of q */
    float sensor_least, sensor_most;   /* of r */
} kq_adaptation_rule_f32;
typedef struct {
    kq_adapted scales; int32_t memory; double step, process_least, process_most;
    double sensor_least, sensor_most;
} kq_adaptation_rule_f64;
typedef struct {
    kq_adapted scales; int32_t memory; kq_scaled_q31 step, process_least, process_most;
    kq_scaled_q31 sensor_least, sensor_most;
} kq_adaptation_rule_q31;

/* The fields are the library's (see process.h). */
typedef struct {
    struct kq_attached_f32 attached;
    uint8_t states, components, waiting; /* n; m; scalar measurements to come before learning begins */
    uint16_t length; /* words at memory */
    float *memory; /* the caller's: D, d, workspace, the noises of the two below */
    const kq_process_f32 *process; /* as given; NULL until initialised */
    const kq_sensor_f32 *sensor; kq_adaptation_rule_f32 rule;
    float process_scale, sensor_scale, information[3]; /* q, r; J: qq, qr, rr */
    kq_process_f32 scaled_process; kq_sensor_f32 scaled_sensor;
    kq_filter_f32 *filter; /* attached to */
} kq_adaptation_f32;
extern const struct kq_hooks_f32 kq_adaptation_hooks_f32; /* what it does in the steps */
typedef struct {
    struct kq_attached_f64 attached; uint8_t states, components, waiting; uint16_t length; double *memory;
    const kq_process_f64 *process; const kq_sensor_f64 *sensor; kq_adaptation_rule_f64 rule;
    double process_scale, sensor_scale, information[3]; kq_process_f64 scaled_process;
    kq_sensor_f64 scaled_sensor; kq_filter_f64 *filter;
} kq_adaptation_f64;
extern const struct kq_hooks_f64 kq_adaptation_hooks_f64;
typedef struct {
    struct kq_attached_q31 attached; uint8_t states, components, waiting; uint16_t length;
    kq_scaled_q31 *memory; /* D, d, workspace, the noise of the scaled sensor */
    int32_t *root;         /* of the scaled process */
    const kq_process_q31 *process; const kq_sensor_q31 *sensor; kq_adaptation_rule_q31 rule;
    kq_scaled_q31 process_scale, sensor_scale, information[3]; kq_process_q31 scaled_process;
    kq_sensor_q31 scaled_sensor; kq_filter_q31 *filter;
} kq_adaptation_q31;
extern const struct kq_hooks_q31 kq_adaptation_hooks_q31;

/* In floating point, what is behind the memory before init */
#define KQ_PRIVATE_ADAPTATION_OBJECT(hooks, n, m, length, memory) \
    { {hooks}, n, m, 0, length, memory, NULL, NULL, {KQ_ADAPT_BOTH, 0, 0, 0, 0, 0, 0}, 0, 0, {0}, {0, 0, 0, \
        NULL, NULL, NULL, NULL, {0}, 0, 0, 0}, { 0, 0, 0, 0, NULL, NULL, NULL, NULL, \
        {0}, 0, 0, 0, NULL }, NULL }

/** Declares an adaptation `name` for n states and m components with its static memory. */
#define KQ_ADAPTATION_F32(name, n, m) \
    static float name##_memory[KQ_ADAPTATION_LEN_F32(n, m)]; \
    static kq_adaptation_f32 name = KQ_PRIVATE_ADAPTATION_OBJECT(&kq_adaptation_hooks_f32, n, m, \
        KQ_ADAPTATION_LEN_F32(n, m), name##_memory)
#define KQ_ADAPTATION_F64(name, n, m) \
    static double name##_memory[KQ_ADAPTATION_LEN_F64(n, m)]; \
    static kq_adaptation_f64 name = KQ_PRIVATE_ADAPTATION_OBJECT(&kq_adaptation_hooks_f64, n, m, \
        KQ_ADAPTATION_LEN_F64(n, m), name##_memory)
#define KQ_ADAPTATION_Q31(name, n, m) \
    static kq_scaled_q31 name##_memory[KQ_ADAPTATION_LEN_Q31(n, m)]; \
    static int32_t name##_root[KQ_ROOT_LEN_Q31(n)]; \
    static kq_adaptation_q31 name = {{&kq_adaptation_hooks_q31}, n, m, 0, KQ_ADAPTATION_LEN_Q31(n, m), \
        name##_memory, name##_root, NULL, NULL, {KQ_ADAPT_BOTH, 0, {0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}}, \
        {0, 0}, {0, 0}, {{0, 0}, {0, 0}, {0, 0}}, {0, 0, {0}, 0, 0, 0, NULL, NULL, NULL, NULL, NULL}, {0, 0, \
        0, 0, NULL, NULL, NULL, NULL, {0}, 0, 0, 0, NULL}, NULL}

/** Sets sizes and memory at run time.
 *   a        written
 *   n        1..16 states
 *   m        1..16 components
 *   memory   `length` words (q31: numbers), yours while in use
 *   length   KQ_ADAPTATION_LEN_<T>(n, m) or more
 *   root     q31: KQ_ROOT_LEN_Q31(n) words, yours while in use
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY. */
KQ_NODISCARD kq_status kq_adaptation_assign_f32(kq_adaptation_f32 *a, int n, int m, float *memory, size_t length);
KQ_NODISCARD kq_status kq_adaptation_assign_f64(kq_adaptation_f64 *a, int n, int m, double *memory, size_t length);
KQ_NODISCARD kq_status kq_adaptation_assign_q31(kq_adaptation_q31 *a, int n, int m, kq_scaled_q31 *memory,
    size_t length, int32_t *root);

/** Initialises: both scales 1, nothing learnt.
 *   a        has sizes and memory; written
 *   p        the process as you know it, kept by reference.  A new A (kq_process_change_transition) counts from the
 *            next step on.  A variance of 0 stays 0
 *   s        the sensor likewise (kq_sensor_change_measurement)
 *   rule     copied
 * KQ_ERR_NULL, KQ_ERR_SIZE (never assigned; M), KQ_ERR_MEMORY, KQ_ERR_NOT_READY (p, s), KQ_ERR_MISMATCH (sizes; q31:
 * formats), KQ_ERR_NOT_FINITE (rule; R times its limits), KQ_ERR_RANGE (rule.scales, step, limits); q31:
 * KQ_ERR_COEFFICIENT (a number of the rule, or a noise times its limits, is not as in a table).
 * Cost: about n^2 + m^2 multiplications, to check the limits. */
KQ_NODISCARD kq_status kq_adaptation_init_f32(kq_adaptation_f32 *a, const kq_process_f32 *p,
    const kq_sensor_f32 *s, const kq_adaptation_rule_f32 *rule);
KQ_NODISCARD kq_status kq_adaptation_init_f64(kq_adaptation_f64 *a, const kq_process_f64 *p,
    const kq_sensor_f64 *s, const kq_adaptation_rule_f64 *rule);
KQ_NODISCARD kq_status kq_adaptation_init_q31(kq_adaptation_q31 *a, const kq_process_q31 *p,
    const kq_sensor_q31 *s, const kq_adaptation_rule_q31 *rule);

/*
 * kq_attach (filter.h): from now on kq_predict with p takes q Q; kq_update, kq_update_subset and kq_step with s take
 * r R, and q and r then move.  Scales and information stay.  While q = r = 1 the filter is bit-identical to one
 * without adaptation.  Nothing else may be attached.  NIS, log-likelihood and count of the filter are of the scales
 * before they moved.  A component that is missing, redundant or not representable teaches nothing.  Steps also answer
 * KQ_ERR_NOT_READY, KQ_ERR_MISMATCH, KQ_ERR_NOT_FINITE (r R), KQ_ERR_COEFFICIENT (q31: q Q, r R) if p or s have
 * changed so that they no longer fit.
 * Cost of a predict: n^2/2 + n^3/6 + 1.5 n^3 multiplications (0.75 n^3 for an upper triangular A) and a root; of an
 * update, for component c: 3 n^2 + 2 c n multiplications, a root, a division, and 7 divisions in all.  Both take 3 to
 * 6 times a kq_step (tools/cost/README.md).
 * Stack: 40 words more than predict and update (q31: 115); 136 (q31: 272) where an update decorrelates R.
 */

/** The scales as they are now.
 *   a        read
 *   q        written: the scale of Q; or NULL
 *   r        written: the scale of R; or NULL
 * KQ_ERR_NULL (a), KQ_ERR_NOT_READY. */
KQ_NODISCARD kq_status kq_adaptation_scales_f32(const kq_adaptation_f32 *a, float *q, float *r);
KQ_NODISCARD kq_status kq_adaptation_scales_f64(const kq_adaptation_f64 *a, double *q, double *r);
KQ_NODISCARD kq_status kq_adaptation_scales_q31(const kq_adaptation_q31 *a, kq_scaled_q31 *q, kq_scaled_q31 *r);

/** The process with q Q and the sensor with r R as they are now, for kq_forecast or kq_measurement.
 *   a        its scaled models are written; they change with the next call of a or of its filter
 * NULL where a is NULL or not initialised, or where process or sensor have changed and no longer fit. */
const kq_process_f32 *kq_adaptation_process_f32(kq_adaptation_f32 *a);
const kq_process_f64 *kq_adaptation_process_f64(kq_adaptation_f64 *a);
const kq_process_q31 *kq_adaptation_process_q31(kq_adaptation_q31 *a);
const kq_sensor_f32 *kq_adaptation_sensor_f32(kq_adaptation_f32 *a);
const kq_sensor_f64 *kq_adaptation_sensor_f64(kq_adaptation_f64 *a);
const kq_sensor_q31 *kq_adaptation_sensor_q31(kq_adaptation_q31 *a);

#ifdef __cplusplus
}
#endif
#endif
