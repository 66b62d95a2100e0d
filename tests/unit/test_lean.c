/* A sensor without the careful path: what it takes as any other, and what it takes coarsely. */
#include "losses.h"
#include "reading.h"
#include "unchanged.h"

#define STEPS 12

PROCESS(motion, 2, 0);
SENSOR_DIAGONAL(full, 2, 3);
SENSOR_DIAGONAL(lean, 2, 3);
SENSOR_DIAGONAL(sharp, 2, 1);
SENSOR_DIAGONAL(blank, 2, 1);
FILTER(track, 2);
FILTER(twin, 2);
HISTORY(tape, 2, 6, STEPS + 1, 0);
HISTORY(other, 2, 6, STEPS + 1, 0);

static const num A[] = {1, 0.5, 0, 1}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1, -1, 0.25};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static num r[3], z[3];

/* Of a component: the noise that is sharp to both, whatever H and P0 are here */
#define SHARP (EPS * EPS)

static void set_up(void)
{
    static const num noises[] = {0.5, 1, 2}, measured[] = {3, 1, -1};
    memcpy(r, noises, sizeof r);
    memcpy(z, measured, sizeof z);
    ASSERT_OK(K(process_init)(&motion, A, NULL, Q));
    ASSERT_OK(K(sensor_init_diagonal)(&full, H, r));
    ASSERT_OK(K(sensor_init_lean)(&lean, H, r));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(K(history_assign)(&other, 2, other_memory, COUNT(other_memory)));
    watch_nothing();
    WATCH(lean), WATCH(lean_memory), WATCH(track), WATCH(track_memory), WATCH(z);
}

/* Component c without noise, or as good as without */
static void sharpen(int c, num noise_now)
{
    r[c] = noise_now;
    ASSERT_OK(K(sensor_init_diagonal)(&full, H, r));
    ASSERT_OK(K(sensor_init_lean)(&lean, H, r));
}

TEST(what_is_not_sharp_is_taken_as_ever)
{
    for (uint32_t seed = 1; seed <= 20; seed++) {
        uint32_t state = seed;
        set_up();
        ASSERT_OK(K(attach)(&track, &tape.attached));
        ASSERT_OK(K(attach)(&twin, &other.attached));
        for (int t = 0; t < STEPS; t++) {
            for (int c = 0; c < 3; c++) z[c] = noise(&state);
            const uint32_t present = 1 + seed % 7;
            ASSERT_OK(K(step)(&track, &motion, NULL, &full, z));
            ASSERT_OK(K(step)(&twin, &motion, NULL, &lean, z));
            ASSERT_SAME_STATE(&track, &twin, 2);
            TEST_ASSERT_TRUE(K(nis)(&track) == K(nis)(&twin));
            TEST_ASSERT_EQUAL_INT(3, K(taken)(&twin));
            TEST_ASSERT_TRUE(K(log_likelihood_last)(&track) == K(log_likelihood_last)(&twin));
            ASSERT_OK(K(update_subset)(&track, &full, z, present));
            ASSERT_OK(K(update_subset)(&twin, &lean, z, present));
            ASSERT_SAME_STATE(&track, &twin, 2);
        }
        TEST_ASSERT_EQUAL_UINT(0, K(events)(&twin));
        TEST_ASSERT_TRUE(K(log_likelihood)(&twin) == 0);
        ASSERT_OK(K(smooth)(&tape));
        ASSERT_OK(K(smooth)(&other));
        for (size_t t = 0; t < K(history_steps)(&tape); t++) {
            TEST_ASSERT_TRUE(K(mean)(SMOOTHED(&tape, t), 1) == K(mean)(SMOOTHED(&other, t), 1));
        }
    }
}

/* What a noise is raised to, a share of S */
#define COARSE (EPS > 1e-10 ? N(0x1p-15) : N(0x1p-47))

/* H_c P H_c' of the prior */
static num variance_of(int c)
{
    const num *h = H + 2 * c;
    return h[0] * h[0] * P0[0] + 2 * h[0] * h[1] * P0[1] + h[1] * h[1] * P0[3];
}

/* The one that is sharp is taken as one with the raised noise; the others are as ever. */
TEST(what_is_sharp_is_taken_coarsely)
{
    static const num noises[] = {0, SHARP};
    for (int k = 0; k < COUNT(noises); k++) {
        set_up();
        sharpen(0, COARSE * variance_of(0));
        ASSERT_OK(K(update)(&track, &full, z));
        sharpen(0, noises[k]);
        ASSERT_OK(K(update)(&twin, &lean, z));
        for (int i = 0; i < 2; i++) {
            ASSERT_CLOSE(K(mean)(&track, i), K(mean)(&twin, i), 4);
            ASSERT_CLOSE(K(sigma)(&track, i), K(sigma)(&twin, i), 2 + EPS / (double)COARSE);
        }
        TEST_ASSERT_TRUE(K(sigma)(&twin, 0) < N(1.01) * N(sqrt((double)(COARSE * variance_of(0)))));
        TEST_ASSERT_EQUAL_INT(3, K(taken)(&twin));
        TEST_ASSERT_EQUAL_UINT(KQ_EVENT_LOW_NOISE, K(events)(&twin));
        K(events_clear)(&twin);
        TEST_ASSERT_EQUAL_UINT(0, K(events)(&twin));
    }
}

/* 2^-16 of S in f32, 2^-48 in f64: as it is above it, coarsely below */
TEST(where_sharp_begins)
{
    const num share = COARSE / 2, s = variance_of(0);
    sharpen(0, s * share * N(1.01));
    ASSERT_OK(K(update_subset)(&track, &lean, z, 1));
    ASSERT_OK(K(update_subset)(&twin, &full, z, 1));
    ASSERT_SAME_STATE(&track, &twin, 2);
    TEST_ASSERT_EQUAL_UINT(0, K(events)(&track));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    sharpen(0, s * share * N(0.99));
    ASSERT_OK(K(update_subset)(&track, &lean, z, 1));
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_LOW_NOISE, K(events)(&track));
}

/* At the same instant, and at every one: another sensor's noise-free measurement shuts nothing out. */
TEST(after_a_sharp_one)
{
    static const num h[] = {1, 0}, none[] = {0}, one[] = {1};
    ASSERT_OK(K(sensor_init_diagonal)(&sharp, h, none));
    for (int t = 0; t < STEPS; t++) {
        ASSERT_OK(K(update)(&track, &sharp, one));
        ASSERT_OK(K(update)(&twin, &sharp, one));
        ASSERT_OK(K(update)(&track, &full, z));
        ASSERT_OK(K(update)(&twin, &lean, z));
        TEST_ASSERT_EQUAL_INT(3, K(taken)(&twin));
        for (int i = 0; i < 2; i++) {
            ASSERT_WITHIN(64 * EPS, K(mean)(&track, i), K(mean)(&twin, i));
            ASSERT_WITHIN(64 * EPS, K(sigma)(&track, i), K(sigma)(&twin, i));
        }
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(predict)(&twin, &motion, NULL));
    }
    TEST_ASSERT_EQUAL_UINT(0, K(events)(&twin));
}

TEST(beyond_the_numbers)
{
    z[1] = NUM_MAX;
    ASSERT_OK(K(update)(&twin, &lean, z));
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_OVERFLOW, K(events)(&twin));
    z[1] = 0;
    ASSERT_OK(K(update_subset)(&track, &full, z, 5));
    ASSERT_SAME_STATE(&track, &twin, 2);
}

/* A smoother of what was done: the history has the raised noise. */
TEST(the_raised_noise_is_recorded)
{
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK(K(attach)(&twin, &other.attached));
    for (int t = 0; t < STEPS; t++) {
        const int is_sharp = t == 0;
        sharpen(0, is_sharp ? COARSE * variance_of(0) : 1);
        ASSERT_OK(K(update)(&track, &full, z));
        sharpen(0, is_sharp ? SHARP : 1);
        ASSERT_OK(K(update)(&twin, &lean, z));
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(predict)(&twin, &motion, NULL));
    }
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_OK(K(smooth)(&other));
    const double allowed = 16 * EPS / (double)COARSE + 256 * EPS;
    for (size_t t = 0; t < K(history_steps)(&tape); t++) {
        for (int i = 0; i < 2; i++) {
            const double sigma = (double)K(sigma)(SMOOTHED(&tape, t), i);
            ASSERT_WITHIN(allowed * sigma, K(mean)(SMOOTHED(&tape, t), i), K(mean)(SMOOTHED(&other, t), i));
            ASSERT_WITHIN(allowed * sigma, sigma, K(sigma)(SMOOTHED(&other, t), i));
        }
    }
}

/* The robust updates bring the careful path along. */
TEST(robust_updates_take_it)
{
    K(loss) g = {.kind = &K(loss_gate), .limit = 1000};
    sharpen(0, 0);
    ASSERT_OK(K(update_robust)(&twin, &lean, z, 7, &g));
    ASSERT_OK(K(update)(&track, &full, z));
    ASSERT_SAME_FILTER(&track, &twin, 2);
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(update_huber(&track, &full, z, 7, 2, NULL));
    ASSERT_OK(update_huber(&twin, &lean, z, 7, 2, NULL));
    ASSERT_SAME_FILTER(&track, &twin, 2);
}

/*
 * The law: after an outage of any length a lean filter is no more than 4 n measurements behind the full one, n in
 * double: what it knows so many later is within 2 %.  Chains of n integrators, of which the last sum is measured.
 */
enum { CHAIN_MAX = 4, AFTER = 120 };
static num sigma_of_full[AFTER][CHAIN_MAX], sigma_of_lean[AFTER][CHAIN_MAX];

static int is_late_by(int late, int n)
{
    for (int t = late; t < AFTER; t++) {
        for (int i = 0; i < n; i++) {
            if (!(sigma_of_lean[t][i] <= N(1.02) * sigma_of_full[t - late][i])) return 0;
        }
    }
    return 1;
}

static void assert_comes_back(int n, int32_t outage, num noise_now)
{
    PROCESS(chain, CHAIN_MAX, 0);
    SENSOR_DIAGONAL(chain_full, CHAIN_MAX, 1);
    SENSOR_DIAGONAL(chain_lean, CHAIN_MAX, 1);
    FILTER(full_track, CHAIN_MAX);
    FILTER(lean_track, CHAIN_MAX);
    num A_n[CHAIN_MAX * CHAIN_MAX] = {0}, Q_n[CHAIN_MAX * CHAIN_MAX] = {0}, P_n[CHAIN_MAX * CHAIN_MAX] = {0};
    const num h[CHAIN_MAX] = {1}, mean[CHAIN_MAX] = {0}, measured[] = {1}, r_n[] = {noise_now};
    for (int i = 0; i < n; i++) {
        A_n[i * n + i] = P_n[i * n + i] = 1;
        Q_n[i * n + i] = N(0.01);
        if (i + 1 < n) A_n[i * n + i + 1] = N(0.5);
    }
    ASSERT_OK(K(process_assign)(&chain, n, 0, chain_memory, COUNT(chain_memory)));
    ASSERT_OK(K(sensor_assign)(&chain_full, n, 1, chain_full_memory, COUNT(chain_full_memory)));
    ASSERT_OK(K(sensor_assign)(&chain_lean, n, 1, chain_lean_memory, COUNT(chain_lean_memory)));
    ASSERT_OK(K(filter_assign)(&full_track, n, full_track_memory, COUNT(full_track_memory)));
    ASSERT_OK(K(filter_assign)(&lean_track, n, lean_track_memory, COUNT(lean_track_memory)));
    ASSERT_OK(K(process_init)(&chain, A_n, NULL, Q_n));
    ASSERT_OK(K(sensor_init_diagonal)(&chain_full, h, r_n));
    ASSERT_OK(K(sensor_init_lean)(&chain_lean, h, r_n));
    ASSERT_OK(K(filter_init)(&full_track, mean, P_n));
    ASSERT_OK(K(filter_init)(&lean_track, mean, P_n));
    for (int32_t t = 0; t < outage; t++) {
        ASSERT_OK(K(predict)(&full_track, &chain, NULL));
        ASSERT_OK(K(predict)(&lean_track, &chain, NULL));
    }
    for (int t = 0; t < AFTER; t++) {
        ASSERT_OK(K(step)(&full_track, &chain, NULL, &chain_full, measured));
        ASSERT_OK(K(step)(&lean_track, &chain, NULL, &chain_lean, measured));
        if (t + 1 == AFTER) TEST_ASSERT_EQUAL_INT(1, K(taken)(&lean_track));
        for (int i = 0; i < n; i++) {
            sigma_of_full[t][i] = K(sigma)(&full_track, i);
            sigma_of_lean[t][i] = K(sigma)(&lean_track, i);
        }
    }
    int late = 0;
    while (late < AFTER && !is_late_by(late, n)) late++;
    TEST_ASSERT_TRUE(late <= (EPS > 1e-10 ? 4 * n : n));
    K(events_clear)(&lean_track);
    ASSERT_OK(K(step)(&lean_track, &chain, NULL, &chain_lean, measured));
    TEST_ASSERT_EQUAL_UINT(0, K(events)(&lean_track)); /* it is no longer raised */
}

TEST(after_any_outage_it_comes_back)
{
    static const int32_t outages[] = {10, 100, 3000};
    static const num noises[] = {1, N(0.01), N(1e-4)};
    for (int n = 1; n <= CHAIN_MAX; n++) {
        for (int k = 0; k < COUNT(outages); k++) {
            for (int j = 0; j < COUNT(noises); j++) assert_comes_back(n, outages[k], noises[j]);
        }
    }
}

/* Far more bits from the prediction than a number has */
TEST(what_is_far_off_is_found_again)
{
    static const num one_state[] = {1, 0}, noise_now[] = {0.0625};
    static const num correlated_P0[] = {1, 0.5, 0.5, 1};
    for (int power = 20; power < 100; power += 8) {
        num wide_P0[4], start[2];
        for (int k = 0; k < 4; k++) wide_P0[k] = correlated_P0[k] * N(ldexp(1, power));
        for (int k = 0; k < 2; k++) start[k] = N(ldexp(1.2345678, power / 2));
        const num near_by[] = {7};
        ASSERT_OK(K(sensor_init_diagonal)(&sharp, one_state, noise_now));
        ASSERT_OK(K(filter_init)(&track, start, wide_P0));
        ASSERT_OK(K(update)(&track, &sharp, near_by));
        ASSERT_WITHIN(0.01, 7, K(mean)(&track, 0));
        TEST_ASSERT_EQUAL_UINT(0, K(events)(&track));
        /* 2^13 sigma off */
        for (int k = 0; k < 2; k++) start[k] *= 8192;
        ASSERT_OK(K(filter_init)(&track, start, wide_P0));
        const double rest = (double)start[0] * 0.0625 / ((double)wide_P0[0] + 0.0625);
        ASSERT_OK(K(update)(&track, &sharp, near_by));
        ASSERT_WITHIN(0.01, 7 + rest, K(mean)(&track, 0));
    }
}

TEST(what_contradicts_is_told)
{
    static const num one_state[] = {1, 0}, noise_now[] = {SHARP};
    const num away[] = {EPS > 1e-10 ? N(1e5) : N(1e9)};
    ASSERT_OK(K(sensor_init_diagonal)(&sharp, one_state, noise_now));
    ASSERT_OK(K(update)(&track, &sharp, away));
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_CONTRADICTION, K(events)(&track));
}

ADAPTATION(taught, 2, 3);
ADAPTATION(taught_lean, 2, 3);

/* What is learnt from is taken: by a lean sensor, too. */
TEST(an_adaptation_takes_it)
{
    static const K(adaptation_rule) rule = {KQ_ADAPT_BOTH, 50, 0.125, 0.0625, 16, 0.125, 8};
    uint32_t seed = 1;
    sharpen(1, SHARP);
    ASSERT_OK(K(adaptation_init)(&taught, &motion, &full, &rule));
    ASSERT_OK(K(attach)(&track, &taught.attached));
    ASSERT_OK(K(adaptation_init)(&taught_lean, &motion, &lean, &rule));
    ASSERT_OK(K(attach)(&twin, &taught_lean.attached));
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < 3; c++) z[c] = noise(&seed);
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(predict)(&twin, &motion, NULL));
        ASSERT_OK(K(update_subset)(&track, &full, z, 7));
        ASSERT_OK(K(update_subset)(&twin, &lean, z, 7));
        ASSERT_SAME_FILTER(&track, &twin, 2);
    }
}

/* The same as constants: the root of Q by columns; A and H are taken for dense */
static const num table_A[] = {1, 0.5, 0, 1}, table_G[] = {0.5, 0.25, 0.5};
static const num table_Q[] = {0.3125, 0.125, 0.125, 0.25}, table_r[] = {0.5, 1, 2};
static const K(process) table = KQ_PROCESS_TABLE(2, 0, table_A, NULL, table_G);
static const K(sensor) lean_table = SENSOR_LEAN_TABLE(2, 3, H, table_r);

TEST(a_const_table_is_a_lean_sensor)
{
    uint32_t seed = 1;
    ASSERT_OK(K(process_init)(&motion, table_A, NULL, table_Q));
    for (int t = 0; t < STEPS; t++) {
        reading expected, now;
        for (int c = 0; c < 3; c++) z[c] = noise(&seed);
        ASSERT_OK(K(step)(&track, &motion, NULL, &full, z));
        ASSERT_OK(K(step)(&twin, &table, NULL, &lean_table, z));
        read_filter(&expected, &track, 2);
        read_filter(&now, &twin, 2);
        for (int i = 0; i < 2; i++) {
            ASSERT_CLOSE(expected.mean[i], now.mean[i], 4);
            ASSERT_CLOSE(expected.sigma[i], now.sigma[i], 2);
        }
    }
    TEST_ASSERT_EQUAL_UINT(0, K(events)(&twin));
}

static const K(process) table_of_zeros = KQ_PROCESS_TABLE(2, 0, table_A, NULL, table_G, (0, 1));
static const num table_H[] = {1, 0, 0.5, 1, 0, 1};
static const K(sensor) lean_of_zeros = SENSOR_LEAN_TABLE(2, 3, table_H, table_r, (1, 0, 2));
static const K(sensor) full_of_zeros = SENSOR_TABLE(2, 3, table_H, table_r, (1, 0, 2));

/* With what is known of A and H: what init finds there, and the same state */
TEST(a_const_table_knows_where_zeros_are)
{
    uint32_t seed = 1;
    ASSERT_OK(K(process_init)(&motion, table_A, NULL, table_Q));
    ASSERT_OK(K(sensor_init_lean)(&lean, table_H, table_r));
    TEST_ASSERT_EQUAL_MEMORY(motion.first, table_of_zeros.first, sizeof motion.first);
    TEST_ASSERT_EQUAL_MEMORY(lean.selects, lean_of_zeros.selects, sizeof lean.selects);
    TEST_ASSERT_EQUAL_MEMORY(lean.selects, full_of_zeros.selects, sizeof lean.selects);
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < 3; c++) z[c] = noise(&seed);
        const K(sensor) *const s = t % 2 ? &lean_of_zeros : &full_of_zeros;
        ASSERT_OK(K(step)(&track, &motion, NULL, &lean, z));
        ASSERT_OK(K(step)(&twin, &table_of_zeros, NULL, s, z));
        for (int i = 0; i < 2; i++) {
            ASSERT_CLOSE(K(mean)(&track, i), K(mean)(&twin, i), 4);
            ASSERT_CLOSE(K(sigma)(&track, i), K(sigma)(&twin, i), 2);
        }
    }
}

TEST(bad_inputs)
{
    const num negative[] = {1, -1, 1}, nan[] = {1, (num)NAN, 1};
    ASSERT_REFUSED(KQ_ERR_NULL, K(sensor_init_lean)(NULL, H, r));
    ASSERT_REFUSED(KQ_ERR_NULL, K(sensor_init_lean)(&lean, NULL, r));
    ASSERT_REFUSED(KQ_ERR_NULL, K(sensor_init_lean)(&lean, H, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(sensor_init_lean)(&lean, H, negative));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(sensor_init_lean)(&lean, H, nan));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update)(&track, &blank, z));
    z[2] = (num)NAN;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(update)(&track, &lean, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(update)(&track, &lean, NULL));
}

SUITE(lean, set_up)
#include "lean.tests"
