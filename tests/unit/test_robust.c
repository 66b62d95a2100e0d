/* Outliers and jumps: the losses, scaled noise, the reweighted smoother. */
#include "losses.h"
#include "reading.h"
#include "sizes.h"
#include "unchanged.h"

PROCESS(motion, 2, 1);
PROCESS(scaled, 2, 1);
SENSOR(radar, 2, 2);
SENSOR(coupled, 2, 2);
FILTER(track, 2);
FILTER(twin, 2);
HISTORY(tape, 2, 2, 8, 0);
HISTORY(twin_tape, 2, 2, 8, 0);

SENSOR(level, 1, 1);
FILTER(river, 1);
FILTER(other_river, 1);

/* never initialised, and of another size */
FILTER(blank, 2);
SENSOR(blank_sensor, 2, 2);
PROCESS(blank_process, 2, 1);
PROCESS(motion3, 3, 0);
SENSOR(radar3, 3, 1);
HISTORY(blank_tape, 2, 2, 2, 0);

static const num A[] = {1, 0.5, 0, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1}, r[] = {0.5, 1};
static const num identity3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static const num one[] = {1}, none[] = {0}, none2[] = {0, 0};

static num z[2], u[1], weights[2], q[8];
static K(loss) gate;

#define ALL UINT32_MAX

static void set_up(void)
{
    static const num measured[] = {3, 1};
    memcpy(z, measured, sizeof z);
    u[0] = 4;
    for (int t = 0; t < COUNT(q); t++) q[t] = 1;
    gate = (K(loss)){.kind = &K(loss_gate), .limit = K(chi_square_limit)(2, KQ_LEVEL_99), .run = 3};
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    ASSERT_OK(K(process_init)(&motion3, identity3, NULL, identity3));
    ASSERT_OK(K(sensor_init_diagonal)(&radar, H, r));
    ASSERT_OK(K(sensor_init)(&coupled, H, R));
    ASSERT_OK(K(sensor_init)(&radar3, identity3, identity3));
    ASSERT_OK(K(sensor_init)(&level, one, one));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(filter_init)(&river, none, one));
    ASSERT_OK(K(filter_init)(&other_river, none, one));
    watch_nothing();
    WATCH(motion), WATCH(motion_memory), WATCH(scaled), WATCH(scaled_memory);
    WATCH(radar), WATCH(radar_memory), WATCH(track), WATCH(track_memory);
    WATCH(tape), WATCH(tape_memory), WATCH(gate), WATCH(u), WATCH(z), WATCH(weights), WATCH(q);
}

/* ------------------------------------------------------------------------------ the gate */

TEST(a_gate_that_passes_is_the_plain_update)
{
    const K(sensor) * sensors[] = {&radar, &coupled};
    for (int k = 0; k < 6; k++) {
        const uint32_t present = k % 3 == 2 ? 2 : ALL;
        ASSERT_OK(K(update_robust)(&track, sensors[k % 2], z, present, &gate));
        ASSERT_OK(K(update_subset)(&twin, sensors[k % 2], z, present));
        ASSERT_SAME_FILTER(&twin, &track, 2);
        ASSERT_OK(K(predict)(&track, &motion, u));
        ASSERT_OK(K(predict)(&twin, &motion, u));
        z[0] = N(4.5 + k), z[1] = N(2 + k);
    }
    TEST_ASSERT_EQUAL_INT(0, gate.rejected);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
}

TEST(a_rejected_measurement_leaves_its_nis_and_an_event)
{
    ASSERT_OK(K(update)(&track, &radar, z));
    ASSERT_OK(K(update)(&twin, &radar, z));
    const num run = K(log_likelihood)(&track);
    z[0] = 50;
    ASSERT_OK(K(update_robust)(&track, &radar, z, ALL, &gate));
    ASSERT_SAME_STATE(&twin, &track, 2);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED, K(events)(&track));
    TEST_ASSERT_EQUAL_INT(0, K(taken)(&track));
    ASSERT_WITHIN(0, 0, K(log_likelihood_last)(&track));
    ASSERT_WITHIN(0, run, K(log_likelihood)(&track));
    ASSERT_OK(K(update)(&twin, &radar, z));
    ASSERT_WITHIN(0, K(nis)(&twin), K(nis)(&track));
    TEST_ASSERT_TRUE(K(nis)(&track) > gate.limit);
}

TEST(a_history_knows_nothing_of_a_rejected_measurement)
{
    reading a, b;
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK(K(attach)(&twin, &twin_tape.attached));
    gate.limit = 100;
    for (int t = 0; t < 4; t++) {
        z[0] = N(3 + t);
        ASSERT_OK(K(update_robust)(&track, &radar, z, ALL, &gate));
        TEST_ASSERT_EQUAL_INT(2, K(taken)(&track));
        ASSERT_OK(K(update)(&twin, &radar, z));
        z[0] = -400;
        ASSERT_OK(K(update_robust)(&track, &coupled, z, ALL, &gate));
        TEST_ASSERT_EQUAL_INT(0, K(taken)(&track));
        ASSERT_OK(K(predict)(&track, &motion, u));
        ASSERT_OK(K(predict)(&twin, &motion, u));
    }
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_OK(K(smooth)(&twin_tape));
    for (size_t t = 0; t < 5; t++) {
        read_smoothed(&a, &twin_tape, t, 2);
        read_smoothed(&b, &tape, t, 2);
        ASSERT_SAME_BITS(a, b);
    }
}

/* Even where the rejected one had no room on it */
TEST(a_full_history_is_full_because_of_what_is_taken_only)
{
    HISTORY(short_tape, 2, 2, 1, 0);
    ASSERT_OK(K(attach)(&track, &short_tape.attached));
    ASSERT_OK(K(update_robust)(&track, &radar, z, ALL, &gate));
    z[0] = 50;
    ASSERT_OK(K(update_robust)(&track, &radar, z, ALL, &gate));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED, K(events)(&track));
    ASSERT_OK(K(smooth)(&short_tape));
}

TEST(a_run_of_rejections_ends_with_a_jump)
{
    static const uint16_t runs[] = {0, 1, 3, 20};
    num good[] = {1, -1.5};
    z[0] = 50;
    for (int j = 0; j < COUNT(runs); j++) {
        ASSERT_OK(K(filter_init)(&track, x0, P0));
        gate.run = runs[j];
        const int most = (int)(runs[j] ? runs[j] : KQ_GATE_RUN);
        for (int k = 1; k <= most; k++) {
            ASSERT_OK(K(update_robust)(&track, &radar, z, ALL, &gate));
            TEST_ASSERT_EQUAL_INT(k, gate.rejected);
            ASSERT_OK(K(update_robust)(&track, &radar, z, 0, &gate)); /* nothing measured */
            TEST_ASSERT_EQUAL_INT(k, gate.rejected);
            TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED, K(events)(&track));
        }
        K(events_clear)(&track);
        ASSERT_OK(K(filter_init)(&twin, x0, P0));
        ASSERT_OK(update_jump(&twin, &radar, z, ALL, 1));
        ASSERT_OK(K(update_robust)(&track, &radar, z, ALL, &gate));
        ASSERT_SAME_STATE(&twin, &track, 2);
        ASSERT_WITHIN(0, K(nis)(&twin), K(nis)(&track));
        TEST_ASSERT_EQUAL_INT(2, K(taken)(&track));
        TEST_ASSERT_EQUAL_INT(0, gate.rejected);
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_JUMP | KQ_EVENT_REJECTIONS, K(events)(&track));
        ASSERT_OK(K(update_robust)(&track, &radar, z, ALL, &gate)); /* as it is where it should be */
        TEST_ASSERT_EQUAL_INT(2, K(taken)(&track));
    }
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(update_robust)(&track, &radar, z, ALL, &gate));
    TEST_ASSERT_EQUAL_INT(1, gate.rejected);
    ASSERT_OK(K(update_robust)(&track, &radar, good, ALL, &gate));
    TEST_ASSERT_EQUAL_INT(0, gate.rejected);
}

TEST(a_gate_may_stay_closed)
{
    z[0] = 50;
    gate.run = KQ_GATE_CLOSED;
    gate.rejected = UINT16_MAX - 1;
    for (int k = 0; k < 3; k++) {
        ASSERT_OK(K(update_robust)(&track, &radar, z, ALL, &gate));
        TEST_ASSERT_EQUAL_UINT(UINT16_MAX, gate.rejected);
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED, K(events)(&track));
    }
}

/* A raised P is nothing that a history could undo: there the measurement is taken as it is. */
TEST(a_run_of_rejections_ends_on_a_history)
{
    reading a, b;
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK(K(attach)(&twin, &twin_tape.attached));
    z[0] = 50;
    gate.run = 2;
    for (int t = 0; t < 6; t++) {
        const int taken = t == 2 || t == 5;
        ASSERT_OK(K(update_robust)(&track, &radar, z, ALL, &gate));
        TEST_ASSERT_EQUAL_INT(taken ? 2 : 0, K(taken)(&track));
        if (taken) ASSERT_OK(K(update)(&twin, &radar, z));
        ASSERT_OK(K(predict)(&track, &motion, u));
        ASSERT_OK(K(predict)(&twin, &motion, u));
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED | KQ_EVENT_REJECTIONS, K(events)(&track));
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_OK(K(smooth)(&twin_tape));
    for (size_t t = 0; t < 7; t++) {
        read_smoothed(&a, &twin_tape, t, 2);
        read_smoothed(&b, &tape, t, 2);
        ASSERT_SAME_BITS(a, b);
    }
}

TEST(a_gate_works_at_every_size)
{
    static num words[2][FILTER_LEN(16)], sensor_words[KQ_SENSOR_DIAGONAL_LEN(16)];
    static num I[256], x[16], far[16], near[16], unit[16];
    K(filter) f, g;
    K(sensor) s;
    for (int n = 1; n <= 16; n++) {
        put_identity(I, n, 1);
        for (int i = 0; i < n; i++) far[i] = 30, near[i] = 0.25, unit[i] = 1;
        ASSERT_OK(K(filter_assign)(&f, n, words[0], FILTER_LEN(16)));
        ASSERT_OK(K(filter_assign)(&g, n, words[1], FILTER_LEN(16)));
        ASSERT_OK(K(sensor_assign)(&s, n, n, sensor_words, COUNT(sensor_words)));
        ASSERT_OK(K(sensor_init_diagonal)(&s, I, unit));
        ASSERT_OK(K(filter_init)(&f, x, I));
        ASSERT_OK(K(filter_init)(&g, x, I));
        gate.limit = K(chi_square_limit)(n, KQ_LEVEL_9999);
        ASSERT_OK(K(update_robust)(&f, &s, far, ALL, &gate));
        ASSERT_OK(K(update_robust)(&f, &s, near, ALL, &gate));
        ASSERT_OK(K(update)(&g, &s, near));
        TEST_ASSERT_EQUAL_MEMORY(words[1], words[0], sizeof(num) * (size_t)FILTER_LEN(n));
        TEST_ASSERT_EQUAL_INT(n, K(taken)(&f));
    }
}

TEST(refusals_of_the_gate)
{
    ASSERT_REFUSED(KQ_ERR_NULL, K(update_robust)(NULL, &radar, z, ALL, &gate));
    ASSERT_REFUSED(KQ_ERR_NULL, K(update_robust)(&track, &radar, z, ALL, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(update_robust)(&track, &radar, z, ALL, &(K(loss)){.kind = NULL, .parameter = 3}));
    ASSERT_REFUSED(KQ_ERR_NULL, K(update_robust)(&track, NULL, z, ALL, &gate));
    ASSERT_REFUSED(KQ_ERR_NULL, K(update_robust)(&track, &radar, NULL, ALL, &gate));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update_robust)(&blank, &radar, z, ALL, &gate));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update_robust)(&track, &blank_sensor, z, ALL, &gate));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(update_robust)(&track, &radar3, z, ALL, &gate));
    z[1] = (num)NAN;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(update_robust)(&track, &radar, z, ALL, &gate));
    ASSERT_OK(K(update_robust)(&track, &radar, z, 1, &gate));
    z[1] = 1;
    const num bad[] = {0, -1, (num)NAN};
    for (int k = 0; k < COUNT(bad); k++) {
        gate.limit = bad[k];
        ASSERT_REFUSED(KQ_ERR_RANGE, K(update_robust)(&track, &radar, z, ALL, &gate));
    }
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
            const double x = (double)K(chi_square_limit)(m, (kq_level)k);
            ASSERT_WITHIN(1e-7 + 300 * EPS, level[k], chi_square_probability(m, x));
        }
    }
    ASSERT_NAN(K(chi_square_limit)(0, KQ_LEVEL_99));
    ASSERT_NAN(K(chi_square_limit)(17, KQ_LEVEL_99));
    ASSERT_NAN(K(chi_square_limit)(1, (kq_level)5));
}

/* ------------------------------------------------------------------------------ the two weights */

static void assert_states_within(const K(filter) * a, const K(filter) * b, double tolerance)
{
    num P[4], C[4];
    ASSERT_OK(K(covariance)(a, P));
    ASSERT_OK(K(covariance)(b, C));
    for (int i = 0; i < 2; i++) ASSERT_WITHIN(tolerance, whole_mean(a, i), whole_mean(b, i));
    for (int k = 0; k < 4; k++) ASSERT_WITHIN(tolerance, P[k], C[k]);
}

TEST(what_is_not_clipped_is_taken_as_it_is)
{
    const K(sensor) * sensors[] = {&radar, &coupled};
    for (int k = 0; k < 6; k++) {
        const uint32_t present = k % 3 == 2 ? 1 : ALL;
        ASSERT_OK(update_huber(&track, sensors[k % 2], z, present, N(1e6), weights));
        ASSERT_OK(K(update_subset)(&twin, sensors[k % 2], z, present));
        ASSERT_SAME_STATE(&twin, &track, 2);
        ASSERT_CLOSE(K(nis)(&twin), K(nis)(&track), 4 + K(nis)(&twin));
        ASSERT_CLOSE(K(log_likelihood)(&twin), K(log_likelihood)(&track),
                     4 - K(log_likelihood)(&twin));
        TEST_ASSERT_EQUAL_INT(K(taken)(&twin), K(taken)(&track));
        ASSERT_WITHIN(0, 1, weights[0]);
        ASSERT_WITHIN(0, present & 2 ? 1 : 0, weights[1]);
        ASSERT_OK(K(predict)(&track, &motion, u));
        ASSERT_OK(K(predict)(&twin, &motion, u));
        z[0] = N(k - 2);
    }
}

TEST(a_student_of_many_degrees_is_gaussian)
{
    for (int k = 0; k < 6; k++) {
        const K(sensor) *s = k % 2 ? &radar : &coupled;
        ASSERT_OK(update_student(&track, s, z, ALL, N(1e30), weights));
        ASSERT_OK(K(update)(&twin, s, z));
        assert_states_within(&twin, &track, TOLERANCE * 16);
        ASSERT_CLOSE(1, weights[0], 1);
        ASSERT_OK(K(predict)(&track, &motion, u));
        ASSERT_OK(K(predict)(&twin, &motion, u));
    }
}

/* The mean moves as by an innovation of k sigma, and as a Gaussian of the noise R / weight would
   move it; what is told is that of R. */
TEST(huber_clips_the_innovation)
{
    const double s = 2, e = 10, k = 1.5, moved = k * sqrt(s) / s;
    num measured[] = {N(e)}, variance[1];
    SENSOR(weak, 1, 1);
    ASSERT_OK(update_huber(&river, &level, measured, ALL, N(k), weights));
    ASSERT_CLOSE(moved, whole_mean(&river, 0), 4);
    ASSERT_CLOSE(e * e / s, K(nis)(&river), e * e);
    ASSERT_CLOSE(-0.5 * (log(2 * 3.14159265358979324 * s) + e * e / s), K(log_likelihood)(&river),
                 e * e);
    variance[0] = 1 / weights[0];
    ASSERT_CLOSE(e * sqrt(s) / k - 1, variance[0], 16);
    ASSERT_OK(K(sensor_init)(&weak, one, variance));
    ASSERT_OK(K(update)(&other_river, &weak, measured));
    ASSERT_CLOSE(K(sigma)(&other_river, 0), K(sigma)(&river, 0), 1);
    ASSERT_OK(K(filter_init)(&river, none, one));
    measured[0] = -N(e);
    ASSERT_OK(update_huber(&river, &level, measured, ALL, N(k), NULL));
    ASSERT_CLOSE(-moved, whole_mean(&river, 0), 4);
}

TEST(student_reweights_three_times)
{
    const double nu = 4, e = 7;
    const num measured[] = {N(e)};
    double heavy = 1;
    for (int k = 0; k < 3; k++) {
        const double s = 1 + heavy, v = e * heavy / s;
        heavy = (nu + v * v + heavy / s) / (nu + 1);
    }
    ASSERT_OK(update_student(&river, &level, measured, ALL, N(nu), weights));
    ASSERT_CLOSE(1 / heavy, weights[0], 1);
    ASSERT_CLOSE(e / (1 + heavy), whole_mean(&river, 0), e);
    ASSERT_CLOSE(sqrt(heavy / (1 + heavy)), K(sigma)(&river, 0), 1);
    ASSERT_CLOSE(e * e / 2, K(nis)(&river), e * e);
}

/* What the smoother undoes is the update that was done. */
TEST(the_smoother_has_the_noise_that_was_used)
{
    reading a, b;
    num noise_now[2];
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK(K(attach)(&twin, &twin_tape.attached));
    for (int t = 0; t < 5; t++) {
        z[0] = t == 2 ? N(60) : N(3 + t), z[1] = t == 3 ? N(-30) : N(1 + t);
        ASSERT_OK(update_student(&track, &radar, z, ALL, 4, weights));
        TEST_ASSERT_TRUE(t != 2 || weights[0] < N(0.01));
        for (int c = 0; c < 2; c++) noise_now[c] = r[c] / weights[c];
        ASSERT_OK(K(sensor_init_diagonal)(&radar, H, noise_now));
        ASSERT_OK(K(update)(&twin, &radar, z));
        ASSERT_OK(K(sensor_init_diagonal)(&radar, H, r));
        assert_states_within(&twin, &track, 16 * TOLERANCE);
        ASSERT_OK(K(predict)(&track, &motion, u));
        ASSERT_OK(K(predict)(&twin, &motion, u));
    }
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_OK(K(smooth)(&twin_tape));
    for (size_t t = 0; t < 6; t++) {
        read_smoothed(&a, &twin_tape, t, 2);
        read_smoothed(&b, &tape, t, 2);
        for (int i = 0; i < 2; i++) ASSERT_CLOSE(a.mean[i], b.mean[i], 64);
        for (int k = 0; k < 4; k++) ASSERT_CLOSE(a.P[k], b.P[k], 16);
    }
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

typedef kq_status robust_update(K(filter) * f, const K(sensor) * s, const num *values,
                                uint32_t present, num parameter);

static kq_status huber(K(filter) * f, const K(sensor) * s, const num *values, uint32_t present,
                       num parameter)
{
    return update_huber(f, s, values, present, parameter, weights);
}

static kq_status student(K(filter) * f, const K(sensor) * s, const num *values, uint32_t present,
                         num parameter)
{
    return update_student(f, s, values, present, parameter, weights);
}

static kq_status jump(K(filter) * f, const K(sensor) * s, const num *values, uint32_t present,
                      num parameter)
{
    return update_jump(f, s, values, present, parameter);
}

/* Twins without noise that say different things.  The plain update takes one of them: so do the
   robust ones, and P is as it leaves it. */
TEST(what_the_plain_update_does_not_take_no_robust_one_takes)
{
    robust_update *updates[] = {huber, student, jump};
    static const num same[] = {N(0.3), N(0.7), N(0.3), N(0.7)}, wide[] = {1, 0, 0, 2};
    static const num values[][2] = {{1, 2}, {1, 1}, {N(0.5), -3}};
    SENSOR(twins, 2, 2);
    ASSERT_OK(K(sensor_init_diagonal)(&twins, same, none2));
    for (int k = 0; k < COUNT(values) * COUNT(updates); k++) {
        const num *seen = values[k / COUNT(updates)];
        ASSERT_OK(K(filter_init)(&track, none2, wide));
        ASSERT_OK(K(filter_init)(&twin, none2, wide));
        ASSERT_OK(K(update)(&twin, &twins, seen));
        ASSERT_OK(updates[k % COUNT(updates)](&track, &twins, seen, ALL, 9));
        TEST_ASSERT_EQUAL_INT(1, K(taken)(&track));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&track));
        assert_states_within(&twin, &track, TOLERANCE);
        if (updates[k % COUNT(updates)] != jump) ASSERT_WITHIN(0, 0, weights[1]);
    }
}

/* The history knows nothing of it. */
TEST(what_is_not_taken_is_not_recorded)
{
    reading a, b;
    static const num same[] = {N(0.3), N(0.7), N(0.3), N(0.7)}, values[] = {1, 2};
    SENSOR(twins, 2, 2);
    ASSERT_OK(K(sensor_init_diagonal)(&twins, same, none2));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK(K(attach)(&twin, &twin_tape.attached));
    for (int t = 0; t < 3; t++) {
        ASSERT_OK(update_huber(&track, &twins, values, ALL, 9, NULL));
        ASSERT_OK(K(update)(&twin, &twins, values));
        ASSERT_OK(K(predict)(&track, &motion, u));
        ASSERT_OK(K(predict)(&twin, &motion, u));
    }
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_OK(K(smooth)(&twin_tape));
    for (size_t t = 0; t < 4; t++) {
        read_smoothed(&a, &twin_tape, t, 2);
        read_smoothed(&b, &tape, t, 2);
        ASSERT_SAME_BITS(a, b);
    }
}

/* After a sharp one: noise r is above the floor, what is left of the state is not, and raised P would
   bring both below it. */
TEST(nothing_is_raised_for_what_is_not_taken)
{
    static const num same[] = {N(0.3), N(0.7), N(0.3), N(0.7)}, wide[] = {1, 0, 0, 2};
    static const num wild[] = {N(0.5), -3}, agreeing[] = {1, 1};
    SENSOR(twins, 2, 2);
    for (double variance = 0; variance < 1; variance = variance * 4 + EPS * EPS) {
        const num noises[] = {0, N(variance)};
        ASSERT_OK(K(sensor_init_diagonal)(&twins, same, noises));
        for (int k = 0; k < 2; k++) {
            ASSERT_OK(K(filter_init)(&track, none2, wide));
            ASSERT_OK(update_jump(&track, &twins, k ? agreeing : wild, ALL, 9));
            const unsigned raised = K(events)(&track) & KQ_EVENT_JUMP;
            TEST_ASSERT_FALSE(raised && K(taken)(&track) < 2);
            if (K(taken)(&track) == 2) continue;
            ASSERT_WITHIN(TOLERANCE, sqrt(0.98 / 1.07), K(sigma)(&track, 0));
            TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&track));
        }
    }
}

/* A component without noise whose innovation is as far as that: the plain update takes it and says
   so. */
TEST(a_contradiction_is_told_by_all)
{
    robust_update *updates[] = {huber, student, jump};
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

/* With fewer degrees of freedom nothing of r would be left in r'. */
TEST(a_student_has_some_freedom)
{
    static const double least = 0x1p-20;
    ASSERT_REFUSED(KQ_ERR_RANGE, student(&track, &radar, z, ALL, N(least * (1 - EPS))));
    ASSERT_REFUSED(KQ_ERR_RANGE, student(&track, &radar, z, ALL, N(TINY_SIGMA)));
    for (double variance = 1; variance < MOST_SIGMA; variance *= 64) {
        const num noises[] = {N(variance)};
        ASSERT_OK(K(sensor_init)(&level, one, noises));
        for (double far = 1e-6; far < 1e6; far *= 10) {
            const num measured[] = {N(far)};
            ASSERT_OK(K(filter_init)(&river, none, one));
            ASSERT_OK(student(&river, &level, measured, ALL, N(least)));
            TEST_ASSERT_TRUE(K(sigma)(&river, 0) > 0 && K(sigma)(&river, 0) <= 1);
            TEST_ASSERT_EQUAL_HEX(0, K(events)(&river) & ~(unsigned)KQ_EVENT_CONTRADICTION);
        }
    }
}

TEST(refusals_of_an_update)
{
    robust_update *updates[] = {huber, student, jump};
    for (int k = 0; k < COUNT(updates); k++) {
        ASSERT_REFUSED(KQ_ERR_NULL, updates[k](NULL, &radar, z, ALL, 4));
        ASSERT_REFUSED(KQ_ERR_NULL, updates[k](&track, NULL, z, ALL, 4));
        ASSERT_REFUSED(KQ_ERR_NULL, updates[k](&track, &radar, NULL, ALL, 4));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, updates[k](&blank, &radar, z, ALL, 4));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, updates[k](&track, &blank_sensor, z, ALL, 4));
        ASSERT_REFUSED(KQ_ERR_MISMATCH, updates[k](&track, &radar3, z, ALL, 4));
        ASSERT_REFUSED(KQ_ERR_RANGE, updates[k](&track, &radar, z, ALL, 0));
        ASSERT_REFUSED(KQ_ERR_RANGE, updates[k](&track, &radar, z, ALL, -1));
        ASSERT_REFUSED(KQ_ERR_NOT_FINITE, updates[k](&track, &radar, z, ALL, (num)NAN));
        ASSERT_REFUSED(KQ_ERR_NOT_FINITE, updates[k](&track, &radar, z, ALL, (num)INFINITY));
        z[1] = (num)INFINITY;
        ASSERT_REFUSED(KQ_ERR_NOT_FINITE, updates[k](&track, &radar, z, ALL, 4));
        z[1] = 1;
    }
    ASSERT_REFUSED(KQ_ERR_RANGE, jump(&track, &radar, z, ALL, N(0.5)));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, jump(&track, &radar, z, ALL, 4));
    ASSERT_OK(K(detach)(&tape.attached));
    ASSERT_OK(jump(&track, &radar, z, ALL, 4));
}

/* ------------------------------------------------------------------------------ jumps */

TEST(without_a_jump_the_update_is_plain)
{
    for (int k = 0; k < 4; k++) {
        const K(sensor) *s = k % 2 ? &radar : &coupled;
        ASSERT_OK(update_jump(&track, s, z, k == 3 ? 2 : ALL, 1000));
        ASSERT_OK(K(update_subset)(&twin, s, z, k == 3 ? 2 : ALL));
        ASSERT_SAME_STATE(&twin, &track, 2);
        TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    }
}

/* S = v^2: P is c^2 times what it was, c^2 = (v^2 - r) / (S - r). */
TEST(a_jump_raises_the_covariance)
{
    num raised[4], measured[] = {31, 0};
    const double c = (900 - 0.5) / 2;
    for (int k = 0; k < 4; k++) raised[k] = N(c * (double)P0[k]);
    ASSERT_OK(K(filter_init)(&twin, x0, raised));
    ASSERT_OK(update_jump(&track, &radar, measured, 1, 9));
    ASSERT_OK(K(update_subset)(&twin, &radar, measured, 1));
    assert_states_within(&twin, &track, TOLERANCE * 1000);
    ASSERT_CLOSE(900 / 2.5, K(nis)(&track), 900);
    TEST_ASSERT_EQUAL_INT(1, K(taken)(&track));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_JUMP, K(events)(&track));
    ASSERT_CLOSE(1, K(nis)(&twin), 4);
}

/* A state that is known does not jump. */
TEST(what_has_no_variance_does_not_jump)
{
    num measured[] = {31};
    ASSERT_OK(K(filter_init)(&river, none, none));
    ASSERT_OK(update_jump(&river, &level, measured, ALL, 4));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&river));
    ASSERT_WITHIN(0, 0, K(mean)(&river, 0));
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

/* ------------------------------------------------------------------------------ scaled noise */

TEST(scaled_noise_is_that_of_the_scaled_covariance)
{
    static const double factors[] = {0.25, 1, 3, 65536};
    num raised[4];
    PROCESS(direct, 2, 1);
    for (int k = 0; k < COUNT(factors); k++) {
        for (int i = 0; i < 4; i++) raised[i] = N(factors[k] * (double)Q[i]);
        ASSERT_OK(K(process_init)(&direct, A, B, raised));
        ASSERT_OK(K(process_scale_noise)(&scaled, &motion, N(factors[k])));
        ASSERT_OK(K(filter_init)(&track, x0, P0));
        ASSERT_OK(K(filter_init)(&twin, x0, P0));
        ASSERT_OK(K(predict)(&track, &scaled, u));
        ASSERT_OK(K(predict)(&twin, &direct, u));
        assert_states_within(&twin, &track, TOLERANCE * (1 + factors[k]));
    }
    ASSERT_OK(K(process_scale_noise)(&scaled, &motion, 1));
    ASSERT_SAME_BITS(motion_memory, scaled_memory);
}

TEST(no_noise_stays_none)
{
    static const num singular[] = {0, 0, 0, 1};
    num P[4];
    ASSERT_OK(K(process_init)(&motion, A, B, singular));
    ASSERT_OK(K(process_scale_noise)(&scaled, &motion, 65536));
    TEST_ASSERT_TRUE(scaled_memory[0] == motion_memory[0]);
    ASSERT_OK(K(process_scale_noise)(&scaled, &motion, 0));
    ASSERT_OK(K(filter_init)(&track, x0, (const num[]){0, 0, 0, 0}));
    ASSERT_OK(K(predict)(&track, &scaled, u));
    ASSERT_OK(K(covariance)(&track, P));
    for (int k = 0; k < 4; k++) ASSERT_WITHIN(TINY_SIGMA * TINY_SIGMA * 4, 0, P[k]);
}

TEST(refusals_of_scaling)
{
    static const num immense[] = {N(MOST_SIGMA * MOST_SIGMA), 0, 0, N(MOST_SIGMA * MOST_SIGMA)};
    K(process) nothing;
    memset(&nothing, 0, sizeof nothing);
    ASSERT_REFUSED(KQ_ERR_NULL, K(process_scale_noise)(NULL, &motion, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(process_scale_noise)(&scaled, NULL, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(process_scale_noise)(&scaled, &blank_process, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(process_scale_noise)(&motion, &motion, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(process_scale_noise)(&scaled, &motion3, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(process_scale_noise)(&scaled, &motion, (num)NAN));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(process_scale_noise)(&scaled, &motion, (num)INFINITY));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(process_scale_noise)(&scaled, &motion, -1));
    ASSERT_REFUSED_SIZE_OR_MEMORY(K(process_scale_noise)(&nothing, &motion, 1));
    ASSERT_OK(K(process_init)(&motion, A, B, immense));
    ASSERT_OK(K(process_scale_noise)(&scaled, &motion, NUM_MAX / 4));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(process_scale_noise)(&motion, &scaled, NUM_MAX / 4));
}

/* ------------------------------------------------------------------------------ the smoother */

static void record(K(filter) * f, K(history) * h, const num *scale)
{
    ASSERT_OK(K(filter_init)(f, x0, P0));
    ASSERT_OK(K(attach)(f, &h->attached));
    for (int t = 0; t < 6; t++) {
        z[0] = t < 3 ? N(1 + t) : N(20 + t), z[1] = N(0.5 * t);
        ASSERT_OK(K(update)(f, t % 2 ? &radar : &coupled, z));
        ASSERT_OK(K(process_scale_noise)(&scaled, &motion, scale ? scale[t] : 1));
        ASSERT_OK(K(predict)(f, &scaled, u));
    }
}

/* E[w'Q^-1 w | T] of the step that was smoothed last, from what kq_smooth_step tells */
static double expected_square(const num *mean, const num *C)
{
    const double d = (double)Q[0] * (double)Q[3] - (double)Q[1] * (double)Q[1];
    const double a = (double)mean[0] * (double)mean[0] + (double)C[0];
    const double b = (double)mean[0] * (double)mean[1] + (double)C[1];
    const double c = (double)mean[1] * (double)mean[1] + (double)C[3];
    return ((double)Q[3] * a - 2 * (double)Q[1] * b + (double)Q[0] * c) / d;
}

TEST(reweighting_follows_the_smoothed_noise)
{
    static const num scale[] = {1, 4, 16, 2, 0.5, 1};
    const double nu = 2;
    num mean[2], C[4];
    reading a, b;
    memcpy(q, scale, sizeof scale);
    record(&track, &tape, scale);
    record(&twin, &twin_tape, scale);
    ASSERT_OK(K(smooth_reweighted)(&tape, &scaled, &motion, N(nu), q));
    const K(smooth_extras) extras = {NULL, mean, C};
    ASSERT_OK(K(smooth_step)(&twin_tape, NULL, NULL));
    for (int t = 5; t >= 0; t--) {
        ASSERT_OK(K(process_scale_noise)(&scaled, &motion, scale[t]));
        ASSERT_OK(K(smooth_step)(&twin_tape, &scaled, &extras));
        const double expected = (nu + expected_square(mean, C)) / (nu + 2);
        ASSERT_CLOSE(expected, q[t], 64 * expected);
    }
    for (size_t t = 0; t < 7; t++) {
        read_smoothed(&a, &twin_tape, t, 2);
        read_smoothed(&b, &tape, t, 2);
        ASSERT_SAME_BITS(a, b);
    }
    TEST_ASSERT_TRUE(q[2] > 4 * q[0]); /* the jump is found */
    ASSERT_WITHIN(0, 1, q[6]);         /* not written behind the last one */
}

/* Only what moves the state counts: noise of rank 1 in two states as in one. */
TEST(noise_of_less_rank_counts_by_its_rank)
{
    static const num F[] = {N(0.70710678118654752), N(1.41421356237309505)};
    num mean[2], C[4];
    ASSERT_OK(K(process_init_factor)(&motion, A, B, F, 1));
    record(&track, &tape, NULL);
    record(&twin, &twin_tape, NULL);
    ASSERT_OK(K(smooth_reweighted)(&tape, &scaled, &motion, 3, q));
    const K(smooth_extras) extras = {NULL, mean, C};
    ASSERT_OK(K(process_scale_noise)(&scaled, &motion, 1));
    ASSERT_OK(K(smooth_step)(&twin_tape, NULL, NULL));
    for (int t = 5; t >= 0; t--) {
        ASSERT_OK(K(smooth_step)(&twin_tape, NULL, &extras));
        const double square = ((double)mean[1] * (double)mean[1] + (double)C[3]) / 2;
        ASSERT_CLOSE((3 + square) / 4, q[t], 64 + 64 * square);
    }
}

TEST(refusals_of_the_smoother)
{
    ASSERT_REFUSED(KQ_ERR_NULL, K(smooth_reweighted)(NULL, &scaled, &motion, 2, q));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth_reweighted)(&blank_tape, &scaled, &motion, 2, q));
    record(&track, &tape, NULL);
    ASSERT_REFUSED(KQ_ERR_NULL, K(smooth_reweighted)(&tape, NULL, &motion, 2, q));
    ASSERT_REFUSED(KQ_ERR_NULL, K(smooth_reweighted)(&tape, &scaled, NULL, 2, q));
    ASSERT_REFUSED(KQ_ERR_NULL, K(smooth_reweighted)(&tape, &scaled, &motion, 2, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(smooth_reweighted)(&tape, &scaled, &blank_process, 2, q));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(smooth_reweighted)(&tape, &scaled, &motion3, 2, q));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(smooth_reweighted)(&tape, &motion, &motion, 2, q));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(smooth_reweighted)(&tape, &motion3, &motion, 2, q));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(smooth_reweighted)(&tape, &scaled, &motion, 0, q));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE,
                   K(smooth_reweighted)(&tape, &scaled, &motion, (num)INFINITY, q));
    q[0] = -1;
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(smooth_reweighted)(&tape, &scaled, &motion, 2, q));
    q[0] = (num)NAN;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(smooth_reweighted)(&tape, &scaled, &motion, 2, q));
    q[0] = 1;
    for (int t = 0; t < 12; t++) ASSERT_OK(K(predict)(&track, &motion, u));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, K(smooth_reweighted)(&tape, &scaled, &motion, 2, q));
    record(&track, &tape, NULL);
    ASSERT_OK(K(smooth_reweighted)(&tape, &scaled, &motion, 2, q));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth_reweighted)(&tape, &scaled, &motion, 2, q));
}

SUITE(robust, set_up)
#include "robust.tests"
