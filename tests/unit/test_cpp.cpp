// A C++ caller: the headers are C++ as well, the macros declare objects there, both arithmetics
// live in one program, and lengths are constant expressions.
#include "kalmanq/kalmanq.h"
#include "unity.h"

#include <array>
#include <type_traits>

extern "C" {
void setUp(void);
void tearDown(void);
}

void setUp(void) {}
void tearDown(void) {}

static_assert(sizeof(float) * KQ_PRIVATE_HISTORY_STEP_LEN_F32(2, 1) == 44, "bytes of one step");
static_assert(KQ_OK == 0 && KQ_ERR_HISTORY_FULL < 0, "status");
static_assert(KQ_VERSION >= 100, "version");
static_assert(std::is_standard_layout<kq_filter_f32>::value, "plain data");
static_assert(std::is_trivially_copyable<kq_history_f64>::value, "plain data");

namespace
{

void accepted(kq_status status) { TEST_ASSERT_EQUAL_INT(KQ_OK, status); }

// Objects at namespace scope, by the macros, and a run of theirs: motion_f32 and so on, run_f32().
#define RUN_OF(T, SUFFIX, number)                                                                  \
    KQ_PROCESS_##SUFFIX(motion_##T, 2, 1);                                                         \
    KQ_SENSOR_##SUFFIX(radar_##T, 2, 1);                                                           \
    KQ_SENSOR_DIAGONAL_##SUFFIX(pair_##T, 2, 2);                                                   \
    KQ_FILTER_##SUFFIX(track_##T, 2);                                                              \
    KQ_HISTORY_##SUFFIX(tape_##T, 2, 3, 4, 1);                                                     \
    constexpr number a_##T[] = {1, 0.5, 0, 1}, b_##T[] = {0.125, 0.5};                             \
    constexpr number q_##T[] = {0.25, 0.125, 0.125, 0.5}, h_##T[] = {1, 0, 0.5, 1};                \
    constexpr number r_##T[] = {0.5, 2}, x_##T[] = {1, -2}, p_##T[] = {2, 0.5, 0.5, 1};            \
    constexpr number u_##T[] = {4}, z_##T[] = {3, 1};                                              \
    void run_##T()                                                                                 \
    {                                                                                              \
        accepted(kq_process_init_##T(&motion_##T, a_##T, b_##T, q_##T));                           \
        accepted(kq_sensor_init_##T(&radar_##T, h_##T, r_##T));                                    \
        accepted(kq_sensor_init_diagonal_##T(&pair_##T, h_##T, r_##T));                            \
        accepted(kq_filter_init_##T(&track_##T, x_##T, p_##T));                                    \
        accepted(kq_attach_##T(&track_##T, &tape_##T.attached));                                   \
        for (int step = 0; step < 3; step++) {                                                     \
            accepted(kq_update_##T(&track_##T, &pair_##T, z_##T));                                 \
            accepted(kq_step_##T(&track_##T, &motion_##T, u_##T, &radar_##T, z_##T));              \
        }                                                                                          \
    }

RUN_OF(f32, F32, float)
RUN_OF(f64, F64, double)

// static_cast, so that no float is promoted by itself
void close(double expected, float actual)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, expected, static_cast<double>(actual));
}

void both_arithmetics_agree()
{
    run_f32();
    run_f64();
    for (int i = 0; i < 2; i++) {
        close(kq_mean_f64(&track_f64, i), kq_mean_f32(&track_f32, i));
        close(kq_sigma_f64(&track_f64, i), kq_sigma_f32(&track_f32, i));
    }
    close(kq_nis_f64(&track_f64), kq_nis_f32(&track_f32));
    close(kq_log_likelihood_f64(&track_f64), kq_log_likelihood_f32(&track_f32));
    TEST_ASSERT_EQUAL_UINT(0, kq_events_f32(&track_f32) | kq_events_f64(&track_f64));
    TEST_ASSERT_EQUAL_INT(1, kq_taken_f32(&track_f32));
}

void both_smoothers_agree()
{
    run_f32();
    run_f64();
    TEST_ASSERT_EQUAL_UINT(4, kq_history_steps_f32(&tape_f32));
    accepted(kq_smooth_f32(&tape_f32));
    accepted(kq_smooth_f64(&tape_f64));
    for (std::size_t t = 0; t < 4; t++) {
        kq_filter_f32 view32;
        kq_filter_f64 view64;
        accepted(kq_smoothed_f32(&tape_f32, t, &view32));
        accepted(kq_smoothed_f64(&tape_f64, t, &view64));
        for (int i = 0; i < 2; i++) {
            close(kq_mean_f64(&view64, i), kq_mean_f32(&view32, i));
            close(kq_sigma_f64(&view64, i), kq_sigma_f32(&view32, i));
        }
    }
}

// Macros at block scope, and a forecast.
void macros_work_inside_a_function()
{
    KQ_FILTER_F32(ahead, 2);
    KQ_FILTER_F64(ahead64, 2);
    run_f32();
    run_f64();
    accepted(kq_forecast_f32(&track_f32, &motion_f32, nullptr, 5, &ahead));
    accepted(kq_forecast_f64(&track_f64, &motion_f64, nullptr, 5, &ahead64));
    close(kq_mean_f64(&ahead64, 0), kq_mean_f32(&ahead, 0));
    close(kq_sigma_f64(&ahead64, 0), kq_sigma_f32(&ahead, 0));
}

// Memory of any container: the lengths are constant expressions.
void memory_may_be_a_container()
{
    std::array<float, KQ_FILTER_LEN_F32(2)> words{};
    std::array<double, KQ_HISTORY_LEN_F64(2, 3, 4, 1)> tape_words{};
    kq_filter_f32 filter{};
    kq_history_f64 tape{};
    accepted(kq_filter_assign_f32(&filter, 2, words.data(), words.size()));
    accepted(kq_history_assign_f64(&tape, 2, tape_words.data(), tape_words.size()));
    accepted(kq_filter_init_f32(&filter, x_f32, p_f32));
    close(-2, kq_mean_f32(&filter, 1));
    accepted(kq_attach_f64(&track_f64, &tape.attached));
    TEST_ASSERT_EQUAL_UINT(1, kq_history_steps_f64(&tape));
    accepted(kq_filter_init_f64(&track_f64, x_f64, p_f64));
}

void a_refusal_has_a_text()
{
    const kq_status status = kq_filter_init_f32(nullptr, x_f32, p_f32);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, status);
    TEST_ASSERT_NOT_NULL(kq_status_text(status));
}

} // namespace

int main()
{
    UNITY_BEGIN();
    RUN_TEST(both_arithmetics_agree);
    RUN_TEST(both_smoothers_agree);
    RUN_TEST(macros_work_inside_a_function);
    RUN_TEST(memory_may_be_a_container);
    RUN_TEST(a_refusal_has_a_text);
    return UNITY_END();
}
