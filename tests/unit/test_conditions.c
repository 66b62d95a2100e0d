/*
 * What decides each condition of the checks: an object of which one field has been damaged is refused, and the call says
 * why.  What an assign or an init has looked at can have been damaged since; the calls that read it look again.
 */
#include "conditions.h"

S_LAG(lag, 2, 2, 1);
S_ADAPTATION(tuner, 2, 2);
S_STEADY(steady, 2, 2);
S_FREEZE(calm, 2, 2);
S_CONSISTENCY(recent, 2, 2);
static S(filter) view;
static entry gains[4];

static void set_up(void)
{
    begin_conditions();
    ASSERT_OK(ASSIGN_ADAPTATION(tuner, 2, 2));
}

/* ------------------------------------------------------------------- the filter */

TEST(flags_of_a_filter)
{
    ASSERT_OK(S(filter_check)(&track));
    track.plain = 0; /* slower, and right */
    ASSERT_OK(S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.plain, 3, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.events, 0xffff, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.events, 2 * KQ_EVENT_CONTRADICTION - 1, KQ_OK, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.ready, 0, KQ_ERR_NOT_READY, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.ready, 2, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.ready, 1 | 8, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.ready, 1 | 16, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.ready, 1 | 2 | 16, KQ_OK, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.states, 200, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.memory, NULL, KQ_ERR_TABLE, S(filter_check)(&track));
    track.seal = 0;
    ASSERT_REFUSED_WITH(track.known, 1, KQ_ERR_TABLE, S(filter_check)(&track));
}

/* One that is not ready has a start attached, to which something is unknown. */
TEST(a_filter_that_is_not_ready)
{
    ASSERT_OK(init_start(&start, &track, &prior, 3));
    ASSERT_OK(S(filter_check)(&track));
    track.seal = 0;
    ASSERT_REFUSED_WITH(track.known, 3, KQ_ERR_NOT_READY, S(filter_check)(&track));
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.ready, 0, KQ_ERR_NOT_READY, S(filter_check)(&track));
}

TEST(likelihoods_of_a_filter)
{
    ASSERT_OK(S(update)(&track, &radar.sensor, z));
    ASSERT_OK(S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.last.nis, -1, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.last.count, -1, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.last.count, KQ_SIZE_MAX + 1, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.run.count, -1, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.run.count, INT32_C(1) << 15, KQ_ERR_TABLE, S(filter_check)(&track));
#ifdef KQ_TEST_Q31
    ASSERT_REFUSED_WITH(track.last.nis, (INT64_C(1) << 61) + 1, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.last.determinant.mantissa, 1, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.last.determinant.exponent, INT32_C(1) << 21, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.last.determinant.exponent, -(INT32_C(1) << 21), KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.run.sum, (INT64_C(1) << 61) + 1, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.run.sum, -(INT64_C(1) << 61) - 1, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.run.determinant.mantissa, 1, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.run.determinant.exponent, INT32_C(1) << 30, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.run.determinant.exponent, -(INT32_C(1) << 30), KQ_ERR_TABLE, S(filter_check)(&track));
#else
    ASSERT_REFUSED_WITH(track.last.determinant, N(0.25), KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.last.determinant, 2, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.last.exponent, INT32_C(1) << 20, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.last.exponent, -(INT32_C(1) << 20), KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.run.determinant, N(0.25), KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.run.determinant, 2, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.run.exponent, INT32_C(1) << 30, KQ_ERR_TABLE, S(filter_check)(&track));
    ASSERT_REFUSED_WITH(track.run.exponent, -(INT32_C(1) << 30), KQ_ERR_TABLE, S(filter_check)(&track));
#endif
}

/* --------------------------------------------------------------- process and sensor */

TEST(fields_of_a_process)
{
    ASSERT_OK(S(process_check)(&motion.process));
    ASSERT_REFUSED_WITH(motion.process.transition, NULL, KQ_ERR_TABLE, S(process_check)(&motion.process));
    ASSERT_REFUSED_WITH(motion.process.controls, 200, KQ_ERR_TABLE, S(process_check)(&motion.process));
    ASSERT_REFUSED_WITH(motion.process.states, 200, KQ_ERR_TABLE, S(process_check)(&motion.process));
    motion.process.seal = 0;
    ASSERT_REFUSED_WITH(motion.process.controls, 200, KQ_ERR_TABLE, S(process_check)(&motion.process));
    ASSERT_REFUSED_WITH(motion.process.transition, NULL, KQ_ERR_TABLE, S(process_check)(&motion.process));
    ASSERT_REFUSED_WITH(motion.process.plain, 2, KQ_ERR_TABLE, S(process_check)(&motion.process)); /* A is upper triangular */
    ASSERT_REFUSED_WITH(motion.process.fingerprint, 1, KQ_ERR_TABLE, S(process_check)(&motion.process));
    motion.process.fingerprint = 0; /* a table has none */
    motion.process.plain = 2;
    ASSERT_OK(S(process_check)(&motion.process));
}

TEST(fields_of_a_sensor)
{
    ASSERT_OK(S(sensor_check)(&radar.sensor));
    ASSERT_REFUSED_WITH(radar.sensor.states, 200, KQ_ERR_TABLE, S(sensor_check)(&radar.sensor));
    ASSERT_REFUSED_WITH(radar.sensor.components, 200, KQ_ERR_TABLE, S(sensor_check)(&radar.sensor));
    ASSERT_REFUSED_WITH(radar.sensor.measurement, NULL, KQ_ERR_TABLE, S(sensor_check)(&radar.sensor));
    ASSERT_REFUSED_WITH(radar.sensor.kind, NULL, KQ_ERR_TABLE, S(sensor_check)(&radar.sensor));
    TEST_ASSERT_EQUAL_INT(1, radar.sensor.selects[0]);
    radar.sensor.seal = 0;
    ASSERT_REFUSED_WITH(radar.sensor.states, 200, KQ_ERR_TABLE, S(sensor_check)(&radar.sensor));
    ASSERT_REFUSED_WITH(radar.sensor.measurement, NULL, KQ_ERR_TABLE, S(sensor_check)(&radar.sensor));
    ASSERT_REFUSED_WITH(radar.sensor.selects[0], 2, KQ_ERR_TABLE, S(sensor_check)(&radar.sensor));
    radar.sensor.selects[0] = 0; /* slower, and right */
    ASSERT_OK(S(sensor_check)(&radar.sensor));
}

/* Whatever is sealed, a seal is none of the values that say that there is none. */
TEST(a_seal_is_never_0)
{
    int largest = 0;
    for (int k = 1; k <= 800; k++) {
        const num variances[] = {(num)k / 64, 1};
        put_independent(&radar, 2, 2, range, measured_range, H, variances);
        ASSERT_OK(S(sensor_check)(&radar.sensor));
        TEST_ASSERT_GREATER_THAN_INT(128, radar.sensor.noise_seal);
        if (radar.sensor.noise_seal > largest) largest = radar.sensor.noise_seal;
    }
    TEST_ASSERT_EQUAL_INT(255, largest); /* a multiple of 127, and so are rows of zeros */
    static const num zeros[4];
    put_independent(&radar, 2, 2, range, measured_range, zeros, r);
    ASSERT_OK(S(sensor_check)(&radar.sensor));
    TEST_ASSERT_EQUAL_INT(255, radar.sensor.measurement_seal);
}

#ifndef KQ_TEST_Q31
TEST_FLOAT(room_for_a_process_and_a_sensor)
{
    K(process) *p = &motion.process;
    K(sensor) *s = &radar.sensor;
    ASSERT_REFUSED_WITH(p->controls, 200, KQ_ERR_SIZE, K(process_init)(p, A, B, Q));
    ASSERT_REFUSED_WITH(p->memory, NULL, KQ_ERR_MEMORY, K(process_init)(p, A, B, Q));
    ASSERT_REFUSED_WITH(p->length, 1, KQ_ERR_MEMORY, K(process_init)(p, A, B, Q));
    ASSERT_REFUSED_WITH(s->components, 200, KQ_ERR_SIZE, K(sensor_init_diagonal)(s, H, r));
    ASSERT_REFUSED_WITH(s->memory, NULL, KQ_ERR_MEMORY, K(sensor_init_diagonal)(s, H, r));
    ASSERT_REFUSED_WITH(s->length, 1, KQ_ERR_MEMORY, K(sensor_init_diagonal)(s, H, r));
}

TEST_FLOAT(room_for_what_is_linearised)
{
    static num E[4], noise[4];
    K(process) *p = &other.process;
    K(sensor) *s = &lean.sensor;
    ASSERT_REFUSED_WITH(p->memory, NULL, KQ_ERR_MEMORY, K(process_linearise)(p, &motion.process, A, E));
    ASSERT_REFUSED_WITH(p->length, 1, KQ_ERR_MEMORY, K(process_linearise)(p, &motion.process, A, E));
    ASSERT_REFUSED_WITH(p->memory, motion.process.memory, KQ_ERR_MISMATCH, K(process_linearise)(p, &motion.process, A, E));
    ASSERT_REFUSED_WITH(E[3], N(INFINITY), KQ_ERR_NOT_FINITE, K(process_linearise)(p, &motion.process, A, E));
    ASSERT_REFUSED_WITH(s->states, 200, KQ_ERR_SIZE, K(sensor_linearise)(s, &radar.sensor, H, E, noise));
    ASSERT_REFUSED_WITH(s->components, 200, KQ_ERR_SIZE, K(sensor_linearise)(s, &radar.sensor, H, E, noise));
    ASSERT_REFUSED_WITH(s->components, 1, KQ_ERR_MISMATCH, K(sensor_linearise)(s, &radar.sensor, H, E, noise));
    ASSERT_REFUSED_WITH(s->memory, NULL, KQ_ERR_MEMORY, K(sensor_linearise)(s, &radar.sensor, H, E, noise));
    ASSERT_REFUSED_WITH(s->memory, radar.sensor.memory, KQ_ERR_MISMATCH, K(sensor_linearise)(s, &radar.sensor, H, E, noise));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(sensor_linearise)(s, &coupled.sensor, H, E, (num *)coupled.sensor.covariance));
}

TEST_FLOAT(room_for_a_scaled_noise)
{
    K(process) *p = &other.process;
    ASSERT_REFUSED_WITH(p->memory, NULL, KQ_ERR_MEMORY, K(process_scale_noise)(p, &motion.process, 2));
    ASSERT_REFUSED_WITH(p->length, 1, KQ_ERR_MEMORY, K(process_scale_noise)(p, &motion.process, 2));
    ASSERT_REFUSED_WITH(p->memory, motion.process.memory, KQ_ERR_MISMATCH, K(process_scale_noise)(p, &motion.process, 2));
}

#ifdef KQ_TEST_F32
KQ_EM_F32(em, 2, 2, 1);
#else
KQ_EM_F64(em, 2, 2, 1);
#endif

TEST_FLOAT(memory_of_an_estimation)
{
    const K(parameters) parameters = {.A = NULL};
    const K(recording) recording = {.steps = 1};
    ASSERT_REFUSED_WITH(em.components, 200, KQ_ERR_SIZE, K(em_init)(&em, &parameters, NULL, &recording, 1));
    ASSERT_REFUSED_WITH(em.memory, NULL, KQ_ERR_MEMORY, K(em_init)(&em, &parameters, NULL, &recording, 1));
    ASSERT_REFUSED_WITH(em.length, 1, KQ_ERR_MEMORY, K(em_init)(&em, &parameters, NULL, &recording, 1));
}

/* A mean or a root that no state may have; a scale that leaves no number of a noise */
TEST_FLOAT(what_a_state_may_not_have)
{
    const num far[] = {2 * N(MOST_SIGMA) * N(MOST_SIGMA), 0}, root[] = {1, 0, 1}, wide[] = {2 * N(MOST_SIGMA), 0, 1};
    ASSERT_REFUSED(KQ_ERR_RANGE, K(filter_init_root)(&track, far, root));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(filter_init_root)(&track, x0, wide));
}
#endif

/* ------------------------------------------------------------------- what is attached */

/* A start is attached by its init alone. */
TEST(a_start_is_neither_attached_nor_detached)
{
    ASSERT_OK(init_start(&start, &twin, &prior, 3));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(attach)(&track, &start.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(detach)(&start.attached));
}

TEST(room_for_a_tape)
{
    ASSERT_REFUSED_WITH(tape.memory, NULL, KQ_ERR_MEMORY, S(attach)(&track, &tape.attached));
    ASSERT_REFUSED_WITH(tape.length, 1, KQ_ERR_MEMORY, S(attach)(&track, &tape.attached));
    ASSERT_REFUSED_WITH(tape.states, 200, KQ_ERR_SIZE, S(attach)(&track, &tape.attached));
}

TEST(room_for_a_tape_of_a_start)
{
    ASSERT_OK(init_start(&start, &track, &prior, 3));
    ASSERT_REFUSED_WITH(tape.memory, NULL, KQ_ERR_MEMORY, S(attach)(&track, &tape.attached));
    ASSERT_REFUSED_WITH(tape.length, 1, KQ_ERR_MEMORY, S(attach)(&track, &tape.attached));
    ASSERT_REFUSED_WITH(tape.states, 200, KQ_ERR_SIZE, S(attach)(&track, &tape.attached));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(detach)(&tape.attached));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_EMPTY, S(smooth)(&tape));
}

TEST(memory_of_a_start)
{
    ASSERT_REFUSED_WITH(start.states, 200, KQ_ERR_SIZE, init_start(&start, &track, &prior, 3));
    ASSERT_REFUSED_WITH(start.memory, NULL, KQ_ERR_MEMORY, init_start(&start, &track, &prior, 3));
}

TEST(memory_of_an_adaptation)
{
    S(adaptation_rule) rule = usual_rule();
    ASSERT_REFUSED_WITH(tuner.components, 200, KQ_ERR_SIZE, S(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule));
    ASSERT_REFUSED_WITH(tuner.memory, NULL, KQ_ERR_MEMORY, S(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule));
#ifdef KQ_TEST_Q31
    ASSERT_REFUSED_WITH(tuner.root, NULL, KQ_ERR_MEMORY, S(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule));
#endif
    rule.scales = (kq_adapted)-1;
    ASSERT_REFUSED(KQ_ERR_RANGE, S(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule));
}

TEST(memory_of_a_freeze)
{
    ASSERT_REFUSED_WITH(calm.components, 200, KQ_ERR_SIZE, S(freeze_init)(&calm, 8));
    ASSERT_REFUSED_WITH(calm.memory, NULL, KQ_ERR_MEMORY, S(freeze_init)(&calm, 8));
    ASSERT_REFUSED_WITH(calm.gain, NULL, KQ_ERR_MEMORY, S(freeze_init)(&calm, 8));
    ASSERT_REFUSED_WITH(calm.length, 1, KQ_ERR_MEMORY, S(freeze_init)(&calm, 8));
}

TEST(memory_of_a_steady_filter)
{
    const word mean[2] = {0};
    sensor_model one;
    put_independent(&one, 2, 1, range, measured_range, H, r);
    ASSERT_OK(S(gain)(&track, &radar.sensor, gains));
    ASSERT_REFUSED_WITH(steady.components, 200, KQ_ERR_SIZE, S(steady_init)(&steady, &motion.process, &radar.sensor, mean, gains, 1));
    ASSERT_REFUSED_WITH(steady.memory, NULL, KQ_ERR_MEMORY, S(steady_init)(&steady, &motion.process, &radar.sensor, mean, gains, 1));
    ASSERT_REFUSED_WITH(steady.length, 1, KQ_ERR_MEMORY, S(steady_init)(&steady, &motion.process, &radar.sensor, mean, gains, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(steady_init)(&steady, &motion.process, &one.sensor, mean, gains, 1));
    ASSERT_OK(S(steady_init)(&steady, &motion.process, &radar.sensor, mean, gains, 1));
#ifdef KQ_TEST_Q31
    TEST_ASSERT_TRUE(is_nothing(S(steady_mean_low)(&steady, 2)));
    TEST_ASSERT_EQUAL_INT(0, S(steady_mean_low)(&steady, 1));
#endif
}

TEST(memory_of_a_window)
{
    ASSERT_OK(S(consistency_clear)(&recent));
    ASSERT_REFUSED_WITH(recent.window, 0, KQ_ERR_NOT_READY, S(consistency_clear)(&recent));
    ASSERT_REFUSED_WITH(recent.memory, NULL, KQ_ERR_NOT_READY, S(consistency_clear)(&recent));
    ASSERT_OK(S(attach)(&track, &tape.attached)); /* what records is never frozen */
    ASSERT_OK(S(consistency_watch)(&recent, &track, &radar.sensor, z, UINT32_MAX));
    ASSERT_OK(S(update)(&track, &radar.sensor, z));
    ASSERT_OK(S(consistency_record)(&recent, &track));
}

TEST(memory_of_jacobians)
{
    ASSERT_REFUSED_WITH(kept.states, 200, KQ_ERR_SIZE, S(attach)(&track, &kept.attached));
    ASSERT_REFUSED_WITH(kept.memory, NULL, KQ_ERR_MEMORY, S(attach)(&track, &kept.attached));
    ASSERT_REFUSED_WITH(kept.processes, NULL, KQ_ERR_MEMORY, S(attach)(&track, &kept.attached));
    ASSERT_REFUSED_WITH(tape.states, 1, KQ_ERR_MISMATCH, S(attach)(&track, &kept.attached));
    ASSERT_REFUSED_WITH(tape.states, 0, KQ_ERR_SIZE, S(attach)(&track, &kept.attached));
    ASSERT_OK(S(attach)(&track, &kept.attached));
    ASSERT_OK(S(detach)(&kept.attached));
}

TEST(a_delay_is_of_something)
{
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, S(delay_assign)(NULL, 2, 2, 0, lag_memory, COUNT(lag_memory)));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, S(delay_assign)(&lag, 2, 2, 0, NULL, COUNT(lag_memory)));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_SIZE, S(delay_assign)(&lag, 2, 2, 0, lag_memory, COUNT(lag_memory)));
}

/* ----------------------------------------------------------------------- recordings */

/* A tape counts 65534 measurements of a step: the next one ends it. */
TEST(a_tape_counts_to_its_end)
{
    ASSERT_OK(S(attach)(&track, &tape.attached));
    tape.records = UINT16_MAX;
    ASSERT_OK(S(update)(&track, &radar.sensor, z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, S(events)(&track));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_FULL, S(smooth)(&tape));
}

/* A noise-free measurement that repeats one is redundant: it is recorded as none, and ends a tape that is full. */
TEST(what_is_not_taken_is_recorded)
{
    static const num none[] = {0, 0};
    sensor_model sharp;
    put_independent(&sharp, 2, 2, range, measured_range, H, none);
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(update)(&track, &sharp.sensor, z));
    const uint16_t records = tape.records;
    ASSERT_OK(S(update)(&track, &sharp.sensor, z));
    TEST_ASSERT_EQUAL_INT(records + 2, tape.records);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, S(events)(&track) & (KQ_EVENT_REDUNDANT | KQ_EVENT_HISTORY_FULL));
    ASSERT_OK(S(smooth)(&tape));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    tape.records = UINT16_MAX;
    ASSERT_OK(S(update)(&track, &sharp.sensor, z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, S(events)(&track) & KQ_EVENT_HISTORY_FULL);
}

TEST(a_recording_that_lost_its_filter)
{
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(update)(&track, &radar.sensor, z));
    ASSERT_REFUSED_WITH(tape.filter, NULL, KQ_ERR_HISTORY_EMPTY, S(smooth)(&tape));
    ASSERT_REFUSED_WITH(track.attached, NULL, KQ_ERR_HISTORY_EMPTY, S(smooth)(&tape));
}

TEST(what_is_smoothed_can_be_shown)
{
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, S(smoothed)(NULL, 0, &view));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(step)(&track, &motion.process, u, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, S(smoothed)(&tape, 0, &view));
    ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, S(smoothed)(&tape, 0, &view));
    ASSERT_OK(S(smoothed)(&tape, 1, &view));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_SIZE, S(smoothed)(&tape, 2, &view));
}

/* States alone stay to be read, too, once the tape is detached. */
TEST(smoothed_states_outlast_the_attachment)
{
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(step)(&track, &motion.process, u, &radar.sensor, z));
    ASSERT_OK(S(smooth_states)(&tape));
    ASSERT_OK(S(detach)(&tape.attached));
    ASSERT_OK(S(smoothed)(&tape, 0, &view));
}

/* A copy of a filter is none that the tape records: its steps leave the tape alone. */
TEST(a_copy_of_a_recorded_filter)
{
    ASSERT_OK(S(attach)(&track, &tape.attached));
    S(filter) copy = track;
    const size_t steps = S(history_steps)(&tape);
    ASSERT_OK(S(predict)(&copy, &motion.process, u));
    TEST_ASSERT_TRUE(S(history_steps)(&tape) == steps);
    TEST_ASSERT_NULL(copy.attached);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, S(events)(&copy));
}

SUITE(conditions, set_up)
#include "conditions.tests"
