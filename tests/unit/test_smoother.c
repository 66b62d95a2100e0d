/* The history and the smoother, in all arithmetics. */
#include "models.h"
#include "textbook.h"
#include "unchanged.h"

#ifdef KQ_TEST_Q31
#define ROUNDING_OF_RUNS 0x1p-25
#define NOISE_FLOOR 1 /* means are rounded to parts of a sigma */
#else
#define ROUNDING_OF_RUNS TOLERANCE
#define NOISE_FLOOR 0
#endif

#define STEPS 6
#define MOST 3 /* scalar measurements of one step */

static process_model motion, other_motion;
static sensor_model radar, compass;
static prior_model prior;
S_FILTER(track, 2);
S_FILTER(twin, 2);
static S(filter) view;
S_HISTORY(tape, 2, MOST, STEPS, 0);

S_HISTORY(unused, 2, 1, 2, 0); /* never attached */

static const num range[] = {100, 100, 100}, drive_range[] = {10}, measured_range[] = {200, 200};
static const num A[] = {1, 0.5, -0.25, 0.75}, B[] = {0.125, 0.5};
static const num Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const num direction[] = {-1, 0.25}, variance[] = {0.125};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static const num identity[] = {1, 0, 0, 1}, zero[4];

static textbook filtered[STEPS], predicted[STEPS], smoothed[STEPS];
static double lag_one[STEPS][4];

static void put_motion(process_model *m, const num *a, const num *q)
{
    put_process(m, 2, 1, range, drive_range, a, B, q);
}

static kq_status begin(S(filter) *f, S(history) *h)
{
    ASSERT_OK(init_filter(f, &prior));
    return S(attach)(f, &h->attached);
}

static void set_up(void)
{
    put_motion(&motion, A, Q);
    put_sensor(&radar, 2, 2, range, measured_range, H, R);
    put_sensor(&compass, 2, 1, range, measured_range, direction, variance);
    put_prior(&prior, 2, range, x0, P0);
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(tape), WATCH(tape_memory), WATCH(motion.process);
    WATCH(unused), WATCH(unused_memory);
}

static kq_status take(S(filter) *f, sensor_model *s, const num *z)
{
    return S(update)(f, &s->sensor, measured(&s->sensor, z));
}

static kq_status take_part(S(filter) *f, sensor_model *s, const num *z, uint32_t present)
{
    return S(update_subset)(f, &s->sensor, measured(&s->sensor, z), present);
}

static kq_status go(S(filter) *f, process_model *p, const num *u)
{
    return S(predict)(f, &p->process, driven(&p->process, u, 1));
}

static kq_status step(S(filter) *f, process_model *p, const num *u, const num *z)
{
    return S(step)(f, &p->process, driven(&p->process, u, 1), &radar.sensor, measured(&radar.sensor, z));
}

/* Smoothed numbers beside the textbook's */
#define ASSERT_SMOOTH(expected, actual, size) ASSERT_WITHIN(ROUNDING_OF_RUNS * (size), expected, actual)

/* ---------------------------------------------------------------------------- scenario */

/* Step 0: radar.  1: nothing.  2: second component of the radar.  3: radar and compass.
   4: compass twice.  5: radar. */
static const num radar_z[STEPS][2] = {{3, 1}, {0, 0}, {0, -1}, {0.5, 0.25}, {0, 0}, {-1, 2}};
static const num compass_z[] = {-0.5, 1.25};
static const num z_zero[2];
static const num control[STEPS] = {1, -2, 0.5, 4, 0, 0};

static void measure(S(filter) * f, textbook *t, int step)
{
    if (step == 0 || step == 3 || step == 5) {
        ASSERT_OK(take(f, &radar, radar_z[step]));
        textbook_update(t, H, R, radar_z[step], 2);
    }
    if (step == 2) {
        ASSERT_OK(take_part(f, &radar, radar_z[step], 2));
        textbook_update(t, H + 2, R + 3, radar_z[step] + 1, 1);
    }
    for (int k = 0; k < (step == 4 ? 2 : step == 3); k++) {
        ASSERT_OK(take(f, &compass, compass_z + k));
        textbook_update(t, direction, variance, compass_z + k, 1);
    }
}

/* The run, by the library and by the textbook. */
static void run(S(filter) * f)
{
    textbook t;
    textbook_init(&t, 2, x0, P0);
    for (int step = 0; step < STEPS; step++) {
        measure(f, &t, step);
        filtered[step] = t;
        if (step + 1 == STEPS) break;
        ASSERT_OK(go(f, &motion, control + step));
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
            ASSERT_SMOOTH(smoothed[t].x[i], shown_mean(S_SMOOTHED(&tape, t), &prior, i), 8);
        }
    }
}

static void assert_covariances(size_t from)
{
    reading now;
    for (size_t t = from; t < STEPS; t++) {
        read_smoothed_at(&now, &tape, t, &prior, 2);
        for (int k = 0; k < 4; k++) ASSERT_SMOOTH(smoothed[t].P[k], now.P[k], 2);
        for (int i = 0; i < 2; i++) {
            ASSERT_WITHIN(ROUNDING_OF_RUNS * 2 + sigma_step(range[i]), sqrt(smoothed[t].P[3 * i]), now.sigma[i]);
        }
        TEST_ASSERT_EQUAL_MEMORY(&now.P[1], &now.P[2], sizeof(num));
    }
}

/* ------------------------------------------------------------------------------ smooth */

TEST(smoothing_is_that_of_the_textbook)
{
    run(&track);
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    ASSERT_OK(S(smooth)(&tape));
    TEST_ASSERT_EQUAL_UINT(STEPS, S(history_steps)(&tape));
    assert_means(0);
    assert_covariances(0);
}

TEST(the_last_step_is_the_filter_s)
{
    reading last, end;
    run(&track);
    ASSERT_OK(S(smooth)(&tape));
    read_now(&end, &track, 2);
    read_smoothed_at(&last, &tape, STEPS - 1, &prior, 2);
    TEST_ASSERT_EQUAL_MEMORY(&end, &last, offsetof(reading, nis));
}

TEST(states_only_gives_the_means)
{
    entry P[4];
    run(&track);
    ASSERT_OK(S(smooth_states)(&tape));
    assert_means(0);
    for (size_t t = 0; t < STEPS; t++) {
        ASSERT_NOTHING(S(sigma)(S_SMOOTHED(&tape, t), 0));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, S(covariance)(S_SMOOTHED(&tape, t), P));
    }
}

TEST(a_history_of_one_step_is_the_filter)
{
    textbook t;
    reading now, end;
    textbook_init(&t, 2, x0, P0);
    measure(&track, &t, 3);
    read_now(&end, &track, 2);
    ASSERT_OK(S(smooth)(&tape));
    TEST_ASSERT_EQUAL_UINT(1, S(history_steps)(&tape));
    read_smoothed_at(&now, &tape, 0, &prior, 2);
    TEST_ASSERT_EQUAL_MEMORY(&end, &now, offsetof(reading, nis));
}

TEST(the_filter_is_detached_and_goes_on)
{
    run(&track);
    run(&twin);
    ASSERT_OK(S(smooth)(&tape));
    ASSERT_SAME(&twin, &track, 2);
    watch_nothing();
    WATCH(tape), WATCH(tape_memory);
    ASSERT_OK_UNCHANGED(step(&track, &motion, NULL, radar_z[0]));
    ASSERT_OK(step(&twin, &motion, NULL, radar_z[0]));
    ASSERT_SAME(&twin, &track, 2);
    TEST_ASSERT_EQUAL_UINT(STEPS, S(history_steps)(&tape));
    assert_means(0);
    assert_covariances(0);
}

/* ------------------------------------------------------------------------- smooth_step */

static void assert_not_smoothed_below(size_t end)
{
    entry P[4];
    for (size_t t = 0; t < end; t++) {
        ASSERT_NOTHING(S(mean)(S_SMOOTHED(&tape, t), 0));
        ASSERT_NOTHING(S(mean_low)(S_SMOOTHED(&tape, t), 0));
        ASSERT_NOTHING(S(sigma)(S_SMOOTHED(&tape, t), 0));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, S(covariance)(S_SMOOTHED(&tape, t), P));
    }
}

TEST(one_step_a_call_can_be_read_on_the_way)
{
    run(&track);
    assert_not_smoothed_below(STEPS);
    for (size_t t = STEPS; t-- > 0;) {
        ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
        TEST_ASSERT_EQUAL_UINT(STEPS, S(history_steps)(&tape));
        assert_means(t);
        assert_covariances(t);
        assert_not_smoothed_below(t);
    }
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(smooth_step)(&tape, NULL, NULL));
    assert_means(0);
    assert_covariances(0);
}

TEST(the_first_step_detaches_the_filter)
{
    run(&track);
    ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
    ASSERT_OK(go(&track, &motion, control));
    ASSERT_OK(take(&track, &radar, radar_z[0]));
    for (int k = 1; k < STEPS; k++) ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
    assert_means(0);
    assert_covariances(0);
}

TEST(steps_may_name_their_process)
{
    put_motion(&other_motion, A, Q);
    run(&track);
    for (int k = 0; k < STEPS; k++) ASSERT_OK(S(smooth_step)(&tape, &other_motion.process, NULL));
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
        ASSERT_SMOOTH(next->x[i] - moved, o->noise_mean[i], 8);
        for (int j = 0; j < 2; j++) {
            const double expected =
                next->P[2 * i + j] - AL[2 * i + j] - AL[2 * j + i] + APA[2 * i + j];
            ASSERT_SMOOTH(expected, o->noise_covariance[2 * i + j], 4);
        }
    }
}

TEST(a_step_gives_extras)
{
    outputs o;
    run(&track);
    for (int t = STEPS - 1; t >= 0; t--) {
        clear_outputs(&o);
        ASSERT_OK(step_back(&tape, NULL, &prior, o.lag_one, o.noise_mean, o.noise_covariance));
        if (t == STEPS - 1) continue;
        for (int k = 0; k < 4; k++) ASSERT_SMOOTH(lag_one[t][k], o.lag_one[k], 2);
        assert_process_noise(&o, t);
    }
    assert_means(0);
    assert_covariances(0);
}

typedef struct {
    entry lag_one[4], noise_mean[2], noise_covariance[4];
} extra_outputs;

/* Which of the extras are wanted (a bit each) makes no difference to those that are; the last step, which has none,
   writes none. */
TEST(each_extra_comes_alone)
{
    static extra_outputs all[STEPS], one, untouched;
    const S(smooth_extras) none = {NULL, NULL, NULL};
    memset(&untouched, 7, sizeof untouched);
    for (unsigned wanted = 8; wanted-- > 0;) {
        ASSERT_OK(begin(&track, &tape));
        run(&track);
        for (int t = STEPS - 1; t >= 0; t--) {
            extra_outputs *o = wanted == 7 ? &all[t] : &one;
            S(smooth_extras) extras = none;
            *o = untouched;
            if (wanted & 1) extras.lag_one = o->lag_one;
            if (wanted & 2) extras.noise_mean = o->noise_mean;
            if (wanted & 4) extras.noise_covariance = o->noise_covariance;
            ASSERT_OK(S(smooth_step)(&tape, NULL, &extras));
            if (t == STEPS - 1) ASSERT_SAME_BITS(untouched, *o);
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
    num mean, spread;
    const textbook *s = &smoothed[t];
    const double v = z - h0 * s->x[0] - h1 * s->x[1];
    const double hPh = h0 * h0 * s->P[0] + 2 * h0 * h1 * s->P[1] + h1 * h1 * s->P[3];
    ASSERT_OK_UNCHANGED(read_noise(&tape, k, &mean, &spread));
    ASSERT_SMOOTH(v / sqrt(r), mean, 32);
    ASSERT_SMOOTH(hPh / r, spread, 8);
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
    static const int32_t beyond[] = {0, 1, 255, 256, 65535, 65536};
    static const int no_count[] = {-1, INT_MAX, INT_MIN};
    entry mean, spread;
    memset(&mean, 7, sizeof mean), memset(&spread, 7, sizeof spread);
    WATCH(mean), WATCH(spread);
    for (int k = 0; k < COUNT(beyond) + COUNT(no_count); k++) {
        if (k < COUNT(beyond) && beyond[k] > INT_MAX - count) continue;
        const int bad = k < COUNT(beyond) ? count + (int)beyond[k] : no_count[k - COUNT(beyond)];
        ASSERT_REFUSED(KQ_ERR_SIZE, S(smoothed_measurement_noise)(&tape, bad, &mean, &spread));
    }
    watched_count -= 2;
}

TEST(the_smoothed_measurement_noise_is_the_residual)
{
    static const int count[STEPS] = {2, 0, 1, 3, 2, 2};
    const double h0 = (double)direction[0], h1 = (double)direction[1];
    run(&track);
    for (int t = STEPS - 1; t >= 0; t--) {
        ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
        if (t == 0 || t == 3 || t == 5) assert_radar_noise(t);
        if (t == 2) assert_noise(t, 0, (double)H[2], (double)H[3], (double)R[3], -1);
        if (t == 3) assert_noise(t, 2, h0, h1, (double)variance[0], (double)compass_z[0]);
        for (int k = 0; k < 2 && t == 4; k++) {
            assert_noise(t, k, h0, h1, (double)variance[0], (double)compass_z[k]);
        }
        assert_number_of_noises(count[t]);
    }
}

TEST(a_measurement_that_was_not_taken_has_no_noise)
{
    static const num h[] = {1, 0.5, 1, 0.5}, z[] = {3, 4};
    num mean, spread;
    put_independent(&radar, 2, 2, range, measured_range, h, zero);
    ASSERT_OK(take(&track, &radar, z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, S(events)(&track));
    ASSERT_OK(go(&track, &motion, NULL));
    for (int k = 0; k < 2; k++) ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
    ASSERT_OK(read_noise(&tape, 1, &mean, &spread));
    TEST_ASSERT_TRUE(mean == 0 && spread == 0);
    ASSERT_OK(read_noise(&tape, 0, &mean, &spread));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_SIZE, read_noise(&tape, 2, &mean, &spread));
}

/* At the last step v is what the update left of the innovation: e r / s, and e sqrt(r) / s in
   units of its standard deviation.  However small that is, it is accurate. */
TEST(the_noise_of_a_sharp_or_dull_measurement_is_accurate)
{
    static const double sizes[] = {1e-10, 1e-6, 1e-4, 1e-2, 1e2, 1e4, 1e6, 1e10};
    static const num z[] = {3}, h[] = {1, 0.5};
    for (int k = 0; k < COUNT(sizes); k++) {
        const num r[] = {N(sizes[k])};
        num mean, spread;
        put_sensor(&compass, 2, 1, range, measured_range, h, r);
        ASSERT_OK(begin(&track, &tape));
        ASSERT_OK(take(&track, &compass, z));
        ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
        ASSERT_OK(read_noise(&tape, 0, &mean, &spread));
        const double s = 2.75 + (double)r[0], e = 3;
        ASSERT_SMOOTH(e * sqrt((double)r[0]) / s, mean, NOISE_FLOOR + e * sqrt((double)r[0]) / s);
        ASSERT_SMOOTH(2.75 / s, spread, NOISE_FLOOR + 2.75 / s);
    }
}

TEST(measurement_noise_refuses)
{
    entry mean, spread;
    memset(&mean, 7, sizeof mean), memset(&spread, 7, sizeof spread);
    WATCH(mean), WATCH(spread);
    run(&track);
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(smoothed_measurement_noise)(&tape, 0, &mean, &spread));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(smoothed_measurement_noise)(&unused, 0, &mean, &spread));
    ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, S(smoothed_measurement_noise)(NULL, 0, &mean, &spread));
    ASSERT_REFUSED(KQ_ERR_NULL, S(smoothed_measurement_noise)(&tape, 0, NULL, &spread));
    ASSERT_REFUSED(KQ_ERR_NULL, S(smoothed_measurement_noise)(&tape, 0, &mean, NULL));
    assert_number_of_noises(2);
}

/* ------------------------------------------------------------------- assign and attach */

/* At least the workspace and one step. */
TEST(assign_refuses_short_memory)
{
    for (size_t n = 1; n <= 16; n++) {
        const size_t least = (size_t)S_HISTORY_LEN(n, 0, 1, 0);
        ASSERT_REFUSED(KQ_ERR_MEMORY, S(history_assign)(&tape, (int)n, tape_memory, least - 1));
        ASSERT_REFUSED(KQ_ERR_MEMORY, S(history_assign)(&tape, (int)n, tape_memory, 0));
        S(history) h;
        ASSERT_OK(S(history_assign)(&h, (int)n, tape_memory, (size_t)S_HISTORY_LEN(n, 1, 1, 0)));
    }
}

TEST(steps_are_the_predicts_and_one)
{
    TEST_ASSERT_EQUAL_UINT(0, S(history_steps)(NULL));
    TEST_ASSERT_EQUAL_UINT(0, S(history_steps)(&unused));
    TEST_ASSERT_EQUAL_UINT(1, S(history_steps)(&tape));
    for (unsigned k = 2; k <= STEPS; k++) {
        ASSERT_OK(take(&track, &compass, compass_z));
        ASSERT_OK(go(&track, &motion, NULL));
        TEST_ASSERT_EQUAL_UINT(k, S(history_steps)(&tape));
    }
}

TEST(attach_empties_the_history)
{
    run(&track);
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_OK(S(detach)(&tape.attached));
    ASSERT_OK(S(attach)(&twin, &tape.attached));
    TEST_ASSERT_EQUAL_UINT(1, S(history_steps)(&tape));
    run(&twin);
    ASSERT_OK(S(smooth)(&tape));
    assert_means(0);
    ASSERT_OK(S(attach)(&track, &tape.attached));
    TEST_ASSERT_EQUAL_UINT(1, S(history_steps)(&tape));
    ASSERT_NOTHING(S(mean)(S_SMOOTHED(&tape, 0), 0));
}

/* The state as it is becomes step 0, whatever came before. */
TEST(attach_begins_in_the_middle_of_a_run)
{
    static prior_model middle;
    reading then, now;
    put_prior(&middle, 2, range, zero, identity);
    ASSERT_OK(init_filter(&track, &middle));
    for (int k = 0; k < 3; k++) ASSERT_OK(step(&track, &motion, NULL, radar_z[3]));
    read_now(&then, &track, 2);
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(go(&track, &motion, NULL));
    ASSERT_OK(S(smooth)(&tape));
    TEST_ASSERT_EQUAL_UINT(2, S(history_steps)(&tape));
    read_smoothed_at(&now, &tape, 0, &prior, 2);
    for (int i = 0; i < 2; i++) ASSERT_SMOOTH(whole(&then, i), whole(&now, i), 4);
    for (int k = 0; k < 4; k++) ASSERT_SMOOTH(then.P[k], now.P[k], 1);
}

TEST(what_was_recorded_is_gone_when_it_is_detached)
{
    run(&track);
    ASSERT_OK(S(detach)(&tape.attached));
    TEST_ASSERT_EQUAL_UINT(0, S(history_steps)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(smooth)(&tape));
    ASSERT_OK(S(detach)(&unused.attached));
}

TEST(what_was_smoothed_stays_when_it_is_detached)
{
    run(&track);
    ASSERT_OK(S(smooth)(&tape));
    ASSERT_OK(S(detach)(&tape.attached));
    assert_means(0);
    assert_covariances(0);
    ASSERT_OK(S(attach)(&twin, &tape.attached));
}

TEST(a_full_history_is_detached_too)
{
    for (int k = 0; k < 2 * STEPS; k++) ASSERT_OK(step(&track, &motion, NULL, z_zero));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, S(smooth)(&tape));
    ASSERT_OK(S(detach)(&tape.attached));
    ASSERT_OK(S(attach)(&twin, &tape.attached));
    run(&twin);
    ASSERT_OK(S(smooth)(&tape));
    assert_means(0);
}

/* ------------------------------------------------------------------------- full, empty */

static void fill(S(history) * h, S(filter) * f, int steps)
{
    ASSERT_OK(init_filter(f, &prior));
    if (h) ASSERT_OK(S(attach)(f, &h->attached));
    for (int t = 0; t < steps; t++) {
        if (t > 0) ASSERT_OK(go(f, &motion, control + t % STEPS));
        ASSERT_OK(take(f, &radar, radar_z[t % STEPS]));
        ASSERT_OK(take(f, &compass, compass_z + t % 2));
    }
}

TEST(the_memory_is_enough_for_its_steps)
{
    fill(&tape, &track, STEPS);
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    ASSERT_OK(S(smooth)(&tape));
    TEST_ASSERT_EQUAL_UINT(STEPS, S(history_steps)(&tape));
}

/* Another process than in the run before is no change of process. */
TEST(the_memory_is_enough_for_another_run)
{
    put_motion(&other_motion, A, Q);
    for (int t = 0; t < STEPS - 1; t++) ASSERT_OK(go(&track, &other_motion, control + t));
    fill(&tape, &track, STEPS);
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    ASSERT_OK(S(smooth)(&tape));
}

TEST(the_memory_is_enough_for_one_step)
{
    S_HISTORY(least, 2, MOST, 1, 0);
    reading now, end;
    fill(&least, &track, 1);
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    read_now(&end, &track, 2);
    ASSERT_OK(S(smooth)(&least));
    read_smoothed_at(&now, &least, 0, &prior, 2);
    TEST_ASSERT_EQUAL_MEMORY(&end, &now, offsetof(reading, nis));
}

static void assert_refused_as_full(void)
{
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, S(smooth)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, S(smooth_states)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, S(smooth_step)(&tape, NULL, NULL));
    ASSERT_NOTHING(S(mean)(S_SMOOTHED(&tape, 0), 0));
    ASSERT_NOTHING(S(sigma)(S_SMOOTHED(&tape, 0), 0));
}

TEST(a_full_history_is_an_event_and_the_filter_goes_on)
{
    for (int more = 1; more < 2 * STEPS; more++) {
        reading a, b;
        fill(&tape, &track, STEPS + more);
        fill(NULL, &twin, STEPS + more);
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, S(events)(&track));
        assert_refused_as_full();
        S(events_clear)(&track);
        read_now(&a, &track, 2);
        read_now(&b, &twin, 2);
        ASSERT_SAME_BITS(b, a);
    }
}

TEST(a_full_history_may_be_used_again)
{
    fill(&tape, &track, STEPS + 1);
    ASSERT_OK(begin(&track, &tape));
    run(&track);
    ASSERT_OK(S(smooth)(&tape));
    assert_means(0);
    assert_covariances(0);
}

/* One measurement more than there is room for, in the last step. */
TEST(a_measurement_too_many_fills_the_history)
{
    fill(&tape, &track, STEPS);
    for (int k = 0; k < 2; k++) ASSERT_OK(take(&track, &radar, radar_z[0]));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, S(events)(&track));
    assert_refused_as_full();
}

/* `more` records beyond the steps that there is memory for, each a predict or a measurement */
static void go_beyond(S(filter) * f, int more, int pattern)
{
    for (int k = 0; k < more; k++) {
        if (pattern >> k & 1) ASSERT_OK(go(f, &motion, control));
        else ASSERT_OK(take(f, &compass, compass_z));
    }
}

/* There may be room for a few records more; then they count. */
TEST(a_history_is_full_or_right)
{
    S_HISTORY(roomy, 2, MOST, STEPS + 4, 0);
    for (int pattern = 0; pattern < 8; pattern++) {
        for (int more = 0; more <= 3; more++) {
            fill(&tape, &track, STEPS);
            fill(&roomy, &twin, STEPS);
            go_beyond(&track, more, pattern);
            go_beyond(&twin, more, pattern);
            if (S(events)(&track) & KQ_EVENT_HISTORY_FULL) {
                assert_refused_as_full();
                continue;
            }
            ASSERT_OK(S(smooth)(&tape));
            ASSERT_OK(S(smooth)(&roomy));
            TEST_ASSERT_EQUAL_UINT(S(history_steps)(&roomy), S(history_steps)(&tape));
            for (size_t t = 0; t < S(history_steps)(&tape); t++) {
                reading a, b;
                read_smoothed_at(&a, &roomy, t, &prior, 2);
                read_smoothed_at(&b, &tape, t, &prior, 2);
                ASSERT_SAME_BITS(a, b);
            }
        }
    }
}

TEST(a_history_is_smoothed_once)
{
    for (int states_only = 0; states_only < 2; states_only++) {
        ASSERT_OK(begin(&track, &tape));
        run(&track);
        ASSERT_OK(states_only ? S(smooth_states)(&tape) : S(smooth)(&tape));
        ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(smooth)(&tape));
        ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(smooth_states)(&tape));
        ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(smooth_step)(&tape, NULL, NULL));
        assert_means(0);
    }
}

/* What moves a filter refuses a view. */
TEST(a_view_is_not_moved)
{
    S(loss) jump = {.kind = &S(loss_jump), .parameter = number(4)};
    run(&track);
    ASSERT_OK(S(smooth)(&tape));
    ASSERT_OK(S(smoothed)(&tape, STEPS - 1, &view));
    const word *z = measured(&radar.sensor, radar_z[0]);
    WATCH(view), WATCH(tape_memory);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, go(&view, &motion, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(update)(&view, &radar.sensor, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(update_subset)(&view, &radar.sensor, z, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(update_robust)(&view, &radar.sensor, z, 3, &jump));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(update)(&view, of_innovations(&radar), z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(step)(&view, &motion.process, NULL, &radar.sensor, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(attach)(&view, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(filter_check)(&view));
    ASSERT_REFUSED(KQ_ERR_MEMORY, init_filter(&view, &prior));
    ASSERT_REFUSED(KQ_ERR_MEMORY, S(filter_copy)(&view, &track));
    ASSERT_REFUSED(KQ_ERR_MEMORY, S(forecast)(&track, &motion.process, NULL, 1, &view));
    ASSERT_NO_SCORE(S(nis)(&view));
    ASSERT_NO_SCORE(S(log_likelihood)(&view));
    TEST_ASSERT_EQUAL_INT(-1, S(taken)(&view));
}

/* What reads a filter takes a view as the filter that was there. */
TEST(a_view_is_measured_copied_and_forecast)
{
    num now[2], then[2], cov[4], other[4];
    word e[2];
    entry gain[4];
    run(&track);
    ASSERT_OK(S(filter_copy)(&twin, &track));
    ASSERT_OK(S(smooth)(&tape));
    ASSERT_OK(S(smoothed)(&tape, STEPS - 1, &view));
    ASSERT_OK(read_measurement(&view, &radar.sensor, now, cov));
    ASSERT_OK(read_measurement(&twin, &radar.sensor, then, other));
    ASSERT_SMOOTH(then[0], now[0], 8);
    ASSERT_SMOOTH(other[0], cov[0], 8);
    ASSERT_OK(S(innovation)(&view, &radar.sensor, measured(&radar.sensor, radar_z[0]), e));
    ASSERT_OK(S(gain)(&view, &radar.sensor, gain));
    ASSERT_OK(S(filter_copy)(&twin, &view));
    for (int i = 0; i < 2; i++) TEST_ASSERT_TRUE(S(sigma)(&twin, i) == S(sigma)(&view, i));
    ASSERT_OK(S(filter_check)(&twin));
    TEST_ASSERT_TRUE(S(log_likelihood)(&twin) == 0);
    ASSERT_OK(go(&twin, &motion, NULL));
    ASSERT_OK(S(forecast)(&view, &motion.process, NULL, 1, &track));
    TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof twin_memory);
}

TEST(a_view_of_means_has_no_covariance)
{
    entry P[4];
    word z[2];
    run(&track);
    ASSERT_OK(S(smooth_states)(&tape));
    ASSERT_OK(S(smoothed)(&tape, 0, &view));
    WATCH(view), WATCH(tape_memory);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(covariance)(&view, P));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(measurement)(&view, &radar.sensor, z, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(filter_copy)(&twin, &view));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(forecast)(&view, &motion.process, NULL, 1, &twin));
    ASSERT_REFUSED(KQ_ERR_MEMORY, init_filter(&view, &prior));
}

TEST(what_is_read_of_a_bad_step_or_state_is_no_number)
{
    static const int bad[] = {-1, 2, 16, 256, INT_MAX, INT_MIN};
    static const size_t beyond[] = {STEPS, STEPS + 1, SIZE_MAX};
    run(&track);
    ASSERT_OK(S(smooth)(&tape));
    for (int k = 0; k < COUNT(bad); k++) assert_nothing_shown(S_SMOOTHED(&tape, 0), bad[k]);
    for (int k = 0; k < COUNT(beyond); k++) assert_nothing_shown(S_SMOOTHED(&tape, beyond[k]), 0);
    assert_nothing_shown(S_SMOOTHED(NULL, 0), 0);
    assert_nothing_shown(S_SMOOTHED(&unused, 0), 0);
}

/* ------------------------------------------------------------------- models that change */

/* Every step by another A: 3 processes taking turns, and one process that is changed. */
static const num turns[3][4] = {{1, 0.5, -0.25, 0.75}, {0.5, 1, 0, 1}, {1, 0, 0.5, 0.25}};
static process_model turn[3];
S_HISTORY(long_tape, 2, 2, STEPS, STEPS - 2);

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

static void assert_smoothed(const S(history) *h)
{
    reading now;
    for (size_t t = 0; t < STEPS; t++) {
        read_smoothed_at(&now, h, t, &prior, 2);
        for (int k = 0; k < 4; k++) ASSERT_SMOOTH(smoothed[t].P[k], now.P[k], 2);
        for (int i = 0; i < 2; i++) ASSERT_SMOOTH(smoothed[t].x[i], whole(&now, i), 8);
    }
}

TEST(processes_may_take_turns)
{
    textbook_of_turns();
    for (int k = 0; k < 3; k++) put_process(&turn[k], 2, 0, range, drive_range, turns[k], NULL, Q);
    for (int by_step = 0; by_step < 2; by_step++) {
        ASSERT_OK(init_filter(&track, &prior));
        ASSERT_OK(S(attach)(&track, &long_tape.attached));
        ASSERT_OK(take(&track, &radar, radar_z[0]));
        for (int t = 1; t < STEPS; t++) {
            ASSERT_OK(step(&track, &turn[(t - 1) % 3], NULL, radar_z[t]));
        }
        TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
        if (!by_step) ASSERT_OK(S(smooth)(&long_tape));
        for (int t = 0; t < STEPS && by_step; t++) {
            ASSERT_OK(S(smooth_step)(&long_tape, NULL, NULL));
        }
        assert_smoothed(&long_tape);
    }
}

/* The tape refers to the one process, which has changed since: the caller passes what it was. */
TEST(a_process_that_changed_may_be_given_back)
{
    textbook_of_turns();
    for (int k = 0; k < 3; k++) put_process(&turn[k], 2, 0, range, drive_range, turns[k], NULL, Q);
    ASSERT_OK(take(&track, &radar, radar_z[0]));
    for (int t = 1; t < STEPS; t++) {
        ASSERT_OK(change_transition(&motion, 2, turns[(t - 1) % 3]));
        ASSERT_OK(step(&track, &motion, NULL, radar_z[t]));
    }
    for (int t = STEPS - 1; t >= 0; t--) {
        ASSERT_OK(S(smooth_step)(&tape, t == STEPS - 1 ? NULL : &turn[t % 3].process, NULL));
    }
    assert_smoothed(&tape);
}

/* A sensor may change at every step: the tape does not refer to it. */
TEST(a_sensor_may_change_after_it_was_used)
{
    static const num other[] = {0.25, 3, -1, 0.5};
    run(&track);
    ASSERT_OK(change_measurement(&radar, 2, 2, other));
    put_sensor(&compass, 2, 1, range, measured_range, other, P0);
    ASSERT_OK(S(smooth)(&tape));
    assert_means(0);
    assert_covariances(0);
}

/* -------------------------------------------------------------------- singular models */

/* Without process noise and with A = I, every step is known as well as the last one. */
TEST(a_constant_is_the_same_at_every_step)
{
    reading now, then;
    put_motion(&motion, identity, zero);
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) ASSERT_OK(go(&track, &motion, NULL));
        ASSERT_OK(take(&track, &radar, radar_z[t]));
    }
    read_now(&now, &track, 2);
    ASSERT_OK(S(smooth)(&tape));
    for (size_t t = 0; t < STEPS; t++) {
        read_smoothed_at(&then, &tape, t, &prior, 2);
        for (int i = 0; i < 2; i++) ASSERT_SMOOTH(whole(&now, i), whole(&then, i), 4);
        for (int k = 0; k < 4; k++) ASSERT_SMOOTH(now.P[k], then.P[k], 2);
    }
}

/* x' = x / 2 + w measured without noise, and its delay: all is known, but where the
   measurement is missing; there x is (x_before + x_after) / 2 / (1 + 1/4), Var q / (1 + 1/4). */
TEST(a_delay_line_measured_without_noise)
{
    static const num delay[] = {0.5, 0, 1, 0}, q[] = {1, 0, 0, 0}, h[] = {1, 0};
    static const num z[STEPS] = {1, 3, 100, -2, 0.5, 4};
    const size_t gap = 2;
    const double between = 0.5 * (3 - 2) / 1.25;
    put_motion(&motion, delay, q);
    put_sensor(&compass, 2, 1, range, measured_range, h, zero);
    for (size_t t = 0; t < STEPS; t++) {
        if (t > 0) ASSERT_OK(go(&track, &motion, NULL));
        ASSERT_OK(take_part(&track, &compass, &z[t], t != gap));
    }
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    ASSERT_OK(S(smooth)(&tape));
    reading now_shown;
    for (size_t t = 0; t < STEPS; t++) {
        read_smoothed_at(&now_shown, &tape, t, &prior, 2);
        const double now = t == gap ? between : (double)z[t];
        ASSERT_SMOOTH(now, shown_mean(S_SMOOTHED(&tape, t), &prior, 0), 8);
        ASSERT_WITHIN(ROUNDING_OF_RUNS + sigma_step(range[0]), t == gap ? sqrt(1 / 1.25) : 0, now_shown.sigma[0]);
        if (t == 0) continue;
        const double before = t - 1 == gap ? between : (double)z[t - 1];
        ASSERT_SMOOTH(before, shown_mean(S_SMOOTHED(&tape, t), &prior, 1), 8);
        ASSERT_WITHIN(ROUNDING_OF_RUNS + sigma_step(range[1]), t - 1 == gap ? sqrt(1 / 1.25) : 0, now_shown.sigma[1]);
    }
}

/* A state known exactly from the start and without noise stays so. */
TEST(a_known_constant_stays_known)
{
    static const num a[] = {1, 0.5, 0, 1}, q[] = {1, 0, 0, 0}, P[] = {1, 0, 0, 0};
    reading now;
    put_motion(&motion, a, q);
    put_prior(&prior, 2, range, x0, P);
    ASSERT_OK(begin(&track, &tape));
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) ASSERT_OK(go(&track, &motion, NULL));
        ASSERT_OK(take(&track, &radar, radar_z[t]));
    }
    ASSERT_OK(S(smooth)(&tape));
    for (size_t t = 0; t < STEPS; t++) {
        read_smoothed_at(&now, &tape, t, &prior, 2);
        ASSERT_SMOOTH(-2, whole(&now, 1), 2);
        ASSERT_WITHIN(8 * TINY_SIGMA, 0, now.sigma[1]);
    }
}

SUITE(smoother, set_up)
#include "smoother.tests"
