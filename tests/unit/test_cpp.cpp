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

// Objects at namespace scope, by the macros.
KQ_PROCESS_F32(motion32, 2, 1);
KQ_SENSOR_F32(radar32, 2, 1);
KQ_SENSOR_DIAGONAL_F32(pair32, 2, 2);
KQ_FILTER_F32(track32, 2);
KQ_HISTORY_F32(tape32, 2, 3, 4, 1);

KQ_PROCESS_F64(motion64, 2, 1);
KQ_SENSOR_F64(radar64, 2, 1);
KQ_SENSOR_DIAGONAL_F64(pair64, 2, 2);
KQ_FILTER_F64(track64, 2);
KQ_HISTORY_F64(tape64, 2, 3, 4, 1);

constexpr double a[] = {1, 0.5, 0, 1}, b[] = {0.125, 0.5}, q[] = {0.25, 0.125, 0.125, 0.5};
constexpr double h[] = {1, 0, 0.5, 1}, r[] = {0.5, 2}, x0[] = {1, -2}, p0[] = {2, 0.5, 0.5, 1};
constexpr double u[] = {4}, z[] = {3, 1};

constexpr float a32[] = {1, 0.5f, 0, 1}, b32[] = {0.125f, 0.5f};
constexpr float q32[] = {0.25f, 0.125f, 0.125f, 0.5f}, h32[] = {1, 0, 0.5f, 1}, r32[] = {0.5f, 2};
constexpr float x32[] = {1, -2}, p32[] = {2, 0.5f, 0.5f, 1}, u32[] = {4}, z32[] = {3, 1};

void accepted(kq_status status) { TEST_ASSERT_EQUAL_INT(KQ_OK, status); }

void run_f32()
{
    accepted(kq_process_init_f32(&motion32, a32, b32, q32));
    accepted(kq_sensor_init_f32(&radar32, h32, r32));
    accepted(kq_sensor_init_diagonal_f32(&pair32, h32, r32));
    accepted(kq_filter_init_f32(&track32, x32, p32));
    accepted(kq_attach_f32(&track32, &tape32.attached));
    for (int step = 0; step < 3; step++) {
        accepted(kq_update_f32(&track32, &pair32, z32));
        accepted(kq_step_f32(&track32, &motion32, u32, &radar32, z32));
    }
}

void run_f64()
{
    accepted(kq_process_init_f64(&motion64, a, b, q));
    accepted(kq_sensor_init_f64(&radar64, h, r));
    accepted(kq_sensor_init_diagonal_f64(&pair64, h, r));
    accepted(kq_filter_init_f64(&track64, x0, p0));
    accepted(kq_attach_f64(&track64, &tape64.attached));
    for (int step = 0; step < 3; step++) {
        accepted(kq_update_f64(&track64, &pair64, z));
        accepted(kq_step_f64(&track64, &motion64, u, &radar64, z));
    }
}

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
        close(kq_mean_f64(&track64, i), kq_mean_f32(&track32, i));
        close(kq_sigma_f64(&track64, i), kq_sigma_f32(&track32, i));
    }
    close(kq_nis_f64(&track64), kq_nis_f32(&track32));
    close(kq_log_likelihood_f64(&track64), kq_log_likelihood_f32(&track32));
    TEST_ASSERT_EQUAL_UINT(0, kq_events_f32(&track32) | kq_events_f64(&track64));
    TEST_ASSERT_EQUAL_INT(1, kq_taken_f32(&track32));
}

void both_smoothers_agree()
{
    run_f32();
    run_f64();
    TEST_ASSERT_EQUAL_UINT(4, kq_history_steps_f32(&tape32));
    accepted(kq_smooth_f32(&tape32));
    accepted(kq_smooth_f64(&tape64));
    for (std::size_t t = 0; t < 4; t++) {
        kq_filter_f32 view32;
        kq_filter_f64 view64;
        accepted(kq_smoothed_f32(&tape32, t, &view32));
        accepted(kq_smoothed_f64(&tape64, t, &view64));
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
    accepted(kq_forecast_f32(&track32, &motion32, nullptr, 5, &ahead));
    accepted(kq_forecast_f64(&track64, &motion64, nullptr, 5, &ahead64));
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
    accepted(kq_filter_init_f32(&filter, x32, p32));
    close(-2, kq_mean_f32(&filter, 1));
    accepted(kq_attach_f64(&track64, &tape.attached));
    TEST_ASSERT_EQUAL_UINT(1, kq_history_steps_f64(&tape));
    accepted(kq_filter_init_f64(&track64, x0, p0));
}

void a_refusal_has_a_text()
{
    const kq_status status = kq_filter_init_f32(nullptr, x32, p32);
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
