/* The process: its checks, the root of its noise. */
#include "reading.h"
#include "sizes.h"
#include "textbook.h"
#include "turned.h"
#include "unchanged.h"

PROCESS(motion, 2, 1);
FILTER(track, 2);

static num A[4], B[2], Q[4], F[4];

static void set_up(void)
{
    static const num a[] = {1, 0.5, 0, 1}, b[] = {0.125, 0.5}, q[] = {0.25, 0.125, 0.125, 0.5};
    static const num f[] = {0.5, 0, 0.25, 0.75};
    memcpy(A, a, sizeof A);
    memcpy(B, b, sizeof B);
    memcpy(Q, q, sizeof Q);
    memcpy(F, f, sizeof F);
    ASSERT_OK(K(process_assign)(&motion, 2, 1, motion_memory, COUNT(motion_memory)));
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    ASSERT_OK(K(filter_assign)(&track, 2, track_memory, COUNT(track_memory)));
    watch_nothing();
    WATCH(motion);
    WATCH(motion_memory);
    WATCH(A);
    WATCH(B);
    WATCH(Q);
    WATCH(F);
}

/* From a state known exactly: then P is Q, and x is A x + B u. */
static const num start[] = {1, -2}, nothing[4] = {0};

static void predict_from_certainty(const K(process) * p, const num *u)
{
    ASSERT_OK(K(filter_init)(&track, start, nothing));
    ASSERT_OK(K(predict)(&track, p, u));
}

static void assert_noise(const K(process) * p, const num *expected)
{
    textbook t;
    textbook_init(&t, 2, start, nothing);
    textbook_predict(&t, A, NULL, NULL, 0, expected);
    predict_from_certainty(p, NULL);
    ASSERT_TEXTBOOK(&t, &track);
}

/* ------------------------------------------------------------------------------ assign */

TEST(assign_takes_more_memory_than_it_needs)
{
    static num memory[KQ_PROCESS_LEN(2) + 1];
    K(process) p;
    ASSERT_OK(K(process_assign)(&p, 2, 0, memory, COUNT(memory)));
    for (int k = 0; k < 2; k++) { /* low halves: all ones; 1 */
        ASSERT_OK(K(process_assign)(&p, 2, 0, memory, k ? SIZE_MAX : SIZE_MAX / 2 + 2));
        ASSERT_OK(K(process_init)(&p, A, NULL, Q));
        assert_noise(&p, Q);
    }
}

TEST(an_assigned_process_still_has_to_be_initialised)
{
    ASSERT_OK(K(process_assign)(&motion, 2, 1, motion_memory, COUNT(motion_memory)));
    ASSERT_OK(K(filter_init)(&track, start, nothing));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(predict)(&track, &motion, NULL));
}

/* -------------------------------------------------------------------------------- init */

TEST(init_prepares_the_model)
{
    static const num u[] = {4};
    predict_from_certainty(&motion, u);
    ASSERT_CLOSE(1 - 0.5 * 2 + 0.125 * 4, K(mean)(&track, 0), 1);
    ASSERT_CLOSE(-2 + 0.5 * 4, K(mean)(&track, 1), 1);
    assert_noise(&motion, Q);
}

TEST(init_needs_no_control_matrix_without_controls)
{
    K(process) p;
    ASSERT_OK(K(process_assign)(&p, 2, 0, motion_memory, COUNT(motion_memory)));
    ASSERT_OK(K(process_init)(&p, A, NULL, Q));
    ASSERT_OK(K(process_init_factor)(&p, A, NULL, F, 2));
}

static kq_status init(void) { return K(process_init)(&motion, A, B, Q); }

TEST(init_refuses_numbers_that_are_not_finite)
{
    assert_entries_must_be_finite(A, 4, init);
    assert_entries_must_be_finite(B, 2, init);
    assert_entries_must_be_finite(Q, 4, init);
}

TEST(init_checks_that_the_noise_is_a_covariance)
{
    assert_covariance_is_checked(Q, init);
}

TEST(init_refuses_a_noise_beyond_the_limit)
{
    static const num large[] = {N(MOST_SIGMA), 0, 0, N(2 * MOST_SIGMA)};
    num Q_large[] = {N(MOST_SIGMA * MOST_SIGMA), 0, 0, 1};
    ASSERT_OK(K(process_init)(&motion, A, B, Q_large));
    Q_large[3] = 2 * Q_large[0];
    ASSERT_REFUSED(KQ_ERR_RANGE, K(process_init)(&motion, A, B, Q_large));
    ASSERT_OK(K(process_init_factor)(&motion, A, B, large, 1));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(process_init_factor)(&motion, A, B, large, 2));
    const num beyond[] = {0, NUM_MAX};
    ASSERT_REFUSED(KQ_ERR_RANGE, K(process_init_factor)(&motion, A, B, beyond, 1));
}

TEST(init_takes_a_singular_noise)
{
    static const double singular[][3] = {
        {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {4, 2, 1}, {1, -1, 1}, {0.25, 0.75, 2.25},
    };
    for (int k = 0; k < COUNT(singular); k++) {
        put_covariance(Q, singular[k][0], singular[k][1], singular[k][1], singular[k][2]);
        ASSERT_OK(init());
        predict_from_certainty(&motion, NULL);
        num P[4];
        ASSERT_OK(K(covariance)(&track, P));
        for (int c = 0; c < 4; c++) ASSERT_CLOSE(Q[c], P[c], 4);
    }
}

/* The lower triangle is compared, within rounding, and not used. */
TEST(init_uses_the_upper_triangle)
{
    FILTER(twin, 2);
    ASSERT_OK(K(filter_init)(&twin, start, nothing));
    ASSERT_OK(K(predict)(&twin, &motion, NULL));
    Q[2] = N(0.125 * (1 + EPS));
    ASSERT_OK(init());
    predict_from_certainty(&motion, NULL);
    ASSERT_SAME_FILTER(&twin, &track, 2);
}

TEST(without_noise_the_state_stays_certain)
{
    memset(Q, 0, sizeof Q);
    ASSERT_OK(init());
    predict_from_certainty(&motion, NULL);
    for (int i = 0; i < 2; i++) {
        ASSERT_WITHIN(4 * TINY_SIGMA, 0, K(sigma)(&track, i));
    }
}

TEST(the_noise_matrix_is_not_kept)
{
    static const num q[] = {0.25, 0.125, 0.125, 0.5};
    memset(Q, 0xFF, sizeof Q);
    assert_noise(&motion, q);
}

TEST(a_refused_init_leaves_the_old_model_working)
{
    static const num q[] = {0.25, 0.125, 0.125, 0.5};
    Q[0] = -1;
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, init());
    F[3] = (num)NAN;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(process_init_factor)(&motion, A, B, F, 2));
    assert_noise(&motion, q);
}

TEST(init_may_be_called_again_with_another_model)
{
    A[2] = 0.25;
    put_covariance(Q, 1, 0.5, 0.5, 1);
    ASSERT_OK(init());
    assert_noise(&motion, Q);
}

/* ------------------------------------------------------------------------- init_factor */

/* Q = F F', columns 0 .. r - 1 of a 2 x 16 row-major table */
static void assert_factor(int r)
{
    static num wide[32], product[4];
    for (int k = 0; k < 2 * r; k++) wide[k] = N((k * k * 7 + k * 3) % 11 - 5) / 8;
    memset(product, 0, sizeof product);
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < r; c++) product[k] += wide[k / 2 * r + c] * wide[k % 2 * r + c];
    }
    ASSERT_OK(K(process_init_factor)(&motion, A, B, r ? wide : NULL, r));
    memset(wide, 0xFF, sizeof wide);
    predict_from_certainty(&motion, NULL);
    num P[4];
    ASSERT_OK(K(covariance)(&track, P));
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(product[k], P[k], 8);
}

TEST(a_factor_of_any_width_gives_its_product)
{
    for (int r = 0; r <= 16; r++) assert_factor(r);
}

TEST(a_factor_and_its_product_are_the_same_noise)
{
    static const num product[] = {0.25, 0.125, 0.125, 0.625};
    ASSERT_OK(K(process_init_factor)(&motion, A, B, F, 2));
    assert_noise(&motion, product);
}

/* Two columns that agree in 20 bits: F F' is singular in float, the factor is not.  What the
   two states differ by has the variance 2^-42, and that must be there. */
TEST(a_factor_keeps_what_its_product_would_round_away)
{
    static const num H[] = {1, -1}, R[] = {0};
    static const num factor[] = {1, 0, 1, 0x1p-21};
    SENSOR(difference, 2, 1);
    num S;
    ASSERT_OK(K(process_init_factor)(&motion, A, B, factor, 2));
    ASSERT_OK(K(sensor_init)(&difference, H, R));
    predict_from_certainty(&motion, NULL);
    ASSERT_OK(K(measurement)(&track, &difference, NULL, &S));
    ASSERT_WITHIN(0.25 * 0x1p-42, 0x1p-42, S);
}

/* ------------------------------------------------------------------------- init_root */

static const num root[] = {0.5, 0.25, 0.75}; /* g_00, g_01, g_11 */

TEST(a_root_is_the_noise_that_it_is_the_root_of)
{
    static const num product[] = {0.3125, 0.1875, 0.1875, 0.5625};
    ASSERT_OK(K(process_init_root)(&motion, A, B, root));
    assert_noise(&motion, product);
}

TEST(a_singular_root_is_taken)
{
    static const num product[] = {0.0625, 0.1875, 0.1875, 0.5625};
    static const num singular[] = {0, 0.25, 0.75};
    ASSERT_OK(K(process_init_root)(&motion, A, B, singular));
    assert_noise(&motion, product);
}

TEST(init_root_refuses_what_is_no_root)
{
    const num negative[] = {0.5, 0.25, N(-0.75)}, infinite[] = {0.5, (num)INFINITY, 0.75};
    const num large[] = {0.5, 0, N(1.01 * MOST_SIGMA)}, along[] = {N(MOST_SIGMA), N(MOST_SIGMA), 1};
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(process_init_root)(&motion, A, B, negative));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(process_init_root)(&motion, A, B, infinite));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(process_init_root)(&motion, A, B, large));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(process_init_root)(&motion, A, B, along));
}

static kq_status init_factor(void) { return K(process_init_factor)(&motion, A, B, F, 2); }

TEST(init_factor_refuses_numbers_that_are_not_finite)
{
    assert_entries_must_be_finite(A, 4, init_factor);
    assert_entries_must_be_finite(B, 2, init_factor);
    assert_entries_must_be_finite(F, 4, init_factor);
}

/* ------------------------------------------------------------------- change_transition */

TEST(change_transition_moves_otherwise_with_the_same_noise)
{
    static const num transitions[][4] = {
        {0.5, 0.25, 0.75, -1}, {1, 2, 0, 1}, {0, 0, 0, 0}, {0, 0, 1, 0}, {1, 0, 0, 1}, {0, 1, 1, 0},
    };
    static const num P0[] = {2, 0.5, 0.5, 1};
    for (int k = 0; k < COUNT(transitions); k++) {
        textbook t;
        if (k % 2) memcpy(A, transitions[k], sizeof A); /* in its own array, or another one */
        ASSERT_OK(K(process_change_transition)(&motion, k % 2 ? A : transitions[k]));
        textbook_init(&t, 2, start, P0);
        textbook_predict(&t, transitions[k], NULL, NULL, 0, Q);
        ASSERT_OK(K(filter_init)(&track, start, P0));
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_TEXTBOOK(&t, &track);
    }
}

static kq_status change(void) { return K(process_change_transition)(&motion, A); }

TEST(change_transition_refuses_numbers_that_are_not_finite)
{
    assert_entries_must_be_finite(A, 4, change);
}

/* --------------------------------------------------------------------------- all sizes */

static num big_A[256], big_Q[256];

/* A sum of r squares whose entries are rounded is indefinite by rounding: it is accepted. */
TEST(sixteen_states_take_a_noise_of_low_rank)
{
    PROCESS(large, 16, 0);
    put_identity(big_A, 16, 1);
    for (int r = 1; r <= 5; r++) {
        for (int k = 0; k < 256; k++) {
            double sum = 0;
            for (int c = 1; c <= r; c++) sum += 1.0 / (k / 16 + 3 * c) / (k % 16 + 3 * c);
            big_Q[k] = N(sum);
        }
        ASSERT_OK(K(process_init)(&large, big_A, NULL, big_Q));
    }
}

/* Every Q = F F' of 3 states with F 3 x 2 from a few round numbers, in what order ever. */
TEST(three_states_take_every_noise_of_rank_two)
{
    static const double entries[] = {-0.9, -0.5, 0.3, 0.7};
    PROCESS(three, 3, 0);
    put_identity(big_A, 3, 1);
    for (int code = 0; code < 4096; code++) {
        double f[6];
        for (int k = 0; k < 6; k++) f[k] = entries[code >> 2 * k & 3];
        for (int k = 0; k < 9; k++) {
            const int i = k / 3, j = k % 3;
            big_Q[k] = N(f[2 * i] * f[2 * j] + f[2 * i + 1] * f[2 * j + 1]);
        }
        ASSERT_OK(K(process_init)(&three, big_A, NULL, big_Q));
    }
}

/* -------------------------------------------------------- continuous time */

#define FLOWS 3 /* states of what follows, at most */
static num flow_memory[KQ_CONTINUOUS_LEN(FLOWS, 1)], flow_root[KQ_PROCESS_LEN(FLOWS)];

static kq_status init_flow(K(process) * p, int n, const num *rates, const num *push, const num *density, num dt)
{
    ASSERT_OK(K(process_assign)(p, n, 1, flow_root, COUNT(flow_root)));
    return K(process_init_continuous)(p, rates, push, density, dt, flow_memory, COUNT(flow_memory));
}

/* Q_ij of the root that p has */
static double noise_of(const K(process) * p, int i, int j)
{
    double sum = 0;
    for (int k = i > j ? i : j; k < p->states; k++) {
        sum += (double)p->noise_root[KQ_TRIANGLE(k) + i] * (double)p->noise_root[KQ_TRIANGLE(k) + j];
    }
    return sum;
}

static void assert_flow_noise(const K(process) * p, int i, int j, double expected)
{
    const double sigmas = sqrt(noise_of(p, i, i)) * sqrt(noise_of(p, j, j));
    ASSERT_WITHIN(TOLERANCE * sigmas, expected, noise_of(p, i, j));
}

static const num steps_of_time[] = {N(1e-5), N(0.01), 1, 300};

/* Pushed by an acceleration, which is held over the step */
TEST(constant_velocity_is_its_closed_form)
{
    static const num rates[] = {0, 1, 0, 0}, push[] = {0, 2}, density[] = {0, 0, 0, N(0.5)};
    K(process) p;
    for (int k = 0; k < COUNT(steps_of_time); k++) {
        const double dt = (double)steps_of_time[k];
        ASSERT_OK(init_flow(&p, 2, rates, push, density, steps_of_time[k]));
        const num right[] = {1, steps_of_time[k], 0, 1};
        TEST_ASSERT_EQUAL_MEMORY(right, p.transition, sizeof right);
        ASSERT_WITHIN(TOLERANCE * dt * dt, dt * dt, p.control[0]);
        ASSERT_WITHIN(TOLERANCE * dt, 2 * dt, p.control[1]);
        assert_flow_noise(&p, 0, 0, 0.5 * dt * dt * dt / 3);
        assert_flow_noise(&p, 0, 1, 0.5 * dt * dt / 2);
        assert_flow_noise(&p, 1, 1, 0.5 * dt);
    }
}

/* exp(x) - 1, which not every C library has */
static double less_1(double x)
{
    double sum = 0;
    if (x < -1) return exp(x) - 1;
    for (int k = 20; k > 0; k--) sum = x / k * (1 + sum);
    return sum;
}

/* x' = -a x + b u, from steps that are short to one that ends where it stays */
TEST(a_bias_that_fades_is_its_closed_form)
{
    static const num density[] = {2}, push[] = {3};
    K(process) p;
    for (int k = 0; k < COUNT(steps_of_time); k++) {
        const num rate = N(-0.25);
        const double dt = (double)steps_of_time[k];
        ASSERT_OK(init_flow(&p, 1, &rate, push, density, steps_of_time[k]));
        ASSERT_WITHIN(TOLERANCE, exp(-0.25 * dt), p.transition[0]);
        ASSERT_WITHIN(TOLERANCE * (double)p.control[0], -12 * less_1(-0.25 * dt), p.control[0]);
        assert_flow_noise(&p, 0, 0, -4 * less_1(-0.5 * dt));
    }
}

/* A damped oscillator that pushes a third state */
TEST(two_steps_are_one_of_twice_the_time)
{
    static const num rates[] = {0, 1, 0, -4, N(-0.5), 0, 1, 0, N(-0.01)}, push[] = {0, 1, 0};
    static const num density[] = {0, 0, 0, 0, N(0.3), N(0.1), 0, N(0.1), N(0.2)};
    K(process) p;
    double A1[9], B1[3], Q1[9], AQ[9], Q2[9];
    for (int k = 0; k < COUNT(steps_of_time); k++) {
        const double many = 1 + 4 * (double)steps_of_time[k];
        ASSERT_OK(init_flow(&p, 3, rates, push, density, steps_of_time[k]));
        for (int i = 0; i < 9; i++) A1[i] = (double)p.transition[i], Q1[i] = noise_of(&p, i / 3, i % 3);
        for (int i = 0; i < 3; i++) B1[i] = (double)p.control[i];
        textbook_multiply(AQ, A1, Q1, 3, 3, 3);
        textbook_multiply_transposed(Q2, AQ, A1, 3, 3, 3);
        ASSERT_OK(init_flow(&p, 3, rates, push, density, 2 * steps_of_time[k]));
        for (int i = 0; i < 3; i++) {
            double pushed = B1[i];
            for (int j = 0; j < 3; j++) {
                double moved = 0;
                for (int l = 0; l < 3; l++) moved += A1[i * 3 + l] * A1[l * 3 + j];
                ASSERT_WITHIN(many * TOLERANCE, moved, p.transition[i * 3 + j]);
                const double sigmas = sqrt(noise_of(&p, i, i) * noise_of(&p, j, j));
                ASSERT_WITHIN(many * TOLERANCE * sigmas, Q1[i * 3 + j] + Q2[i * 3 + j], noise_of(&p, i, j));
                pushed += A1[i * 3 + j] * B1[j];
            }
            ASSERT_WITHIN(many * TOLERANCE, pushed, p.control[i]);
        }
    }
}

/* More controls than states, and fewer: the memory has room for both. */
TEST(no_flow_writes_outside_its_memory)
{
    enum { SIZE = sizeof(void *) == 2 ? 6 : 16 };
    static num rates[SIZE * SIZE], push[SIZE * 16], density[SIZE * SIZE], room[GUARDED(KQ_CONTINUOUS_LEN(SIZE, 16))];
    static num root[KQ_PROCESS_LEN(SIZE)];
    for (int n = 1; n <= SIZE; n += 5) {
        for (int l = 0; l <= 16; l += 8) {
            const size_t length = KQ_CONTINUOUS_LEN(n, l);
            K(process) p;
            for (int k = 0; k < n * n; k++) rates[k] = N(k % (n + 1) ? 0.1 : -3), density[k] = k % (n + 1) ? 0 : 1;
            for (int k = 0; k < n * l; k++) push[k] = 1;
            ASSERT_OK(K(process_assign)(&p, n, l, root, COUNT(root)));
            ASSERT_OK(K(process_init_continuous)(&p, rates, push, density, 1, guard(room, COUNT(room)), length));
            assert_guards(room, length, COUNT(room));
        }
    }
}

TEST(a_flow_out_of_the_numbers_is_refused)
{
    static const num far[] = {0, NUM_MAX / 4, 0, 0}, growing[] = {100, 0, 0, 100}, push[] = {1, 1}, density[4] = {0};
    static const num rates[4] = {0};
    K(process) p;
    ASSERT_OK(init_flow(&p, 2, rates, push, density, 1));
    watch_nothing();
    WATCH(p), WATCH(flow_root), watch(flow_memory, 6 * sizeof(num)); /* A and B; the rest is scratch */
    ASSERT_REFUSED(KQ_ERR_RANGE, K(process_init_continuous)(&p, far, push, density, 16, flow_memory, COUNT(flow_memory)));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(process_init_continuous)(&p, growing, push, density, 1000, flow_memory, COUNT(flow_memory)));
}

/* ------------------------------------------------ correlated with the measurement's noise */

SENSOR(seen, 2, 2);
static num seen_H[4] = {1, 0, 0.5, 2}, seen_R[4] = {1, 0.5, 0.5, 2}, shared[4] = {0.25, -0.25, 0.5, 0.125};
static num drift_memory[KQ_CORRELATED_LEN(2, 1, 2)];

static kq_status init_drift(K(process) * p, uint32_t present)
{
    ASSERT_OK(K(sensor_init)(&seen, seen_H, seen_R));
    ASSERT_OK(K(process_assign)(p, 2, 3, drift_memory, COUNT(drift_memory)));
    return K(process_init_correlated)(p, A, B, Q, &seen, shared, present);
}

/* A*, B* and Q* by the inverse of R, of the rows of `present` alone */
TEST(a_correlated_process_is_its_formula)
{
    K(process) p;
    for (uint32_t present = 1; present < 4; present++) {
        double inverse[4] = {0}, K[4], H[4];
        for (int k = 0; k < 4; k++) H[k] = (double)seen_H[k];
        if (present == 3) inverse[0] = 2 / 1.75, inverse[1] = inverse[2] = -0.5 / 1.75, inverse[3] = 1 / 1.75;
        else if (present == 2) inverse[3] = 0.5;
        else inverse[0] = 1;
        ASSERT_OK(init_drift(&p, present));
        for (int i = 0; i < 2; i++) {
            for (int c = 0; c < 2; c++) {
                K[i * 2 + c] = (double)shared[i * 2] * inverse[c] + (double)shared[i * 2 + 1] * inverse[2 + c];
                ASSERT_WITHIN(TOLERANCE, K[i * 2 + c], p.control[i * 3 + 1 + c]);
            }
            TEST_ASSERT_EQUAL_MEMORY(&B[i], p.control + i * 3, sizeof *B);
        }
        for (int i = 0; i < 2; i++) {
            for (int j = 0; j < 2; j++) {
                const double KS = K[i * 2] * (double)shared[j * 2] + K[i * 2 + 1] * (double)shared[j * 2 + 1];
                const double KH = K[i * 2] * H[j] + K[i * 2 + 1] * H[2 + j];
                ASSERT_WITHIN(TOLERANCE, (double)A[i * 2 + j] - KH, p.transition[i * 2 + j]);
                ASSERT_WITHIN(TOLERANCE, (double)Q[i * 2 + j] - KS, noise_of(&p, i, j));
            }
        }
    }
}

TEST(without_a_measurement_a_correlated_process_is_the_plain_one)
{
    K(process) p;
    static const num u[] = {4, 7, -9};
    ASSERT_OK(init_drift(&p, 0));
    TEST_ASSERT_EQUAL_MEMORY(motion_memory, p.noise_root, sizeof motion_memory);
    TEST_ASSERT_EQUAL_MEMORY(A, p.transition, sizeof A);
    predict_from_certainty(&motion, u);
    const num mean = K(mean)(&track, 1);
    predict_from_certainty(&p, u);
    ASSERT_CLOSE(mean, K(mean)(&track, 1), 0);
}

/* w = g v: a measurement tells all of it, and one without noise tells nothing. */
TEST(noise_that_the_measurement_has_whole_is_gone)
{
    static const num g[] = {0.75, -3}, R[] = {0.3125};
    static num memory[KQ_CORRELATED_LEN(2, 0, 1)], all[4], S[2];
    K(process) p;
    SENSOR(one, 2, 1);
    for (int k = 0; k < 4; k++) all[k] = g[k / 2] * R[0] * g[k % 2];
    for (int i = 0; i < 2; i++) S[i] = g[i] * R[0];
    ASSERT_OK(K(process_assign)(&p, 2, 1, memory, COUNT(memory)));
    ASSERT_OK(K(sensor_init)(&one, seen_H, R));
    ASSERT_OK(K(process_init_correlated)(&p, A, NULL, all, &one, S, UINT32_MAX));
    for (int i = 0; i < 2; i++) {
        ASSERT_WITHIN(TOLERANCE, g[i], p.control[i]);
        ASSERT_WITHIN(1e-30, 0, noise_of(&p, i, i));
    }
    ASSERT_OK(K(sensor_init)(&one, seen_H, nothing));
    ASSERT_OK(K(process_init_correlated)(&p, A, NULL, Q, &one, nothing, UINT32_MAX));
    TEST_ASSERT_EQUAL_MEMORY(A, p.transition, sizeof A);
    TEST_ASSERT_EQUAL_MEMORY(motion_memory, p.noise_root, sizeof motion_memory);
}

/* w = K v + F e, of whole numbers: R = L L' and Q - S R^-1 S' = unit F F' are exact, and then scaled by `size`. */
enum { SHARED_MOST = sizeof(void *) == 2 ? 6 : 16 };
static num all_Q[SHARED_MOST * SHARED_MOST], all_R[SHARED_MOST * SHARED_MOST], all_S[SHARED_MOST * SHARED_MOST];
static double left[SHARED_MOST * SHARED_MOST];

static int whole(uint32_t *seed, int most)
{
    *seed = *seed * UINT32_C(1664525) + UINT32_C(1013904223);
    return (int)(*seed >> 16) % (2 * most + 1) - most;
}

static void put_shared(int n, int m, double unit, double size, uint32_t seed)
{
    static int L[SHARED_MOST * SHARED_MOST], KL[SHARED_MOST * SHARED_MOST], F[SHARED_MOST * SHARED_MOST];
    for (int k = 0; k < m * m; k++) L[k] = k / m == k % m ? 1 : k / m - k % m == 1 ? whole(&seed, 1) : 0;
    for (int k = 0; k < n * n; k++) F[k] = k / n == k % n ? 1 : k / n < k % n ? whole(&seed, 1) : 0;
    for (int i = 0; i < n; i++) {
        int K[SHARED_MOST];
        for (int c = 0; c < m; c++) K[c] = whole(&seed, 2);
        for (int c = 0; c < m; c++) KL[i * m + c] = K[c] + (c + 1 < m ? K[c + 1] * L[(c + 1) * m + c] : 0);
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            int seen_part = 0, own = 0;
            for (int c = 0; c < m; c++) seen_part += KL[i * m + c] * KL[j * m + c];
            for (int k = 0; k < n; k++) own += F[i * n + k] * F[j * n + k];
            left[i * n + j] = size * unit * own;
            all_Q[i * n + j] = N(size * (seen_part + unit * own));
        }
    }
    for (int k = 0; k < (n + m) * m; k++) {
        int sum = 0;
        const int *row = k < n * m ? KL + k / m * m : L + (k / m - n) * m;
        for (int b = 0; b < m; b++) sum += row[b] * L[k % m * m + b];
        *(k < n * m ? all_S + k : all_R + k - n * m) = N(size * sum);
    }
}

static void init_shared(K(process) * p, int n, int m)
{
    static num one[SHARED_MOST * SHARED_MOST], memory[KQ_CORRELATED_LEN(SHARED_MOST, 0, SHARED_MOST)], noise[KQ_SENSOR_LEN(SHARED_MOST)];
    K(sensor) s;
    put_identity(one, SHARED_MOST, 1);
    ASSERT_OK(K(sensor_assign)(&s, n, m, noise, COUNT(noise)));
    ASSERT_OK(K(sensor_init)(&s, one, all_R));
    ASSERT_OK(K(process_assign)(p, n, m, memory, COUNT(memory)));
    ASSERT_OK(K(process_init_correlated)(p, one, NULL, all_Q, &s, all_S, UINT32_MAX));
}

/* Down to a few eps of Q, it has all its digits. */
TEST(noise_that_the_measurement_leaves_is_rounded_at_its_own_size)
{
    K(process) p;
    for (int k = 0; k < 4 * SHARED_MOST * SHARED_MOST; k += KQ_TEST_IS_SLOW ? 13 : 1) {
        const int n = k / 4 % SHARED_MOST + 1, m = k / 4 / SHARED_MOST + 1;
        put_shared(n, m, ldexp(EPS, 9 + k % 4 * 4), 1, (uint32_t)k);
        init_shared(&p, n, m);
        for (int i = 0; i < n * n; i++) {
            const double sigmas = sqrt(left[i / n * (n + 1)]) * sqrt(left[i % n * (n + 1)]);
            ASSERT_WITHIN(TOLERANCE * sigmas, left[i], noise_of(&p, i / n, i % n));
        }
    }
}

/* A joint covariance that rounding alone keeps from being singular, or makes indefinite, is one. */
TEST(noise_that_rounding_leaves_is_rounding)
{
    K(process) p;
    for (int k = 0; k < SHARED_MOST * SHARED_MOST; k += KQ_TEST_IS_SLOW ? 5 : 1) {
        const int n = k % SHARED_MOST + 1, m = k / SHARED_MOST + 1;
        put_shared(n, m, 0, 1.0 / 3, (uint32_t)k);
        init_shared(&p, n, m);
        for (int i = 0; i < n; i++) ASSERT_WITHIN(TOLERANCE * (double)all_Q[i * (n + 1)] + TINY_SIGMA * TINY_SIGMA, 0, noise_of(&p, i, i));
    }
}

/* d = (A - I) x + B u + K e, K in the process's memory; a position, far away, which A and H move as it is */
static void drift_from(num far, double *means)
{
    K(process) p;
    ASSERT_OK(init_drift(&p, UINT32_MAX));
    const num x0[] = {far, 0}, *control = drift_memory + KQ_PROCESS_LEN(2) + 4;
    ASSERT_OK(K(filter_init)(&track, x0, Q));
    for (int t = 0; t < 20; t++) {
        const num u = (num)(t % 3 - 1), z[] = {far + (num)(t * 5 % 7 - 3) / 8, far / 2 + (num)(t * 3 % 5 - 2) / 4};
        num e[2], d[2] = {0, 0}, both[] = {u, z[0], z[1]};
        ASSERT_OK(K(update)(&track, &seen, z));
        ASSERT_OK(K(innovation)(&track, &seen, z, e));
        d[0] = A[1] * K(mean)(&track, 1);
        for (int i = 0; i < 2; i++) d[i] += control[i * 3] * u + control[i * 3 + 1] * e[0] + control[i * 3 + 2] * e[1];
        if (far > 0) ASSERT_OK(K(predict_extended)(&track, &p, d));
        else ASSERT_OK(K(predict)(&track, &p, both));
    }
    for (int i = 0; i < 2; i++) means[i] = (double)K(mean)(&track, i) - (i ? 0 : (double)far) + (double)K(mean_low)(&track, i);
}

TEST(a_correlated_process_moves_a_state_far_away_by_increments)
{
    const double far = EPS < 1e-9 ? 1048576 : 1; /* f64 has no low part */
    double here[2], there[2];
    drift_from(0, here);
    drift_from(N(1048576), there);
    for (int i = 0; i < 2; i++) ASSERT_WITHIN(far * TOLERANCE, here[i], there[i]);
}

TEST(no_correlated_process_writes_outside_its_memory)
{
    enum { SIZE = sizeof(void *) == 2 ? 6 : 16 };
    static num one[SIZE * SIZE], zero[SIZE * SIZE], room[GUARDED(KQ_CORRELATED_LEN(SIZE, 0, SIZE))], noise[KQ_SENSOR_LEN(SIZE)];
    put_identity(one, SIZE, 1);
    for (int n = 1; n <= SIZE; n += 5) {
        for (int m = 1; m <= SIZE; m += 5) {
            const size_t length = KQ_CORRELATED_LEN(n, SIZE - m, m);
            K(process) p;
            K(sensor) s;
            put_identity(one, n, 1);
            ASSERT_OK(K(sensor_assign)(&s, n, m, noise, COUNT(noise)));
            ASSERT_OK(K(process_assign)(&p, n, SIZE, guard(room, COUNT(room)), length));
            put_identity(zero, m, 1); /* R */
            ASSERT_OK(K(sensor_init)(&s, one, zero));
            for (int k = 0; k < SIZE * SIZE; k++) zero[k] = 0;
            ASSERT_OK(K(process_init_correlated)(&p, one, zero, one, &s, zero, UINT32_MAX));
            assert_guards(room, length, COUNT(room));
        }
    }
}

TEST(a_correlated_process_out_of_the_numbers_is_refused)
{
    static const num far_H[] = {NUM_MAX, 0, 0, 1}, small_R[] = {N(1e-10), 0, 0, 1}, small_S[] = {N(4e-6), 0, 0, 0};
    K(process) p;
    ASSERT_OK(init_drift(&p, UINT32_MAX));
    ASSERT_OK(K(sensor_init)(&seen, far_H, small_R)); /* K H overflows */
    WATCH(p);
    ASSERT_REFUSED(KQ_ERR_RANGE, K(process_init_correlated)(&p, A, B, Q, &seen, small_S, UINT32_MAX));
}

/* Nothing is shared with a noise that is 0, however large or small it is said to be. */
TEST(a_noise_that_is_none_shares_nothing)
{
    static const num shares[] = {N(1e-20), 1, N(1e21), NUM_MAX}, no_R[] = {0, 0, 0, 0};
    K(process) p;
    ASSERT_OK(init_drift(&p, UINT32_MAX));
    ASSERT_OK(K(sensor_init)(&seen, seen_H, no_R));
    WATCH(p);
    for (int k = 0; k < COUNT(shares); k++) {
        const num one[] = {shares[k], 0, 0, 0}, both[] = {shares[k], -shares[k], 0, 0};
        ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(process_init_correlated)(&p, A, B, Q, &seen, one, UINT32_MAX));
        ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(process_init_correlated)(&p, A, B, Q, &seen, both, UINT32_MAX));
    }
}

/* A covariance whose root overflows is none. */
TEST(a_correlation_beyond_the_numbers_is_refused)
{
    static const num far[] = {1, N(0.1), 0, N(0.1), 1, NUM_MAX / 4, 0, NUM_MAX / 4, N(1e-30)};
    static const num x0[3], still[9];
    static num memory[KQ_PROCESS_LEN(3)], noise[KQ_SENSOR_LEN(3)], state[FILTER_LEN(3)];
    K(process) p;
    K(sensor) s;
    K(filter) f;
    ASSERT_OK(K(process_assign)(&p, 3, 0, memory, COUNT(memory)));
    ASSERT_OK(K(sensor_assign)(&s, 3, 3, noise, COUNT(noise)));
    ASSERT_OK(K(filter_assign)(&f, 3, state, COUNT(state)));
    WATCH(p), WATCH(s), WATCH(f), WATCH(memory), WATCH(state);
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(process_init)(&p, still, NULL, far));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(sensor_init)(&s, still, far));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(filter_init)(&f, x0, far));
}

/* ------------------------------------------------------------------- check */

static kq_status check_motion(void) { return K(process_check)(&motion); }

/* All but padding */
static int process_bits(void)
{
    return 8 * (int)(2 + sizeof motion.length + 4 * sizeof(void *) + KQ_SIZE_MAX + 2) + 32;
}

TEST(check_finds_every_bit_of_a_process)
{
    TEST_ASSERT_EQUAL_INT(process_bits(), BITS_FOUND(motion, check_motion));
    ASSERT_ALL_FOUND(motion_memory, check_motion);
    ASSERT_ALL_FOUND(A, check_motion);
}

TEST(check_takes_what_calls_have_left)
{
    static num memory[KQ_PROCESS_LEN(2)];
    static const num other[] = {1, 0, 0.5, 1}, G[] = {1, 0, 1};
    static K(process) table = KQ_PROCESS_TABLE(2, 0, other, NULL, G);
    K(process) copy = motion, scaled;
    ASSERT_OK(K(process_check)(&copy));
    ASSERT_OK(K(process_check)(&table));
    ASSERT_OK(K(process_change_transition)(&copy, other));
    ASSERT_OK_UNCHANGED(K(process_check)(&copy));
    ASSERT_OK(K(process_assign)(&scaled, 2, 1, memory, COUNT(memory)));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(process_check)(&scaled));
    ASSERT_OK(K(process_scale_noise)(&scaled, &motion, 2));
    ASSERT_OK(K(process_check)(&scaled));
    ASSERT_OK(K(process_change_transition)(&scaled, other));
    ASSERT_OK(K(process_check)(&scaled));
    ASSERT_REFUSED(KQ_ERR_NULL, K(process_check)(NULL));
}

SUITE(process, set_up)
#include "process.tests"
