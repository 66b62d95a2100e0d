/* EM: its E-step beside filter and smoother, its M-step beside sums of what they tell, what is
   held, what is refused; and a fit that comes out the same on every chip. */
#include "reading.h"
#include "sizes.h"
#include "unchanged.h"

#ifdef KQ_TEST_F32
#define EM KQ_EM_F32
#define EM_LEN KQ_EM_LEN_F32
#else
#define EM KQ_EM_F64
#define EM_LEN KQ_EM_LEN_F64
#endif

#define STEPS 30
#define LONG 200

EM(em, 2, 2, STEPS);
EM(twin, 2, 2, STEPS);
PROCESS(motion, 2, 1);
SENSOR(radar, 2, 2);
FILTER(track, 2);
HISTORY(tape, 2, 2, STEPS, 0);

/* What the tests begin with: two states, two correlated components, a control */
static const num A_first[] = {0.75, 0.5, -0.25, 0.5}, Q_first[] = {0.5, 0.125, 0.125, 0.25};
static const num H_first[] = {1, 0, 0.5, 1}, R_first[] = {0.5, 0.25, 0.25, 1};
static const num x0_first[] = {1, -2}, P0_first[] = {2, 0.5, 0.5, 1};
static const num B[] = {0.125, 0.5};

static struct {
    num A[4], Q[4], H[4], R[4], x0[2], P0[4];
} model, other_model;
static K(parameters) parameters, other_parameters;
static K(recording) recordings[2];
static kq_em_choice choice;
static num z[2 * STEPS], u[STEPS - 1];
static uint16_t present[STEPS];

static K(parameters) put_model(void *at)
{
    memcpy(model.A, A_first, sizeof A_first);
    memcpy(model.Q, Q_first, sizeof Q_first);
    memcpy(model.H, H_first, sizeof H_first);
    memcpy(model.R, R_first, sizeof R_first);
    memcpy(model.x0, x0_first, sizeof x0_first);
    memcpy(model.P0, P0_first, sizeof P0_first);
    memcpy(at, &model, sizeof model);
    num *p = at;
    const K(parameters) all = {1, 0, p, B, NULL, p + 4, p + 8, p + 12, p + 16, p + 18};
    return all;
}

static void set_up(void)
{
    uint32_t seed = 7;
    parameters = put_model(&model);
    other_parameters = put_model(&other_model);
    for (int t = 0; t < STEPS; t++) {
        z[2 * t] = 2 * noise(&seed);
        z[2 * t + 1] = 2 * noise(&seed) - 1;
        present[t] = (uint16_t)(t % 5 == 2 ? 0 : t % 4 == 1 ? 2 : t % 7 == 3 ? 1 : 3);
        if (t + 1 < STEPS) u[t] = noise(&seed);
    }
    const K(recording) whole = {STEPS, z, NULL, u};
    recordings[0] = recordings[1] = whole;
    const kq_em_choice usual = {KQ_EM_Q | KQ_EM_R, KQ_EM_FULL, KQ_EM_FULL, NULL, NULL};
    choice = usual;
    ASSERT_OK(K(em_assign)(&em, 2, 2, em_memory, COUNT(em_memory)));
    ASSERT_OK(K(em_assign)(&twin, 2, 2, twin_memory, COUNT(twin_memory)));
    memset(em_memory, 0, sizeof em_memory);
    watch_nothing();
}

static void expect(void)
{
    do ASSERT_OK(K(em_advance)(&em));
    while (K(em_remaining)(&em));
}

/* The filter over recording 0, on a tape */
static void run_filter(void)
{
    ASSERT_OK(K(process_init)(&motion, A_first, B, Q_first));
    ASSERT_OK(K(sensor_init)(&radar, H_first, R_first));
    ASSERT_OK(K(filter_init)(&track, x0_first, P0_first));
    ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    for (int t = 0; t < STEPS; t++) {
        const uint32_t there = recordings[0].present ? present[t] : 3;
        if (t) ASSERT_OK(K(predict)(&track, &motion, recordings[0].u ? u + t - 1 : NULL));
        ASSERT_OK(K(update_subset)(&track, &radar, z + 2 * t, there));
    }
}

/* ------------------------------------------------------------------ E-step */

TEST(test_log_likelihood_is_the_filters)
{
    for (int gaps = 0; gaps < 2; gaps++) {
        recordings[0].present = gaps ? present : NULL;
        ASSERT_OK(K(em_init)(&em, &parameters, NULL, recordings, 1));
        ASSERT_NAN(K(em_log_likelihood)(&em));
        ASSERT_OK(K(em_advance)(&em));
        ASSERT_NAN(K(em_log_likelihood)(&em));
        expect();
        run_filter();
        TEST_ASSERT_EQUAL_MEMORY(&(num){K(log_likelihood)(&track)},
                                 &(num){K(em_log_likelihood)(&em)}, sizeof(num));
    }
}

TEST(test_slices_are_counted_and_make_the_same_iteration)
{
    recordings[0].present = present;
    choice.free = KQ_EM_ALL;
    recordings[1].steps = 11;
    kq_em_choice all = choice;
    TEST_ASSERT_EQUAL_INT(KQ_NOT_IDENTIFIED, K(em_init)(&em, &parameters, &all, recordings, 2));
    TEST_ASSERT_EQUAL_INT(KQ_NOT_IDENTIFIED,
                          K(em_init)(&twin, &other_parameters, &all, recordings, 2));
    TEST_ASSERT_EQUAL_UINT32(0, K(em_remaining)(&em));
    for (uint32_t left = 2 * (STEPS + 11); left > 0; left--) {
        ASSERT_OK(K(em_advance)(&em));
        TEST_ASSERT_EQUAL_UINT32(left - 1, K(em_remaining)(&em));
    }
    ASSERT_OK(K(em_maximise)(&em));
    ASSERT_OK(K(em_iterate)(&twin));
    ASSERT_SAME_BITS(model, other_model);
    TEST_ASSERT_TRUE(K(em_log_likelihood)(&em) == K(em_log_likelihood)(&twin));
    TEST_ASSERT_TRUE(K(em_change)(&em) == K(em_change)(&twin));
}

TEST(test_a_new_e_step_begins_after_the_last)
{
    ASSERT_OK(K(em_init)(&em, &parameters, NULL, recordings, 1));
    expect();
    const num first = K(em_log_likelihood)(&em);
    expect();
    TEST_ASSERT_TRUE(first == K(em_log_likelihood)(&em));
    ASSERT_OK(K(em_maximise)(&em));
    TEST_ASSERT_TRUE(first == K(em_log_likelihood)(&em));
    expect();
    TEST_ASSERT_TRUE(first < K(em_log_likelihood)(&em));
}

/* ------------------------------------------------------------------ M-step */

/* Sums of what the smoother tells: E[w w'], E[u u'] of decorrelated components, x and P of step 0
 */
static double of_Q[4], of_R[2], first_x[2];
static num first_P[4];

static void sum_smoothed(void)
{
    num mean[2], covariance[4], u_mean, u_variance;
    const K(smooth_extras) extras = {NULL, mean, covariance};
    memset(of_Q, 0, sizeof of_Q);
    memset(of_R, 0, sizeof of_R);
    for (int t = STEPS - 1; t >= 0; t--) {
        ASSERT_OK(K(smooth_step)(&tape, NULL, &extras));
        for (int k = 0; k < 4 && t < STEPS - 1; k++) {
            of_Q[k] += (double)mean[k / 2] * (double)mean[k % 2] + (double)covariance[k];
        }
        for (int c = 0; c < 2; c++) {
            ASSERT_OK(K(smoothed_measurement_noise)(&tape, c, &u_mean, &u_variance));
            of_R[c] += (double)u_mean * (double)u_mean + (double)u_variance;
        }
    }
    for (int i = 0; i < 2; i++) first_x[i] = whole_smoothed_mean(&tape, 0, i);
    ASSERT_OK(K(covariance)(SMOOTHED(&tape, 0), first_P));
}

TEST(test_new_parameters_are_means_of_the_smoothed_noises)
{
    choice.free = KQ_EM_Q | KQ_EM_X0 | KQ_EM_P0;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
    ASSERT_OK(K(em_iterate)(&em));
    run_filter();
    sum_smoothed();
    for (int k = 0; k < 4; k++) {
        ASSERT_CLOSE(of_Q[k] / (STEPS - 1), model.Q[k], 1);
        ASSERT_CLOSE(first_P[k], model.P0[k], 1);
    }
    for (int i = 0; i < 2; i++) ASSERT_CLOSE(first_x[i], model.x0[i], 4);
    ASSERT_SAME_BITS(A_first, model.A);
    ASSERT_SAME_BITS(H_first, model.H);
    ASSERT_SAME_BITS(R_first, model.R);
}

/* Of the components' own noises, those of the smoother in its decorrelated ones: U^-1 v, R = U D U'
 */
TEST(test_measurement_noise_is_correlated_as_R)
{
    choice.free = KQ_EM_R;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
    ASSERT_OK(K(em_iterate)(&em));
    run_filter();
    sum_smoothed();
    const double slope = 0.25,
                 own = 0.5 - slope * 0.25; /* v_0 - slope v_1 and v_1 are independent */
    const double r00 = (double)model.R[0], r01 = (double)model.R[1], r11 = (double)model.R[3];
    ASSERT_CLOSE(of_R[1] / STEPS, r11, 1);
    ASSERT_CLOSE(own * of_R[0] / STEPS, r00 - 2 * slope * r01 + slope * slope * r11, 1);
    TEST_ASSERT_TRUE(model.R[1] == model.R[2]);
}

TEST(test_recordings_add_up)
{
    choice.free = KQ_EM_ALL;
    recordings[0].present = recordings[1].present = present;
    TEST_ASSERT_EQUAL_INT(KQ_NOT_IDENTIFIED, K(em_init)(&em, &parameters, &choice, recordings, 2));
    TEST_ASSERT_EQUAL_INT(KQ_NOT_IDENTIFIED,
                          K(em_init)(&twin, &other_parameters, &choice, recordings, 1));
    ASSERT_OK(K(em_iterate)(&em));
    ASSERT_OK(K(em_iterate)(&twin));
    ASSERT_CLOSE(2 * (double)K(em_log_likelihood)(&twin), K(em_log_likelihood)(&em), 100);
    const num *one = (const num *)&other_model, *two = (const num *)&model;
    for (size_t k = 0; k < sizeof model / sizeof(num); k++) ASSERT_CLOSE(one[k], two[k], 4);
}

/* Steps at the end that nothing was measured in: H and R are those of the steps before. */
TEST(test_a_step_without_measurement_has_no_part_in_H_and_R)
{
    choice.free = KQ_EM_H | KQ_EM_R;
    for (int t = 0; t < STEPS; t++) present[t] = t < STEPS / 2 ? 3 : 0;
    recordings[0].present = present;
    recordings[1].steps = STEPS / 2;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
    ASSERT_OK(K(em_init)(&twin, &other_parameters, &choice, recordings + 1, 1));
    ASSERT_OK(K(em_iterate)(&em));
    ASSERT_OK(K(em_iterate)(&twin));
    for (int k = 0; k < 4; k++) {
        ASSERT_CLOSE(other_model.R[k], model.R[k], 2);
        ASSERT_CLOSE(other_model.H[k], model.H[k], 4);
    }
}

/* Beside one that is measured, a component counts with the R that is expected of it. */
TEST(test_a_missing_component_contributes_the_current_R)
{
    choice.free = KQ_EM_R;
    model.R[1] = model.R[2] = 0;
    for (int t = 0; t < STEPS; t++) present[t] = 1;
    recordings[0].present = present;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
    ASSERT_OK(K(em_iterate)(&em));
    TEST_ASSERT_TRUE(model.R[0] != R_first[0]);
    ASSERT_CLOSE(R_first[3], model.R[3], 1);
    ASSERT_CLOSE(0, model.R[1], 1);
}

TEST(test_missing_measurements_are_not_read)
{
    recordings[0].present = present;
    ASSERT_OK(K(em_init)(&em, &parameters, NULL, recordings, 1));
    ASSERT_OK(K(em_iterate)(&em));
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < 2; c++) {
            if (!(present[t] >> c & 1)) z[2 * t + c] = N(NAN);
        }
    }
    ASSERT_OK(K(em_init)(&twin, &other_parameters, NULL, recordings, 1));
    ASSERT_OK(K(em_iterate)(&twin));
    ASSERT_SAME_BITS(model, other_model);
}

/* z less what the control alone makes of it, without the control */
TEST(test_a_control_is_what_it_does)
{
    static num plain[2 * STEPS];
    double x[2] = {0, 0};
    recordings[0].present = present;
    recordings[1] = recordings[0];
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < 2; c++) {
            const double shift = (double)H_first[2 * c] * x[0] + (double)H_first[2 * c + 1] * x[1];
            plain[2 * t + c] = N((double)z[2 * t + c] - shift);
        }
        if (t == STEPS - 1) continue;
        const double before = x[0];
        x[0] = 0.75 * x[0] + 0.5 * x[1] + 0.125 * (double)u[t];
        x[1] = -0.25 * before + 0.5 * x[1] + 0.5 * (double)u[t];
    }
    recordings[1].z = plain;
    recordings[1].u = NULL;
    ASSERT_OK(K(em_init)(&em, &parameters, NULL, recordings, 1));
    ASSERT_OK(K(em_init)(&twin, &other_parameters, NULL, recordings + 1, 1));
    ASSERT_OK(K(em_iterate)(&em));
    ASSERT_OK(K(em_iterate)(&twin));
    for (int k = 0; k < 4; k++) {
        ASSERT_CLOSE(other_model.Q[k], model.Q[k], 2);
        ASSERT_CLOSE(other_model.R[k], model.R[k], 2);
    }
}

TEST(test_likelihood_rises_with_everything_free)
{
    num last = -NUM_MAX;
    choice.free = KQ_EM_ALL;
    recordings[0].present = present;
    TEST_ASSERT_EQUAL_INT(KQ_NOT_IDENTIFIED, K(em_init)(&em, &parameters, &choice, recordings, 2));
    for (int k = 0; k < 12; k++) {
        ASSERT_OK(K(em_iterate)(&em));
        const num now = K(em_log_likelihood)(&em);
        TEST_ASSERT_TRUE((double)now >= (double)last - 100 * TOLERANCE);
        last = now;
    }
}

/* ------------------------------------------------------------------ what is held, and forms */

TEST(test_held_entries_stay)
{
    static const uint8_t A_held[] = {0, 1, 1, 0}, H_held[] = {1, 1, 0, 1};
    choice.free = KQ_EM_A | KQ_EM_H | KQ_EM_Q | KQ_EM_R;
    choice.A_held = A_held;
    choice.H_held = H_held;
    recordings[0].present = present;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
    num last = -NUM_MAX;
    for (int k = 0; k < 8; k++) {
        ASSERT_OK(K(em_iterate)(&em));
        TEST_ASSERT_TRUE(K(em_log_likelihood)(&em) >= last);
        last = K(em_log_likelihood)(&em);
    }
    for (int k = 0; k < 4; k++) {
        TEST_ASSERT_EQUAL_INT(A_held[k], model.A[k] == A_first[k]);
        TEST_ASSERT_EQUAL_INT(H_held[k], model.H[k] == H_first[k]);
    }
    ASSERT_SAME_BITS(x0_first, model.x0);
    ASSERT_SAME_BITS(P0_first, model.P0);
}

TEST(test_a_mask_that_holds_nothing_is_no_mask)
{
    static const uint8_t none[4] = {0, 0, 0, 0};
    const kq_em_choice masked = {KQ_EM_A | KQ_EM_R, KQ_EM_FULL, KQ_EM_FULL, none, none};
    choice.free = KQ_EM_A | KQ_EM_R;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
    ASSERT_OK(K(em_init)(&twin, &other_parameters, &masked, recordings, 1));
    ASSERT_OK(K(em_iterate)(&em));
    ASSERT_OK(K(em_iterate)(&twin));
    ASSERT_SAME_BITS(model, other_model);
}

TEST(test_forms_are_kept)
{
    choice.Q_form = KQ_EM_MULTIPLE;
    choice.R_form = KQ_EM_DIAGONAL;
    model.R[1] = model.R[2] = 0;
    recordings[0].present = present;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
    for (int k = 0; k < 5; k++) ASSERT_OK(K(em_iterate)(&em));
    TEST_ASSERT_TRUE(model.R[1] == 0 && model.R[2] == 0);
    TEST_ASSERT_TRUE(model.R[0] != R_first[0] && model.R[3] != R_first[3]);
    const double multiple = (double)model.Q[0] / (double)Q_first[0];
    TEST_ASSERT_TRUE(multiple > 0 && multiple != 1);
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(multiple * (double)Q_first[k], model.Q[k], 1);
}

/* One noise on both states: Q = q F F', and F as a factor with q as its Q */
TEST(test_noise_through_a_factor)
{
    static const num F[] = {0.5, 1};
    static num q[] = {0.25};
    for (int k = 0; k < 4; k++) model.Q[k] = q[0] * F[k / 2] * F[k % 2];
    other_parameters.F = F;
    other_parameters.noises = 1;
    other_parameters.Q = q;
    choice.Q_form = KQ_EM_MULTIPLE;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
    ASSERT_OK(K(em_init)(&twin, &other_parameters, NULL, recordings, 1));
    for (int k = 0; k < 5; k++) {
        ASSERT_OK(K(em_iterate)(&em));
        ASSERT_OK(K(em_iterate)(&twin));
    }
    TEST_ASSERT_TRUE(q[0] != (num)0.25);
    for (int k = 0; k < 4; k++) {
        ASSERT_CLOSE((double)q[0] * (double)F[k / 2] * (double)F[k % 2], model.Q[k], 4);
        ASSERT_CLOSE(other_model.R[k], model.R[k], 4);
    }
}

/* (F q F')_ij of two noises */
static num through_factor(const num *F, const num *q, int i, int j)
{
    num total = 0;
    for (int k = 0; k < 4; k++) total += F[2 * i + k / 2] * q[k] * F[2 * j + k % 2];
    return total;
}

/* As many noises as states: Q = F q F' at the end, too. */
TEST(test_two_noises_through_a_factor)
{
    static const num F[] = {0.5, 1, 1, 0};
    static num q[] = {0.25, 0.125, 0.125, 0.5};
    for (int k = 0; k < 4; k++) model.Q[k] = through_factor(F, q, k / 2, k % 2);
    other_parameters.F = F;
    other_parameters.noises = 2;
    other_parameters.Q = q;
    ASSERT_OK(K(em_init)(&em, &parameters, NULL, recordings, 1));
    ASSERT_OK(K(em_init)(&twin, &other_parameters, NULL, recordings, 1));
    for (int k = 0; k < 5; k++) {
        ASSERT_OK(K(em_iterate)(&em));
        ASSERT_OK(K(em_iterate)(&twin));
    }
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(through_factor(F, q, k / 2, k % 2), model.Q[k], 4);
}

/* Rows that the noise does not move stay as they are. */
TEST(test_a_singular_noise_holds_rows_of_A)
{
    memset(model.Q, 0, sizeof model.Q);
    model.Q[0] = 1;
    choice.free = KQ_EM_A;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
    ASSERT_OK(K(em_iterate)(&em));
    TEST_ASSERT_TRUE(model.A[0] != A_first[0] && model.A[1] != A_first[1]);
    ASSERT_CLOSE(A_first[2], model.A[2], 0x1p-20);
    ASSERT_CLOSE(A_first[3], model.A[3], 0x1p-20);
}

TEST(test_what_is_not_identified_is_told)
{
    static const uint8_t one[] = {1, 0, 0, 0}, zero[] = {0, 1, 0, 0};
    choice.free = KQ_EM_H | KQ_EM_Q;
    TEST_ASSERT_EQUAL_INT(KQ_NOT_IDENTIFIED, K(em_init)(&em, &parameters, &choice, recordings, 1));
    choice.H_held = zero;
    TEST_ASSERT_EQUAL_INT(KQ_NOT_IDENTIFIED, K(em_init)(&em, &parameters, &choice, recordings, 1));
    choice.H_held = one;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
    choice.H_held = NULL;
    choice.free = KQ_EM_H | KQ_EM_R;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
}

TEST(test_stop_rule)
{
    ASSERT_NAN(K(em_change)(&em));
    ASSERT_OK(K(em_init)(&em, &parameters, NULL, recordings, 1));
    ASSERT_NAN(K(em_change)(&em));
    ASSERT_OK(K(em_iterate)(&em));
    double largest = 0;
    for (int k = 0; k < 4; k++) {
        const double q = sqrt((double)Q_first[3 * (k / 2)] * (double)Q_first[3 * (k % 2)]);
        const double r = sqrt((double)R_first[3 * (k / 2)] * (double)R_first[3 * (k % 2)]);
        largest = fmax(largest, fabs((double)model.Q[k] - (double)Q_first[k]) / q);
        largest = fmax(largest, fabs((double)model.R[k] - (double)R_first[k]) / r);
    }
    ASSERT_CLOSE(largest, K(em_change)(&em), 1);
}

TEST(test_distance_to_the_maximum)
{
    ASSERT_NAN(K(em_distance)(&em));
    ASSERT_OK(K(em_init)(&em, &parameters, NULL, recordings, 1));
    for (int k = 0; k < 2; k++) {
        ASSERT_NAN(K(em_distance)(&em));
        ASSERT_OK(K(em_iterate)(&em));
    }
    for (int k = 0; k < 20; k++) { /* the change of an iteration is the rate of the next */
        const num before = K(em_change)(&em), likelihood = K(em_log_likelihood)(&em);
        ASSERT_OK(K(em_iterate)(&em));
        const double gain = (double)K(em_log_likelihood)(&em) - (double)likelihood;
        const double rate = (double)K(em_change)(&em) / (double)before;
        const double expected = gain * rate * rate / (1 - rate);
        if (rate >= 1) continue;
        ASSERT_WITHIN(1e-2 * expected + 1e4 * EPS, expected, K(em_distance)(&em));
    }
    ASSERT_OK(K(em_advance)(&em));
    ASSERT_NAN(K(em_distance)(&em));
    ASSERT_NAN(K(em_distance)(NULL));
}

/* ------------------------------------------------------------------ gradient */

static double likelihood_at(num *parameter, num value)
{
    const num before = *parameter;
    *parameter = value;
    expect();
    *parameter = before;
    return (double)K(em_log_likelihood)(&em);
}

/* Central differences have (step)^2 and rounding / step to lose. */
static void assert_derivative(num *parameter, num *twin_parameter, num derivative)
{
    const double step = cbrt(EPS), tolerance = 4000 * step * step;
    const num value = *parameter, up = value + N(step), down = value - N(step);
    double difference;
    if (twin_parameter == parameter) {
        difference = likelihood_at(parameter, up) - likelihood_at(parameter, down);
    } else { /* both triangles of a covariance */
        *twin_parameter = up;
        difference = likelihood_at(parameter, up);
        *twin_parameter = down;
        difference -= likelihood_at(parameter, down);
        *twin_parameter = value;
        difference /= 2;
    }
    ASSERT_WITHIN(tolerance, difference / ((double)up - (double)down), derivative);
}

TEST(test_gradient_against_differences)
{
    struct {
        num A[4], H[4], Q[4], R[4], x0[2], P0[4];
    } g;
    const K(gradient) gradient = {g.A, g.H, g.Q, g.R, g.x0, g.P0};
    choice.free = KQ_EM_ALL;
    recordings[0].present = present;
    recordings[1].steps = 9;
    TEST_ASSERT_EQUAL_INT(KQ_NOT_IDENTIFIED, K(em_init)(&em, &parameters, &choice, recordings, 2));
    expect();
    ASSERT_OK(K(em_gradient)(&em, &gradient));
    for (int k = 0; k < 4; k++) {
        const int transposed = k == 1 ? 2 : k == 2 ? 1 : k;
        assert_derivative(model.A + k, model.A + k, g.A[k]);
        assert_derivative(model.H + k, model.H + k, g.H[k]);
        assert_derivative(model.Q + k, model.Q + transposed, g.Q[k]);
        assert_derivative(model.R + k, model.R + transposed, g.R[k]);
        assert_derivative(model.P0 + k, model.P0 + transposed, g.P0[k]);
    }
    for (int i = 0; i < 2; i++) assert_derivative(model.x0 + i, model.x0 + i, g.x0[i]);
}

TEST(test_gradient_says_where_it_is_not_known)
{
    num of_A[4], of_Q[4];
    const K(gradient) gradient = {of_A, NULL, of_Q, NULL, NULL, NULL};
    memset(model.Q, 0, sizeof model.Q);
    model.Q[0] = 1;
    choice.free = KQ_EM_A;
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
    expect();
    ASSERT_OK(K(em_gradient)(&em, &gradient));
    for (int k = 0; k < 4; k++) {
        TEST_ASSERT_EQUAL_INT(k >= 2, isnan(of_A[k]) != 0);
        TEST_ASSERT_EQUAL_INT(k >= 1, isnan(of_Q[k]) != 0);
    }
}

TEST(test_gradient_of_what_is_not_free_is_refused)
{
    static num out[4];
    static const unsigned free[] = {KQ_EM_A, KQ_EM_H, KQ_EM_X0};
    const K(gradient) of[] = {{.A = out}, {.H = out}, {.x0 = out}};
    const K(gradient) always = {.Q = out, .R = NULL, .P0 = NULL};
    for (int k = 0; k < 3; k++) {
        choice.free = KQ_EM_Q | (KQ_EM_ALL & ~free[k] & ~(unsigned)KQ_EM_Q);
        if (choice.free & KQ_EM_H)
            TEST_ASSERT_EQUAL_INT(KQ_NOT_IDENTIFIED,
                                  K(em_init)(&em, &parameters, &choice, recordings, 1));
        else ASSERT_OK(K(em_init)(&em, &parameters, &choice, recordings, 1));
        WATCH(em), WATCH(out);
        ASSERT_REFUSED(KQ_ERR_NOT_READY, K(em_gradient)(&em, &always));
        expect();
        ASSERT_REFUSED(KQ_ERR_NOT_READY, K(em_gradient)(&em, of + k));
        ASSERT_REFUSED(KQ_ERR_NULL, K(em_gradient)(&em, NULL));
        ASSERT_REFUSED(KQ_ERR_NULL, K(em_gradient)(NULL, &always));
        ASSERT_OK(K(em_gradient)(&em, &always));
        ASSERT_OK(K(em_maximise)(&em));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, K(em_gradient)(&em, &always));
        set_up();
    }
}

/* ------------------------------------------------------------------ what is refused */

static void watch_all(void)
{
    WATCH(em), WATCH(model), WATCH(recordings), WATCH(choice), WATCH(parameters);
    watch(em_memory, 2048); /* the object's own, without the tape */
}

static kq_status init(void) { return K(em_init)(&em, &parameters, &choice, recordings, 2); }

TEST(test_what_was_never_initialised_is_refused)
{
    K(em) none;
    memset(&none, 0, sizeof none);
    ASSERT_OK(K(em_assign)(&em, 2, 2, em_memory, COUNT(em_memory)));
    watch_all();
    WATCH(none);
    ASSERT_REFUSED_SIZE_OR_MEMORY(K(em_init)(&none, &parameters, NULL, recordings, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(em_iterate)(&em)); /* assigned, not initialised */
    TEST_ASSERT_EQUAL_UINT32(0, K(em_remaining)(NULL));
    ASSERT_NAN(K(em_log_likelihood)(NULL));
    ASSERT_NAN(K(em_log_likelihood)(&none));
    ASSERT_NAN(K(em_change)(NULL));
}

TEST(test_maximise_refuses_half_an_e_step)
{
    ASSERT_OK(init());
    watch_all();
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(em_maximise)(&em));
    ASSERT_OK(K(em_advance)(&em));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(em_maximise)(&em));
    expect();
    ASSERT_OK(K(em_maximise)(&em));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(em_maximise)(&em));
}

TEST(test_init_refuses_null)
{
    num **arrays[] = {&parameters.A, &parameters.H,  &parameters.Q,
                      &parameters.R, &parameters.x0, &parameters.P0};
    watch_all();
    ASSERT_REFUSED(KQ_ERR_NULL, K(em_init)(NULL, &parameters, NULL, recordings, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(em_init)(&em, NULL, NULL, recordings, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(em_init)(&em, &parameters, NULL, NULL, 1));
    for (int k = 0; k < COUNT(arrays); k++) ASSERT_REFUSED_WITH(*arrays[k], NULL, KQ_ERR_NULL, init());
    ASSERT_REFUSED_WITH(parameters.B, NULL, KQ_ERR_NULL, init());
    ASSERT_REFUSED_WITH(recordings[1].z, NULL, KQ_ERR_NULL, init());
}

TEST(test_init_refuses_sizes)
{
    static const num F[] = {1, 0, 0, 1, 1, 1};
    watch_all();
    ASSERT_REFUSED(KQ_ERR_SIZE, K(em_init)(&em, &parameters, NULL, recordings, 0));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(em_init)(&em, &parameters, NULL, recordings, KQ_COUNT_MAX + 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(em_init)(&em, &parameters, NULL, recordings, SIZE_MAX));
    ASSERT_REFUSED_WITH(recordings[1].steps, 0, KQ_ERR_SIZE, init());
    ASSERT_REFUSED_WITH(recordings[1].steps, KQ_COUNT_MAX + 1, KQ_ERR_SIZE, init());
    ASSERT_REFUSED_WITH(recordings[1].steps, SIZE_MAX, KQ_ERR_SIZE, init());
    ASSERT_REFUSED_WITH(recordings[1].steps, STEPS + 1, KQ_ERR_MEMORY, init());
#if SIZE_MAX > 65535
    ASSERT_REFUSED_WITH(recordings[1].steps, 65536 + STEPS, KQ_ERR_MEMORY, init()); /* STEPS in 16 bits */
#endif
    for (int32_t l = -1; l <= 17; l += 18) ASSERT_REFUSED_WITH(parameters.controls, l, KQ_ERR_SIZE, init());
    ASSERT_REFUSED_WITH(parameters.noises, 1, KQ_ERR_SIZE, init()); /* without F */
    parameters.F = F;
    for (int32_t r = 0; r <= 3; r += 3) ASSERT_REFUSED_WITH(parameters.noises, r, KQ_ERR_SIZE, init());
    parameters.F = NULL;
    ASSERT_REFUSED_WITH(choice.free, KQ_EM_ALL + 1, KQ_ERR_SIZE, init());
    choice.free = KQ_EM_ALL;
    ASSERT_REFUSED_WITH(choice.Q_form, (kq_em_form)(KQ_EM_MULTIPLE + 1), KQ_ERR_SIZE, init());
    ASSERT_REFUSED_WITH(choice.R_form, (kq_em_form)(KQ_EM_MULTIPLE + 1), KQ_ERR_SIZE, init());
}

TEST(test_there_may_be_16_controls)
{
    static num to_each[2 * KQ_SIZE_MAX], drives[KQ_SIZE_MAX * (STEPS - 1)];
    parameters.B = to_each;
    parameters.controls = KQ_SIZE_MAX;
    recordings[0].u = recordings[1].u = drives;
    ASSERT_OK(init());
}

TEST(test_init_refuses_numbers)
{
    static num controls[] = {0.125, 0.5}, factor[] = {1, 0.5};
    parameters.B = controls;
    watch_all();
    assert_entries_must_be_finite(model.A, 4, init);
    assert_entries_must_be_finite(model.H, 4, init);
    assert_entries_must_be_finite(model.x0, 2, init);
    assert_entries_must_be_finite(controls, 2, init);
    assert_entries_must_be_finite(z, 2 * STEPS, init);
    assert_entries_must_be_finite(u, STEPS - 1, init);
    assert_covariance_is_checked(model.Q, init);
    memcpy(model.Q, Q_first, sizeof Q_first);
    assert_covariance_is_checked(model.R, init);
    memcpy(model.R, R_first, sizeof R_first);
    assert_covariance_is_checked(model.P0, init);
    memcpy(model.P0, P0_first, sizeof P0_first);
    parameters.F = factor;
    parameters.noises = 1;
    assert_entries_must_be_finite(factor, 2, init);
}

TEST(what_is_behind_a_recording_is_not_read)
{
    recordings[0].steps = recordings[1].steps = STEPS - 1;
    z[2 * STEPS - 2] = z[2 * STEPS - 1] = u[STEPS - 2] = (num)NAN;
    ASSERT_OK(init());
}

TEST(test_init_refuses_too_few_measurements)
{
    memset(present, 0, sizeof present);
    recordings[0].present = recordings[1].present = present;
    watch_all();
    ASSERT_REFUSED(KQ_ERR_NO_DATA, init());
    present[3] = 0xfffc; /* bits of no component */
    ASSERT_REFUSED(KQ_ERR_NO_DATA, init());
    present[3] = 3; /* in two recordings: 4 measurements for the 3 entries of Q and 3 of R */
    ASSERT_REFUSED(KQ_ERR_FEW_DATA, init());
    choice.Q_form = KQ_EM_MULTIPLE;
    ASSERT_OK(init());
    choice.free = KQ_EM_ALL;
    ASSERT_OK(K(em_assign)(&em, 2, 2, em_memory, COUNT(em_memory)));
    memset(em_memory, 0, sizeof em_memory);
    ASSERT_REFUSED(KQ_ERR_FEW_DATA, init());
}

TEST(test_init_refuses_what_is_not_of_its_form)
{
    static num parallel[] = {1, 2, 2, 4};
    watch_all();
    choice.Q_form = KQ_EM_DIAGONAL;
    ASSERT_REFUSED(KQ_ERR_FORM, init());
    choice.Q_form = KQ_EM_FULL;
    choice.R_form = KQ_EM_DIAGONAL;
    ASSERT_REFUSED(KQ_ERR_FORM, init());
    choice.free = KQ_EM_Q; /* R is held: its form is of no interest */
    ASSERT_OK(init());
    ASSERT_OK(K(em_assign)(&em, 2, 2, em_memory, COUNT(em_memory)));
    memset(em_memory, 0, sizeof em_memory);
    memset(model.Q, 0, sizeof model.Q);
    choice.Q_form = KQ_EM_MULTIPLE;
    ASSERT_REFUSED(KQ_ERR_FORM, init());
    choice.Q_form = KQ_EM_FULL;
    parameters.F = parallel;
    parameters.noises = 2;
    ASSERT_REFUSED(KQ_ERR_FORM, init());
}

/* Nothing is noisy, and the measurement is not what it has to be; then far beyond the numbers. */
TEST(test_a_likelihood_that_is_not_finite_is_refused)
{
    memset(model.Q, 0, sizeof model.Q);
    memset(model.P0, 0, sizeof model.P0);
    memset(model.R, 0, sizeof model.R);
    ASSERT_OK(init());
    watch_nothing();
    WATCH(model), WATCH(recordings), WATCH(choice), WATCH(parameters);
    ASSERT_REFUSED(KQ_ERR_LIKELIHOOD, K(em_iterate)(&em));
    TEST_ASSERT_EQUAL_UINT32(0, K(em_remaining)(&em));
    ASSERT_NAN(K(em_log_likelihood)(&em));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(em_maximise)(&em));
    memcpy(model.R, R_first, sizeof R_first);
    z[0] = NUM_MAX / 2;
    ASSERT_REFUSED(KQ_ERR_LIKELIHOOD, K(em_iterate)(&em));
    z[0] = 1;
    ASSERT_OK(K(em_iterate)(&em));
}

/* A measurement at the last step, 2^61 sigmas off: the smoothed means before it overflow, and nothing is learnt of them. */
TEST(test_a_smoothed_mean_that_overflows_is_refused)
{
    static uint16_t present[STEPS];
    static const num identity[] = {1, 0, 0, 1};
    const num square = N(MOST_SIGMA) * N(MOST_SIGMA), wide[] = {square / 4, 0, 0, 1};
    kq_status status = KQ_OK;
    memcpy(model.A, identity, sizeof identity), memcpy(model.H, identity, sizeof identity);
    memcpy(model.P0, wide, sizeof wide), memcpy(model.R, wide, sizeof wide);
    for (int t = 0; t < STEPS; t++) present[t] = t < STEPS - 1 ? 2 : 3;
    z[2 * (STEPS - 1)] = N(2.5) * square;
    recordings[0].present = recordings[1].present = present;
    ASSERT_OK(init());
    do status = K(em_advance)(&em);
    while (!status && K(em_remaining)(&em));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_LIKELIHOOD, status);
}

/* A state that is not measured grows beyond what can be represented: its history has ended, and is not smoothed. */
TEST(test_a_state_that_overflows_is_refused)
{
    static uint16_t none[STEPS];
    model.A[0] = N(0x1p60);
    none[0] = none[STEPS - 1] = 3;
    for (int k = 0; k < 2; k++) {
        recordings[0].present = none;
        memset(em_memory, k ? 0xA5 : 0, sizeof em_memory);
        ASSERT_OK(init());
        watch_nothing();
        WATCH(model);
        ASSERT_REFUSED(KQ_ERR_LIKELIHOOD, K(em_iterate)(&em));
        ASSERT_NAN(K(em_log_likelihood)(&em));
    }
    model.A[0] = A_first[0];
    ASSERT_OK(K(em_iterate)(&em));
}

/* The caller's arrays are read anew at every E-step. */
TEST(test_a_model_spoilt_between_iterations_is_refused)
{
    ASSERT_OK(init());
    model.Q[1] = 5;
    watch_nothing();
    WATCH(model);
    ASSERT_REFUSED(KQ_ERR_NOT_SYMMETRIC, K(em_iterate)(&em));
    model.Q[1] = Q_first[1];
    model.A[0] = N(NAN);
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(em_iterate)(&em));
    model.A[0] = A_first[0];
    ASSERT_OK(K(em_iterate)(&em));
}

/* Whoever makes the model worse after an M-step gets back what it was before. */
TEST(test_parameters_that_are_worse_are_taken_back)
{
    choice.free = KQ_EM_ALL;
    TEST_ASSERT_EQUAL_INT(KQ_NOT_IDENTIFIED, init());
    ASSERT_OK(K(em_iterate)(&em));
    const num likelihood = K(em_log_likelihood)(&em);
    for (int k = 0; k < 4; k++) model.R[k] *= 1000;
    TEST_ASSERT_EQUAL_INT(KQ_ERR_LIKELIHOOD, K(em_iterate)(&em));
    ASSERT_SAME_BITS(A_first, model.A);
    ASSERT_SAME_BITS(H_first, model.H);
    ASSERT_SAME_BITS(Q_first, model.Q);
    ASSERT_SAME_BITS(R_first, model.R);
    ASSERT_SAME_BITS(x0_first, model.x0);
    ASSERT_SAME_BITS(P0_first, model.P0);
    TEST_ASSERT_TRUE(likelihood == K(em_log_likelihood)(&em));
    TEST_ASSERT_EQUAL_UINT32(0, K(em_remaining)(&em));
    ASSERT_NAN(K(em_distance)(&em));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(em_maximise)(&em));
    ASSERT_OK(K(em_iterate)(&em));
    TEST_ASSERT_TRUE(likelihood == K(em_log_likelihood)(&em));
    for (int k = 0; k < 4; k++) model.R[k] *= 1000; /* a model of the caller's own, said by init */
    TEST_ASSERT_EQUAL_INT(KQ_NOT_IDENTIFIED, init());
    ASSERT_OK(K(em_iterate)(&em));
}

/* One component is twice the other, in z and in H: no noise that has that direction is as likely as
   none.  A refused M-step leaves all that can be read. */
TEST(test_a_noise_that_becomes_singular_is_refused)
{
    struct {
        num Q[4], R[4], P0[4];
    } before, after;
    const K(gradient) first = {NULL, NULL, before.Q, before.R, NULL, before.P0};
    const K(gradient) second = {NULL, NULL, after.Q, after.R, NULL, after.P0};
    for (int k = 0; k < 2; k++) model.H[2 + k] = 2 * model.H[k];
    for (int t = 0; t < STEPS; t++) z[2 * t + 1] = 2 * z[2 * t];
    ASSERT_OK(init());
    expect();
    const num likelihood = K(em_log_likelihood)(&em);
    ASSERT_OK(K(em_gradient)(&em, &first));
    watch_nothing();
    WATCH(em), WATCH(model), WATCH(recordings), WATCH(choice), WATCH(parameters);
    for (int k = 0; k < 2; k++) ASSERT_REFUSED(KQ_ERR_LIKELIHOOD, K(em_maximise)(&em));
    ASSERT_OK(K(em_gradient)(&em, &second));
    ASSERT_SAME_BITS(before, after);
    expect();
    TEST_ASSERT_TRUE(likelihood == K(em_log_likelihood)(&em));
}

/* One step says nothing of the process. */
TEST(test_one_step_leaves_the_process_alone)
{
    choice.free = KQ_EM_A | KQ_EM_Q | KQ_EM_X0;
    recordings[0].steps = 1;
    for (int k = 0; k < 2; k++) recordings[k] = recordings[0];
    static K(recording) many[6];
    for (int k = 0; k < COUNT(many); k++) many[k] = recordings[0];
    ASSERT_OK(K(em_init)(&em, &parameters, &choice, many, COUNT(many)));
    ASSERT_OK(K(em_iterate)(&em));
    ASSERT_SAME_BITS(A_first, model.A);
    ASSERT_SAME_BITS(Q_first, model.Q);
    TEST_ASSERT_TRUE(model.x0[0] != x0_first[0]);
}

/* ------------------------------------------------------------------ sizes */

/* where int has 16 bits an array has at most 32767 bytes, and time counts */
#define LARGEST (INT_MAX > 32767 ? 16 : 6)
#define ROOM GUARDED((size_t)EM_LEN(LARGEST, LARGEST, 3))
#define MANY 40
#define FEW (LARGEST / 2 + 2)

static num room[ROOM];
static num all_A[256], all_H[256], all_Q[256], all_R[256], all_P0[256], all_x0[16];
static num all_z[LARGEST * FEW > 48 + MANY ? LARGEST * FEW : 48 + MANY];
static K(recording) many[MANY]; /* of three steps, each a number later than the one before */

static void put_large_model(int n, int m)
{
    static const uint16_t gaps[] = {0xffff, 0x5555, 0xfffe};
    uint32_t seed = 3;
    for (int k = 0; k < 256; k++) all_H[k] = N(0.25) * noise(&seed);
    for (int k = 0; k < COUNT(all_z); k++) all_z[k] = noise(&seed);
    for (int k = 0; k < MANY; k++) {
        const K(recording) three = {3, all_z + k, gaps, NULL};
        many[k] = three;
    }
    put_identity(all_A, n, 0.5);
    put_identity(all_Q, n, 1);
    put_identity(all_P0, n, 2);
    put_identity(all_R, m, 1);
    if (m > 1) all_R[1] = all_R[m] = 0.5; /* correlated, and components are missing */
    memset(all_x0, 0, sizeof all_x0);
}

/* An iteration stays within the memory that it was given. */
static void assert_size(int n, int m, const kq_em_choice *free, int count)
{
    const size_t length = (size_t)EM_LEN(n, m, 3);
    const K(parameters) all = {0, 0, all_A, NULL, NULL, all_Q, all_H, all_R, all_x0, all_P0};
    K(em) object;
    put_large_model(n, m);
    ASSERT_OK(K(em_assign)(&object, n, m, guard(room, ROOM), length));
    TEST_ASSERT_TRUE(K(em_init)(&object, &all, free, many, (size_t)count) >= KQ_OK);
    ASSERT_OK(K(em_iterate)(&object));
    assert_guards(room, length, ROOM);
}

TEST(test_every_size_stays_within_its_memory)
{
    static uint8_t all_but_one[256];
    kq_em_choice everything = {KQ_EM_ALL, KQ_EM_DIAGONAL, KQ_EM_MULTIPLE, NULL, NULL};
    memset(all_but_one, 1, sizeof all_but_one);
    all_but_one[0] = 0;
    const kq_em_choice little = {KQ_EM_ALL - KQ_EM_P0, KQ_EM_MULTIPLE, KQ_EM_MULTIPLE, all_but_one,
                                 all_but_one};
    for (int n = 1; n <= LARGEST; n += 5) {
        for (int m = 1; m <= LARGEST; m += 5) {
            if (n <= 6) assert_size(n, m, &everything, MANY);
            assert_size(n, m, &little, 12);
        }
    }
}

/* ------------------------------------------------------------------ too few measurements */

/* n states that m components see, and m / 2 + 2 steps: a full R fits them better and better while
   it becomes singular. */
static K(recording) put_few(int n, int m, uint32_t seed)
{
    const K(recording) few = {(size_t)(m / 2 + 2), all_z, NULL, NULL};
    double x[2] = {0, 0};
    for (int k = 0; k < m * n; k++) all_H[k] = noise(&seed);
    for (int t = 0; t < (int)few.steps; t++) {
        for (int i = 0; i < n; i++) x[i] = 0.875 * x[i] + (double)noise(&seed);
        for (int c = 0; c < m; c++) {
            double sum = (double)noise(&seed);
            for (int i = 0; i < n; i++) sum += (double)all_H[c * n + i] * x[i];
            all_z[t * m + c] = N(sum);
        }
    }
    put_identity(all_A, n, N(0.875));
    put_identity(all_Q, n, 1);
    put_identity(all_P0, n, 1);
    put_identity(all_R, m, 1);
    memset(all_x0, 0, sizeof all_x0);
    return few;
}

/* Is EM stopped within 60 iterations?  It never loses likelihood, and what it leaves is the best
   that it has seen. */
static int is_stopped_at_the_best(int n, int m, uint32_t seed)
{
    const K(recording) few = put_few(n, m, seed);
    const K(parameters) all = {0, 0, all_A, NULL, NULL, all_Q, all_H, all_R, all_x0, all_P0};
    K(em) object;
    kq_status status = KQ_OK;
    double best = -(double)NUM_MAX, rounding = 0;
    ASSERT_OK(K(em_assign)(&object, n, m, room, ROOM));
    ASSERT_OK(K(em_init)(&object, &all, NULL, &few, 1));
    for (int k = 0; k < 60 && !status; k++) {
        status = K(em_iterate)(&object);
        const double now = (double)K(em_log_likelihood)(&object);
        rounding = 64 * EPS * ((double)few.steps * m + fabs(now));
        TEST_ASSERT_TRUE(now >= best - rounding);
        best = fmax(best, now);
    }
    if (!status) return 0;
    TEST_ASSERT_EQUAL_INT(KQ_ERR_LIKELIHOOD, status);
    const num told = K(em_log_likelihood)(&object);
    do ASSERT_OK(K(em_advance)(&object));
    while (K(em_remaining)(&object));
    TEST_ASSERT_TRUE(told == K(em_log_likelihood)(&object));
    return 1;
}

TEST(test_the_likelihood_never_falls_silently)
{
    int stopped = 0;
    for (int m = 3; m <= LARGEST; m++) {
        for (uint32_t seed = 1; seed <= 4; seed++) {
            stopped += is_stopped_at_the_best(1 + m % 2, m, seed);
        }
    }
    TEST_ASSERT_TRUE(stopped >= 4);
}

/* ------------------------------------------------------------------ a fit */

EM(fit, 2, 1, LONG);
static num long_z[LONG];

/* All memory of f32 on a chip of 32 bits: the object and what it is given, and an iteration's stack (as gcc 12 had it
   on a Cortex-M4F) */
#ifdef KQ_TEST_F32
enum { STACK = 992 };
_Static_assert(sizeof(void *) > 4 || sizeof fit + sizeof fit_memory + sizeof long_z +
                                             17 * sizeof(float) + sizeof(kq_parameters_f32) +
                                             sizeof(kq_recording_f32) + STACK <=
                                         12 * 1024,
               "n = 2, m = 1, T = 200");
#endif

/* The sum of 12 uniform numbers of 8 bits, about N(0, 1) in units of 1/256 */
static int32_t whole_noise(uint32_t *seed)
{
    int32_t sum = -1530;
    for (int k = 0; k < 12; k++) {
        *seed = *seed * UINT32_C(1664525) + UINT32_C(1013904223);
        sum += (int32_t)(*seed >> 24);
    }
    return sum;
}

/* A damped oscillator in whole numbers of 1/1024: the same data everywhere */
static void put_oscillation(void)
{
    int32_t x[2] = {0, 0};
    uint32_t seed = 11;
    for (int t = 0; t < LONG; t++) {
        long_z[t] = (num)(x[0] + 3 * whole_noise(&seed)) / 1024;
        const int32_t before = x[0];
        x[0] = (9 * x[0] + 3 * x[1]) / 10 + whole_noise(&seed);
        x[1] = (9 * x[1] - 3 * before) / 10 + whole_noise(&seed);
    }
}

/* From noises a few times what they are: parameters as f64 has them on the host, in both
   arithmetics and on every chip. */
TEST(test_a_fit_is_the_same_everywhere)
{
    static const double expected[] = {0.1010404, -0.0143968, -0.0143968, 0.0931181};
    static const double expected_R = 0.6415634, expected_log_likelihood = -275.8123;
    num A[] = {N(0.9), N(0.3), N(-0.3), N(0.9)}, H[] = {1, 0};
    num Q[] = {0.25, 0, 0, 0.25}, R[] = {0.125}, x0[] = {0, 0}, P0[] = {1, 0, 0, 1};
    const K(parameters) oscillator = {0, 0, A, NULL, NULL, Q, H, R, x0, P0};
    const K(recording) night = {LONG, long_z, NULL, NULL};
    put_oscillation();
    ASSERT_OK(K(em_init)(&fit, &oscillator, NULL, &night, 1));
    for (int k = 0; k < 20; k++) ASSERT_OK(K(em_iterate)(&fit));
    for (int k = 0; k < 4; k++) ASSERT_WITHIN(1e-4 * expected[0], expected[k], Q[k]);
    ASSERT_WITHIN(1e-4 * expected_R, expected_R, R[0]);
    ASSERT_WITHIN(2e-4, expected_log_likelihood, K(em_log_likelihood)(&fit));
}

SUITE(em, set_up)
#include "em.tests"
