/* Outliers and jumps, in all arithmetics: the losses beside their formulas, scaled noise, the reweighted smoother. */
#include "models.h"
#include "textbook.h"
#include "unchanged.h"

#define ALL UINT32_MAX
enum { STEPS = 8, REWEIGHTED = 6 };
enum { OF_HUBER, OF_STUDENT, OF_JUMP, OF_GATE, LOSSES }; /* a loss of each kind; those before OF_JUMP have weights */

static process_model motion, scaled, direct;
static sensor_model radar, coupled, twins;
static prior_model prior, certain, wide, at_zero;
S_FILTER(track, 2);
S_FILTER(twin, 2);
S_HISTORY(tape, 2, 2, STEPS, 0);
S_HISTORY(twin_tape, 2, 2, STEPS, 0);
S_HISTORY(short_tape, 2, 2, 1, 0);

static const num range[] = {100000, 1000}, measured_range[] = {100000, 100000}, drive_range[] = {100};
static const num A[] = {1, 0.5, 0, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1}, r[] = {0.5, 1}, none[] = {0, 0, 0, 0};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static const num same_rows[] = {N(0.3), N(0.7), N(0.3), N(0.7)}, wide_P0[] = {1, 0, 0, 2};

static entry weights[2], q[STEPS];
static S(loss) gate;
static const word *u;

static void set_up(void)
{
    static const num push[] = {4};
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_process(&scaled, 2, 1, range, drive_range, A, B, Q);
    put_process(&direct, 2, 1, range, drive_range, A, B, Q);
    put_independent(&radar, 2, 2, range, measured_range, H, r);
    put_sensor(&coupled, 2, 2, range, measured_range, H, R);
    put_independent(&twins, 2, 2, range, measured_range, same_rows, none);
    put_prior(&prior, 2, range, x0, P0);
    put_prior(&certain, 2, range, x0, none);
    put_prior(&wide, 2, range, none, wide_P0);
    u = driven(&motion.process, push, 1);
    for (int t = 0; t < COUNT(q); t++) q[t] = number(1);
    gate = (S(loss)){.kind = &S(loss_gate), .limit = S(chi_square_limit)(2, KQ_LEVEL_99), .run = 3};
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(weights), WATCH(tape), WATCH(tape_memory);
}

/* The measurement (a, b) of either sensor, until the next one */
static const word *seen(double a, double b)
{
    static num z[2];
    z[0] = N(a), z[1] = N(b);
    return measured(&radar.sensor, z);
}

typedef const struct S(loss_kind) *kind;

static kq_status robust(S(filter) *f, const S(sensor) *s, const word *z, uint32_t present, kind of, double parameter)
{
    S(loss) loss = {.kind = of, .parameter = number(parameter), .weights = weights};
    return S(update_robust)(f, s, z, present, &loss);
}

#define HUBER &S(loss_huber)
#define STUDENT &S(loss_student)
#define JUMP &S(loss_jump)

static const S(sensor) *sensor_at(int t) { return t % 2 ? &radar.sensor : &coupled.sensor; }

static void predict_both(void)
{
    ASSERT_OK(S(predict)(&track, &motion.process, u));
    ASSERT_OK(S(predict)(&twin, &motion.process, u));
}

static void attach_both(void)
{
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(attach)(&twin, &twin_tape.attached));
}

#define ASSERT_SAME_MEMORY() TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof twin_memory)

static void assert_readings_within(const reading *a, const reading *b, double tolerance)
{
    for (int i = 0; i < 2; i++) ASSERT_WITHIN(tolerance, whole(a, i), whole(b, i));
    for (int k = 0; k < 4; k++) ASSERT_WITHIN(tolerance, a->P[k], b->P[k]);
}

static void assert_states_within(double tolerance)
{
    reading a, b;
    read_now(&a, &twin, 2);
    read_now(&b, &track, 2);
    assert_readings_within(&a, &b, tolerance);
}

/* Both tapes, bit for bit or nearly so */
static void assert_same_smoothed(size_t steps, double tolerance)
{
    reading a, b;
    ASSERT_OK(S(smooth)(&tape));
    ASSERT_OK(S(smooth)(&twin_tape));
    for (size_t t = 0; t < steps; t++) {
        read_smoothed_at(&a, &twin_tape, t, &prior, 2);
        read_smoothed_at(&b, &tape, t, &prior, 2);
        if (tolerance > 0) assert_readings_within(&a, &b, tolerance);
        else ASSERT_SAME_BITS(a, b);
    }
}

/* ------------------------------------------------------------------------------ the gate */

TEST(a_gate_takes_or_leaves)
{
    attach_both();
    gate.limit = score_of(100);
    for (int t = 0; t < STEPS - 1; t++) {
        ASSERT_OK(S(update_robust)(&track, sensor_at(t), seen(1 + 0.5 * t, 0), t % 3 ? ALL : 1, &gate));
        ASSERT_OK(S(update_subset)(&twin, sensor_at(t), seen(1 + 0.5 * t, 0), t % 3 ? ALL : 1));
        ASSERT_SAME(&twin, &track, 2);
        TEST_ASSERT_EQUAL_INT(t % 3 ? 2 : 1, S(taken)(&track));
        TEST_ASSERT_EQUAL_INT(0, gate.rejected);
        TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
        const score run = S(log_likelihood)(&track);
        ASSERT_OK(S(update_robust)(&track, sensor_at(t), seen(900, 20), ALL, &gate));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED, S(events)(&track));
        ASSERT_SAME_MEMORY();
        TEST_ASSERT_EQUAL_INT(0, S(taken)(&track));
        TEST_ASSERT_EQUAL_INT(1, gate.rejected);
        TEST_ASSERT_TRUE(S(log_likelihood_last)(&track) == 0 && S(log_likelihood)(&track) == run);
        TEST_ASSERT_TRUE(S(nis)(&track) > gate.limit);
        S(events_clear)(&track);
        predict_both();
    }
    assert_same_smoothed(STEPS, 0);
    const word *far = seen(900, 20);
    ASSERT_OK(S(update_robust)(&track, &radar.sensor, far, ALL, &gate));
    ASSERT_OK(S(update)(&twin, &radar.sensor, far));
    TEST_ASSERT_TRUE(S(nis)(&track) == S(nis)(&twin));
}

/* Even where the rejected one had no room on it */
TEST(a_full_history_is_full_because_of_what_is_taken_only)
{
    ASSERT_OK(S(attach)(&track, &short_tape.attached));
    ASSERT_OK(S(update_robust)(&track, &radar.sensor, seen(3, 1), ALL, &gate));
    ASSERT_OK(S(update_robust)(&track, &radar.sensor, seen(50, 1), ALL, &gate));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED, S(events)(&track));
    ASSERT_OK(S(smooth)(&short_tape));
}

TEST(a_run_of_rejections_ends_with_a_jump)
{
    static const uint16_t runs[] = {0, 1, 3, 20};
    const word *far = seen(50, 1);
    for (int j = 0; j < COUNT(runs); j++) {
        ASSERT_OK(init_filter(&track, &prior));
        gate.run = runs[j];
        for (int k = 1; k <= (int)(runs[j] ? runs[j] : KQ_GATE_RUN); k++) {
            ASSERT_OK(S(update_robust)(&track, &radar.sensor, far, ALL, &gate));
            TEST_ASSERT_EQUAL_INT(k, gate.rejected);
            ASSERT_OK(S(update_robust)(&track, &radar.sensor, far, 0, &gate)); /* nothing measured */
            TEST_ASSERT_EQUAL_INT(k, gate.rejected);
            TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED, S(events)(&track));
        }
        S(events_clear)(&track);
        ASSERT_OK(init_filter(&twin, &prior));
        ASSERT_OK(robust(&twin, &radar.sensor, far, ALL, JUMP, 1));
        ASSERT_OK(S(update_robust)(&track, &radar.sensor, far, ALL, &gate));
        ASSERT_SAME_MEMORY();
        TEST_ASSERT_TRUE(S(nis)(&twin) == S(nis)(&track));
        TEST_ASSERT_EQUAL_INT(2, S(taken)(&track));
        TEST_ASSERT_EQUAL_INT(0, gate.rejected);
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_JUMP | KQ_EVENT_REJECTIONS, S(events)(&track));
        ASSERT_OK(S(update_robust)(&track, &radar.sensor, far, ALL, &gate)); /* as it is where it should be */
        TEST_ASSERT_EQUAL_INT(2, S(taken)(&track));
    }
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(S(update_robust)(&track, &radar.sensor, far, ALL, &gate));
    TEST_ASSERT_EQUAL_INT(1, gate.rejected);
    ASSERT_OK(S(update_robust)(&track, &radar.sensor, seen(1, -1.5), ALL, &gate));
    TEST_ASSERT_EQUAL_INT(0, gate.rejected);
}

TEST(a_gate_takes_what_is_at_its_limit)
{
    ASSERT_OK(S(update)(&twin, &radar.sensor, seen(3, 1)));
    gate.limit = S(nis)(&twin);
    ASSERT_OK(S(update_robust)(&track, &radar.sensor, seen(3, 1), ALL, &gate));
    TEST_ASSERT_EQUAL_INT(0, gate.rejected);
    ASSERT_SAME_MEMORY();
}

TEST(a_gate_may_stay_closed)
{
    gate.run = KQ_GATE_CLOSED;
    gate.rejected = UINT16_MAX - 1;
    for (int k = 0; k < 3; k++) {
        ASSERT_OK(S(update_robust)(&track, &radar.sensor, seen(50, 1), ALL, &gate));
        TEST_ASSERT_EQUAL_UINT(UINT16_MAX, gate.rejected);
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED, S(events)(&track));
    }
}

/* A raised P is nothing that a history could undo: there the measurement is taken as it is. */
TEST(a_run_of_rejections_ends_on_a_history)
{
    const word *far = seen(50, 1);
    attach_both();
    gate.run = 2;
    for (int t = 0; t < 6; t++) {
        const int taken = t == 2 || t == 5;
        ASSERT_OK(S(update_robust)(&track, &radar.sensor, far, ALL, &gate));
        TEST_ASSERT_EQUAL_INT(taken ? 2 : 0, S(taken)(&track));
        if (taken) ASSERT_OK(S(update)(&twin, &radar.sensor, far));
        predict_both();
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED | KQ_EVENT_REJECTIONS, S(events)(&track));
    assert_same_smoothed(7, 0);
}

/* The lower incomplete gamma function by its series */
static double chi_square_probability(int m, double x)
{
    double a = 0.5 * m, y = 0.5 * x, term = 1 / a, sum = term,
           gamma = m % 2 ? 1.7724538509055160 : 1;
    for (int k = 1; k < 200; k++) sum += term *= y / (a + k);
    for (double k = m % 2 ? 0.5 : 1; k < a - 0.25; k++) gamma *= k;
    return sum * exp(-y) * pow(y, a) / gamma;
}

TEST(limits_are_those_of_chi_square)
{
    static const double level[] = {0.9, 0.95, 0.99, 0.999, 0.9999};
    for (int m = 1; m <= 16; m++) {
        for (int k = 0; k < COUNT(level); k++) {
            const double x = score_number(S(chi_square_limit)(m, (kq_level)k));
            ASSERT_WITHIN(1e-7 + 300 * EPS, level[k], chi_square_probability(m, x));
        }
    }
    ASSERT_NO_SCORE(S(chi_square_limit)(0, KQ_LEVEL_99));
    ASSERT_NO_SCORE(S(chi_square_limit)(17, KQ_LEVEL_99));
    ASSERT_NO_SCORE(S(chi_square_limit)(1, (kq_level)5));
}

/* ------------------------------------------------------------------------------ beside the formulas */

static double raised; /* how much P was, at most, in a measurement */

/* One scalar measurement by a loss, in double (robust.h); answers its weight */
static double take_by_formula(textbook *t, const double *h, double variance, double z, kind of, double parameter)
{
    double Ph[2], noise_now = variance;
    for (int i = 0; i < 2; i++) Ph[i] = t->P[2 * i] * h[0] + t->P[2 * i + 1] * h[1];
    double square = h[0] * Ph[0] + h[1] * Ph[1];
    const double e = z - h[0] * t->x[0] - h[1] * t->x[1], s = square + variance;
    t->nis += e * e / s;
    t->log_likelihood -= 0.5 * (1.8378770664093454836 + log(s) + e * e / s);
    if (of == HUBER && fabs(e) > parameter * sqrt(s)) noise_now = fabs(e) * sqrt(s) / parameter - square;
    for (int k = 0; of == STUDENT && k < 3; k++) {
        const double share = noise_now / (square + noise_now), v = e * share;
        noise_now = (parameter * variance + v * v + square * share) / (parameter + 1);
    }
    if (of == JUMP && e * e > parameter * s) {
        const double c = (e * e - variance) / square;
        for (int k = 0; k < 4; k++) t->P[k] *= c;
        for (int i = 0; i < 2; i++) Ph[i] *= c;
        square *= c, raised *= c;
    }
    for (int i = 0; i < 2; i++) t->x[i] += Ph[i] * e / (square + noise_now);
    for (int k = 0; k < 4; k++) t->P[k] -= Ph[k / 2] * Ph[k % 2] / (square + noise_now);
    return variance / noise_now;
}

/* R = U D U': component 0 without what it has in common with component 1 */
static void update_by_formula(textbook *t, double *weight, int is_coupled, const double *z, uint32_t present, kind of,
                              double parameter)
{
    const int both = is_coupled && (present & 3) == 3;
    const double u01 = both ? 0.25 : 0, h0[] = {1 - 0.5 * u01, -u01}, h1[] = {0.5, 1};
    t->nis = t->log_likelihood = weight[0] = weight[1] = 0, raised = 1;
    textbook_note_size(t);
    if (present & 1) weight[0] = take_by_formula(t, h0, 0.5 - 0.25 * u01, z[0] - u01 * z[1], of, parameter);
    if (present & 2) weight[1] = take_by_formula(t, h1, 1, z[1], of, parameter);
}

/* q31's innovations are whole raw values, of a range of 100000 here. */
static void assert_score(double expected, double actual)
{
    if (score_step() > 0) ASSERT_WITHIN(1e-6 * (10 + fabs(expected)), expected, actual);
    else ASSERT_ALIKE(expected, actual, raised * (4 + fabs(expected)));
}

/* Of a step: from what the filter was to what it is, which has followed jumps and outliers */
static void assert_by_formulas(kind of, double parameter, double outlier, double jump)
{
    uint32_t seed = 5;
    int jumps = 0;
    ASSERT_OK(init_filter(&track, &prior));
    for (int t = 0; t < 60; t++) {
        const uint32_t present = t % 7 == 3 ? 2 : t % 11 == 3 ? 1 : ALL;
        const double far = t > 20 ? jump : 0, a = 2 * t + far + (double)noise(&seed), b = t + (double)noise(&seed);
        const word *z = seen(a + (t % 5 == 2 ? outlier : 0), b - (t % 5 == 4 ? outlier : 0));
        const double seen_now[] = {measured_value(&radar.sensor, z[0], 0), measured_value(&radar.sensor, z[1], 1)};
        textbook expected = {.n = 2};
        double weight[2];
        reading before, now;
        read_now(&before, &track, 2);
        for (int i = 0; i < 2; i++) expected.x[i] = whole(&before, i);
        for (int k = 0; k < 4; k++) expected.P[k] = (double)before.P[k];
        update_by_formula(&expected, weight, t % 2 == 0, seen_now, present, of, parameter);
        S(events_clear)(&track);
        ASSERT_OK(robust(&track, sensor_at(t), z, present, of, parameter));
        read_now(&now, &track, 2);
        describe("a loss", "parameter", (int)parameter, "step", t);
        for (int i = 0; i < 2; i++) {
            const double size = sqrt(raised) * expected.size[i] + fabs(expected.x[i]);
            ASSERT_ALIKE(expected.x[i], whole(&now, i), size);
            ASSERT_ALIKE(weight[i], number_of(weights[i]), 1);
            for (int j = 0; j < 2; j++) {
                const double area = raised * expected.size[i] * expected.size[j];
                ASSERT_ALIKE(expected.P[2 * i + j], now.P[2 * i + j], area);
            }
        }
        assert_score(expected.nis, (double)now.nis);
        assert_score(expected.log_likelihood, (double)now.last);
        TEST_ASSERT_EQUAL_INT(present == ALL ? 2 : 1, now.taken);
        jumps += (now.events & KQ_EVENT_JUMP) != 0;
        TEST_ASSERT_EQUAL_HEX(0, now.events & ~(unsigned)KQ_EVENT_JUMP);
        ASSERT_OK(S(predict)(&track, &motion.process, u));
    }
    if (of != JUMP) TEST_ASSERT_EQUAL_INT(0, jumps);
    else TEST_ASSERT_TRUE(outlier + jump == 0 || jumps > 0);
}

TEST(losses_are_those_of_the_formulas)
{
    for (int k = 0; k < 3; k++) {
        const double outlier = k == 1 ? 40 : 0, jump = k == 2 ? 500 : 0;
        assert_by_formulas(HUBER, 1.5, outlier, jump);
        assert_by_formulas(HUBER, 3, outlier, jump);
        assert_by_formulas(STUDENT, 1, outlier, jump);
        assert_by_formulas(STUDENT, 4, outlier, jump);
        assert_by_formulas(JUMP, 12, outlier, jump);
        assert_by_formulas(JUMP, 30, outlier, jump);
    }
}

TEST(what_is_not_clipped_is_taken_as_it_is)
{
    for (int k = 0; k < 8; k++) {
        const uint32_t present = k % 3 == 2 ? 1 : ALL;
        const word *z = seen(k - 2, 1);
        ASSERT_OK(robust(&track, sensor_at(k), z, present, HUBER, 1e6));
        ASSERT_OK(S(update_subset)(&twin, sensor_at(k), z, present));
        ASSERT_SAME_MEMORY();
        TEST_ASSERT_EQUAL_INT(S(taken)(&twin), S(taken)(&track));
        ASSERT_WITHIN(0, 1, number_of(weights[0]));
        ASSERT_WITHIN(0, present & 2 ? 1 : 0, number_of(weights[1]));
        predict_both();
    }
}

TEST(a_student_of_many_degrees_is_gaussian)
{
    for (int k = 0; k < 6; k++) {
        const word *z = seen(3, 1);
        ASSERT_OK(robust(&track, sensor_at(k), z, ALL, STUDENT, 1e30));
        ASSERT_OK(S(update)(&twin, sensor_at(k), z));
        assert_states_within(ROUNDING * 16);
        ASSERT_ALIKE(1, number_of(weights[0]), 1);
        predict_both();
    }
}

/* What the smoother undoes is the update that was done. */
TEST(the_smoother_has_the_noise_that_was_used)
{
    attach_both();
    for (int t = 0; t < 5; t++) {
        num noise_now[2];
        ASSERT_OK(robust(&track, &radar.sensor, seen(t == 2 ? 60 : 3 + t, t == 3 ? -30 : 1 + t), ALL, STUDENT, 4));
        TEST_ASSERT_TRUE(t != 2 || number_of(weights[0]) < 0.01);
        for (int c = 0; c < 2; c++) noise_now[c] = N((double)r[c] / number_of(weights[c]));
        put_independent(&radar, 2, 2, range, measured_range, H, noise_now);
        ASSERT_OK(S(update)(&twin, &radar.sensor, seen(t == 2 ? 60 : 3 + t, t == 3 ? -30 : 1 + t)));
        put_independent(&radar, 2, 2, range, measured_range, H, r);
        assert_states_within(16 * ROUNDING);
        predict_both();
    }
    assert_same_smoothed(6, 64 * ROUNDING);
}

/* Twins without noise that say different things.  The plain update takes one of them: so do the
   robust ones, P is as it leaves it, and a history knows nothing of the other. */
TEST(what_the_plain_update_does_not_take_no_robust_one_takes)
{
    static const kind kinds[] = {HUBER, STUDENT, JUMP};
    static const double values[][2] = {{1, 2}, {1, 1}, {0.5, -3}};
    for (int k = 0; k < COUNT(values) * COUNT(kinds); k++) {
        const kind of = kinds[k % COUNT(kinds)];
        const double *said = values[k / COUNT(kinds)];
        const word *z = seen(said[0], said[1]);
        ASSERT_OK(init_filter(&track, &wide));
        ASSERT_OK(init_filter(&twin, &wide));
        if (of != JUMP) attach_both();
        for (int t = 0; t < 3; t++) {
            ASSERT_OK(S(update)(&twin, &twins.sensor, z));
            ASSERT_OK(robust(&track, &twins.sensor, z, ALL, of, 9));
            if (t == 0) {
                TEST_ASSERT_EQUAL_INT(1, S(taken)(&track));
                TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, S(events)(&track));
                assert_states_within(ROUNDING);
                ASSERT_WITHIN(0, 0, number_of(weights[1]));
            }
            if (of != HUBER) break;
            predict_both();
        }
        if (of == HUBER) assert_same_smoothed(4, 0);
    }
}

/* The loss `of`; behind the losses the plain update, and a part of it */
static void update_by(int of, S(loss) *losses, S(filter) *f, const S(sensor) *s, const word *z)
{
    if (of == LOSSES) ASSERT_OK(S(update)(f, s, z));
    else if (of > LOSSES) ASSERT_OK(S(update_subset)(f, s, z, 1));
    else ASSERT_OK(S(update_robust)(f, s, z, ALL, &losses[of]));
}

/* track is where twin is, but for x0. */
static void assert_shifted(void)
{
    reading a, b;
    read_now(&a, &twin, 2);
    read_now(&b, &track, 2);
    for (int i = 0; i < 2; i++) ASSERT_WITHIN(EPS + sigma_step(range[i]), (double)x0[i] + whole(&a, i), whole(&b, i));
    memcpy(a.mean, b.mean, sizeof a.mean), memcpy(a.low, b.low, sizeof a.low);
    ASSERT_SAME_BITS(a, b);
}

/* An innovation is a measurement of a filter at 0, correlated and independent, near and far. */
TEST(every_update_takes_an_innovation)
{
    S(loss) losses[LOSSES] = {[OF_HUBER] = {.kind = HUBER, .parameter = number(1.5)},
                              [OF_STUDENT] = {.kind = STUDENT, .parameter = number(4)},
                              [OF_JUMP] = {.kind = JUMP, .parameter = number(36)},
                              [OF_GATE] = {.kind = &S(loss_gate), .limit = score_of(36)}};
    S(loss) twins_of[LOSSES];
    entry twin_weights[2];
    losses[OF_HUBER].weights = losses[OF_STUDENT].weights = weights;
    memcpy(twins_of, losses, sizeof losses);
    twins_of[OF_HUBER].weights = twins_of[OF_STUDENT].weights = twin_weights;
    put_prior(&at_zero, 2, range, none, P0);
    for (int k = 0; k < 4 * (LOSSES + 2); k++) {
        const int of = k / 4, is_far = k % 2;
        sensor_model *s = k % 4 < 2 ? &coupled : &radar;
        const word *e = is_far ? seen(200, -400) : seen(2, -4);
        describe("way", "number", of, "far", is_far);
        ASSERT_OK(init_filter(&track, &prior));
        ASSERT_OK(init_filter(&twin, &at_zero));
        update_by(of, twins_of, &twin, &s->sensor, e);
        update_by(of, losses, &track, of_innovations(s), e);
        assert_shifted();
        if (of < OF_JUMP) {
            TEST_ASSERT_EQUAL_MEMORY(twin_weights, weights, sizeof weights);
            TEST_ASSERT_TRUE(!is_far || number_of(weights[0]) < 1);
        }
        if (of == OF_JUMP) TEST_ASSERT_EQUAL_INT(is_far, (S(events)(&track) & KQ_EVENT_JUMP) != 0);
        if (of == OF_GATE) TEST_ASSERT_EQUAL_INT(is_far, losses[OF_GATE].rejected);
        losses[OF_GATE].rejected = twins_of[OF_GATE].rejected = 0;
    }
}

/* With fewer degrees of freedom nothing of r would be left in r'. */
TEST(a_student_has_some_freedom)
{
    const word *z = seen(1, 2);
    ASSERT_REFUSED(KQ_ERR_RANGE, robust(&track, &radar.sensor, z, ALL, STUDENT, 0x1p-20 * (1 - EPS)));
    ASSERT_REFUSED(KQ_ERR_RANGE, robust(&track, &radar.sensor, z, ALL, STUDENT, 0x1p-60));
    ASSERT_OK(robust(&track, &radar.sensor, z, ALL, STUDENT, 0x1p-20));
}

TEST(a_history_cannot_undo_a_jump)
{
    const word *z = seen(3, 1);
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, robust(&track, &radar.sensor, z, ALL, JUMP, 4));
    ASSERT_OK(S(detach)(&tape.attached));
    ASSERT_OK(robust(&track, &radar.sensor, z, ALL, JUMP, 4));
}

TEST(without_a_jump_the_update_is_plain)
{
    for (int k = 0; k < 4; k++) {
        const word *z = seen(3, 1);
        ASSERT_OK(robust(&track, sensor_at(k), z, k == 3 ? 2 : ALL, JUMP, 1000));
        ASSERT_OK(S(update_subset)(&twin, sensor_at(k), z, k == 3 ? 2 : ALL));
        ASSERT_SAME_MEMORY();
        TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    }
}

/* A state that is known does not jump. */
TEST(what_has_no_variance_does_not_jump)
{
    ASSERT_OK(init_filter(&track, &certain));
    ASSERT_OK(init_filter(&twin, &certain));
    ASSERT_OK(robust(&track, &radar.sensor, seen(31, 1), ALL, JUMP, 4));
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    ASSERT_SAME_MEMORY();
}

/* ------------------------------------------------------------------------------ scaled noise */

TEST(scaled_noise_is_that_of_the_scaled_covariance)
{
    for (int k = -2; k < 20; k++) {
        const double factor = k < 0 ? (k == -1 ? 0.25 : 65536) : exp(k - 8);
        num raised[4];
        for (int i = 0; i < 4; i++) raised[i] = N(factor * (double)Q[i]);
        put_process(&direct, 2, 1, range, drive_range, A, B, raised);
        ASSERT_OK(scale_noise(&scaled, &motion, number(factor)));
        ASSERT_OK(init_filter(&track, &prior));
        ASSERT_OK(init_filter(&twin, &prior));
        ASSERT_OK(S(predict)(&track, &scaled.process, u));
        ASSERT_OK(S(predict)(&twin, &direct.process, u));
        assert_states_within(ROUNDING * (1 + factor));
    }
    ASSERT_OK(scale_noise(&scaled, &motion, number(1)));
    TEST_ASSERT_EQUAL_MEMORY(motion.process.noise_root, scaled.process.noise_root, sizeof(word) * S_ROOT_LEN(2));
}

TEST(no_noise_stays_none)
{
    static const num singular[] = {0, 0, 0, 1};
    reading now;
    put_process(&motion, 2, 1, range, drive_range, A, B, singular);
    ASSERT_OK(scale_noise(&scaled, &motion, number(65536)));
    TEST_ASSERT_TRUE(scaled.process.noise_root[0] == motion.process.noise_root[0]);
    ASSERT_OK(scale_noise(&scaled, &motion, number(0)));
    ASSERT_OK(init_filter(&track, &certain));
    ASSERT_OK(S(predict)(&track, &scaled.process, u));
    read_now(&now, &track, 2);
    for (int k = 0; k < 4; k++) ASSERT_WITHIN(TINY_SIGMA * TINY_SIGMA * 4, 0, now.P[k]);
}

#ifdef KQ_TEST_Q31 /* which exponents it has */
static const kq_scaled_q31 one = {INT32_C(1) << 30, -30};

/* It is written as a whole: nothing of it is looked at. */
TEST_Q31(a_target_needs_nothing_before)
{
    kq_process_q31 fresh;
    memset(&fresh, 0xa5, sizeof fresh);
    ASSERT_OK(kq_process_scale_noise_q31(&fresh, &motion.process, scaled.noise_root, one));
    TEST_ASSERT_EQUAL_UINT8(motion.process.states, fresh.states);
    TEST_ASSERT_TRUE(fresh.noise_root == scaled.noise_root && fresh.transition == motion.transition);
}

TEST_Q31(powers_of_4_move_the_exponents_alone)
{
    static const kq_scaled_q31 zero = {0, 0};
    for (int k = -3; k < 8; k++) {
        const kq_scaled_q31 factor = {one.mantissa, one.exponent + 2 * k};
        ASSERT_OK(kq_process_scale_noise_q31(&scaled.process, &motion.process, scaled.noise_root, factor));
        for (int i = 0; i < 3; i++) TEST_ASSERT_EQUAL_INT32(motion.noise_root[i], scaled.noise_root[i]);
        for (int i = 3; i < 5; i++) TEST_ASSERT_EQUAL_INT32(motion.noise_root[i] + k, scaled.noise_root[i]);
    }
    ASSERT_OK(kq_process_scale_noise_q31(&scaled.process, &motion.process, scaled.noise_root, zero));
    for (int i = 0; i < 3; i++) TEST_ASSERT_EQUAL_INT32(0, scaled.noise_root[i]);
    ASSERT_OK(kq_predict_q31(&track, &scaled.process, NULL));
}

TEST_Q31(a_noise_too_small_to_be_held_is_refused)
{
    for (int32_t exponent = -1000; exponent < -960; exponent++) {
        motion.noise_root[3] = exponent;
        ASSERT_OK(kq_process_init_q31(&motion.process, &motion.table, NULL));
        const kq_status status = kq_process_scale_noise_q31(&scaled.process, &motion.process, scaled.noise_root, one);
        TEST_ASSERT_EQUAL_INT(exponent < 32 - 1000 ? KQ_ERR_COEFFICIENT : KQ_OK, status);
    }
}

/* A factor of the root that would take its exponents beyond those of a table */
TEST_Q31(exponents_stay_within_their_limits)
{
    for (int exponent = -1000; exponent <= 1000; exponent += 2000) {
        const kq_scaled_q31 factor = {one.mantissa, exponent};
        kq_process_q31 again;
        int32_t other[KQ_ROOT_LEN_Q31(2)];
        ASSERT_OK(kq_process_scale_noise_q31(&scaled.process, &motion.process, scaled.noise_root, factor));
        kq_status status = KQ_OK;
        for (int k = 0; k < 4 && !status; k++) {
            status = kq_process_scale_noise_q31(&again, &scaled.process, other, factor);
            if (!status) status = kq_process_scale_noise_q31(&scaled.process, &again, scaled.noise_root, factor);
        }
        TEST_ASSERT_EQUAL_INT(KQ_ERR_COEFFICIENT, status);
        ASSERT_OK(kq_predict_q31(&track, &scaled.process, NULL));
    }
}
#endif

/* ------------------------------------------------------------------------------ the smoother */

static void record(S(filter) *f, S(history) *h)
{
    ASSERT_OK(init_filter(f, &prior));
    ASSERT_OK(S(attach)(f, &h->attached));
    for (int t = 0; t < REWEIGHTED; t++) {
        ASSERT_OK(S(update)(f, sensor_at(t), seen(t < 3 ? 1 + t : 20 + t, 0.5 * t)));
        ASSERT_OK(scale_noise(&scaled, &motion, q[t]));
        ASSERT_OK(S(predict)(f, &scaled.process, u));
    }
}

/* Three passes: each q is that of the noise that the smoother tells of its step, `square` of it of rank `rank`. */
static void assert_reweighted(double (*square)(const num *mean, const num *C), double nu, int rank)
{
    for (int pass = 0; pass < 3; pass++) {
        entry used[REWEIGHTED];
        reading a, b;
        memcpy(used, q, sizeof used);
        record(&track, &tape);
        record(&twin, &twin_tape);
        ASSERT_OK(smooth_reweighted(&tape, &scaled, &motion, number(nu), q));
        num lag_one[4], mean[2], C[4];
        ASSERT_OK(step_back(&twin_tape, NULL, &prior, lag_one, mean, C));
        for (int t = REWEIGHTED - 1; t >= 0; t--) {
            ASSERT_OK(scale_noise(&scaled, &motion, used[t]));
            ASSERT_OK(step_back(&twin_tape, &scaled.process, &prior, lag_one, mean, C));
            const double expected = (nu + square(mean, C)) / (nu + rank);
            ASSERT_ALIKE(expected, number_of(q[t]), 64 * expected);
        }
        for (size_t t = 0; t <= REWEIGHTED; t++) {
            read_smoothed_at(&a, &twin_tape, t, &prior, 2);
            read_smoothed_at(&b, &tape, t, &prior, 2);
            ASSERT_SAME_BITS(a, b);
        }
    }
    ASSERT_WITHIN(0, 1, number_of(q[REWEIGHTED])); /* not written behind the last one */
}

/* E[w'Q^-1 w | T], from the noise's mean and covariance */
static double square_by_inverse(const num *mean, const num *C)
{
    const double d = (double)Q[0] * (double)Q[3] - (double)Q[1] * (double)Q[1];
    const double a = (double)mean[0] * (double)mean[0] + (double)C[0];
    const double b = (double)mean[0] * (double)mean[1] + (double)C[1];
    const double c = (double)mean[1] * (double)mean[1] + (double)C[3];
    return ((double)Q[3] * a - 2 * (double)Q[1] * b + (double)Q[0] * c) / d;
}

TEST(reweighting_follows_the_smoothed_noise)
{
    assert_reweighted(square_by_inverse, 2, 2);
    TEST_ASSERT_TRUE(number_of(q[2]) > 4 * number_of(q[0])); /* the jump is found */
}

/* Only what moves the state counts: noise of rank 1 in two states as in one. */
static double square_of_rank_1(const num *mean, const num *C)
{
    return ((double)mean[1] * (double)mean[1] + (double)C[3]) / 2;
}

TEST(noise_of_less_rank_counts_by_its_rank)
{
    static const num F[] = {N(0.70710678118654752), N(1.41421356237309505)};
#ifdef KQ_TEST_Q31
    ASSERT_OK(kq_root_prepare_factor_q31(motion.noise_root, F, 2, 1, motion.state_format));
#else
    ASSERT_OK(K(process_init_factor)(&motion.process, A, B, F, 1));
#endif
    assert_reweighted(square_of_rank_1, 3, 1);
}

TEST(a_history_that_is_full_or_smoothed_is_refused)
{
    record(&track, &tape);
    for (int t = 0; t < STEPS; t++) ASSERT_OK(S(predict)(&track, &motion.process, u));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, smooth_reweighted(&tape, &scaled, &motion, number(2), q));
    record(&track, &tape);
    ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, smooth_reweighted(&tape, &scaled, &motion, number(2), q));
    record(&track, &tape);
    ASSERT_OK(smooth_reweighted(&tape, &scaled, &motion, number(2), q));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, smooth_reweighted(&tape, &scaled, &motion, number(2), q));
}

SUITE(robust, set_up)
#include "robust.tests"
