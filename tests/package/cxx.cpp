// The macros, the tables and the names without a suffix, in C++: the consumer's filter, once more.
#include <kalmanq/kalmanq.h>
#include <kalmanq/generic.h>

namespace {
const float A[] = {1, 0.5f, 0, 1}, G[] = {0.1f, 0.2f, 0.1f}, H[] = {1, 0}, r[] = {1};
const kq_process_f32 dense = KQ_PROCESS_TABLE(2, 0, A, nullptr, G), upper = KQ_PROCESS_TABLE(2, 0, A, nullptr, G, (0, 1));
const kq_sensor_f32 ranger = KQ_SENSOR_TABLE_F32(2, 1, H, r), lean = KQ_SENSOR_LEAN_TABLE_F32(2, 1, H, r, (1));
}
KQ_PROCESS_F64(motion, 1, 0);
KQ_SENSOR_DIAGONAL_F64(gauge, 1, 1);
KQ_FILTER_F64(level, 1);
KQ_FILTER_F32(cart, 2);

int main()
{
    static const double one = 1, zero = 0, z = 3;
    if (kq_process_init(&motion, &one, nullptr, &one) || kq_sensor_init(&gauge, &one, &one) ||
        kq_filter_init(&level, &zero, &one) || kq_update(&level, &gauge, &z) || kq_predict(&level, &motion, nullptr)) {
        return 1;
    }
    static const float x0[] = {0, 0}, P0[] = {1, 0, 0, 1}, range[] = {2};
    if (kq_filter_init(&cart, x0, P0) || kq_step(&cart, &dense, nullptr, &ranger, range) ||
        kq_step(&cart, &upper, nullptr, &lean, range)) {
        return 2;
    }
    const bool is_right = kq_mean(&level, 0) == 1.5 && kq_mean(&cart, 0) > 1 && kq_sigma(&cart, 0) < 1 && !kq_events(&cart);
    return is_right ? 0 : 3;
}
