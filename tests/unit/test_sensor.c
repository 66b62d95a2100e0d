/* The sensor: its checks, what it makes of the noise. */
#include "reading.h"
#include "textbook.h"
#include "turned.h"
#include "unchanged.h"

SENSOR(radar, 2, 2);
FILTER(track, 2);

static num H[4], R[4], r[2];

static void set_up(void)
{
    static const num h[] = {1, 0, 0.5, 1}, covariance[] = {0.5, 0.25, 0.25, 1};
    static const num variances[] = {0.5, 2};
    memcpy(H, h, sizeof H);
    memcpy(R, covariance, sizeof R);
    memcpy(r, variances, sizeof r);
    ASSERT_OK(K(sensor_assign)(&radar, 2, 2, radar_memory, COUNT(radar_memory)));
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    ASSERT_OK(K(filter_assign)(&track, 2, track_memory, COUNT(track_memory)));
    watch_nothing();
    WATCH(radar);
    WATCH(radar_memory);
    WATCH(H);
    WATCH(R);
    WATCH(r);
}

static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1}, z[] = {3, 1};

/* One update by the sensor is that by H and the 2 x 2 covariance C. */
static void assert_model(const K(sensor) * s, const num *h, const num *C)
{
    textbook t;
    textbook_init(&t, 2, x0, P0);
    textbook_update(&t, h, C, z, 2);
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(update)(&track, s, z));
    ASSERT_TEXTBOOK(&t, &track);
    ASSERT_CLOSE(t.nis, K(nis)(&track), t.nis);
}

/* ------------------------------------------------------------------------------ assign */

TEST(assign_takes_more_memory_than_it_needs)
{
    K(sensor) s;
    ASSERT_OK(K(sensor_assign)(&s, 2, 2, radar_memory, SIZE_MAX));
    ASSERT_OK(K(sensor_init)(&s, H, R));
    assert_model(&s, H, R);
    ASSERT_OK(K(sensor_assign)(&s, 2, 2, radar_memory, SIZE_MAX / 2 + 2));
    ASSERT_OK(K(sensor_init)(&s, H, R));
    assert_model(&s, H, R);
}

TEST(an_assigned_sensor_still_has_to_be_initialised)
{
    ASSERT_OK(K(sensor_assign)(&radar, 2, 2, radar_memory, COUNT(radar_memory)));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update)(&track, &radar, z));
}

/* -------------------------------------------------------------------------------- init */

TEST(init_takes_correlated_components) { assert_model(&radar, H, R); }

TEST(init_takes_independent_components)
{
    put_covariance(R, 0.5, 0, 0, 2);
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    assert_model(&radar, H, R);
}

TEST(init_refuses_correlation_where_there_is_memory_for_a_diagonal)
{
    static K(sensor) s;
    ASSERT_OK(K(sensor_assign)(&s, 2, 2, radar_memory, KQ_SENSOR_DIAGONAL_LEN(2)));
    WATCH(s);
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(sensor_init)(&s, H, R));
    ASSERT_OK(K(sensor_assign)(&s, 2, 2, radar_memory, KQ_SENSOR_LEN(2) - 1));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(sensor_init)(&s, H, R));
}

static kq_status init(void) { return K(sensor_init)(&radar, H, R); }

TEST(init_refuses_numbers_that_are_not_finite)
{
    assert_entries_must_be_finite(H, 4, init);
    assert_entries_must_be_finite(R, 4, init);
}

TEST(init_checks_that_the_noise_is_a_covariance)
{
    assert_covariance_is_checked(R, init);
}

TEST(init_takes_a_singular_noise)
{
    static const double singular[][3] = {
        {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {4, 2, 1}, {1, -1, 1}, {0.25, 0.75, 2.25},
    };
    for (int k = 0; k < COUNT(singular); k++) {
        put_covariance(R, singular[k][0], singular[k][1], singular[k][1], singular[k][2]);
        ASSERT_OK(init());
        assert_model(&radar, H, R);
    }
}

/* The lower triangle is compared, within rounding, and not used. */
TEST(init_uses_the_upper_triangle)
{
    FILTER(twin, 2);
    num S[4], lower[4];
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(update)(&twin, &radar, z));
    ASSERT_OK(K(measurement)(&twin, &radar, NULL, S));
    R[2] = N(0.25 * (1 + EPS));
    ASSERT_OK(init());
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(update)(&track, &radar, z));
    ASSERT_OK(K(measurement)(&track, &radar, NULL, lower));
    ASSERT_SAME_FILTER(&twin, &track, 2);
    ASSERT_SAME_BITS(S, lower);
}

TEST(an_independent_noise_is_not_kept)
{
    static const num diagonal[] = {0.5, 0, 0, 2};
    memcpy(R, diagonal, sizeof R);
    ASSERT_OK(init());
    memset(R, 0xFF, sizeof R);
    assert_model(&radar, H, diagonal);
}

TEST(a_refused_init_leaves_the_old_model_working)
{
    static num bad[4] = {1, 2, 2, 1};
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(sensor_init)(&radar, H, bad));
    r[1] = -1;
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(sensor_init_diagonal)(&radar, H, r));
    assert_model(&radar, H, R);
}

TEST(init_may_be_called_again_with_another_model)
{
    static const num other[] = {1, 0.75, 0.75, 1}, independent[] = {1, 0, 0, 1};
    ASSERT_OK(K(sensor_init)(&radar, H, other));
    assert_model(&radar, H, other);
    ASSERT_OK(K(sensor_init)(&radar, H, independent));
    assert_model(&radar, H, independent);
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    assert_model(&radar, H, R);
}

/* ---------------------------------------------------------------------- init_diagonal */

TEST(init_diagonal_takes_variances)
{
    static const num covariance[] = {0.5, 0, 0, 2};
    ASSERT_OK(K(sensor_init_diagonal)(&radar, H, r));
    memset(r, 0xFF, sizeof r); /* not kept */
    assert_model(&radar, H, covariance);
}

TEST(init_diagonal_takes_noise_free_components)
{
    static const num covariance[] = {0, 0, 0, 2};
    r[0] = 0;
    ASSERT_OK(K(sensor_init_diagonal)(&radar, H, r));
    assert_model(&radar, H, covariance);
    ASSERT_CLOSE(0, K(sigma)(&track, 0), 1);
}

static kq_status init_diagonal(void) { return K(sensor_init_diagonal)(&radar, H, r); }

TEST(init_diagonal_refuses_numbers_that_are_not_finite)
{
    assert_entries_must_be_finite(H, 4, init_diagonal);
    assert_entries_must_be_finite(r, 2, init_diagonal);
}

TEST(init_diagonal_refuses_a_negative_variance)
{
    for (int c = 0; c < 2; c++) {
        const num good = r[c];
        r[c] = N(-1e-6);
        ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, init_diagonal());
        r[c] = good;
    }
    ASSERT_OK(init_diagonal());
}

/* ------------------------------------------------------------------ change_measurement */

TEST(change_measurement_measures_otherwise_with_the_same_noise)
{
    static const num other[] = {0.5, -1, 2, 0.25};
    ASSERT_OK(K(sensor_change_measurement)(&radar, other));
    assert_model(&radar, other, R);
    H[1] = 3;
    ASSERT_OK(K(sensor_change_measurement)(&radar, H));
    assert_model(&radar, H, R);
}

static kq_status change(void) { return K(sensor_change_measurement)(&radar, H); }

TEST(change_measurement_refuses_numbers_that_are_not_finite)
{
    assert_entries_must_be_finite(H, 4, change);
}

/* ------------------------------------------------------------------- check */

static kq_status check_radar(void) { return K(sensor_check)(&radar); }

/* All but padding; of the memory so many words */
static void assert_every_bit_is_found(int words)
{
    const size_t fields = 2 + 2 + 5 * sizeof(void *) + KQ_SIZE_MAX + sizeof radar.plain + 2;
    TEST_ASSERT_EQUAL_INT(8 * (int)fields, BITS_FOUND(radar, check_radar));
    const size_t size = (size_t)words * sizeof *radar_memory;
    TEST_ASSERT_EQUAL_INT(8 * (int)size, bits_found(radar_memory, size, check_radar));
}

TEST(check_finds_every_bit_of_a_sensor)
{
    assert_every_bit_is_found(3);
    static num other[COUNT(H)];
    memcpy(other, H, sizeof other);
    ASSERT_OK(K(sensor_change_measurement)(&radar, other));
    ASSERT_ALL_FOUND(other, check_radar);
    ASSERT_OK(K(sensor_init_diagonal)(&radar, H, r));
    assert_every_bit_is_found(2);
    ASSERT_OK(K(sensor_init_lean)(&radar, H, r));
    assert_every_bit_is_found(2);
    ASSERT_OK(K(sensor_change_measurement)(&radar, R));
    assert_every_bit_is_found(2);
}

TEST(check_takes_what_calls_have_left)
{
    static K(sensor) table = SENSOR_TABLE(2, 2, H, r);
    K(sensor) copy = radar;
    ASSERT_OK(K(sensor_check)(&copy));
    ASSERT_OK(K(sensor_check)(&table));
    ASSERT_OK(K(sensor_change_measurement)(&copy, R));
    ASSERT_OK_UNCHANGED(K(sensor_check)(&copy));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(update_subset)(&track, &radar, z, 2));
    ASSERT_OK(K(sensor_check)(&radar));
    ASSERT_OK(K(sensor_assign)(&copy, 2, 2, radar_memory, COUNT(radar_memory)));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(sensor_check)(&copy));
    ASSERT_REFUSED(KQ_ERR_NULL, K(sensor_check)(NULL));
}

SUITE(sensor, set_up)
#include "sensor.tests"
