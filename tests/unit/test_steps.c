/* Steps: measurements, whole and in part, and what is told of them, beside the textbook; the state some steps ahead, on
   a filter of its own; copies. */
#include "models.h"
#include "textbook.h"
#include "unchanged.h"

#ifdef KQ_TEST_Q31
#define LIKE 0x1p-24
#define LIKE_SCORES 1e-6
#define LIKE_KNOWN 1e-6
#define MAY_SAY KQ_EVENT_PRECISION
#else
#define LIKE TOLERANCE
#define LIKE_SCORES TOLERANCE
#define LIKE_KNOWN 1e-4
#define MAY_SAY 0
#endif

enum { MISSING = 3 }; /* which of the words that are refused stands where nothing was measured */

static process_model motion;
static sensor_model radar, compass, chosen;
static prior_model prior;
S_FILTER(track, 2);
S_FILTER(twin, 2);
S_FILTER(ahead, 2);
S_FILTER(blank, 2);
S_HISTORY(tape, 2, 2, 4, 0);

static const num A[] = {1, 0.5, -0.25, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1}, x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static const num range[] = {100, 10, 40}, drive_range[] = {5}, values[] = {3, 1, -1}, pushes[] = {-1, -0.5, 0, 0.5, 1};

/* three components for two states, independent or correlated */
static const num H3[] = {1, 0, 0.5, 1, -1, 0.25};
static const num independent3[] = {0.5, 0, 0, 0, 1, 0, 0, 0, 2};
static const num correlated3[] = {0.5, 0.25, -0.125, 0.25, 1, 0.5, -0.125, 0.5, 2};

static word z[3], u[5];

static void set_up(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_sensor(&radar, 2, 2, range, range, H, R);
    put_prior(&prior, 2, range, x0, P0);
    memcpy(z, measured(&radar.sensor, values), 2 * sizeof(word));
    memcpy(u, driven(&motion.process, pushes, 5), sizeof u);
    ASSERT_OK(S(filter_assign)(&ahead, 2, ahead_memory, COUNT(ahead_memory)));
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_OK(S(detach)(&tape.attached));
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(motion.process), WATCH(u), WATCH(z);
}

/* What its mean was before the last update is its rounding's size. */
static void assert_textbook_of(const textbook *t, const S(filter) *f)
{
    reading now;
    read_now(&now, f, 2);
    for (int i = 0; i < 2; i++) {
        const double size = t->size[i], sigma = (double)now.sigma[i];
        ASSERT_WITHIN(LIKE * (size + fabs(t->x[i])), t->x[i], whole(&now, i));
        ASSERT_WITHIN(LIKE * size * size + 2 * sigma * sigma_step(range[i]), t->P[3 * i], sigma * sigma);
        for (int j = 0; j < 2; j++) ASSERT_WITHIN(LIKE * size * t->size[j], t->P[2 * i + j], now.P[2 * i + j]);
    }
}

static void assert_told(const textbook *t, int taken)
{
    reading now;
    read_now(&now, &track, 2);
    TEST_ASSERT_EQUAL_INT(taken, now.taken);
    ASSERT_WITHIN(LIKE_SCORES * (4 + t->nis), t->nis, now.nis);
    ASSERT_WITHIN(LIKE_SCORES * (4 + t->nis), t->log_likelihood, now.last);
}

/* ------------------------------------------------------------------------------ update */

/* S, K and the innovation, of the state before: `t` has been updated. */
static void assert_expected(const textbook *before, const textbook *t, const num *h, int m)
{
    num implied[3], S_now[9], gain[6], e[3];
    const word *seen = measured(&chosen.sensor, values);
    watch_nothing();
    WATCH(track), WATCH(track_memory);
    ASSERT_OK_UNCHANGED(read_measurement(&track, &chosen.sensor, implied, S_now));
    ASSERT_OK_UNCHANGED(read_innovation(&track, &chosen.sensor, seen, e));
    ASSERT_OK_UNCHANGED(read_gain(&track, &chosen.sensor, gain));
    for (int c = 0; c < m; c++) {
        const double expected = (double)h[2 * c] * before->x[0] + (double)h[2 * c + 1] * before->x[1];
        ASSERT_WITHIN(LIKE, expected, implied[c]);
        ASSERT_WITHIN(3 * LIKE, (double)values[c] - expected, e[c]);
        for (int d = 0; d < m; d++) ASSERT_WITHIN(4 * LIKE, t->S[m * c + d], S_now[m * c + d]);
        for (int d = 0; d < c; d++) TEST_ASSERT_TRUE(S_now[m * c + d] == S_now[m * d + c]);
    }
    for (int k = 0; k < 2 * m; k++) ASSERT_WITHIN(2 * LIKE, t->K[k], gain[k]);
}

static void assert_update(const num *h, const num *C, int m)
{
    textbook t;
    double sum = 0;
    put_sensor(&chosen, 2, m, range, range, h, C);
    textbook_init(&t, 2, x0, P0);
    ASSERT_OK(init_filter(&track, &prior));
    for (int step = 0; step < 4; step++) {
        const textbook before = t;
        textbook_update(&t, h, C, values, m);
        assert_expected(&before, &t, h, m);
        ASSERT_OK(S(update)(&track, &chosen.sensor, measured(&chosen.sensor, values)));
        assert_textbook_of(&t, &track);
        assert_told(&t, m);
        sum += t.log_likelihood;
        ASSERT_WITHIN(LIKE_SCORES * (8 - sum), sum, score_number(S(log_likelihood)(&track)));
        textbook_predict(&t, A, B, pushes + step, 1, Q);
        ASSERT_OK(S(predict)(&track, &motion.process, u + step));
        assert_textbook_of(&t, &track);
    }
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
}

TEST(update_is_that_of_the_textbook)
{
    static const num independent[] = {0.5, 0, 0, 1};
    assert_update(H, R, 1);
    assert_update(H, independent, 2);
    assert_update(H, R, 2);
    assert_update(H3, independent3, 3);
    assert_update(H3, correlated3, 3);
}

/* Two components of the same noise, wherever they are */
TEST(a_singular_noise_is_that_of_the_textbook)
{
    static const num same[][9] = {{2, 1, 1, 1, 1.5, 1.5, 1, 1.5, 1.5},
                                  {1.5, 1.5, 1, 1.5, 1.5, 1, 1, 1, 2},
                                  {1.5, 1, 1.5, 1, 2, 1, 1.5, 1, 1.5}};
    for (int k = 0; k < COUNT(same); k++) assert_update(H3, same[k], 3);
}

TEST(sensors_of_any_size_take_turns)
{
    static const num h[] = {-1, 0.25}, variance[] = {0.125};
    textbook t;
    put_sensor(&compass, 2, 1, range, range, h, variance);
    textbook_init(&t, 2, x0, P0);
    for (int step = 0; step < 200; step++) {
        const num seen[] = {N(0.5 * sin(step)), N(0.125 * (step % 16))}, push = N(sin(step));
        if (step % 2 == 0) {
            ASSERT_OK(S(update)(&track, &compass.sensor, measured(&compass.sensor, seen)));
            textbook_update(&t, h, variance, seen, 1);
            assert_told(&t, 1);
        }
        if (step % 3 == 0) {
            ASSERT_OK(S(update)(&track, &radar.sensor, measured(&radar.sensor, seen)));
            textbook_update(&t, H, R, seen, 2);
            assert_told(&t, 2);
        }
        assert_textbook_of(&t, &track);
        const int is_pushed = step % 5 != 0;
        ASSERT_OK(S(predict)(&track, &motion.process, is_pushed ? driven(&motion.process, &push, 1) : NULL));
        textbook_predict(&t, A, is_pushed ? B : NULL, &push, 1, Q);
    }
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
}

TEST(an_innovation_may_overwrite_its_measurement)
{
    word e[2];
    ASSERT_OK(S(innovation)(&track, &radar.sensor, z, e));
    ASSERT_OK(S(innovation)(&track, &radar.sensor, z, z));
    TEST_ASSERT_EQUAL_MEMORY(e, z, sizeof e);
    z[1] = bad_word(&radar.sensor, 0);
    ASSERT_REFUSED(NOT_A_NUMBER, S(innovation)(&track, &radar.sensor, z, z));
}

/* ------------------------------------------------------------------------------ subset */

/* The rows whose bit is set: h and C hold them afterwards, w what they measured. */
static int choose_rows(uint32_t present, const num *C, num *h, num *of_rows, num *w)
{
    int m = 0, rows[3];
    for (int c = 0; c < 3; c++) {
        if (present >> c & 1) rows[m++] = c;
    }
    for (int c = 0; c < m; c++) {
        w[c] = values[rows[c]];
        for (int i = 0; i < 2; i++) h[c * 2 + i] = H3[rows[c] * 2 + i];
        for (int d = 0; d < m; d++) of_rows[c * m + d] = C[rows[c] * 3 + rows[d]];
    }
    return m;
}

/* What is missing is not read, and bits of no component are ignored. */
static void assert_subset(const num *C, uint32_t present)
{
    num h[6], of_rows[9], w[3];
    textbook t;
    const int m = choose_rows(present, C, h, of_rows, w);
    put_sensor(&chosen, 2, 3, range, range, H3, C);
    memcpy(z, measured(&chosen.sensor, values), sizeof z);
    for (int c = 0; c < 3; c++) z[c] = present >> c & 1 ? z[c] : bad_word(&chosen.sensor, MISSING);
    textbook_init(&t, 2, x0, P0);
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
    for (int step = 0; step < 4; step++) {
        textbook_update(&t, h, of_rows, w, m);
        ASSERT_OK(S(update_subset)(&track, &chosen.sensor, z, present));
        assert_textbook_of(&t, &track);
        assert_told(&t, m);
        ASSERT_OK(S(update_subset)(&twin, &chosen.sensor, z, present | ~UINT32_C(7)));
        ASSERT_SAME(&track, &twin, 2);
        textbook_predict(&t, A, NULL, NULL, 0, Q);
        ASSERT_OK(S(predict)(&track, &motion.process, NULL));
        ASSERT_OK(S(predict)(&twin, &motion.process, NULL));
    }
}

TEST(any_components_may_be_missing)
{
    for (uint32_t present = 1; present < 8; present++) {
        assert_subset(independent3, present);
        assert_subset(correlated3, present);
    }
}

/* What the components that are there say does not depend on those that are not. */
TEST(a_subset_leaves_the_sensor_as_it_is)
{
    const word *seen = measured(&radar.sensor, values);
    WATCH(radar.sensor);
    ASSERT_OK(S(update_subset)(&twin, &radar.sensor, seen, 2));
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_OK(S(update)(&twin, &radar.sensor, seen));
    put_sensor(&radar, 2, 2, range, range, H, R);
    ASSERT_OK(S(update)(&track, &radar.sensor, seen));
    ASSERT_SAME(&twin, &track, 2);
}

TEST(all_components_present_is_the_update)
{
    static const uint32_t all[] = {3, UINT32_MAX};
    for (int k = 0; k < 2; k++) {
        ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, all[k]));
        ASSERT_OK(S(update)(&twin, &radar.sensor, z));
        ASSERT_SAME(&twin, &track, 2);
    }
}

/* Also after a move larger than the state, whose low part is not yet taken into the mean; nothing is read. */
TEST(nothing_present_changes_no_bit)
{
    static const num wide[] = {1e6, 1e6}, wide_drive[] = {1e6};
    put_process(&motion, 2, 1, wide, wide_drive, A, B, Q);
    put_sensor(&radar, 2, 2, wide, wide, H, R);
    put_prior(&prior, 2, wide, x0, P0);
    ASSERT_OK(init_filter(&track, &prior));
    for (int step = 0; step < 200; step++) {
        const num push = N(1e5 * sin(7 * step)), seen[] = {N(sin(3 * step)), N(sin(3 * step + 1))};
        const word none[] = {bad_word(&radar.sensor, MISSING), bad_word(&radar.sensor, MISSING)};
        word before[COUNT(track_memory)];
        ASSERT_OK(S(step)(&track, &motion.process, NULL, &radar.sensor, measured(&radar.sensor, seen)));
        ASSERT_OK(S(predict)(&track, &motion.process, driven(&motion.process, &push, 1)));
        memcpy(before, track_memory, sizeof before);
        const score run = S(log_likelihood)(&track);
        ASSERT_OK(S(update_subset)(&track, &radar.sensor, none, step % 2 ? 0 : ~UINT32_C(3)));
        ASSERT_SAME_BITS(before, track_memory);
        TEST_ASSERT_EQUAL_INT(0, S(taken)(&track));
        TEST_ASSERT_TRUE(run == S(log_likelihood)(&track));
        TEST_ASSERT_TRUE(S(nis)(&track) == 0 && S(log_likelihood_last)(&track) == 0);
    }
}

TEST(a_component_present_must_be_a_number)
{
    for (int k = 0; k < 4; k++) {
        z[0] = bad_word(&radar.sensor, k);
        ASSERT_OK(S(update_subset)(&twin, &radar.sensor, z, 2));
        ASSERT_REFUSED(NOT_A_NUMBER, S(update_subset)(&track, &radar.sensor, z, 3));
        ASSERT_REFUSED(NOT_A_NUMBER, S(update_subset)(&track, &radar.sensor, z, 1));
    }
}

/* ------------------------------------------------------------- components without noise */

TEST(a_redundant_noise_free_component_is_not_taken)
{
    static const num twice[] = {1, 0.5, 1, 0.5}, none[4] = {0}, same[] = {3, 3};
    put_sensor(&chosen, 2, 2, range, range, twice, none);
    const word *seen = measured(&chosen.sensor, same);
    ASSERT_OK(S(update)(&track, &chosen.sensor, seen));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, S(events)(&track));
    TEST_ASSERT_EQUAL_INT(1, S(taken)(&track));
    ASSERT_OK(S(update_subset)(&twin, &chosen.sensor, seen, 1));
    ASSERT_SAME_BITS(track_memory, twin_memory);
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&twin));
    ASSERT_OK(S(update)(&twin, &chosen.sensor, seen));
    TEST_ASSERT_EQUAL_INT(0, S(taken)(&twin));
    ASSERT_SAME_BITS(track_memory, twin_memory);
    S(events_clear)(&twin);
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&twin));
}

/* Constraints that hold at every step: x0 = 0, x1 = x0, x2 = x1 + x3.  The last of them tells all of x1,
   whose row was long; what rounding leaves of it must not be taken for knowledge of x2 the next time. */
TEST(noise_free_components_may_come_again)
{
    static const num C[] = {-1, 1, 0, 0, 0, -1, 1, -1, -1, 0, 0, 0}, nothing[16] = {0}, wide[] = {20, 20, 20, 20};
    static const num h[] = {0, 0, 1, 0}, noise_of_h[] = {1. / 128}, seen[] = {-1};
    static const num P[] = {4, 0, 0, 0, 0, 4, 0, 0, 0, 0, 4, 0, 0, 0, 0, 4};
    static sensor_model constraints, third;
    static prior_model of_four;
    S_FILTER(four, 4);
    put_independent(&constraints, 4, 3, wide, wide, C, nothing);
    put_sensor(&third, 4, 1, wide, wide, h, noise_of_h);
    put_prior(&of_four, 4, wide, nothing, P);
    ASSERT_OK(init_filter(&four, &of_four));
    for (int step = 1; step <= 40; step++) {
        ASSERT_OK(S(update)(&four, &constraints.sensor, measured(&constraints.sensor, nothing)));
        TEST_ASSERT_EQUAL_INT(step == 1 ? 3 : 0, S(taken)(&four));
        TEST_ASSERT_EQUAL_HEX(step == 1 ? 0 : KQ_EVENT_REDUNDANT, S(events)(&four) & ~(unsigned)MAY_SAY);
        S(events_clear)(&four);
        ASSERT_OK(S(update)(&four, &third.sensor, measured(&third.sensor, seen)));
        /* x2 has the variance 2 before, of x3's and its own */
        const double variance = 1 / (0.5 + 128 * step);
        ASSERT_WITHIN(LIKE_KNOWN, sqrt(variance), word_value(&of_four, S(sigma)(&four, 2), 2));
        ASSERT_WITHIN(LIKE_KNOWN, -128 * step * variance, shown_mean(&four, &of_four, 2));
    }
}

/* ---------------------------------------------------------------------------- readings */

TEST(nothing_is_read_of_a_bad_filter_or_state)
{
    static const int bad[] = {-1, 2, 16, 256, INT_MAX, INT_MIN};
    static const S(filter) *const none[] = {NULL, &blank};
    for (int k = 0; k < COUNT(bad); k++) assert_nothing_shown(&track, bad[k]);
    for (int k = 0; k < COUNT(none); k++) {
        assert_nothing_shown(none[k], 0);
        ASSERT_NO_SCORE(S(nis)(none[k]));
        ASSERT_NO_SCORE(S(log_likelihood)(none[k]));
        ASSERT_NO_SCORE(S(log_likelihood_last)(none[k]));
        TEST_ASSERT_EQUAL_INT(-1, S(taken)(none[k]));
        TEST_ASSERT_EQUAL_HEX(0, S(events)(none[k]));
    }
    S(events_clear)(NULL);
}

/* -------------------------------------------------------------------------------- step */

/* B by its rows: more controls than states */
TEST(predict_takes_several_controls)
{
    static const num b[] = {1, 0.5, -2, 0.25, 0, 4}, inputs[] = {3, -1, 0.5}, ranges[] = {5, 5, 5};
    static process_model several;
    textbook t;
    put_process(&several, 2, 3, range, ranges, A, b, Q);
    textbook_init(&t, 2, x0, P0);
    textbook_predict(&t, A, b, inputs, 3, Q);
    ASSERT_OK(S(predict)(&track, &several.process, driven(&several.process, inputs, 1)));
    assert_textbook_of(&t, &track);
}

TEST(step_is_predict_and_update)
{
    for (int step = 0; step < 5; step++) {
        const word *const push = step < 4 ? u + step : NULL;
        ASSERT_OK(S(step)(&track, &motion.process, push, &radar.sensor, z));
        ASSERT_OK(S(predict)(&twin, &motion.process, push));
        ASSERT_OK(S(update)(&twin, &radar.sensor, z));
        ASSERT_SAME(&twin, &track, 2);
    }
}

/* ---------------------------------------------------------------------------- forecast */

static kq_status forecast(const word *controls, size_t steps)
{
    return S(forecast)(&track, &motion.process, controls, steps, &ahead);
}

TEST(a_forecast_is_so_many_predicts)
{
    for (int is_pushed = 0; is_pushed < 2; is_pushed++) {
        ASSERT_OK(init_filter(&twin, &prior));
        for (size_t steps = 0; steps <= 5; steps++) {
            ASSERT_OK_UNCHANGED(forecast(is_pushed ? u : NULL, steps));
            ASSERT_SAME(&twin, &ahead, 2);
            if (steps < 5) ASSERT_OK(S(predict)(&twin, &motion.process, is_pushed ? u + steps : NULL));
        }
    }
}

TEST(a_forecast_is_that_of_the_textbook)
{
    textbook t;
    textbook_init(&t, 2, x0, P0);
    for (int k = 0; k < 5; k++) textbook_predict(&t, A, B, pushes + k, 1, Q);
    ASSERT_OK(forecast(u, 5));
    assert_textbook_of(&t, &ahead);
}

/* The measurement to come: H x and H P H' + R. */
TEST(a_forecast_tells_the_measurement_to_come)
{
    textbook t;
    num implied[2], S_then[4];
    textbook_init(&t, 2, x0, P0);
    for (int k = 0; k < 3; k++) textbook_predict(&t, A, NULL, NULL, 0, Q);
    ASSERT_OK(forecast(NULL, 3));
    ASSERT_OK(read_measurement(&ahead, &radar.sensor, implied, S_then));
    ASSERT_WITHIN(8 * LIKE, 0.5 * t.x[0] + t.x[1], implied[1]);
    textbook_update(&t, H, R, values, 2);
    for (int k = 0; k < 4; k++) ASSERT_WITHIN(8 * LIKE, t.S[k], S_then[k]);
}

TEST(what_looks_ahead_is_a_filter_like_any_other)
{
    ASSERT_OK(forecast(u, 5));
    ASSERT_OK(forecast(NULL, 2)); /* once more */
    for (int k = 0; k < 2; k++) ASSERT_OK(S(predict)(&twin, &motion.process, NULL));
    ASSERT_OK(S(update)(&ahead, &radar.sensor, z));
    ASSERT_OK(S(update)(&twin, &radar.sensor, z));
    ASSERT_OK(S(step)(&ahead, &motion.process, u, &radar.sensor, z));
    ASSERT_OK(S(step)(&twin, &motion.process, u, &radar.sensor, z));
    ASSERT_SAME(&twin, &ahead, 2);
}

TEST(a_forecast_is_not_recorded)
{
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(predict)(&track, &motion.process, NULL));
    WATCH(tape), WATCH(tape_memory);
    ASSERT_OK_UNCHANGED(forecast(NULL, 9));
    ASSERT_OK_UNCHANGED(S(predict)(&ahead, &motion.process, NULL));
    ASSERT_OK_UNCHANGED(S(update)(&ahead, &radar.sensor, z));
    TEST_ASSERT_EQUAL_UINT(2, S(history_steps)(&tape));
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&ahead));
}

/* The filter that looks ahead has no history, also if it had one. */
TEST(a_history_of_the_filter_ahead_is_detached)
{
    ASSERT_OK(init_filter(&ahead, &prior));
    ASSERT_OK(S(attach)(&ahead, &tape.attached));
    ASSERT_OK(forecast(NULL, 1));
    const size_t steps = S(history_steps)(&tape);
    ASSERT_OK(S(predict)(&ahead, &motion.process, NULL));
    TEST_ASSERT_EQUAL_UINT(steps, S(history_steps)(&tape));
}

TEST(each_control_of_a_forecast_must_be_a_number)
{
    for (int step = 0; step < 4; step++) {
        const word good = u[step];
        for (int k = 0; k < 4; k++) {
            u[step] = bad_word(&radar.sensor, k);
            ASSERT_REFUSED(NOT_A_NUMBER, forecast(u, 4));
            ASSERT_OK(forecast(u, (size_t)step)); /* not read beyond the steps */
        }
        u[step] = good;
    }
}

TEST(forecast_reads_no_control_that_the_process_has_not)
{
    static process_model idle;
    put_process(&idle, 2, 0, range, NULL, A, NULL, Q);
    u[0] = u[1] = bad_word(&radar.sensor, MISSING);
    ASSERT_OK(S(forecast)(&track, &idle.process, u, 2, &ahead));
    for (int k = 0; k < 2; k++) ASSERT_OK(S(predict)(&twin, &idle.process, NULL));
    ASSERT_SAME(&twin, &ahead, 2);
}

/* ------------------------------------------------------------------------------ copies */

TEST(a_copy_is_the_filter)
{
    ASSERT_OK(S(update)(&track, &radar.sensor, z));
    track.events = KQ_EVENT_REDUNDANT;
    ASSERT_OK_UNCHANGED(S(filter_copy)(&ahead, &track));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, S(events)(&ahead));
    TEST_ASSERT_EQUAL_INT(2, S(taken)(&ahead));
    ASSERT_SAME(&track, &ahead, 2);
    ASSERT_OK(S(step)(&track, &motion.process, u, &radar.sensor, z));
    ASSERT_OK(S(step)(&ahead, &motion.process, u, &radar.sensor, z));
    ASSERT_SAME_BITS(track_memory, ahead_memory);
    ASSERT_SAME(&track, &ahead, 2);
}

/* What moves the copy leaves the original alone, and its history. */
TEST(a_copy_has_its_own_memory)
{
    ASSERT_OK(S(attach)(&track, &tape.attached));
    WATCH(tape), WATCH(tape_memory);
    ASSERT_OK_UNCHANGED(S(filter_copy)(&ahead, &track));
    ASSERT_OK_UNCHANGED(S(step)(&ahead, &motion.process, u, &radar.sensor, z));
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&ahead));
    ASSERT_OK(S(predict)(&track, &motion.process, NULL));
    TEST_ASSERT_EQUAL_UINT(2, S(history_steps)(&tape));
}

TEST(a_filter_is_not_copied_onto_itself)
{
    S(filter) bare = {.states = 2}, shared = track;
    ASSERT_REFUSED(KQ_ERR_MEMORY, S(filter_copy)(&bare, &track));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(filter_copy)(&shared, &track));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(forecast)(&track, &motion.process, u, 0, &track));
}

SUITE(steps, set_up)
#include "steps.tests"
