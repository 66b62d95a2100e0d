/* The history and the smoother. */
#include "innovations.h"
#include "losses.h"
#include "reading.h"
#include "sizes.h"
#include "textbook.h"
#include "unchanged.h"

#define STEPS 6
#define MOST 3 /* scalar measurements of one step */

PROCESS(motion, 2, 1);
SENSOR(radar, 2, 2);
SENSOR(compass, 2, 1);
FILTER(track, 2);
FILTER(twin, 2);
static K(filter) view;
HISTORY(tape, 2, MOST, STEPS, 0);

/* never initialised, and of another size */
FILTER(blank, 2);
PROCESS(blank_process, 2, 1);
HISTORY(unused, 2, 1, 2, 0);
FILTER(track3, 3);
PROCESS(motion3, 3, 0);
HISTORY(tape3, 3, 1, 2, 0);

static const num A[] = {1, 0.5, -0.25, 0.75}, B[] = {0.125, 0.5};
static const num Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const num direction[] = {-1, 0.25}, variance[] = {0.125};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static const num identity3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, zero3[3];

static textbook filtered[STEPS], predicted[STEPS], smoothed[STEPS];
static double lag_one[STEPS][4];

static void set_up(void)
{
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    ASSERT_OK(K(process_init)(&motion3, identity3, NULL, identity3));
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    ASSERT_OK(K(sensor_init)(&compass, direction, variance));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(filter_init)(&track3, zero3, identity3));
    ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(tape), WATCH(tape_memory), WATCH(motion);
    WATCH(motion_memory), WATCH(blank), WATCH(blank_memory), WATCH(unused), WATCH(unused_memory);
    WATCH(tape3), WATCH(tape3_memory), WATCH(track3), WATCH(track3_memory);
}

/* ---------------------------------------------------------------------------- scenario */

/* Step 0: radar.  1: nothing.  2: second component of the radar.  3: radar and compass.
   4: compass twice.  5: radar. */
static const num radar_z[STEPS][2] = {{3, 1}, {0, 0}, {0, -1}, {0.5, 0.25}, {0, 0}, {-1, 2}};
static const num compass_z[] = {-0.5, 1.25};
static const num z_zero[2];
static const num control[STEPS] = {1, -2, 0.5, 4, 0, 0};

static void measure(K(filter) * f, textbook *t, int step)
{
    if (step == 0 || step == 3 || step == 5) {
        ASSERT_OK(K(update)(f, &radar, radar_z[step]));
        textbook_update(t, H, R, radar_z[step], 2);
    }
    if (step == 2) {
        ASSERT_OK(K(update_subset)(f, &radar, radar_z[step], 2));
        textbook_update(t, H + 2, R + 3, radar_z[step] + 1, 1);
    }
    for (int k = 0; k < (step == 4 ? 2 : step == 3); k++) {
        ASSERT_OK(K(update)(f, &compass, compass_z + k));
        textbook_update(t, direction, variance, compass_z + k, 1);
    }
}

/* The run, by the library and by the textbook. */
static void run(K(filter) * f)
{
    textbook t;
    textbook_init(&t, 2, x0, P0);
    for (int step = 0; step < STEPS; step++) {
        measure(f, &t, step);
        filtered[step] = t;
        if (step + 1 == STEPS) break;
        ASSERT_OK(K(predict)(f, &motion, control + step));
        textbook_predict(&t, A, B, control + step, 1, Q);
        predicted[step + 1] = t;
    }
    smoothed[STEPS - 1] = filtered[STEPS - 1];
    for (int step = STEPS - 2; step >= 0; step--) {
        smoothed[step] = filtered[step];
        textbook_smooth(&smoothed[step], &predicted[step + 1], &smoothed[step + 1], A,
                        lag_one[step]);
    }
}

static void assert_means(size_t from)
{
    for (size_t t = from; t < STEPS; t++) {
        for (int i = 0; i < 2; i++) {
            ASSERT_CLOSE(smoothed[t].x[i], whole_smoothed_mean(&tape, t, i), 8);
        }
    }
}

static void assert_covariances(size_t from)
{
    num P[4];
    for (size_t t = from; t < STEPS; t++) {
        ASSERT_OK(K(covariance)(SMOOTHED(&tape, t), P));
        for (int k = 0; k < 4; k++) ASSERT_CLOSE(smoothed[t].P[k], P[k], 2);
        for (int i = 0; i < 2; i++) {
            ASSERT_CLOSE(sqrt(smoothed[t].P[3 * i]), K(sigma)(SMOOTHED(&tape, t), i), 2);
        }
        TEST_ASSERT_EQUAL_MEMORY(&P[1], &P[2], sizeof(num));
    }
}

/* ------------------------------------------------------------------------------ smooth */

static void smoothing_is_that_of_the_textbook(void)
{
    run(&track);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    ASSERT_OK(K(smooth)(&tape));
    TEST_ASSERT_EQUAL_UINT(STEPS, K(history_steps)(&tape));
    assert_means(0);
    assert_covariances(0);
}

static void the_mean_is_rounded_once(void)
{
    run(&track);
    ASSERT_OK(K(smooth)(&tape));
    for (size_t t = 0; t < STEPS; t++) {
        for (int i = 0; i < 2; i++) {
            const double mean = (double)K(mean)(SMOOTHED(&tape, t), i);
            const double low = (double)K(mean_low)(SMOOTHED(&tape, t), i);
            TEST_ASSERT_TRUE(fabs(low) <= 0.5 * EPS * fabs(mean));
        }
    }
}

static void the_last_step_is_the_filter_s(void)
{
    reading last, end;
    run(&track);
    ASSERT_OK(K(smooth)(&tape));
    read_filter(&end, &track, 2);
    read_smoothed(&last, &tape, STEPS - 1, 2);
    TEST_ASSERT_EQUAL_MEMORY(&end, &last, offsetof(reading, nis));
}

static void states_only_gives_the_means(void)
{
    num P[4];
    run(&track);
    ASSERT_OK(K(smooth_states)(&tape));
    assert_means(0);
    for (size_t t = 0; t < STEPS; t++) {
        ASSERT_NAN(K(sigma)(SMOOTHED(&tape, t), 0));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(SMOOTHED(&tape, t), P));
    }
}

static void a_history_of_one_step_is_the_filter(void)
{
    textbook t;
    reading now, end;
    textbook_init(&t, 2, x0, P0);
    measure(&track, &t, 3);
    read_filter(&end, &track, 2);
    ASSERT_OK(K(smooth)(&tape));
    TEST_ASSERT_EQUAL_UINT(1, K(history_steps)(&tape));
    read_smoothed(&now, &tape, 0, 2);
    TEST_ASSERT_EQUAL_MEMORY(&end, &now, offsetof(reading, nis));
}

static void the_filter_is_detached_and_goes_on(void)
{
    run(&track);
    run(&twin);
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_SAME_FILTER(&twin, &track, 2);
    watch_nothing();
    WATCH(tape), WATCH(tape_memory);
    ASSERT_OK_UNCHANGED(K(step)(&track, &motion, NULL, &radar, radar_z[0]));
    ASSERT_OK(K(step)(&twin, &motion, NULL, &radar, radar_z[0]));
    ASSERT_SAME_FILTER(&twin, &track, 2);
    TEST_ASSERT_EQUAL_UINT(STEPS, K(history_steps)(&tape));
    assert_means(0);
    assert_covariances(0);
}

static void recording_changes_nothing_of_the_filter(void)
{
    run(&track);
    run(&twin);
    ASSERT_SAME_FILTER(&twin, &track, 2);
}

/* ------------------------------------------------------------------------- smooth_step */

static void assert_not_smoothed_below(size_t end)
{
    num P[4];
    for (size_t t = 0; t < end; t++) {
        ASSERT_NAN(K(mean)(SMOOTHED(&tape, t), 0));
        ASSERT_NAN(K(mean_low)(SMOOTHED(&tape, t), 0));
        ASSERT_NAN(K(sigma)(SMOOTHED(&tape, t), 0));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(SMOOTHED(&tape, t), P));
    }
}

static void one_step_a_call_can_be_read_on_the_way(void)
{
    run(&track);
    assert_not_smoothed_below(STEPS);
    for (size_t t = STEPS; t-- > 0;) {
        ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
        TEST_ASSERT_EQUAL_UINT(STEPS, K(history_steps)(&tape));
        assert_means(t);
        assert_covariances(t);
        assert_not_smoothed_below(t);
    }
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth_step)(&tape, NULL, NULL));
    assert_means(0);
    assert_covariances(0);
}

static void the_first_step_detaches_the_filter(void)
{
    run(&track);
    ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
    ASSERT_OK(K(predict)(&track, &motion, control));
    ASSERT_OK(K(update)(&track, &radar, radar_z[0]));
    for (int k = 1; k < STEPS; k++) ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
    assert_means(0);
    assert_covariances(0);
}

static void steps_may_name_their_process(void)
{
    PROCESS(copy, 2, 1);
    ASSERT_OK(K(process_init)(&copy, A, B, Q));
    run(&track);
    for (int k = 0; k < STEPS; k++) ASSERT_OK(K(smooth_step)(&tape, &copy, NULL));
    assert_means(0);
    assert_covariances(0);
}

typedef struct {
    num lag_one[4], noise_mean[2], noise_covariance[4];
} outputs;

static void clear_outputs(outputs *o)
{
    num *words = (num *)o;
    for (size_t k = 0; k < sizeof *o / sizeof(num); k++) words[k] = 77;
}

/* E[w | T] = x+ - A x - B u and Cov(w | T) = P+ - L A' - A L' + A P A', all smoothed. */
static void assert_process_noise(const outputs *o, int t)
{
    const textbook *now = &smoothed[t], *next = &smoothed[t + 1];
    double a[4], AL[4], AP[4], APA[4];
    textbook_widen(a, A, 4);
    textbook_multiply_transposed(AL, a, lag_one[t], 2, 2, 2);
    textbook_multiply(AP, a, now->P, 2, 2, 2);
    textbook_multiply_transposed(APA, AP, a, 2, 2, 2);
    for (int i = 0; i < 2; i++) {
        const double moved =
            a[2 * i] * now->x[0] + a[2 * i + 1] * now->x[1] + (double)B[i] * (double)control[t];
        ASSERT_CLOSE(next->x[i] - moved, o->noise_mean[i], 8);
        for (int j = 0; j < 2; j++) {
            const double expected =
                next->P[2 * i + j] - AL[2 * i + j] - AL[2 * j + i] + APA[2 * i + j];
            ASSERT_CLOSE(expected, o->noise_covariance[2 * i + j], 4);
        }
    }
}

static void a_step_gives_extras(void)
{
    outputs o;
    const K(smooth_extras) extras = {o.lag_one, o.noise_mean, o.noise_covariance};
    run(&track);
    for (int t = STEPS - 1; t >= 0; t--) {
        clear_outputs(&o);
        ASSERT_OK(K(smooth_step)(&tape, NULL, &extras));
        if (t == STEPS - 1) {
            const num *words = (const num *)&o;
            for (size_t k = 0; k < sizeof o / sizeof(num); k++) TEST_ASSERT_TRUE(words[k] == 77);
            continue;
        }
        for (int k = 0; k < 4; k++) ASSERT_CLOSE(lag_one[t][k], o.lag_one[k], 2);
        assert_process_noise(&o, t);
    }
    assert_means(0);
    assert_covariances(0);
}

/* Which of the extras are wanted (a bit each) makes no difference to those that are. */
static void each_extra_comes_alone(void)
{
    outputs all[STEPS], one;
    const K(smooth_extras) none = {NULL, NULL, NULL};
    for (unsigned wanted = 8; wanted-- > 0;) {
        ASSERT_OK(K(filter_init)(&track, x0, P0));
        ASSERT_OK(K(attach)(&track, &tape.attached));
        run(&track);
        for (int t = STEPS - 1; t >= 0; t--) {
            outputs *o = wanted == 7 ? &all[t] : &one;
            K(smooth_extras) extras = none;
            clear_outputs(o);
            if (wanted & 1) extras.lag_one = o->lag_one;
            if (wanted & 2) extras.noise_mean = o->noise_mean;
            if (wanted & 4) extras.noise_covariance = o->noise_covariance;
            ASSERT_OK(K(smooth_step)(&tape, NULL, &extras));
            if (wanted & 1) ASSERT_SAME_BITS(all[t].lag_one, o->lag_one);
            if (wanted & 2) ASSERT_SAME_BITS(all[t].noise_mean, o->noise_mean);
            if (wanted & 4) ASSERT_SAME_BITS(all[t].noise_covariance, o->noise_covariance);
        }
        assert_means(0);
        assert_covariances(0);
    }
}

/* ------------------------------------------------------------------- measurement noise */

/* z = h x + v with Var v = r: v / sqrt(r) given all is (z - h x) / sqrt(r), h P h' / r. */
static void assert_noise(int t, int k, double h0, double h1, double r, double z)
{
    num mean = 77, spread = 77;
    const textbook *s = &smoothed[t];
    const double v = z - h0 * s->x[0] - h1 * s->x[1];
    const double hPh = h0 * h0 * s->P[0] + 2 * h0 * h1 * s->P[1] + h1 * h1 * s->P[3];
    ASSERT_OK_UNCHANGED(K(smoothed_measurement_noise)(&tape, k, &mean, &spread));
    ASSERT_CLOSE(v / sqrt(r), mean, 32);
    ASSERT_CLOSE(hPh / r, spread, 8);
}

/* R = U D U', U unit upper triangular: the first component less U_01 of the second. */
static void assert_radar_noise(int t)
{
    const double u = (double)R[1] / (double)R[3];
    const double r = (double)R[0] - u * (double)R[1];
    const double z = (double)radar_z[t][0] - u * (double)radar_z[t][1];
    assert_noise(t, 0, (double)H[0] - u * (double)H[2], (double)H[1] - u * (double)H[3], r, z);
    assert_noise(t, 1, (double)H[2], (double)H[3], (double)R[3], (double)radar_z[t][1]);
}

static void assert_number_of_noises(int count)
{
    num mean = 77, spread = 77;
    static const int32_t beyond[] = {0, 1, 255, 256, 65535, 65536};
    for (int k = 0; k < COUNT(beyond); k++) {
        if (beyond[k] > INT_MAX - count) continue;
        ASSERT_REFUSED(KQ_ERR_SIZE, K(smoothed_measurement_noise)(&tape, count + (int)beyond[k],
                                                                  &mean, &spread));
    }
    ASSERT_REFUSED(KQ_ERR_SIZE, K(smoothed_measurement_noise)(&tape, -1, &mean, &spread));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(smoothed_measurement_noise)(&tape, INT_MAX, &mean, &spread));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(smoothed_measurement_noise)(&tape, INT_MIN, &mean, &spread));
    TEST_ASSERT_TRUE(mean == 77 && spread == 77);
}

static void the_smoothed_measurement_noise_is_the_residual(void)
{
    static const int count[STEPS] = {2, 0, 1, 3, 2, 2};
    const double h0 = (double)direction[0], h1 = (double)direction[1];
    run(&track);
    for (int t = STEPS - 1; t >= 0; t--) {
        ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
        if (t == 0 || t == 3 || t == 5) assert_radar_noise(t);
        if (t == 2) assert_noise(t, 0, (double)H[2], (double)H[3], (double)R[3], -1);
        if (t == 3) assert_noise(t, 2, h0, h1, (double)variance[0], (double)compass_z[0]);
        for (int k = 0; k < 2 && t == 4; k++) {
            assert_noise(t, k, h0, h1, (double)variance[0], (double)compass_z[k]);
        }
        assert_number_of_noises(count[t]);
    }
}

static void a_measurement_that_was_not_taken_has_no_noise(void)
{
    static const num h[] = {1, 0.5, 1, 0.5}, free_of_noise[] = {0, 0}, z[] = {3, 4};
    num mean = 77, spread = 77;
    ASSERT_OK(K(sensor_init_diagonal)(&radar, h, free_of_noise));
    ASSERT_OK(K(update)(&track, &radar, z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&track));
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    for (int k = 0; k < 2; k++) ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
    ASSERT_OK(K(smoothed_measurement_noise)(&tape, 1, &mean, &spread));
    TEST_ASSERT_TRUE(mean == 0 && spread == 0);
    ASSERT_OK(K(smoothed_measurement_noise)(&tape, 0, &mean, &spread));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(smoothed_measurement_noise)(&tape, 2, &mean, &spread));
}

/* At the last step v is what the update left of the innovation: e r / s, and e sqrt(r) / s in
   units of its standard deviation.  However small that is, it is accurate. */
static void the_noise_of_a_sharp_or_dull_measurement_is_accurate(void)
{
    static const double sizes[] = {1e-10, 1e-6, 1e-4, 1e-2, 1e2, 1e4, 1e6, 1e10};
    static const num z[] = {3}, h[] = {1, 0.5};
    for (int k = 0; k < COUNT(sizes); k++) {
        const num r[] = {N(sizes[k])};
        num mean, spread;
        ASSERT_OK(K(filter_init)(&track, x0, P0));
        ASSERT_OK(K(attach)(&track, &tape.attached));
        ASSERT_OK(K(sensor_init)(&compass, h, r));
        ASSERT_OK(K(update)(&track, &compass, z));
        ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
        ASSERT_OK(K(smoothed_measurement_noise)(&tape, 0, &mean, &spread));
        const double s = 2.75 + (double)r[0], e = 3;
        ASSERT_CLOSE(e * sqrt((double)r[0]) / s, mean, e * sqrt((double)r[0]) / s);
        ASSERT_CLOSE(2.75 / s, spread, 2.75 / s);
    }
}

static void measurement_noise_refuses(void)
{
    num mean = 77, spread = 77;
    WATCH(mean), WATCH(spread);
    run(&track);
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smoothed_measurement_noise)(&tape, 0, &mean, &spread));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smoothed_measurement_noise)(&unused, 0, &mean, &spread));
    ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(smoothed_measurement_noise)(NULL, 0, &mean, &spread));
    ASSERT_REFUSED(KQ_ERR_NULL, K(smoothed_measurement_noise)(&tape, 0, NULL, &spread));
    ASSERT_REFUSED(KQ_ERR_NULL, K(smoothed_measurement_noise)(&tape, 0, &mean, NULL));
    assert_number_of_noises(2);
    watch_nothing();
}

/* ------------------------------------------------------------------- assign and attach */

static void assign_does_what_the_macro_does(void)
{
    HISTORY(declared, 2, MOST, STEPS, 0);
    TEST_ASSERT_EQUAL_UINT(HISTORY_LEN(2, MOST, STEPS, 0), COUNT(declared_memory));
    ASSERT_OK(K(attach)(&track, &declared.attached));
    run(&track);
    ASSERT_OK(K(smooth)(&declared));
    ASSERT_OK(K(detach)(&tape.attached));
    ASSERT_OK(K(attach)(&twin, &tape.attached));
    run(&twin);
    ASSERT_OK(K(smooth)(&tape));
    assert_means(0);
    for (size_t t = 0; t < STEPS; t++) {
        reading a, b;
        read_smoothed(&a, &tape, t, 2);
        read_smoothed(&b, &declared, t, 2);
        ASSERT_SAME_BITS(a, b);
    }
}

static void assign_refuses_null(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, K(history_assign)(NULL, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_REFUSED(KQ_ERR_NULL, K(history_assign)(&tape, 2, NULL, COUNT(tape_memory)));
}

static void assign_refuses_sizes_out_of_range(void)
{
    static const int bad[] = {0, -1, 17, 258, -254, INT_MAX, INT_MIN};
    for (int k = 0; k < COUNT(bad); k++) {
        ASSERT_REFUSED(KQ_ERR_SIZE, K(history_assign)(&tape, bad[k], tape_memory, SIZE_MAX));
    }
}

/* At least the workspace and one step. */
static void assign_refuses_short_memory(void)
{
    for (size_t n = 1; n <= 16; n++) {
        const size_t least = (size_t)HISTORY_LEN(n, 0, 1, 0);
        ASSERT_REFUSED(KQ_ERR_MEMORY, K(history_assign)(&tape, (int)n, tape_memory, least - 1));
        ASSERT_REFUSED(KQ_ERR_MEMORY, K(history_assign)(&tape, (int)n, tape_memory, 0));
        K(history) h;
        ASSERT_OK(K(history_assign)(&h, (int)n, tape_memory, (size_t)HISTORY_LEN(n, 1, 1, 0)));
    }
}

static void attach_refuses(void)
{
    K(history) bare;
    memset(&bare, 0, sizeof bare);
    WATCH(bare);
    ASSERT_REFUSED(KQ_ERR_NULL, K(attach)(&track, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(attach)(NULL, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&blank, &unused.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&track, &bare.attached));
    bare.attached.hooks = tape.attached.hooks; /* without sizes */
    ASSERT_REFUSED_SIZE_OR_MEMORY(K(attach)(&track, &bare.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(attach)(&track, &tape3.attached));
    run(&track);
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(attach)(&track3, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&blank, &tape.attached));
    ASSERT_OK(K(smooth)(&tape));
    assert_means(0);
    watch_nothing();
}

static void steps_are_the_predicts_and_one(void)
{
    TEST_ASSERT_EQUAL_UINT(0, K(history_steps)(NULL));
    TEST_ASSERT_EQUAL_UINT(0, K(history_steps)(&unused));
    TEST_ASSERT_EQUAL_UINT(1, K(history_steps)(&tape));
    for (unsigned k = 2; k <= STEPS; k++) {
        ASSERT_OK(K(update)(&track, &compass, compass_z));
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        TEST_ASSERT_EQUAL_UINT(k, K(history_steps)(&tape));
    }
}

static void attach_empties_the_history(void)
{
    run(&track);
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(detach)(&tape.attached));
    ASSERT_OK(K(attach)(&twin, &tape.attached));
    TEST_ASSERT_EQUAL_UINT(1, K(history_steps)(&tape));
    run(&twin);
    ASSERT_OK(K(smooth)(&tape));
    assert_means(0);
    ASSERT_OK(K(attach)(&track, &tape.attached));
    TEST_ASSERT_EQUAL_UINT(1, K(history_steps)(&tape));
    ASSERT_NAN(K(mean)(SMOOTHED(&tape, 0), 0));
}

/* The first filter still points to the history, must not write on it any more, and says so. */
static void a_history_assigned_anew_forgets_its_filter(void)
{
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(K(attach)(&twin, &tape.attached));
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, K(events)(&track));
    ASSERT_OK(K(update)(&track, &radar, radar_z[3]));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&twin));
    TEST_ASSERT_EQUAL_UINT(1, K(history_steps)(&tape));
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_WITHIN(0, x0[0], K(mean)(SMOOTHED(&tape, 0), 0));
}

/* Nor is it attached to another one: the filter says so at what it would have recorded first. */
static void a_history_assigned_anew_is_not_recorded_on(void)
{
    for (int updates = 0; updates < 2; updates++) {
        ASSERT_OK(K(filter_init)(&track, x0, P0));
        ASSERT_OK(K(attach)(&track, &tape.attached));
        ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
        const kq_status status = updates ? K(update)(&track, &radar, radar_z[3])
                                         : K(predict)(&track, &motion, NULL);
        ASSERT_OK(status);
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, K(events)(&track));
        ASSERT_OK(K(step)(&track, &motion, NULL, &radar, radar_z[3]));
        ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth)(&tape));
    }
}

/* The state as it is becomes step 0, whatever came before. */
static void attach_begins_in_the_middle_of_a_run(void)
{
    num mean[2], P[4];
    ASSERT_OK(K(filter_init)(&track, zero3, identity3));
    for (int k = 0; k < 3; k++) ASSERT_OK(K(step)(&track, &motion, NULL, &radar, radar_z[3]));
    for (int i = 0; i < 2; i++) mean[i] = K(mean)(&track, i);
    ASSERT_OK(K(covariance)(&track, P));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    ASSERT_OK(K(smooth)(&tape));
    TEST_ASSERT_EQUAL_UINT(2, K(history_steps)(&tape));
    for (int i = 0; i < 2; i++) ASSERT_CLOSE(mean[i], K(mean)(SMOOTHED(&tape, 0), i), 4);
    num Ps[4];
    ASSERT_OK(K(covariance)(SMOOTHED(&tape, 0), Ps));
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(P[k], Ps[k], 1);
}

static void a_history_records_one_filter_at_a_time(void)
{
    ASSERT_OK(K(update)(&track, &radar, radar_z[5]));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&twin, &tape.attached));
    ASSERT_OK(K(predict)(&track, &motion, control));
    TEST_ASSERT_EQUAL_UINT(2, K(history_steps)(&tape));
    ASSERT_OK(K(detach)(&tape.attached));
    ASSERT_OK(K(attach)(&twin, &tape.attached));
    ASSERT_OK(K(update)(&track, &radar, radar_z[5]));
    ASSERT_OK(K(predict)(&track, &motion, control));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    run(&twin);
    ASSERT_OK(K(predict)(&track, &motion, control));
    TEST_ASSERT_EQUAL_UINT(STEPS, K(history_steps)(&tape));
    ASSERT_OK(K(smooth)(&tape));
    assert_means(0);
    assert_covariances(0);
}

static void a_filter_goes_on_without_its_history(void)
{
    run(&track);
    ASSERT_OK(K(detach)(&tape.attached));
    TEST_ASSERT_EQUAL_UINT(0, K(history_steps)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth)(&tape));
    watch_nothing();
    WATCH(tape), WATCH(tape_memory);
    ASSERT_OK_UNCHANGED(K(step)(&track, &motion, control, &radar, radar_z[0]));
    ASSERT_OK_UNCHANGED(K(detach)(&tape.attached));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, K(detach)(NULL));
    ASSERT_OK(K(detach)(&unused.attached));
}

static void what_was_smoothed_stays_when_it_is_detached(void)
{
    run(&track);
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_OK(K(detach)(&tape.attached));
    assert_means(0);
    assert_covariances(0);
    ASSERT_OK(K(attach)(&twin, &tape.attached));
}

static void a_full_history_is_detached_too(void)
{
    for (int k = 0; k < 2 * STEPS; k++) ASSERT_OK(K(step)(&track, &motion, NULL, &radar, z_zero));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, K(smooth)(&tape));
    ASSERT_OK(K(detach)(&tape.attached));
    ASSERT_OK(K(attach)(&twin, &tape.attached));
    run(&twin);
    ASSERT_OK(K(smooth)(&tape));
    assert_means(0);
}

/* A history that has gone out of scope is memory of someone else's.  So these leave it alone. */
static void a_history_that_may_be_gone_is_not_looked_at(void)
{
    HISTORY(other, 2, 1, 2, 0);
    watch_nothing();
    WATCH(tape), WATCH(tape_memory);
    ASSERT_OK_UNCHANGED(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK_UNCHANGED(K(attach)(&track, &other.attached));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK_UNCHANGED(K(forecast)(&twin, &motion, NULL, 1, &track));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK_UNCHANGED(K(filter_copy)(&track, &twin));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK_UNCHANGED(K(filter_assign)(&track, 2, track_memory, COUNT(track_memory)));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK_UNCHANGED(K(predict)(&track, &motion, NULL));
}

/* The same of a filter: of it a history that has it knows no more than where it was. */
static void a_filter_that_may_be_gone_is_not_looked_at(void)
{
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(tape);
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&twin, &tape.attached));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&twin, &tape.attached));
    memset(&track, 0xa5, sizeof track);
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&twin, &tape.attached));
    watch_nothing();
    WATCH(track), WATCH(track_memory);
    watched_store();
    ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(K(attach)(&twin, &tape.attached));
    run(&twin);
    ASSERT_OK(K(smooth)(&tape));
    watched_assert_unchanged(__LINE__);
    ASSERT_OK(K(filter_assign)(&track, 2, track_memory, COUNT(track_memory)));
}

/* A state that turns and drifts, one combination of it without noise: the sigma of what is past falls by 3 at each step
   back, below the rounding of the mean. */
static void sigmas_below_rounding_are_an_event(void)
{
    enum { LONG = 64 };
    static const num a[] = {-1, -1, 0, -1}, q[] = {0, 0, 0, N(0.000244140625)}, h[] = {-2, 1}, none[] = {0};
    static const num x[] = {-2, 0}, P[] = {0, 0, 0, 1024}, r[] = {1};
    PROCESS(turn, 2, 0);
    SENSOR(exact, 2, 1);
    SENSOR(noisy, 2, 1);
    FILTER(f, 2);
    HISTORY(past, 2, 1, LONG, 0);
    ASSERT_OK(K(process_init)(&turn, a, NULL, q));
    ASSERT_OK(K(sensor_init)(&exact, h, none));
    ASSERT_OK(K(sensor_init)(&noisy, h, r));
    for (int is_exact = 0; is_exact < 2; is_exact++) {
        num truth[] = {N(-2.3), N(31.7)};
        ASSERT_OK(K(filter_init)(&f, x, P));
        ASSERT_OK(K(attach)(&f, &past.attached));
        for (int t = 1; t < LONG; t++) {
            truth[0] = -truth[0] - truth[1];
            truth[1] = N(0.015625) * (num)(t % 5 - 2) - truth[1];
            const num z = truth[1] - 2 * truth[0];
            ASSERT_OK(K(predict)(&f, &turn, NULL));
            ASSERT_OK(K(update)(&f, is_exact ? &exact : &noisy, &z));
        }
        TEST_ASSERT_EQUAL_HEX(0, K(events)(&f));
        ASSERT_OK(K(smooth)(&past));
        TEST_ASSERT_EQUAL_HEX(is_exact ? KQ_EVENT_PRECISION : 0, K(events)(SMOOTHED(&past, 0)));
    }
}

/* A tape and a filter that are both gone when their call returns */
static void on_the_stack(K(history) * h, K(filter) * f)
{
    num memory[HISTORY_LEN(2, MOST, STEPS, 0)], state[FILTER_LEN(2)];
    K(history) own_tape;
    K(filter) own;
    ASSERT_OK(K(history_assign)(&own_tape, 2, memory, COUNT(memory)));
    ASSERT_OK(K(filter_assign)(&own, 2, state, COUNT(state)));
    ASSERT_OK(K(filter_init)(&own, x0, P0));
    if (!h) h = &own_tape;
    if (!f) f = &own;
    ASSERT_OK(K(attach)(f, &h->attached));
    ASSERT_OK(K(predict)(f, &motion, NULL));
    memset(memory, 0, sizeof memory);
}

static void tapes_and_filters_may_be_gone(void)
{
    on_the_stack(NULL, &track);
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    on_the_stack(NULL, &track);
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK(K(detach)(&tape.attached));
    on_the_stack(&tape, NULL);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RECORDING, K(attach)(&track, &tape.attached));
    ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(K(attach)(&track, &tape.attached));
}

/* The struct alone is no filter: its copy does not record, and says so. */
static void an_assigned_copy_does_not_record(void)
{
    K(filter) copied = track;
    watch_nothing();
    WATCH(tape), WATCH(tape_memory);
    ASSERT_OK_UNCHANGED(K(predict)(&copied, &motion, NULL));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, K(events)(&copied));
    for (int way = 0; way < 2; way++) {
        copied = track;
        if (way == 0) ASSERT_OK_UNCHANGED(K(step)(&copied, &motion, NULL, &radar, radar_z[0]));
        if (way == 1) ASSERT_OK_UNCHANGED(K(update)(&copied, &radar, radar_z[0]));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, K(events)(&copied));
        K(events_clear)(&copied);
        ASSERT_OK_UNCHANGED(K(step)(&copied, &motion, NULL, &radar, radar_z[0]));
        TEST_ASSERT_EQUAL_HEX(0, K(events)(&copied));
    }
}


static void a_filter_has_one_history_at_a_time(void)
{
    HISTORY(other, 2, 1, 2, 0);
    ASSERT_OK(K(attach)(&track, &other.attached));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    watch_nothing();
    WATCH(other), WATCH(other_memory);
    watched_store();
    run(&track);
    ASSERT_OK(K(smooth)(&tape));
    assert_means(0);
    TEST_ASSERT_EQUAL_UINT(1, K(history_steps)(&other));
    watched_assert_unchanged(__LINE__);
}

static void init_of_the_filter_detaches_its_history(void)
{
    ASSERT_OK(K(update)(&track, &radar, radar_z[0]));
    ASSERT_OK(K(predict)(&track, &motion, control));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    const size_t steps = K(history_steps)(&tape);
    for (int k = 0; k < 2 * STEPS; k++) ASSERT_OK(K(predict)(&track, &motion, control));
    TEST_ASSERT_EQUAL_UINT(steps, K(history_steps)(&tape));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
}

/* ------------------------------------------------------------------------- full, empty */

static void fill(K(history) * h, K(filter) * f, int steps)
{
    ASSERT_OK(K(filter_init)(f, x0, P0));
    if (h) ASSERT_OK(K(attach)(f, &h->attached));
    for (int t = 0; t < steps; t++) {
        if (t > 0) ASSERT_OK(K(predict)(f, &motion, control + t % STEPS));
        ASSERT_OK(K(update)(f, &radar, radar_z[t % STEPS]));
        ASSERT_OK(K(update)(f, &compass, compass_z + t % 2));
    }
}

static void the_memory_is_enough_for_its_steps(void)
{
    fill(&tape, &track, STEPS);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    ASSERT_OK(K(smooth)(&tape));
    TEST_ASSERT_EQUAL_UINT(STEPS, K(history_steps)(&tape));
}

/* Another process than in the run before is no change of process. */
static void the_memory_is_enough_for_another_run(void)
{
    PROCESS(copy, 2, 1);
    ASSERT_OK(K(process_init)(&copy, A, B, Q));
    for (int t = 0; t < STEPS - 1; t++) ASSERT_OK(K(predict)(&track, &copy, control + t));
    fill(&tape, &track, STEPS);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    ASSERT_OK(K(smooth)(&tape));
}

static void the_memory_is_enough_for_one_step(void)
{
    HISTORY(least, 2, MOST, 1, 0);
    reading now, end;
    fill(&least, &track, 1);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    read_filter(&end, &track, 2);
    ASSERT_OK(K(smooth)(&least));
    read_smoothed(&now, &least, 0, 2);
    TEST_ASSERT_EQUAL_MEMORY(&end, &now, offsetof(reading, nis));
}

static void assert_refused_as_full(void)
{
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, K(smooth)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, K(smooth_states)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, K(smooth_step)(&tape, NULL, NULL));
    ASSERT_NAN(K(mean)(SMOOTHED(&tape, 0), 0));
    ASSERT_NAN(K(sigma)(SMOOTHED(&tape, 0), 0));
}

static void a_full_history_is_an_event_and_the_filter_goes_on(void)
{
    for (int more = 1; more < 2 * STEPS; more++) {
        reading a, b;
        fill(&tape, &track, STEPS + more);
        fill(NULL, &twin, STEPS + more);
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, K(events)(&track));
        assert_refused_as_full();
        K(events_clear)(&track);
        read_filter(&a, &track, 2);
        read_filter(&b, &twin, 2);
        ASSERT_SAME_BITS(b, a);
    }
}

static void a_full_history_may_be_used_again(void)
{
    fill(&tape, &track, STEPS + 1);
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    run(&track);
    ASSERT_OK(K(smooth)(&tape));
    assert_means(0);
    assert_covariances(0);
}

/* One measurement more than there is room for, in the last step. */
static void a_measurement_too_many_fills_the_history(void)
{
    fill(&tape, &track, STEPS);
    for (int k = 0; k < 2; k++) ASSERT_OK(K(update)(&track, &radar, radar_z[0]));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, K(events)(&track));
    assert_refused_as_full();
}

/* `more` records beyond the steps that there is memory for, each a predict or a measurement */
static void go_beyond(K(filter) * f, int more, int pattern)
{
    for (int k = 0; k < more; k++) {
        if (pattern >> k & 1) ASSERT_OK(K(predict)(f, &motion, control));
        else ASSERT_OK(K(update)(f, &compass, compass_z));
    }
}

/* There may be room for a few records more; then they count. */
static void a_history_is_full_or_right(void)
{
    HISTORY(roomy, 2, MOST, STEPS + 4, 0);
    for (int pattern = 0; pattern < 8; pattern++) {
        for (int more = 0; more <= 3; more++) {
            fill(&tape, &track, STEPS);
            fill(&roomy, &twin, STEPS);
            go_beyond(&track, more, pattern);
            go_beyond(&twin, more, pattern);
            if (K(events)(&track) & KQ_EVENT_HISTORY_FULL) {
                assert_refused_as_full();
                continue;
            }
            ASSERT_OK(K(smooth)(&tape));
            ASSERT_OK(K(smooth)(&roomy));
            TEST_ASSERT_EQUAL_UINT(K(history_steps)(&roomy), K(history_steps)(&tape));
            for (size_t t = 0; t < K(history_steps)(&tape); t++) {
                reading a, b;
                read_smoothed(&a, &roomy, t, 2);
                read_smoothed(&b, &tape, t, 2);
                ASSERT_SAME_BITS(a, b);
            }
        }
    }
}

static void smooth_refuses_an_empty_or_smoothed_history(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, K(smooth)(NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(smooth_states)(NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(smooth_step)(NULL, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth)(&unused));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth_states)(&unused));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth_step)(&unused, NULL, NULL));
    run(&track);
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth_states)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth_step)(&tape, NULL, NULL));
    assert_means(0);
}

static void smooth_refuses_a_history_whose_states_are_smoothed(void)
{
    run(&track);
    ASSERT_OK(K(smooth_states)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth_states)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth_step)(&tape, NULL, NULL));
    assert_means(0);
}

static void smooth_step_refuses_a_process_that_does_not_fit(void)
{
    run(&track);
    ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(smooth_step)(&tape, &motion3, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(smooth_step)(&tape, &blank_process, NULL));
    for (int k = 1; k < STEPS; k++) ASSERT_OK(K(smooth_step)(&tape, &motion, NULL));
    assert_means(0);
    assert_covariances(0);
}

static void smoothed_results_refuse(void)
{
    num P[4] = {77, 77, 77, 77};
    WATCH(P);
    run(&track);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(SMOOTHED(&tape, 0), P));
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_REFUSED(KQ_ERR_NULL, K(smoothed)(NULL, 0, &view));
    ASSERT_REFUSED(KQ_ERR_NULL, K(covariance)(SMOOTHED(&tape, 0), NULL));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(smoothed)(&tape, STEPS, &view));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(smoothed)(&tape, SIZE_MAX, &view));
    watch_nothing();
}

/* What moves a filter refuses a view; what reads one takes it as the filter that was there. */
static void a_view_is_read_and_not_moved(void)
{
    num now[4], then[4], S[4], other[4];
    run(&track);
    ASSERT_OK(K(filter_copy)(&twin, &track));
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_OK(K(smoothed)(&tape, STEPS - 1, &view));
    ASSERT_OK(K(measurement)(&view, &radar, now, S));
    ASSERT_OK(K(measurement)(&twin, &radar, then, other));
    ASSERT_CLOSE(then[0], now[0], 8);
    ASSERT_CLOSE(other[0], S[0], 8);
    ASSERT_OK(K(innovation)(&view, &radar, radar_z[0], now));
    ASSERT_OK(K(gain)(&view, &radar, S));
    ASSERT_NAN(K(nis)(&view));
    ASSERT_NAN(K(log_likelihood)(&view));
    TEST_ASSERT_EQUAL_INT(-1, K(taken)(&view));
    WATCH(view), WATCH(tape_memory);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(predict)(&view, &motion, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update)(&view, &radar, radar_z[0]));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update_subset)(&view, &radar, radar_z[0], 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, update_jump(&view, &radar, radar_z[0], 3, 4));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update)(&view, of_innovations(&radar), radar_z[0]));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(step)(&view, &motion, NULL, &radar, radar_z[0]));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&view, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(filter_check)(&view));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(filter_init)(&view, x0, P0));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(filter_copy)(&view, &track));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(forecast)(&track, &motion, NULL, 1, &view));
    ASSERT_OK(K(filter_copy)(&twin, &view));
    for (int i = 0; i < 2; i++) TEST_ASSERT_TRUE(K(sigma)(&twin, i) == K(sigma)(&view, i));
    ASSERT_OK(K(filter_check)(&twin));
    TEST_ASSERT_TRUE(K(log_likelihood)(&twin) == 0);
    ASSERT_OK(K(predict)(&twin, &motion, NULL));
    ASSERT_OK(K(forecast)(&view, &motion, NULL, 1, &track));
    ASSERT_SAME_STATE(&twin, &track, 2);
}

static void a_view_of_means_has_no_covariance(void)
{
    num P[4];
    run(&track);
    ASSERT_OK(K(smooth_states)(&tape));
    ASSERT_OK(K(smoothed)(&tape, 0, &view));
    WATCH(view), WATCH(tape_memory);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(&view, P));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(measurement)(&view, &radar, P, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(filter_copy)(&twin, &view));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(forecast)(&view, &motion, NULL, 1, &twin));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(filter_init)(&view, x0, P0));
}

static void what_is_read_of_a_bad_step_or_state_is_no_number(void)
{
    static const int bad[] = {-1, 2, 16, 256, INT_MAX, INT_MIN};
    static const size_t beyond[] = {STEPS, STEPS + 1, SIZE_MAX};
    run(&track);
    ASSERT_OK(K(smooth)(&tape));
    for (int k = 0; k < COUNT(bad); k++) {
        ASSERT_NAN(K(mean)(SMOOTHED(&tape, 0), bad[k]));
        ASSERT_NAN(K(mean_low)(SMOOTHED(&tape, 0), bad[k]));
        ASSERT_NAN(K(sigma)(SMOOTHED(&tape, 0), bad[k]));
    }
    for (int k = 0; k < COUNT(beyond); k++) {
        ASSERT_NAN(K(mean)(SMOOTHED(&tape, beyond[k]), 0));
        ASSERT_NAN(K(mean_low)(SMOOTHED(&tape, beyond[k]), 0));
        ASSERT_NAN(K(sigma)(SMOOTHED(&tape, beyond[k]), 0));
    }
    ASSERT_NAN(K(mean)(SMOOTHED(NULL, 0), 0));
    ASSERT_NAN(K(mean_low)(SMOOTHED(NULL, 0), 0));
    ASSERT_NAN(K(sigma)(SMOOTHED(NULL, 0), 0));
    ASSERT_NAN(K(mean)(SMOOTHED(&unused, 0), 0));
    ASSERT_NAN(K(sigma)(SMOOTHED(&unused, 0), 0));
}

/* ------------------------------------------------------------------- models that change */

/* Every step by another A: 3 processes taking turns, and one process that is changed. */
static const num turns[3][4] = {{1, 0.5, -0.25, 0.75}, {0.5, 1, 0, 1}, {1, 0, 0.5, 0.25}};
PROCESS(turn0, 2, 0);
PROCESS(turn1, 2, 0);
PROCESS(turn2, 2, 0);
HISTORY(long_tape, 2, 2, STEPS, STEPS - 2);
static K(process) *const turn[] = {&turn0, &turn1, &turn2};

static void textbook_of_turns(void)
{
    textbook t;
    textbook_init(&t, 2, x0, P0);
    for (int step = 0; step < STEPS; step++) {
        textbook_update(&t, H, R, radar_z[step], 2);
        filtered[step] = t;
        textbook_predict(&t, turns[step % 3], NULL, NULL, 0, Q);
        if (step + 1 < STEPS) predicted[step + 1] = t;
    }
    smoothed[STEPS - 1] = filtered[STEPS - 1];
    for (int step = STEPS - 2; step >= 0; step--) {
        smoothed[step] = filtered[step];
        textbook_smooth(&smoothed[step], &predicted[step + 1], &smoothed[step + 1], turns[step % 3],
                        lag_one[step]);
    }
}

static void assert_smoothed(const K(history) * h)
{
    for (size_t t = 0; t < STEPS; t++) {
        num P[4];
        ASSERT_OK(K(covariance)(SMOOTHED(h, t), P));
        for (int k = 0; k < 4; k++) ASSERT_CLOSE(smoothed[t].P[k], P[k], 2);
        for (int i = 0; i < 2; i++) {
            ASSERT_CLOSE(smoothed[t].x[i], whole_smoothed_mean(h, t, i), 8);
        }
    }
}

static void processes_may_take_turns(void)
{
    textbook_of_turns();
    for (int k = 0; k < 3; k++) ASSERT_OK(K(process_init)(turn[k], turns[k], NULL, Q));
    for (int by_step = 0; by_step < 2; by_step++) {
        ASSERT_OK(K(filter_init)(&track, x0, P0));
        ASSERT_OK(K(attach)(&track, &long_tape.attached));
        ASSERT_OK(K(update)(&track, &radar, radar_z[0]));
        for (int t = 1; t < STEPS; t++) {
            ASSERT_OK(K(step)(&track, turn[(t - 1) % 3], NULL, &radar, radar_z[t]));
        }
        TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
        if (!by_step) ASSERT_OK(K(smooth)(&long_tape));
        for (int t = 0; t < STEPS && by_step; t++) {
            ASSERT_OK(K(smooth_step)(&long_tape, NULL, NULL));
        }
        assert_smoothed(&long_tape);
    }
}

/* The tape refers to the one process, which has changed since: the caller passes what it was. */
static void a_process_that_changed_may_be_given_back(void)
{
    textbook_of_turns();
    for (int k = 0; k < 3; k++) ASSERT_OK(K(process_init)(turn[k], turns[k], NULL, Q));
    ASSERT_OK(K(update)(&track, &radar, radar_z[0]));
    for (int t = 1; t < STEPS; t++) {
        ASSERT_OK(K(process_change_transition)(&motion, turns[(t - 1) % 3]));
        ASSERT_OK(K(step)(&track, &motion, NULL, &radar, radar_z[t]));
    }
    for (int t = STEPS - 1; t >= 0; t--) {
        ASSERT_OK(K(smooth_step)(&tape, t == STEPS - 1 ? NULL : turn[t % 3], NULL));
    }
    assert_smoothed(&tape);
}

/* A sensor may change at every step: the tape does not refer to it. */
static void a_sensor_may_change_after_it_was_used(void)
{
    static const num other[] = {0.25, 3, -1, 0.5};
    run(&track);
    ASSERT_OK(K(sensor_change_measurement)(&radar, other));
    ASSERT_OK(K(sensor_init)(&compass, other, P0));
    ASSERT_OK(K(smooth)(&tape));
    assert_means(0);
    assert_covariances(0);
}

/* -------------------------------------------------------------------- singular models */

/* Without process noise and with A = I, every step is known as well as the last one. */
static void a_constant_is_the_same_at_every_step(void)
{
    static const num I[] = {1, 0, 0, 1}, none[4] = {0};
    num P[4], Pt[4];
    ASSERT_OK(K(process_init)(&motion, I, B, none));
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(update)(&track, &radar, radar_z[t]));
    }
    ASSERT_OK(K(covariance)(&track, P));
    ASSERT_OK(K(smooth)(&tape));
    for (size_t t = 0; t < STEPS; t++) {
        for (int i = 0; i < 2; i++) {
            ASSERT_CLOSE(whole_mean(&track, i), whole_smoothed_mean(&tape, t, i), 4);
        }
        ASSERT_OK(K(covariance)(SMOOTHED(&tape, t), Pt));
        for (int k = 0; k < 4; k++) ASSERT_CLOSE(P[k], Pt[k], 2);
    }
}

/* x' = x / 2 + w measured without noise, and its delay: all is known, but where the
   measurement is missing; there x is (x_before + x_after) / 2 / (1 + 1/4), Var q / (1 + 1/4). */
static void a_delay_line_measured_without_noise(void)
{
    static const num delay[] = {0.5, 0, 1, 0}, q[] = {1, 0, 0, 0}, h[] = {1, 0}, none[] = {0};
    static const num z[STEPS] = {1, 3, 100, -2, 0.5, 4};
    const size_t gap = 2;
    const double between = 0.5 * (3 - 2) / 1.25;
    ASSERT_OK(K(process_init)(&motion, delay, B, q));
    ASSERT_OK(K(sensor_init)(&compass, h, none));
    for (size_t t = 0; t < STEPS; t++) {
        if (t > 0) ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(update_subset)(&track, &compass, &z[t], t != gap));
    }
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    ASSERT_OK(K(smooth)(&tape));
    for (size_t t = 0; t < STEPS; t++) {
        const double now = t == gap ? between : (double)z[t];
        ASSERT_CLOSE(now, whole_smoothed_mean(&tape, t, 0), 8);
        ASSERT_CLOSE(t == gap ? sqrt(1 / 1.25) : 0, K(sigma)(SMOOTHED(&tape, t), 0), 1);
        if (t == 0) continue;
        const double before = t - 1 == gap ? between : (double)z[t - 1];
        ASSERT_CLOSE(before, whole_smoothed_mean(&tape, t, 1), 8);
        ASSERT_CLOSE(t - 1 == gap ? sqrt(1 / 1.25) : 0, K(sigma)(SMOOTHED(&tape, t), 1), 1);
    }
}

/* A state known exactly from the start and without noise stays so. */
static void a_known_constant_stays_known(void)
{
    static const num a[] = {1, 0.5, 0, 1}, q[] = {1, 0, 0, 0}, P[] = {1, 0, 0, 0};
    ASSERT_OK(K(process_init)(&motion, a, B, q));
    ASSERT_OK(K(filter_init)(&track, x0, P));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(update)(&track, &radar, radar_z[t]));
    }
    ASSERT_OK(K(smooth)(&tape));
    for (size_t t = 0; t < STEPS; t++) {
        ASSERT_CLOSE(-2, whole_smoothed_mean(&tape, t, 1), 2);
        ASSERT_WITHIN(8 * TINY_SIGMA, 0, K(sigma)(SMOOTHED(&tape, t), 1));
    }
}

/* --------------------------------------------------------------------------- all sizes */

static num room[GUARDED(HISTORY_LEN(16, 16, 2, 0))];
static num big_A[256], big_P[256], big_x[16];
static num big_process[2][KQ_PROCESS_LEN(16)], big_sensor[KQ_SENSOR_LEN(16)];
static num big_filter[FILTER_LEN(16)], big_output[GUARDED(256)];

/* Three steps, one change of process, one measurement a step, and all that can be read. */
static void record(K(history) * h, int n)
{
    K(process) p[2];
    K(sensor) s;
    K(filter) f;
    for (int k = 0; k < 2; k++) {
        ASSERT_OK(K(process_assign)(&p[k], n, 0, big_process[k], COUNT(big_process[k])));
        ASSERT_OK(K(process_init)(&p[k], big_A, NULL, big_P));
    }
    ASSERT_OK(K(sensor_assign)(&s, n, 1, big_sensor, COUNT(big_sensor)));
    ASSERT_OK(K(sensor_init)(&s, big_A, big_P));
    ASSERT_OK(K(filter_assign)(&f, n, big_filter, COUNT(big_filter)));
    ASSERT_OK(K(filter_init)(&f, big_x, big_P));
    ASSERT_OK(K(attach)(&f, &h->attached));
    ASSERT_OK(K(update)(&f, &s, big_x));
    ASSERT_OK(K(step)(&f, &p[0], NULL, &s, big_x));
    ASSERT_OK(K(step)(&f, &p[1], NULL, &s, big_x));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&f));
    num *out = guard(big_output, COUNT(big_output));
    for (int t = 0; t < 3; t++) {
        const K(smooth_extras) extras = {t == 1 ? out : NULL, NULL, t == 2 ? out : NULL};
        ASSERT_OK(K(smooth_step)(h, NULL, &extras));
        assert_guards(big_output, t ? (size_t)(n * n) : 0, COUNT(big_output));
    }
    guard(big_output, COUNT(big_output));
    ASSERT_OK(K(covariance)(SMOOTHED(h, 0), out));
    assert_guards(big_output, (size_t)(n * n), COUNT(big_output));
}

static void no_size_writes_outside_its_memory(void)
{
    for (int n = 1; n <= 16; n++) {
        const size_t length = (size_t)HISTORY_LEN((size_t)n, 1, 3, 1);
        K(history) h;
        put_identity(big_A, n, 1);
        put_identity(big_P, n, 1);
        ASSERT_OK(K(history_assign)(&h, n, guard(room, COUNT(room)), length));
        assert_guards(room, 0, COUNT(room));
        record(&h, n);
        assert_guards(room, length, COUNT(room));
    }
}

/* 16 independent scalars x' = a x + w seen through a rotation, all measured, two steps. */
static void sixteen_states_work(void)
{
    static double a[16], q[16], p[16], p_then[16], p_between[16], now[16];
    K(process) move;
    K(sensor) wide;
    K(filter) many;
    K(history) h;
    for (int i = 0; i < 16; i++) {
        a[i] = 0.25 * (i % 5) - 0.5, q[i] = 0.5 + 0.125 * i, p[i] = 1 + 0.5 * i;
        p_then[i] = 2 * p[i] / (2 + p[i]);
        p_between[i] = a[i] * a[i] * p_then[i] + q[i];
    }
    ASSERT_OK(K(history_assign)(&h, 16, guard(room, COUNT(room)), HISTORY_LEN(16, 16, 2, 0)));
    ASSERT_OK(K(filter_assign)(&many, 16, big_filter, COUNT(big_filter)));
    memset(big_x, 0, sizeof big_x);
    put_rotated(big_P, p);
    ASSERT_OK(K(filter_init)(&many, big_x, big_P));
    put_rotated(big_A, a);
    put_rotated(big_P, q);
    ASSERT_OK(K(process_assign)(&move, 16, 0, big_process[0], COUNT(big_process[0])));
    ASSERT_OK(K(process_init)(&move, big_A, NULL, big_P));
    for (int k = 0; k < 256; k++) big_output[k] = hadamard(k / 16, k % 16);
    put_identity(big_P, 16, 2);
    ASSERT_OK(K(sensor_assign)(&wide, 16, 16, big_sensor, COUNT(big_sensor)));
    ASSERT_OK(K(sensor_init)(&wide, big_output, big_P));
    ASSERT_OK(K(attach)(&many, &h.attached));
    ASSERT_OK(K(update)(&many, &wide, big_x));
    for (int i = 0; i < 16; i++) big_x[i] = N(i - 7.5);
    ASSERT_OK(K(step)(&many, &move, NULL, &wide, big_x));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&many));
    ASSERT_OK(K(smooth)(&h));
    assert_guards(room, HISTORY_LEN(16, 16, 2, 0), COUNT(room));
    for (int i = 0; i < 16; i++) {
        const double G = p_then[i] * a[i] / p_between[i];
        const double K1 = p_between[i] / (2 + p_between[i]);
        now[i] = G * K1 * (i - 7.5);
        p[i] = p_then[i] - G * G * K1 * p_between[i];
    }
    put_rotated(big_P, p);
    ASSERT_OK(K(covariance)(SMOOTHED(&h, 0), big_A));
    for (int k = 0; k < 256; k++) ASSERT_CLOSE(big_P[k], big_A[k], 4);
    for (int i = 0; i < 16; i++) ASSERT_CLOSE(rotated(now, i), K(mean)(SMOOTHED(&h, 0), i), 8);
}

/* ------------------------------------------------------------------------------------- */

static void run_smooth(void)
{
    RUN_TEST(smoothing_is_that_of_the_textbook);
    RUN_TEST(the_mean_is_rounded_once);
    RUN_TEST(the_last_step_is_the_filter_s);
    RUN_TEST(states_only_gives_the_means);
    RUN_TEST(a_history_of_one_step_is_the_filter);
    RUN_TEST(the_filter_is_detached_and_goes_on);
    RUN_TEST(recording_changes_nothing_of_the_filter);
    RUN_TEST(one_step_a_call_can_be_read_on_the_way);
    RUN_TEST(the_first_step_detaches_the_filter);
    RUN_TEST(steps_may_name_their_process);
    RUN_TEST(a_step_gives_extras);
    RUN_TEST(each_extra_comes_alone);
    RUN_TEST(the_smoothed_measurement_noise_is_the_residual);
    RUN_TEST(a_measurement_that_was_not_taken_has_no_noise);
    RUN_TEST(the_noise_of_a_sharp_or_dull_measurement_is_accurate);
    RUN_TEST(measurement_noise_refuses);
}

static void run_history(void)
{
    RUN_TEST(assign_does_what_the_macro_does);
    RUN_TEST(assign_refuses_null);
    RUN_TEST(assign_refuses_sizes_out_of_range);
    RUN_TEST(assign_refuses_short_memory);
    RUN_TEST(attach_refuses);
    RUN_TEST(steps_are_the_predicts_and_one);
    RUN_TEST(attach_empties_the_history);
    RUN_TEST(a_history_assigned_anew_forgets_its_filter);
    RUN_TEST(a_history_assigned_anew_is_not_recorded_on);
    RUN_TEST(attach_begins_in_the_middle_of_a_run);
    RUN_TEST(a_history_records_one_filter_at_a_time);
    RUN_TEST(a_filter_goes_on_without_its_history);
    RUN_TEST(what_was_smoothed_stays_when_it_is_detached);
    RUN_TEST(a_full_history_is_detached_too);
    RUN_TEST(a_history_that_may_be_gone_is_not_looked_at);
    RUN_TEST(a_filter_that_may_be_gone_is_not_looked_at);
    RUN_TEST(sigmas_below_rounding_are_an_event);
    RUN_TEST(tapes_and_filters_may_be_gone);
    RUN_TEST(an_assigned_copy_does_not_record);
    RUN_TEST(a_filter_has_one_history_at_a_time);
    RUN_TEST(init_of_the_filter_detaches_its_history);
    RUN_TEST(the_memory_is_enough_for_its_steps);
    RUN_TEST(the_memory_is_enough_for_another_run);
    RUN_TEST(the_memory_is_enough_for_one_step);
    RUN_TEST(a_full_history_is_an_event_and_the_filter_goes_on);
    RUN_TEST(a_full_history_may_be_used_again);
    RUN_TEST(a_measurement_too_many_fills_the_history);
    RUN_TEST(a_history_is_full_or_right);
}

static void run_refusals(void)
{
    RUN_TEST(smooth_refuses_an_empty_or_smoothed_history);
    RUN_TEST(smooth_refuses_a_history_whose_states_are_smoothed);
    RUN_TEST(smooth_step_refuses_a_process_that_does_not_fit);
    RUN_TEST(smoothed_results_refuse);
    RUN_TEST(a_view_is_read_and_not_moved);
    RUN_TEST(a_view_of_means_has_no_covariance);
    RUN_TEST(what_is_read_of_a_bad_step_or_state_is_no_number);
}

SUITE(smoother, set_up)
{
    run_smooth();
    run_history();
    run_refusals();
    RUN_TEST(processes_may_take_turns);
    RUN_TEST(a_process_that_changed_may_be_given_back);
    RUN_TEST(a_sensor_may_change_after_it_was_used);
    RUN_TEST(a_constant_is_the_same_at_every_step);
    RUN_TEST(a_delay_line_measured_without_noise);
    RUN_TEST(a_known_constant_stays_known);
    RUN_TEST(no_size_writes_outside_its_memory);
    RUN_TEST(sixteen_states_work);
}
