/*
 * kalmanq: the scales of the noises, learnt on line.
 *
 * You know the shapes of Q and R and not their sizes: the noises are q Q and r R.  An adaptation
 * carries q and r (1 at first), runs the filter with them, and moves them by what every
 * measurement says.  Nothing adapts to which none is attached: there is no other switch.
 *
 *     kq_adaptation_init_f32(&tuner, &motion, &ranger, &rule);
 *     kq_attach_f32(&track, &tuner.attached);
 *     ... kq_predict_f32(&track, &motion, NULL);        with q Q
 *         kq_update_f32(&track, &ranger, z);            with r R; q and r then move
 *
 * How: recursive maximum likelihood.  Beside the filter run the slopes of P and x with log q,
 *
 *     D- = A D A' + q Q        D+ = (I - K H) D- (I - K H)'
 *     d- = A d                 d+ = (I - K H) (d- + D- H' nu / sqrt(s))
 *
 * those with log r being P - D and -d, as a gain stays what it is where q and r grow together.
 * A scalar measurement, of innovation e and variance s, has with
 *
 *     nu = e / sqrt(s)         a = H D- H' / s         y = H d- / sqrt(s)
 *
 * nu and y within -4 .. 4, so that an outlier bends the slope d and the scores no further, the scores
 * (derivatives of its log-likelihood) and the information
 *
 *     g_q = a (nu^2 - 1) / 2 + nu y              J_qq = a^2 / 2 + y^2
 *     g_r = (1 - a) (nu^2 - 1) / 2 - nu y        J_rr = (1 - a)^2 / 2 + y^2
 *                                                J_qr = a (1 - a) / 2 - y^2
 *
 * nu^2 says how large both scales are together; nu y, whether innovations are white, which of the
 * two is too small.  Summed over the measurements of an update,
 *
 *     J <- (1 - 1/M) J + J(z)        (c_q, c_r) = (J + 4 I)^-1 (g_q, g_r)
 *     q <- q (1 + c_q) where c_q >= 0, q / (1 + |c_q|) where c_q < 0, and so r by c_r
 *
 * which is log q += c_q to first order, the same up as down, without an exponential.  M is the memory in
 * updates.  4 is the information that the scales are worth before anything is measured: what the
 * measurements do not tell moves slowly.  Where one scale alone is learnt J_qr counts as 0.
 *
 * Bounds.  |c_q| and |c_r| count up to `step`: at one update a scale changes by a factor of at most
 * 1 + step.  It stays within its limits.  Memory and work are fixed by n and m.
 *
 * How soon and how well.  "4", "16": updates until the median scales of 100 runs are within a
 * factor of 1.25 of the truth for good, the worst of eight starts: q, r or both are too large or
 * too small by that factor.  "Spread": standard deviations of log q and log r over 100,000
 * updates of four runs with the right model.  None drifts: their means are within 0.03, for M = 50
 * and for r at Q / R = 10 within 0.1.  step = 0.1, limits 2^-10 and 2^10.  What f32 and q31 learn
 * is what f64 learns to 2e-6 and 4e-8 (tests/reference/test_adaptation.cpp; with the arguments
 * `1 long` it prints this table).
 *
 *                                 M = 50                M = 200               M = 1000
 *                              4   16  spread        4   16  spread        4   16  spread
 *   level, Q/R 0.01           750 1200  0.32 0.13  1050 1790  0.28 0.07  1770 4810  0.17 0.03
 *   level, Q/R 0.1            430  700  0.28 0.14   640 1480  0.21 0.08  1200 4490  0.11 0.04
 *   level, Q/R 1              460  940  0.23 0.20   520 1410  0.15 0.13   910 3510  0.07 0.06
 *   level, Q/R 10               -    -  0.15 0.31     -    -  0.10 0.29     -    -  0.05 0.21
 *   velocity (a)              290  540  0.27 0.14   460 1230  0.19 0.08   710 3540  0.09 0.04
 *   (a), 20 % missing         480  640  0.26 0.14   550 1440  0.18 0.08  1020 4280  0.09 0.04
 *   AR(1), -0.9               340  750  0.24 0.18   540 1360  0.16 0.11   970 3630  0.08 0.05
 *   two states, two sensors   250  410  0.23 0.12   400 1080  0.15 0.07   700 3050  0.07 0.03
 *   (b), 20 % missing         270  460  0.24 0.13   430 1080  0.15 0.07   730 3050  0.07 0.03
 *
 *   (a) velocity that lasts 100 steps, seen through its position    (b) R correlated
 *
 * What was learnt far from the truth is remembered, too: where the scales may be off by 16, a
 * large M is slow to forget it.
 *
 * If one scale is known, say so (rule.scales), and the other is found sooner: from 16, M = 200,
 * after 300 updates (r) and 700 (q) for Q / R = 0.1.
 *
 * What cannot be told.  The spreads are about 1 / sqrt(2 (M J + 4)), J per update, and so never
 * much above 0.35, whatever the model.  Where Q is far above R, K is 1 and only q + r shows: r
 * wanders within that spread and hardly comes back from elsewhere; let only q adapt.  Where Q is
 * far below R, q is learnt slowly (a random walk: J_qq is about K / 8, so at Q / R = 0.01 it takes
 * 300 measurements to know log q within 0.5).  A model that is wrong otherwise (a state too few, a
 * bias, noise that is not white) bends both scales to what fits best.
 *
 * Outliers and jumps.  1 % of outliers of 10 sigma raise r by a factor of 1.15 to 1.34 (a velocity;
 * their variance: 1.99) and q by 1.05 to 1.2 (a level with Q / R = 0.01: 1.4), 10 % of them raise r
 * by 7 (their variance: 11).  A jump is taken for a larger q.
 *
 * Learning begins with the first whole update after n scalar measurements, when those have replaced what
 * the prior said: J, q and r rest until then, and the update that has the n-th still moves D and d alone.
 * The filter may be read as ever.  Another process and another sensor than those of init move the filter
 * as they are; they, robust updates and a fade are not seen by D and d: what is learnt is the less right,
 * the more of them there are.
 *
 * Sources: Ljung and Soderstrom, Theory and Practice of Recursive Identification (1983); Mehra, On
 * the identification of variances and adaptive Kalman filtering, IEEE Trans. AC-15 (1970); Gupta
 * and Mehra, Computational aspects of maximum likelihood estimation and reduction in sensitivity
 * function calculations, IEEE Trans. AC-19 (1974).
 */
#ifndef KALMANQ_ADAPTATION_H
#define KALMANQ_ADAPTATION_H

#include "filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Words of memory for n states and m components (q31: numbers, and a root beside them).  Bytes at
    n, m = 2, 1; 4, 2; 9, 3: 56, 188, 720 in f32, with the root 100, 320, 1224 in q31. */
#define KQ_ADAPTATION_LEN_F32(n, m) (KQ_ADAPTATION_LEN_Q31(n, m) + (m) * (m) + KQ_PROCESS_LEN(n))
#define KQ_ADAPTATION_LEN_F64(n, m) KQ_ADAPTATION_LEN_F32(n, m)
#define KQ_ADAPTATION_LEN_Q31(n, m) (((n) + (m) + 1) * (n) + (m) + KQ_SENSOR_LEN(m))

/** The longest and the shortest M. */
#define KQ_ADAPTATION_MEMORY_MIN 10
#define KQ_ADAPTATION_MEMORY_MAX 100000

/** Which scales are learnt; the other one stays 1. */
typedef enum {
    KQ_ADAPT_BOTH,
    KQ_ADAPT_PROCESS,
    KQ_ADAPT_SENSOR,
    KQ_ADAPT_IS_INT = INT_MAX
} kq_adapted;

/** How.  A beginning: {KQ_ADAPT_BOTH, 500, 0.1f, 1e-3f, 1e3f, 1e-3f, 1e3f}. */
typedef struct {
    kq_adapted scales;
    int32_t memory;                    /* M, in updates: 10 .. 100000 */
    float step;                        /* 0 < step <= 1 */
    float process_least, process_most; /* 0 < least <= 1 <= most: the limits of q */
    float sensor_least, sensor_most;   /* of r */
} kq_adaptation_rule_f32;

typedef struct {
    kq_adapted scales;
    int32_t memory;
    double step;
    double process_least, process_most;
    double sensor_least, sensor_most;
} kq_adaptation_rule_f64;

typedef struct {
    kq_adapted scales;
    int32_t memory;
    kq_scaled_q31 step;
    kq_scaled_q31 process_least, process_most;
    kq_scaled_q31 sensor_least, sensor_most;
} kq_adaptation_rule_q31;

/* The fields are the library's (see process.h). */
typedef struct {
    struct kq_attached_f32 attached;
    uint8_t states;                /* n */
    uint8_t components;            /* m */
    uint8_t waiting;               /* scalar measurements to come before learning begins */
    uint16_t length;               /* words at memory */
    float *memory;                 /* the caller's: D, d, workspace, the noises of the two below */
    const kq_process_f32 *process; /* as given; NULL until initialised */
    const kq_sensor_f32 *sensor;
    kq_adaptation_rule_f32 rule;
    float process_scale, sensor_scale; /* q, r */
    float information[3];              /* J: qq, qr, rr */
    kq_process_f32 scaled_process;
    kq_sensor_f32 scaled_sensor;
    kq_filter_f32 *filter; /* attached to */
} kq_adaptation_f32;

extern const struct kq_hooks_f32 kq_adaptation_hooks_f32; /* what it does in the steps */

typedef struct {
    struct kq_attached_f64 attached;
    uint8_t states;
    uint8_t components;
    uint8_t waiting;
    uint16_t length;
    double *memory;
    const kq_process_f64 *process;
    const kq_sensor_f64 *sensor;
    kq_adaptation_rule_f64 rule;
    double process_scale, sensor_scale;
    double information[3];
    kq_process_f64 scaled_process;
    kq_sensor_f64 scaled_sensor;
    kq_filter_f64 *filter; /* attached to */
} kq_adaptation_f64;

extern const struct kq_hooks_f64 kq_adaptation_hooks_f64;

typedef struct {
    struct kq_attached_q31 attached;
    uint8_t states;
    uint8_t components;
    uint8_t waiting;
    uint16_t length;
    kq_scaled_q31 *memory; /* D, d, workspace, the noise of the scaled sensor */
    int32_t *root;         /* of the scaled process */
    const kq_process_q31 *process;
    const kq_sensor_q31 *sensor;
    kq_adaptation_rule_q31 rule;
    kq_scaled_q31 process_scale, sensor_scale;
    kq_scaled_q31 information[3];
    kq_process_q31 scaled_process;
    kq_sensor_q31 scaled_sensor;
    kq_filter_q31 *filter; /* attached to */
} kq_adaptation_q31;

extern const struct kq_hooks_q31 kq_adaptation_hooks_q31;

/* In floating point, what is behind the memory before init */
#define KQ_PRIVATE_ADAPTATION_OBJECT(hooks, n, m, length, memory)                                  \
    {                                                                                              \
        {hooks}, n, m, 0, length, memory, NULL, NULL, {KQ_ADAPT_BOTH, 0, 0, 0, 0, 0, 0}, 0, 0, {0},\
            {0, 0, 0, NULL, NULL, NULL, NULL, {0}, 0, 0, 0},                                       \
        {                                                                                          \
            0, 0, 0, 0, NULL, NULL, NULL, NULL, {0}, 0, 0, 0, NULL                                 \
        },                                                                                         \
            NULL                                                                                   \
    }

/** An adaptation `name` for n states and m components with its storage, in static memory. */
#define KQ_ADAPTATION_F32(name, n, m)                                                              \
    static float name##_memory[KQ_ADAPTATION_LEN_F32(n, m)];                                       \
    static kq_adaptation_f32 name =                                                                \
        KQ_PRIVATE_ADAPTATION_OBJECT(&kq_adaptation_hooks_f32, n, m, KQ_ADAPTATION_LEN_F32(n, m), name##_memory)
#define KQ_ADAPTATION_F64(name, n, m)                                                              \
    static double name##_memory[KQ_ADAPTATION_LEN_F64(n, m)];                                      \
    static kq_adaptation_f64 name =                                                                \
        KQ_PRIVATE_ADAPTATION_OBJECT(&kq_adaptation_hooks_f64, n, m, KQ_ADAPTATION_LEN_F64(n, m), name##_memory)
#define KQ_ADAPTATION_Q31(name, n, m)                                                              \
    static kq_scaled_q31 name##_memory[KQ_ADAPTATION_LEN_Q31(n, m)];                               \
    static int32_t name##_root[KQ_ROOT_LEN_Q31(n)];                                                \
    static kq_adaptation_q31 name = {{&kq_adaptation_hooks_q31},                                           \
                                     n,                                                            \
                                     m,                                                            \
                                     0,                                                            \
                                     KQ_ADAPTATION_LEN_Q31(n, m),                                  \
                                     name##_memory,                                                \
                                     name##_root,                                                  \
                                     NULL,                                                         \
                                     NULL,                                                         \
                                     {KQ_ADAPT_BOTH, 0, {0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}},   \
                                     {0, 0},                                                       \
                                     {0, 0},                                                       \
                                     {{0, 0}, {0, 0}, {0, 0}},                                     \
                                     {0, 0, {0}, 0, 0, 0, NULL, NULL, NULL, NULL, NULL},           \
                                     {0, 0, 0, 0, NULL, NULL, NULL, NULL, {0}, 0, 0, 0, NULL},     \
                                     NULL}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   a        written
 *   n, m     1..16
 *   length   words (q31: numbers) at memory: KQ_ADAPTATION_LEN_<T>(n, m)
 *   root     q31: KQ_ROOT_LEN_Q31(n) words
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 */
KQ_NODISCARD kq_status kq_adaptation_assign_f32(kq_adaptation_f32 *a, int n, int m, float *memory,
                                   size_t length);
KQ_NODISCARD kq_status kq_adaptation_assign_f64(kq_adaptation_f64 *a, int n, int m, double *memory,
                                   size_t length);
KQ_NODISCARD kq_status kq_adaptation_assign_q31(kq_adaptation_q31 *a, int n, int m, kq_scaled_q31 *memory,
                                   size_t length, int32_t *root);

/**
 * Both scales 1, nothing learnt.
 *   a        read: sizes, memory.  Written: the rest.
 *   p, s     the process and the sensor as you think they are; kept by reference and read at every
 *            call: another A or H by kq_process_change_transition, kq_sensor_change_measurement is
 *            that of the next step.  A variance that is none stays none at any scale.
 *   rule     copied
 * KQ_ERR_NULL, KQ_ERR_SIZE and KQ_ERR_MEMORY (a was never given them; KQ_ERR_SIZE also for M),
 * KQ_ERR_NOT_READY (p, s), KQ_ERR_MISMATCH (states and components, q31: formats),
 * KQ_ERR_NOT_FINITE (rule; R times its limits), KQ_ERR_RANGE (rule.scales, step, limits);
 * q31: KQ_ERR_COEFFICIENT (a number of the rule, or a noise times its limits, is not as in a
 * table).
 */
KQ_NODISCARD kq_status kq_adaptation_init_f32(kq_adaptation_f32 *a, const kq_process_f32 *p,
                                 const kq_sensor_f32 *s, const kq_adaptation_rule_f32 *rule);
KQ_NODISCARD kq_status kq_adaptation_init_f64(kq_adaptation_f64 *a, const kq_process_f64 *p,
                                 const kq_sensor_f64 *s, const kq_adaptation_rule_f64 *rule);
KQ_NODISCARD kq_status kq_adaptation_init_q31(kq_adaptation_q31 *a, const kq_process_q31 *p,
                                 const kq_sensor_q31 *s, const kq_adaptation_rule_q31 *rule);

/*
 * From now on kq_predict of f with the p of init takes q Q, kq_update, kq_update_subset and kq_step with its
 * s take r R, and q and r then move.  D and d are 0, scales and information stay: attach it again where the
 * filter has started anew (kq_filter_init detaches it).  While q and r are 1, the very bits of the filter.
 *   f        with nothing attached but a itself.  a and f have to outlive each other until
 *            kq_detach.  kq_filter_init detaches f and does not tell a, which may be gone: an
 *            adaptation still has the filter that it was attached to, and goes to another one when it is
 *            detached, or assigned anew where that filter is gone
 * NIS, log-likelihood and count of the filter are those of the scales before they moved.  Nothing
 * is learnt of a component that is missing, at the floor (filter.h), or not representable.
 * The steps answer, beside their own errors: KQ_ERR_NOT_READY, KQ_ERR_MISMATCH, KQ_ERR_NOT_FINITE (r R), q31:
 * KQ_ERR_COEFFICIENT (q Q, r R) where p or s have since changed so that they no longer fit.
 * Cost of a predict: a root, and multiplications: n^2/2 to scale G, n^3/6 for Q, and for D 1.5 n^3
 * where A is dense, half as many where it is upper triangular; of an update: for each component 3 n^2 +
 * 2 c n multiplications (c: components before it), a root and a division; up to seven divisions more.
 * Predict and update on a Cortex-M4F in f32: 2934 instructions at n, m = 2, 1, 8029 at 4, 2, 35095 at 9, 3
 * (kq_step: 884, 1941, 6864); on an M3 in q31 12291, 35114, 152240 (2541, 6147, 19804).
 * Stack: 40 words more than predict and update (q31: 115), 136 more (q31: 272) where the update decorrelates
 * R.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (a, f), KQ_ERR_MISMATCH (states), KQ_ERR_RECORDING (a has another filter, or
 * something else is attached to f: detach it; a history refers to the processes, and q Q changes).
 */

/** q and r.  NaN, q31: {0, 0}, where a is NULL or not initialised. */
KQ_NODISCARD kq_status kq_adaptation_scales_f32(const kq_adaptation_f32 *a, float *q, float *r);
KQ_NODISCARD kq_status kq_adaptation_scales_f64(const kq_adaptation_f64 *a, double *q, double *r);
KQ_NODISCARD kq_status kq_adaptation_scales_q31(const kq_adaptation_q31 *a, kq_scaled_q31 *q, kq_scaled_q31 *r);

/**
 * The process with q Q and the sensor with r R as they are now: for kq_forecast, kq_measurement, a
 * steady state.  They change with the next call of a.  NULL where a is NULL or not initialised, or
 * what it was given has since changed so that it no longer fits.
 */
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
