/*
 * What decides each condition of the steps, where it takes a filter that is unusual: one that is a copy, whose start is
 * over, whose recording is another one's, or whose numbers overflow.
 */
#include "conditions.h"

S_HISTORY(second, 2, 2, STEPS, STEPS);
S_ADAPTATION(tuner, 2, 2);
S_FREEZE(calm, 2, 2);

static void set_up(void)
{
    begin_conditions();
    ASSERT_OK(S(history_assign)(&second, 2, second_memory, COUNT(second_memory)));
    ASSERT_OK(ASSIGN_ADAPTATION(tuner, 2, 2));
}

static void begin_start(uint32_t unknown)
{
    ASSERT_OK(S(diffuse_assign)(&start, 2, 0, start_memory, COUNT(start_memory)));
    ASSERT_OK(init_start(&start, &track, &prior, unknown));
}

/* --------------------------------------------------------------------------- starts */

/* A start of which nothing was unknown is attached up to the first step, whatever that is. */
TEST(a_start_that_is_over_leaves_a_linearised_predict)
{
    const num d[] = {0.5, 0.25};
    begin_start(0);
    TEST_ASSERT_EQUAL_PTR(&start.attached, track.attached);
    ASSERT_OK(S(predict_extended)(&track, &other.process, moved_by(&other, d)));
    TEST_ASSERT_NULL(track.attached);
}

TEST(a_start_that_is_over_takes_innovations)
{
    begin_start(3);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, S(step)(&track, &other.process, NULL, of_innovations(&radar), z));
    begin_start(0);
    ASSERT_OK(S(step)(&track, &other.process, NULL, of_innovations(&radar), z));
    TEST_ASSERT_NULL(track.attached);
}

/* A filter that was initialised since is no business of the start's. */
TEST(a_start_whose_filter_began_anew)
{
    begin_start(3);
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(init_filter(&track, &prior));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_EMPTY, S(diffuse_smooth)(&start));
}

/* Of no early instants there is nothing to smooth before all is known. */
TEST(a_start_without_early_instants)
{
    begin_start(3);
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(predict)(&track, &motion.process, u));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_EMPTY, S(diffuse_smooth)(&start));
}

/* A tape that was assigned anew, and records another filter */
TEST(a_start_whose_tape_is_anothers)
{
    begin_start(3);
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(S(attach)(&twin, &tape.attached));
    ASSERT_OK(S(predict)(&track, &motion.process, u));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_EMPTY, S(diffuse_smooth)(&start));
}

/* Of two tapes the start has the second: to detach the first one changes nothing; a copy has none. */
TEST(a_start_loses_the_tape_that_it_has)
{
    begin_start(3);
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(attach)(&track, &second.attached));
    tape.filter = &track;
    ASSERT_OK(S(detach)(&tape.attached));
    TEST_ASSERT_EQUAL_PTR(&second, start.tape);
    S(filter) copy = track;
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, S(predict)(&copy, &motion.process, u));
    second.filter = &copy;
    ASSERT_OK(S(detach)(&second.attached));
    TEST_ASSERT_EQUAL_PTR(&second, start.tape);
    second.filter = &track;
    ASSERT_OK(S(detach)(&second.attached));
    TEST_ASSERT_NULL(start.tape);
}

/* ----------------------------------------------------------------- losses and recordings */

/* A copy of a recorded filter is not recorded: P may be raised. */
TEST(a_copy_may_jump)
{
    S(loss) jump = {.kind = &S(loss_jump), .parameter = number(9)};
    ASSERT_OK(S(attach)(&track, &tape.attached));
    S(filter) copy = track;
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RECORDING, S(update_robust)(&track, &radar.sensor, z, UINT32_MAX, &jump));
    ASSERT_OK(S(update_robust)(&copy, &radar.sensor, z, UINT32_MAX, &jump));
}

/* A gate that takes nothing, since nothing is present or all of it redundant, says nothing of the run. */
TEST(a_gate_that_nothing_comes_to)
{
    static const num none[] = {0, 0};
    sensor_model sharp;
    S(loss) gate = {.kind = &S(loss_gate), .limit = score_of(1000), .run = 2};
    put_independent(&sharp, 2, 2, range, measured_range, H, none);
    ASSERT_OK(S(update)(&track, &sharp.sensor, z));
    gate.rejected = 1;
    ASSERT_OK(S(update_robust)(&track, &sharp.sensor, z, UINT32_MAX, &gate));
    TEST_ASSERT_EQUAL_INT(1, gate.rejected);
    ASSERT_OK(S(update_robust)(&track, &radar.sensor, z, UINT32_MAX, &gate));
    TEST_ASSERT_EQUAL_INT(0, gate.rejected);
}

/* The first scale that is none ends the check of the others. */
TEST(the_first_scale_is_refused)
{
    entry scales[STEPS] = {number(-0.5), number(1), number(1), number(1)};
    ASSERT_OK(S(attach)(&track, &tape.attached));
    for (int t = 0; t < 3; t++) ASSERT_OK(S(step)(&track, &motion.process, u, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_SEMIDEFINITE, smooth_reweighted(&tape, &other, &motion, number(4), scales));
}

/* A copy is none that the tape records; after as many predicts as there are Jacobians for, or words, the recording ends. */
TEST(a_tape_of_jacobians_comes_to_its_end)
{
    const num d[] = {0.5, 0.25};
    for (int is_short = 0; is_short < 2; is_short++) {
        ASSERT_OK(S(jacobians_assign)(&kept, &tape, 2, kept_processes, 2, kept_memory, COUNT(kept_memory)));
        if (is_short) kept.length = S_JACOBIANS_LEN(2, 1, 1);
        ASSERT_OK(init_filter(&track, &prior));
        ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
        ASSERT_OK(S(attach)(&track, &kept.attached));
        S(filter) copy = track;
        ASSERT_OK(S(predict_extended)(&copy, &other.process, moved_by(&other, d)));
        TEST_ASSERT_NULL(copy.attached);
        for (int t = 0; t < 4; t++) ASSERT_OK(S(predict_extended)(&track, &other.process, moved_by(&other, d)));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, S(events)(&track));
    }
}

/* What is smoothed down to its first step stays so. */
TEST(a_start_is_smoothed_once_its_tape_is)
{
    for (int states_only = 0; states_only < 2; states_only++) {
        ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
        begin_start(3);
        ASSERT_OK(S(attach)(&track, &tape.attached));
        for (int t = 0; t < 3; t++) ASSERT_OK(S(step)(&track, &motion.process, u, &radar.sensor, z));
        ASSERT_OK(states_only ? S(smooth_states)(&tape) : S(smooth)(&tape));
        ASSERT_OK(S(diffuse_smooth)(&start));
    }
}

/* Frozen by one sensor: another one moves the gain again. */
TEST(a_freeze_knows_its_sensor)
{
    static sensor_model twin_radar;
    put_independent(&twin_radar, 2, 2, range, measured_range, H, r);
    ASSERT_OK(S(freeze_init)(&calm, 8));
    ASSERT_OK(S(attach)(&track, &calm.attached));
    for (int t = 0; t < 100; t++) ASSERT_OK(S(step)(&track, &motion.process, u, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(1, S(freeze_is_active)(&calm));
    ASSERT_OK(S(step)(&track, &motion.process, u, &twin_radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(0, S(freeze_is_active)(&calm));
}

/* ------------------------------------------------------------------- what overflows */

#ifndef KQ_TEST_Q31
/* A x overflows where the filter is a copy: there is no recording that could end. */
TEST_FLOAT(a_copy_that_overflows)
{
    static const num wild[] = {NUM_MAX, 0, 0, 1};
    ASSERT_OK(K(process_init)(&other.process, wild, NULL, Q));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    K(filter) copy = track;
    ASSERT_OK(K(predict)(&copy, &other.process, NULL));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW | KQ_EVENT_HISTORY_FULL, K(events)(&copy));
    TEST_ASSERT_NULL(copy.attached);
}

static void put_far(num h, num noise, num variance)
{
    static num row[2], one_noise[1], P[4];
    row[0] = h, one_noise[0] = noise, P[0] = variance, P[3] = 1;
    put_independent(&radar, 2, 1, range, measured_range, row, one_noise);
    put_independent(&lean, 2, 1, range, measured_range, row, one_noise);
    ASSERT_OK(init_lean(&lean, one_noise));
    put_prior(&prior, 2, range, x0, P);
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(S(attach)(&track, &tape.attached));
}

/* H P H' overflows: the state is held, and the recording ends. */
TEST_FLOAT(a_state_that_is_held_ends_a_recording)
{
    put_far(N(0x1p20), 1, N(MOST_SIGMA) * N(MOST_SIGMA));
    ASSERT_OK(K(update)(&track, &radar.sensor, z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW | KQ_EVENT_HISTORY_FULL, K(events)(&track) & (KQ_EVENT_OVERFLOW | KQ_EVENT_HISTORY_FULL));
}

/* H P H' is a number, and with R it is none: the state is held until it is; by a loss nothing is taken. */
TEST_FLOAT(a_noise_that_overflows)
{
    put_far(8, NUM_MAX, N(MOST_SIGMA) * N(MOST_SIGMA));
    ASSERT_OK(K(update)(&track, &radar.sensor, z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&track) & KQ_EVENT_OVERFLOW);
    put_far(8, NUM_MAX, N(MOST_SIGMA) * N(MOST_SIGMA));
    K(loss) loss = {.kind = &K(loss_huber), .parameter = 2};
    ASSERT_OK(K(update_robust)(&track, &radar.sensor, z, UINT32_MAX, &loss));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&track) & KQ_EVENT_OVERFLOW);
}

/* By a loss, too: the state is held, and the recording ends. */
TEST_FLOAT(a_state_that_a_loss_finds_too_large)
{
    K(loss) loss = {.kind = &K(loss_huber), .parameter = 2};
    put_far(N(0x1p20), 1, N(MOST_SIGMA) * N(MOST_SIGMA));
    ASSERT_OK(K(update_robust)(&track, &radar.sensor, z, UINT32_MAX, &loss));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW | KQ_EVENT_HISTORY_FULL, K(events)(&track) & (KQ_EVENT_OVERFLOW | KQ_EVENT_HISTORY_FULL));
}

/* x + d overflows: the mean is lost, and so is the recording; a copy has none. */
TEST_FLOAT(increments_that_overflow)
{
    const num far[] = {NUM_MAX, 0};
    track_memory[0] = twin_memory[0] = NUM_MAX;
    ASSERT_OK(K(attach)(&track, &kept.attached));
    K(filter) copy = track, moved = track;
    ASSERT_OK(K(predict_extended)(&copy, &other.process, far));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW | KQ_EVENT_HISTORY_FULL, K(events)(&copy));
    ASSERT_OK(K(move)(&twin, far));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&twin));
    track_memory[0] = NUM_MAX;
    ASSERT_OK(K(move)(&moved, far));
    TEST_ASSERT_NULL(moved.attached);
    track_memory[0] = NUM_MAX;
    ASSERT_OK(K(predict_extended)(&track, &other.process, far));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_FULL, K(smooth)(&tape));
}

/* A mean that is finite and beyond its limit is lost at once, though what its rounding left is 0. */
TEST_FLOAT(means_that_reach_too_far)
{
    static const num twice[] = {2, 0, 0, 1};
    const num far[] = {NUM_MAX, 0};
    ASSERT_OK(K(move)(&twin, far));
    ASSERT_OK(K(predict_extended)(&track, &other.process, far));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&twin));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&track));
    TEST_ASSERT_TRUE(K(mean)(&twin, 0) == 0 && K(mean)(&track, 0) == 0);
    ASSERT_OK(K(process_init)(&other.process, twice, NULL, Q));
    ASSERT_OK(init_filter(&track, &prior));
    track_memory[0] = N(MOST_SIGMA) * N(MOST_SIGMA) / 2;
    ASSERT_OK(K(predict)(&track, &other.process, NULL));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    ASSERT_OK(K(predict)(&track, &other.process, NULL));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&track));
    TEST_ASSERT_TRUE(K(mean)(&track, 0) == 0);
}

/* A measurement 2^61 sigmas off, and of smoothers what it makes of the state before: beyond its limit, so that it is lost. */
static void run_far(struct K(attached) *object)
{
    static const num stay[] = {1, 0, 0, 1};
    const num square = N(MOST_SIGMA) * N(MOST_SIGMA), off[] = {N(2.5) * square, 0};
    put_far(1, square / 4, square / 4);
    ASSERT_OK(K(attach)(&track, object));
    ASSERT_OK(K(process_init)(&other.process, stay, NULL, Q));
    ASSERT_OK(K(predict)(&track, &other.process, NULL));
    ASSERT_OK(K(update)(&track, &radar.sensor, off));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
}

TEST_FLOAT(smoothed_means_that_overflow)
{
    S_LAG(lag, 2, 2, 1);
    S_INSTANT(instant, 2, 2);
    K(filter) views[5];
    run_far(&tape.attached);
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_OK(K(smoothed)(&tape, 0, views));
    ASSERT_OK(K(history_assign)(&second, 2, second_memory, COUNT(second_memory)));
    run_far(&second.attached);
    ASSERT_OK(K(smooth_states)(&second));
    ASSERT_OK(K(smoothed)(&second, 0, views + 1));
    ASSERT_OK(K(lag_assign)(&lag, 2, 2, 1, lag_memory, COUNT(lag_memory)));
    run_far(&lag.attached);
    ASSERT_OK(K(lagged_states)(&lag, 1, views + 2));
    TEST_ASSERT_TRUE(K(mean)(views + 2, 0) == 0);
    ASSERT_OK(K(lagged)(&lag, 1, views + 3));
    ASSERT_OK(K(instant_assign)(&instant, 2, 2, instant_memory, COUNT(instant_memory)));
    run_far(&instant.attached);
    ASSERT_OK(K(instant_smooth)(&instant, views + 4));
    for (int k = 0; k < 5; k++) {
        TEST_ASSERT_EQUAL_HEX_MESSAGE(KQ_EVENT_OVERFLOW, K(events)(views + k) & KQ_EVENT_OVERFLOW, "no event");
        TEST_ASSERT_TRUE(K(mean)(views + k, 0) == 0);
    }
    TEST_ASSERT_TRUE((double)K(sigma)(views, 0) >= MOST_SIGMA * 0x1p-16);
}

/* R times its largest scale is beyond the numbers, though what is left of it without the other component is not; what is
   no noise stays none, however small its scale. */
TEST_FLOAT(scales_of_a_noise_at_the_ends_of_the_numbers)
{
    const K(adaptation_rule) rule = usual_rule();
    const num tiny = N(TINY_SIGMA) * N(TINY_SIGMA), least[] = {2 * tiny, 1};
    const num root = N(sqrt((double)NUM_MAX) * 0.999), wide[] = {NUM_MAX, root, root, 1};
    put_sensor(&coupled, 2, 2, range, measured_range, H, wide);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_FINITE, K(adaptation_init)(&tuner, &motion.process, &coupled.sensor, &rule));
    put_independent(&radar, 2, 2, range, measured_range, H, least);
    ASSERT_OK(K(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule));
    ASSERT_OK(K(attach)(&track, &tuner.attached));
    for (int t = 0; t < 100; t++) ASSERT_OK(K(step)(&track, &motion.process, u, &radar.sensor, z));
    TEST_ASSERT_TRUE(tuner.scaled_sensor.noise[0] >= tiny);
}

/* A measurement that overflows is recorded as none, of a lean sensor, too. */
TEST_FLOAT(a_lean_measurement_that_overflows_is_recorded)
{
    const num most[] = {NUM_MAX};
    put_far(1, 1, 1);
    ASSERT_OK(K(update)(&track, &lean.sensor, most));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&track));
    TEST_ASSERT_EQUAL_INT(1, tape.records);
}

/* h'S of which nothing is left but rounding: terms far above the innovation's sigma, which cancel */
TEST_FLOAT(rows_that_cancel_say_nothing)
{
    static const num difference[] = {1, -1}, noise[] = {256};
    const int most = EPS > 1e-10 ? 30 : 60;
    put_independent(&radar, 2, 1, range, measured_range, difference, noise);
    for (int e = 0; e <= most; e++) {
        const num root[] = {1, N(ldexp(1, e) + 1), N(ldexp(1, e))}; /* by columns */
        ASSERT_OK(K(filter_init_root)(&track, x0, root));
        for (int t = 0; t < 40; t++) ASSERT_OK(K(update)(&track, &radar.sensor, z));
        if (e == 0) TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_PRECISION, K(events)(&track) & KQ_EVENT_PRECISION);
}

/* The same on a tape, which adds up what its measurements are rounded by, as far as it counts */
TEST_FLOAT(rows_that_cancel_on_a_tape)
{
    static const num difference[] = {1, -1}, noise[] = {1};
    const int most = EPS > 1e-10 ? 30 : 60;
    const num root[] = {1, N(ldexp(1, most)), N(ldexp(1, most))};
    put_independent(&radar, 2, 1, range, measured_range, difference, noise);
    ASSERT_OK(K(filter_init_root)(&track, x0, root));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    for (int t = 0; t < 3; t++) ASSERT_OK(K(update)(&track, &radar.sensor, z));
    TEST_ASSERT_EQUAL_UINT32(UINT32_C(1) << 30, tape.rounding);
}

/* What comes late overflows by itself, or by its noise. */
TEST_FLOAT(late_measurements_that_overflow)
{
    S_LAG(lag, 2, 2, 1);
    const num most[] = {NUM_MAX, 0}, none[] = {NUM_MAX, NUM_MAX}, wide[] = {N(MOST_SIGMA) * N(MOST_SIGMA), 0, 0, 1};
    static const num far[] = {8, 0, 0, 1};
    for (int k = 0; k < 2; k++) {
        put_independent(&radar, 2, 2, range, measured_range, k ? far : H, k ? none : r);
        put_prior(&prior, 2, range, x0, k ? wide : P0);
        ASSERT_OK(init_filter(&track, &prior));
        ASSERT_OK(K(delay_assign)(&lag, 2, 2, 1, lag_memory, COUNT(lag_memory)));
        ASSERT_OK(K(attach)(&track, &lag.attached));
        ASSERT_OK(K(predict)(&track, &motion.process, u));
        ASSERT_OK(K(update_delayed)(&lag, 1, &radar.sensor, k ? z : most, 1));
        TEST_ASSERT_EQUAL_INT(0, K(taken)(&track));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&track) & KQ_EVENT_OVERFLOW);
        ASSERT_OK(K(detach)(&lag.attached));
    }
}

/* ------------------------------------------------------------------- continuous time */

static num flow_memory[KQ_CONTINUOUS_LEN(2, 1)];

static kq_status flow(num f, num b, num variance, num dt)
{
    const num F[] = {0, f, 0, 0}, drive[] = {b, 0}, noise[] = {0, 0, 0, variance};
    return K(process_init_continuous)(&motion.process, F, drive, noise, dt, flow_memory, COUNT(flow_memory));
}

/* e^(F dt), its integral times B, and the noise over dt, each beyond the numbers */
TEST_FLOAT(what_time_makes_too_large)
{
    const num growing[] = {N(1e15), 0, 0, 0}, wild[] = {NUM_MAX, NUM_MAX, NUM_MAX, NUM_MAX};
    const num most = N(MOST_SIGMA) * N(MOST_SIGMA);
    ASSERT_REFUSED(KQ_ERR_RANGE, K(process_init_continuous)(&motion.process, growing, B, Q, N(1e15), flow_memory, COUNT(flow_memory)));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(process_init_continuous)(&motion.process, wild, B, Q, 1, flow_memory, COUNT(flow_memory)));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, flow(0, NUM_MAX, 1, 4));       /* B dt */
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, flow(0, 1, most, 4));          /* Q dt, beyond a state's variance */
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, flow(NUM_MAX / 4, 1, most, 1)); /* Q, not finite */
    ASSERT_OK(flow(1, 1, 1, 1));
}
#endif

#ifndef KQ_TEST_Q31
/* A state that follows another one so fast that, given that one, nothing is left of it but rounding */
TEST_FLOAT(a_state_that_follows_another)
{
    const num fast = N(ldexp(1, EPS > 1e-10 ? 50 : 90)), dt = N(EPS > 1e-10 ? 48.5 : 91.5);
    const num F[] = {-fast, fast, 0, -1}, noise[] = {0, 0, 0, 1};
    if (K(process_init_continuous)(&motion.process, F, B, noise, dt, flow_memory, COUNT(flow_memory)) == KQ_ERR_RANGE) return;
    for (int k = 0; k < 3; k++) ASSERT_WITHIN(k == 0 ? 1 : 1e-3, k == 0 ? 0 : sqrt(0.5), motion.process.noise_root[k]);
}
#endif

SUITE(conditions_steps, set_up)
#include "conditions_steps.tests"
