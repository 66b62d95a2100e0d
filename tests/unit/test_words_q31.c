/* Words in q31: a result is held at its word, and flagged; what leads to it is not. */
#include "q31.h"

static process_model still, shrink, trend;
static sensor_model pair, independent, first, second, line;
static prior_model prior, linked, level_prior;
KQ_FILTER_Q31(track, 2);
KQ_HISTORY_Q31(tape, 2, 2, 16, 16);
KQ_LAG_Q31(lag, 2, 2, 3);
KQ_INSTANT_Q31(point, 2, 2);
static kq_filter_q31 lag_view, point_view;
KQ_DIFFUSE_Q31(start, 2, 16);
KQ_FREEZE_Q31(settling, 2, 2);

/* the same in double */
PROCESS(trend_f64, 2, 0);
SENSOR(line_f64, 2, 1);
FILTER(track_f64, 2);
HISTORY(tape_f64, 2, 1, 16, 0);
DIFFUSE(start_f64, 2, 16);

/* The states' words end at 128. */
static const double range[] = {100, 100}, measured_range[] = {20000, 20000};
static const double identity[] = {1, 0, 0, 1}, tenth[] = {0.1, 0, 0, 0.1}, none[4];
static const double trend_A[] = {1, 1, 0, 1}, x0[2];
static const double H[] = {1, 30, 1, 0}, R[] = {0.01, 0, 0, 0.01}, sharp[] = {1e-4};
static const double wide[] = {1e4, 0, 0, 1}, correlated[] = {1.01e6, 1e4, 1e4, 1e2};

static void put_independent(sensor_model *s)
{
    put_sensor(s, 2, 2, range, measured_range, H, R);
    ASSERT_OK(kq_noise_prepare_diagonal_q31(s->noise, (double[]){0.01, 0.01}, 2,
                                            s->measurement_format));
    s->table.correlated = 0;
    ASSERT_OK(kq_sensor_init_q31(&s->sensor, &s->table, NULL));
}

static void set_up(void)
{
    put_process(&still, 2, 0, range, NULL, identity, NULL, none);
    put_process(&shrink, 2, 0, range, NULL, tenth, NULL, none);
    put_process(&trend, 2, 0, range, NULL, trend_A, NULL, none);
    put_sensor(&pair, 2, 2, range, measured_range, H, R);
    put_independent(&independent);
    put_sensor(&first, 2, 1, range, measured_range, identity, sharp);
    put_sensor(&second, 2, 1, range, measured_range, identity + 2, sharp);
    put_sensor(&line, 2, 1, range, range, identity, R);
    put_prior(&prior, 2, range, x0, wide);
    put_prior(&linked, 2, range, x0, correlated);
    put_prior(&level_prior, 2, range, x0, identity);
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    ASSERT_OK(kq_history_assign_q31(&tape, 2, tape_memory, COUNT(tape_memory)));
}

static void assert_mean(double x, double y)
{
    ASSERT_WITHIN(1e-2, x, mean_value(&track, 0));
    ASSERT_WITHIN(1e-2, y, mean_value(&track, 1));
}

/* ------------------------------------------------------------------ the filter */

/* (5, 20) is measured: by the first component alone state 0 would be at 550. */
static const int32_t *inside(void)
{
    static int32_t words[2];
    const double z[] = {605, 5};
    ASSERT_OK(kq_vector_prepare_q31(words, z, 2, pair.measurement_format, NULL));
    return words;
}

TEST(a_mean_may_leave_its_word_between_components)
{
    const sensor_model *sensors[] = {&pair, &independent};
    for (int k = 0; k < 2; k++) {
        ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
        ASSERT_OK(kq_update_q31(&track, &sensors[k]->sensor, inside()));
        assert_mean(5, 20);
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
        ASSERT_OK(kq_predict_q31(&track, &still.process, NULL));
        ASSERT_OK(kq_update_subset_q31(&track, &sensors[k]->sensor, inside(), 2));
        assert_mean(5, 20);
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
    }
}

/* The same where the first component is not sharp, so that it takes the ordinary path: what all is
   then, beside double */
TEST(so_it_may_where_nothing_is_sharp)
{
    static const double dull[] = {100, 50, 50, 100}, z[] = {605, 5};
    SENSOR(pair_f64, 2, 2);
    put_sensor(&pair, 2, 2, range, measured_range, H, dull);
    ASSERT_OK(K(sensor_init)(&pair_f64, H, dull));
    ASSERT_OK(K(filter_init)(&track_f64, x0, wide));
    ASSERT_OK(K(update)(&track_f64, &pair_f64, z));
    ASSERT_OK(kq_update_q31(&track, &pair.sensor, inside()));
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
    ASSERT_LIKE(&track_f64, &track, 0x1p-22);
}

TEST(so_it_may_in_robust_updates)
{
    static const struct kq_loss_kind_q31 *const losses[] = {&kq_loss_huber_q31, &kq_loss_student_q31,
                                                            &kq_loss_jump_q31, &kq_loss_gate_q31};
    static const kq_scaled_q31 large = {INT32_C(1) << 30, 20};
    const sensor_model *sensors[] = {&pair, &independent};
    for (int k = 0; k < 8; k++) {
        const kq_sensor_q31 *s = &sensors[k % 2]->sensor;
        ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
        kq_loss_q31 loss = {.kind = losses[k / 2], .parameter = large, .limit = INT64_MAX};
        ASSERT_OK(kq_update_robust_q31(&track, s, inside(), 3, &loss));
        assert_mean(5, 20);
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
    }
}

TEST(what_stays_beyond_is_held_and_flagged)
{
    const double z[] = {605, 605};
    int32_t words[2];
    ASSERT_OK(kq_vector_prepare_q31(words, z, 2, pair.measurement_format, NULL));
    ASSERT_OK(kq_update_q31(&track, &pair.sensor, words));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, kq_mean_q31(&track, 0));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_events_q31(&track));
}

/* Beyond 64 words: state 0 would be at about 1.8e4. */
TEST(the_end_of_the_headroom_is_flagged)
{
    static const double steep[] = {1, 900, 1, 0}, wider[] = {1e8, 0, 0, 1}, z[] = {18005, 5};
    int32_t words[2];
    put_sensor(&pair, 2, 2, range, measured_range, steep, R);
    put_prior(&prior, 2, range, x0, wider);
    ASSERT_OK(kq_vector_prepare_q31(words, z, 2, pair.measurement_format, NULL));
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    ASSERT_OK(kq_update_q31(&track, &pair.sensor, words));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_events_q31(&track));
}

/* ------------------------------------------------------------------ the smoother */

/* Nothing at step 0, both states at step 1; all filtered means are within their words.  Of the
   smoothed state 0 the two terms are 2000 and -1995. */
static void run_linked(void)
{
    const double five[] = {5}, twenty[] = {20};
    ASSERT_OK(kq_predict_q31(&track, &still.process, NULL));
    ASSERT_OK(kq_update_q31(&track, &first.sensor, words_of(five, 1, first.measurement_format)));
    ASSERT_OK(kq_update_q31(&track, &second.sensor, words_of(twenty, 1, second.measurement_format)));
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
}

static double value_of_word(int32_t word) { return ldexp(word, -prior.state_format[0].fraction); }

TEST(a_part_of_a_smoothed_mean_may_be_beyond_its_word)
{
    for (int k = 0; k < 3; k++) {
        ASSERT_OK(kq_filter_init_q31(&track, &linked.table, NULL));
        ASSERT_OK(kq_attach_q31(&track, &tape.attached));
        run_linked();
        if (k == 0) ASSERT_OK(kq_smooth_q31(&tape));
        if (k == 1) ASSERT_OK(kq_smooth_states_q31(&tape));
        for (int t = 0; k == 2 && t < 2; t++) ASSERT_OK(kq_smooth_step_q31(&tape, NULL, NULL));
        ASSERT_WITHIN(0.02, 5, value_of_word(kq_mean_q31(SMOOTHED_Q31(&tape, 0), 0)));
        ASSERT_WITHIN(0.02, 20, value_of_word(kq_mean_q31(SMOOTHED_Q31(&tape, 0), 1)));
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(SMOOTHED_Q31(&tape, 0)));
    }
}

TEST(so_it_may_on_line)
{
    ASSERT_OK(kq_filter_init_q31(&track, &linked.table, NULL));
    ASSERT_OK(kq_attach_q31(&track, &lag.attached));
    run_linked();
    ASSERT_OK(kq_lagged_q31(&lag, 1, &lag_view));
    ASSERT_WITHIN(0.02, 5, value_of_word(kq_mean_q31(&lag_view, 0)));
    ASSERT_WITHIN(0.02, 20, value_of_word(kq_mean_q31(&lag_view, 1)));
    ASSERT_OK(kq_filter_init_q31(&track, &linked.table, NULL));
    ASSERT_OK(kq_attach_q31(&track, &point.attached));
    run_linked();
    ASSERT_OK(kq_instant_smooth_q31(&point, &point_view));
    ASSERT_WITHIN(0.02, 5, value_of_word(kq_mean_q31(&point_view, 0)));
    ASSERT_WITHIN(0.02, 20, value_of_word(kq_mean_q31(&point_view, 1)));
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
}

/* x_0 = 10 x_1 = 1000 */
static void run_shrinking(void)
{
    const double hundred[] = {100};
    ASSERT_OK(kq_predict_q31(&track, &shrink.process, NULL));
    ASSERT_OK(kq_update_q31(&track, &first.sensor, words_of(hundred, 1, first.measurement_format)));
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
}

TEST(a_smoothed_mean_that_is_held_is_flagged)
{
    for (int k = 0; k < 3; k++) {
        ASSERT_OK(kq_filter_init_q31(&track, &linked.table, NULL));
        ASSERT_OK(kq_attach_q31(&track, &tape.attached));
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(SMOOTHED_Q31(&tape, 0)));
        run_shrinking();
        if (k == 0) ASSERT_OK(kq_smooth_q31(&tape));
        if (k == 1) ASSERT_OK(kq_smooth_states_q31(&tape));
        for (int t = 0; k == 2 && t < 2; t++) ASSERT_OK(kq_smooth_step_q31(&tape, NULL, NULL));
        TEST_ASSERT_EQUAL_INT32(INT32_MAX, kq_mean_q31(SMOOTHED_Q31(&tape, 0), 0));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_events_q31(SMOOTHED_Q31(&tape, 0)));
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
    }
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(SMOOTHED_Q31(NULL, 0)));
}

TEST(so_is_one_on_line)
{
    ASSERT_OK(kq_filter_init_q31(&track, &linked.table, NULL));
    ASSERT_OK(kq_attach_q31(&track, &lag.attached));
    run_shrinking();
    ASSERT_OK(kq_lagged_q31(&lag, 1, &lag_view));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_events_q31(&track));
    ASSERT_OK(kq_filter_init_q31(&track, &linked.table, NULL));
    ASSERT_OK(kq_attach_q31(&track, &point.attached));
    run_shrinking();
    ASSERT_OK(kq_instant_smooth_q31(&point, &point_view));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_events_q31(&track));
}

/* An innovation of 1e6 sigma is held at 32768. */
TEST(coordinates_that_are_held_are_flagged)
{
    static const double tiny[] = {1e-8, 0, 0, 1e-8}, sharper[] = {1e-8}, z[] = {100};
    put_prior(&prior, 2, range, x0, tiny);
    put_sensor(&first, 2, 1, range, measured_range, identity, sharper);
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    ASSERT_OK(kq_predict_q31(&track, &still.process, NULL));
    ASSERT_OK(kq_update_q31(&track, &first.sensor, words_of(z, 1, first.measurement_format)));
    ASSERT_OK(kq_smooth_q31(&tape));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_events_q31(SMOOTHED_Q31(&tape, 0)));
}

/* ------------------------------------------------------------------ the steady state */

/* Once its gain is kept a filter is moved by all components at once. */
TEST(a_settled_filter_is_held_at_the_end_of_a_step)
{
    static const double Q[] = {1e4, 0, 0, 1};
    put_process(&still, 2, 0, range, NULL, identity, NULL, Q);
    ASSERT_OK(kq_freeze_init_q31(&settling, 8));
    ASSERT_OK(kq_attach_q31(&track, &settling.attached));
    for (int t = 0; t < 40; t++) {
        ASSERT_OK(kq_step_q31(&track, &still.process, NULL, &independent.sensor, inside()));
    }
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&settling));
    for (int sign = -1; sign <= 1; sign += 2) {
        const double z[] = {605 * sign, 5 * sign};
        int32_t words[2];
        ASSERT_OK(kq_vector_prepare_q31(words, z, 2, independent.measurement_format, NULL));
        for (int t = 0; t < 40; t++) {
            ASSERT_OK(kq_step_q31(&track, &still.process, NULL, &independent.sensor, words));
        }
        assert_mean(5 * sign, 20 * sign);
    }
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
}

/* ------------------------------------------------------------------ the unknown start */

static uint32_t seed;

/* -1 .. 1 */
static double draw(void)
{
    seed = seed * UINT32_C(1664525) + UINT32_C(1013904223);
    return (double)(seed >> 8) * 0x1p-23 - 1;
}

static void begin_trend(void)
{
    ASSERT_OK(kq_diffuse_assign_q31(&start, 2, 16, start_memory, COUNT(start_memory)));
    ASSERT_OK(kq_diffuse_init_q31(&start, &track, &level_prior.table, 3, NULL));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    ASSERT_OK(K(diffuse_assign)(&start_f64, 2, 16, start_f64_memory, COUNT(start_f64_memory)));
    ASSERT_OK(K(diffuse_init)(&start_f64, &track_f64, x0, identity, 3));
    ASSERT_OK(K(attach)(&track_f64, &tape_f64.attached));
}

/* Is what is known of the present, in double, within 2/3 of the word? */
static int is_within(void)
{
    const double level = K(mean)(&track_f64, 0), slope = K(mean)(&track_f64, 1);
    return !(fabs(level) > 85) && !(fabs(slope) > 85);
}

/* The last measurements of 16 steps of a line, with noise that may be large.  Answers whether the
   exact states, filtered and smoothed, are all within 2/3 of the word. */
static int run_trend(double noise, int from)
{
    const double level = 60 * draw(), slope = 8 * draw();
    int within = 1;
    begin_trend();
    for (int t = 0; t < 16; t++) {
        double z[] = {level + slope * t + noise * draw()};
        z[0] = fmin(fmax(z[0], -99), 99);
        if (t) ASSERT_OK(kq_predict_q31(&track, &trend.process, NULL));
        if (t) ASSERT_OK(K(predict)(&track_f64, &trend_f64, NULL));
        within &= is_within();
        if (t < from) continue;
        const int32_t *words = words_of(z, 1, line.measurement_format);
        ASSERT_OK(kq_update_q31(&track, &line.sensor, words));
        ASSERT_OK(K(update)(&track_f64, &line_f64, z));
        within &= is_within();
    }
    const kq_status smoothed = kq_diffuse_smooth_q31(&start);
    ASSERT_OK(K(diffuse_smooth)(&start_f64));
    for (size_t t = 0; t < 16; t++) {
        within &= fabs(K(mean)(START_SMOOTHED(&start_f64, t), 0)) < 85;
        within &= fabs(K(mean)(START_SMOOTHED(&start_f64, t), 1)) < 85;
    }
    if (within) ASSERT_OK(smoothed);
    TEST_ASSERT_EQUAL_INT(kq_events_q31(&track) & KQ_EVENT_SATURATED ? KQ_SATURATED : KQ_OK, smoothed);
    return within;
}

/* The first two measurements of a line are close together, and the line through them leaves the
   words of the past; that through all does not. */
TEST(the_past_may_be_beyond_its_word_before_it_is_smoothed)
{
    int runs = 0;
    seed = 1;
    ASSERT_OK(K(process_init)(&trend_f64, trend_A, NULL, none));
    ASSERT_OK(K(sensor_init)(&line_f64, identity, R));
    for (int k = 0; k < 200; k++) {
        if (!run_trend(30, 4 + k % 4)) continue;
        runs++;
        for (size_t t = 0; t < 16; t++) {
            for (int i = 0; i < 2; i++) {
                const double mean = value_of_word(kq_mean_q31(START_SMOOTHED_Q31(&start, t), i));
                const double sigma = K(sigma)(START_SMOOTHED(&start_f64, t), i);
                ASSERT_WITHIN(1e-3 * sigma, K(mean)(START_SMOOTHED(&start_f64, t), i), mean);
            }
        }
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
    }
    TEST_ASSERT_TRUE(runs > 40);
}

SUITE(words_q31, set_up)
#include "words_q31.tests"
