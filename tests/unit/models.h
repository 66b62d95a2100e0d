/*
 * Models for texts of all arithmetics: KQ_TEST_F32, KQ_TEST_F64 or KQ_TEST_Q31 says which one is tested.
 *
 * S(name) is kq_name_<T>, S_FILTER and so on declare its objects.  Numbers are `num`, for q31 doubles, as K(name) is
 * then the library in double (arithmetic.h).  What calls take and give is a `word` (a measurement, a control, a
 * mean), an `entry` (of a covariance, a gain) or a `score`: in floating point all three are `num`.
 *
 * Models are made of numbers and of declared ranges, at which floating point does not look:
 *     put_process, put_sensor, put_independent, put_prior      (the arrays must stay)
 *     init_filter(f, &prior), init_start(s, f, &prior, unknown)
 *     change_transition(&process, n, A), change_measurement(&sensor, n, m, H), init_lean(&sensor, r)
 *     ASSIGN_ADAPTATION(a, n, m), usual_rule()                  of a declared adaptation
 *     measured(s, z), driven(p, u, steps)                      the words of numbers, until the next call
 *     moved_by(&process, d)                                    an increment of the mean
 *     of_innovations(&sensor), lean_of_innovations(&sensor, r) a sensor like it that takes innovations
 *     number(a), score_of(a), score_number(score)              a parameter, a factor; a score and back
 * Readings are numbers in the states' units, which are the same bits where the words are (reading.h):
 *     read_now(&r, f, n), read_shown(&r, view, &prior, n), read_smoothed_at(&r, &tape, t, &prior, n)
 *     read_gain, read_measurement, read_innovation, step_back, read_noise, number_of(entry)
 *     ASSERT_SAME(f, g, n)                                     two filters, bit for bit
 *     is_nothing(word), is_no_score(score)                     what is read where there is nothing
 * What rounding may do, relative to the size of the numbers: ROUNDING, to the results of a law's
 * calls; ROUNDING_OF_MEANS, where P is the same bits; ROUNDING_IN_TURN, to a mean that is taken apart by
 * components; score_rounding(score, terms).  Last bits beside those of `num`, 0 if there are none:
 * sigma_step(range), score_step(), smoother_step() of a smoothed mean in sigmas.
 */
#ifndef KALMANQ_TESTS_MODELS_H
#define KALMANQ_TESTS_MODELS_H

/* What a test of garbage does before each call; nothing, mostly. */
static void do_nothing(void) {}
static void (*volatile before_call)(void) = do_nothing;

#define CALL(call)                                                                                 \
    do {                                                                                           \
        before_call();                                                                             \
        ASSERT_OK(call);                                                                           \
    } while (0)

#ifdef KQ_TEST_Q31
#include "models_q31.h"
#else
#include "models_float.h"
#endif

/* Objects and lengths */
#define S_FILTER S_IN_T(KQ_FILTER)
#define S_HISTORY S_IN_T(KQ_HISTORY)
#define S_LAG S_IN_T(KQ_LAG)
#define S_INSTANT S_IN_T(KQ_INSTANT)
#define S_DIFFUSE S_IN_T(KQ_DIFFUSE)
#define S_ADAPTATION S_IN_T(KQ_ADAPTATION)
#define S_STEADY S_IN_T(KQ_STEADY)
#define S_FREEZE S_IN_T(KQ_FREEZE)
#define S_CONSISTENCY S_IN_T(KQ_CONSISTENCY)
#define S_JACOBIANS S_IN_T(KQ_JACOBIANS)
#define S_JACOBIANS_LEN S_IN_T(KQ_JACOBIANS_LEN)
#define S_CONSISTENCY_LEN S_IN_T(KQ_CONSISTENCY_LEN)
#define S_FILTER_LEN S_IN_T(KQ_FILTER_LEN)
#define S_HISTORY_LEN S_IN_T(KQ_HISTORY_LEN)
#define S_LAG_LEN S_IN_T(KQ_LAG_LEN)
#define S_INSTANT_LEN S_IN_T(KQ_INSTANT_LEN)
#define S_DIFFUSE_LEN S_IN_T(KQ_DIFFUSE_LEN)
#define S_SMOOTHED S_IN_T(SMOOTHED)

#define ASSERT_NOTHING(word) TEST_ASSERT_TRUE(is_nothing(word))
#define ASSERT_NO_SCORE(score) TEST_ASSERT_TRUE(is_no_score(score))

/* Equal but for rounding; size: the size of the numbers that it came from. */
#define ASSERT_ALIKE(expected, actual, size)                                                       \
    assert_within(ROUNDING *(double)(size), (double)(expected), (double)(actual), __LINE__)

/* What most adaptations of tests learn by: both scales, a memory of 50 */
static inline S(adaptation_rule) usual_rule(void)
{
    return (S(adaptation_rule)){KQ_ADAPT_BOTH, 50, number(0.125), number(0.0625), number(16), number(0.125), number(8)};
}

/* The mean with its low part */
static inline double whole(const reading *r, int i) { return (double)r->mean[i] + (double)r->low[i]; }

static inline void read_smoothed_at(reading *r, const S(history) *h, size_t t, const prior_model *p, int n)
{
    read_shown(r, S_SMOOTHED(h, t), p, n);
}

/* Nothing is shown of component i. */
static inline void assert_nothing_shown(const S(filter) *view, int i)
{
    ASSERT_NOTHING(S(mean)(view, i));
    ASSERT_NOTHING(S(mean_low)(view, i));
    ASSERT_NOTHING(S(sigma)(view, i));
}

#endif
