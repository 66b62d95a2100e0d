/* Robust updates in floating point where numbers, P or noises are as large or small as they get. */
#include "losses.h"
#include "unchanged.h"

#define ALL UINT32_MAX

FILTER(track, 2);
SENSOR(level, 1, 1);
FILTER(river, 1);
FILTER(other_river, 1);

static const num x0[] = {1, -2};
static const num one[] = {1}, none[] = {0}, none2[] = {0, 0};
static num weights[2];

static void set_up(void)
{
    ASSERT_OK(K(sensor_init)(&level, one, one));
    ASSERT_OK(K(filter_init)(&river, none, one));
    ASSERT_OK(K(filter_init)(&other_river, none, one));
}

typedef kq_status update_with(K(filter) *f, const K(sensor) *s, const num *z, uint32_t present, num parameter);

static kq_status huber(K(filter) *f, const K(sensor) *s, const num *z, uint32_t present, num k)
{
    return update_huber(f, s, z, present, k, weights);
}

static kq_status student(K(filter) *f, const K(sensor) *s, const num *z, uint32_t present, num nu)
{
    return update_student(f, s, z, present, nu, weights);
}

/* An outlier that the numbers cannot weigh is not taken. */
TEST(an_outlier_beyond_the_numbers_is_an_event)
{
    const num huge[] = {NUM_MAX / 4}, wide[] = {N(MOST_SIGMA * MOST_SIGMA)}, measured[] = {NUM_MAX / 2};
    ASSERT_OK(update_huber(&river, &level, huge, ALL, 1, weights));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&river));
    ASSERT_WITHIN(0, 0, weights[0]);
    ASSERT_WITHIN(0, 0, K(mean)(&river, 0));
    ASSERT_OK(K(filter_init)(&river, none, wide));
    ASSERT_OK(update_huber(&river, &level, measured, ALL, N(1e-6), weights));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&river));
    TEST_ASSERT_EQUAL_INT(0, K(taken)(&river));
    ASSERT_WITHIN(0, 0, weights[0]);
    ASSERT_WITHIN(0, 0, K(mean)(&river, 0));
}

/* After a sharp one: noise r is above the floor, what is left of the state is not, and raised P would
   bring both below it.  Where it is taken, and P left alone, what the state has jumped by is lost in rounding. */
TEST(nothing_is_raised_for_what_is_not_taken)
{
    static const num same[] = {N(0.3), N(0.7), N(0.3), N(0.7)}, wide[] = {1, 0, 0, 2};
    static const num wild[] = {N(0.5), -3}, agreeing[] = {1, 1};
    SENSOR(twins, 2, 2);
    for (double variance = 0; variance < 1; variance = variance * 4 + EPS * EPS) {
        for (int k = 0; k < 4; k++) {
            const num noises[] = {k < 2 ? 0 : N(EPS * EPS), N(variance)};
            ASSERT_OK(K(sensor_init_diagonal)(&twins, same, noises));
            ASSERT_OK(K(filter_init)(&track, none2, wide));
            ASSERT_OK(update_jump(&track, &twins, k % 2 ? agreeing : wild, ALL, 9));
            const unsigned raised = K(events)(&track) & KQ_EVENT_JUMP;
            TEST_ASSERT_FALSE(raised && K(taken)(&track) < 2);
            if (k == 2 && !raised && K(taken)(&track) == 2) TEST_ASSERT_EQUAL_HEX(KQ_EVENT_PRECISION, K(events)(&track));
            if (K(taken)(&track) == 2) continue;
            ASSERT_WITHIN(TOLERANCE, sqrt(0.98 / 1.07), K(sigma)(&track, 0));
            const unsigned rounded = k < 2 ? 0 : KQ_EVENT_PRECISION; /* H x, by more than sqrt(R): in f32 and f64 */
            TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&track) & ~rounded);
        }
    }
}

/* A component without noise whose innovation is as far as that: the plain update takes it and says
   so. */
TEST(a_contradiction_is_told_by_all)
{
    update_with *updates[] = {huber, student, update_jump};
    const num far[] = {N(1 / sqrt(EPS) * 4)};
    ASSERT_OK(K(sensor_init)(&level, one, none));
    ASSERT_OK(K(update)(&other_river, &level, far));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_CONTRADICTION, K(events)(&other_river));
    for (int k = 0; k < COUNT(updates); k++) {
        ASSERT_OK(K(filter_init)(&river, none, one));
        ASSERT_OK(updates[k](&river, &level, far, ALL, 9));
        TEST_ASSERT_BITS(KQ_EVENT_CONTRADICTION, KQ_EVENT_CONTRADICTION, K(events)(&river));
    }
}

TEST(a_student_of_few_degrees_takes_what_is_near_and_far)
{
    static const double least = 0x1p-20;
    for (double variance = 1; variance < MOST_SIGMA; variance *= 64) {
        const num noises[] = {N(variance)};
        ASSERT_OK(K(sensor_init)(&level, one, noises));
        for (double far = 1e-6; far < 1e6; far *= 10) {
            const num measured[] = {N(far)};
            ASSERT_OK(K(filter_init)(&river, none, one));
            ASSERT_OK(update_student(&river, &level, measured, ALL, N(least), NULL));
            TEST_ASSERT_TRUE(K(sigma)(&river, 0) > 0 && K(sigma)(&river, 0) <= 1);
            TEST_ASSERT_EQUAL_HEX(0, K(events)(&river) & ~(unsigned)KQ_EVENT_CONTRADICTION);
        }
    }
}

/* However far a measurement is: it is followed, and P stays within the limit of filter_fade, or
   there is an event that says why not. */
TEST(a_jump_is_followed_as_far_as_the_numbers_reach)
{
    const double most = LARGE_SIGMA * 1.001;
    for (double far = 8; far < (double)NUM_MAX / 16; far *= 16) {
        const num measured[] = {N(far)};
        ASSERT_OK(K(filter_init)(&river, none, one));
        ASSERT_OK(update_jump(&river, &level, measured, ALL, 9));
        const unsigned events = K(events)(&river);
        const int taken = K(taken)(&river);
        TEST_ASSERT_TRUE(K(sigma)(&river, 0) <= 1 + 4 * (num)EPS);
        TEST_ASSERT_EQUAL_INT((events & KQ_EVENT_JUMP) != 0, taken);
        TEST_ASSERT_EQUAL_INT(taken == 0 || far > most, (events & KQ_EVENT_OVERFLOW) != 0);
        TEST_ASSERT_EQUAL_INT(far * far / 2 < (double)NUM_MAX / 16, taken);
        if (taken) ASSERT_WITHIN(1 + far * 4 * EPS, far, whole_mean(&river, 0));
        else ASSERT_WITHIN(0, 0, K(mean)(&river, 0));
    }
}

/* The state that is not measured may be far larger than the one that is. */
TEST(no_variance_is_raised_beyond_its_limit)
{
    static const num alone[] = {1};
    const double wide = LARGE_SIGMA / 64;
    const num prior[] = {1, 0, 0, N(wide * wide)}, measured[] = {N(1e6)};
    num P[4];
    SENSOR(first, 2, 1);
    ASSERT_OK(K(sensor_init)(&first, (const num[]){1, 0}, alone));
    ASSERT_OK(K(filter_init)(&track, x0, prior));
    ASSERT_OK(update_jump(&track, &first, measured, ALL, 9));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_JUMP | KQ_EVENT_OVERFLOW, K(events)(&track));
    ASSERT_OK(K(covariance)(&track, P));
    ASSERT_WITHIN(1e-3, 1, sqrt((double)P[3]) / LARGE_SIGMA);
    ASSERT_WITHIN(1e6 / 4096, 1e6, whole_mean(&track, 0));
    K(events_clear)(&track);
    ASSERT_OK(update_jump(&track, &first, (const num[]){N(-1e6)}, ALL, 9));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&track)); /* nothing left to raise */
    ASSERT_OK(K(covariance)(&track, P));
    TEST_ASSERT_TRUE(sqrt((double)P[3]) <= LARGE_SIGMA * 1.001);
}

TEST(a_noise_beyond_the_numbers_is_refused)
{
    static const num A[] = {1, 0.5, 0, 1}, immense[] = {N(MOST_SIGMA * MOST_SIGMA), 0, 0, N(MOST_SIGMA * MOST_SIGMA)};
    PROCESS(motion, 2, 0);
    PROCESS(scaled, 2, 0);
    watch_nothing();
    WATCH(motion), WATCH(motion_memory);
    ASSERT_OK(K(process_init)(&motion, A, NULL, immense));
    ASSERT_OK(K(process_scale_noise)(&scaled, &motion, NUM_MAX / 4));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(process_scale_noise)(&motion, &scaled, NUM_MAX / 4));
}

SUITE(robust_limits, set_up)
#include "robust_limits.tests"
