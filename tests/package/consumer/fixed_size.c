/* The installed kernels: one filter of a size that the compiler knows. */
#include <kalmanq/kernels/fixed_size/kq_fixed_f32.h>
#include <stdio.h>

KQ_SENSOR_F32(gauge, 1, 1);
KQ_FILTER_F32(level, 1);

int main(void)
{
    static const float one = 1, zero = 0, z = 3;
    if (kq_sensor_init_f32(&gauge, &one, &one) || kq_filter_init_f32(&level, &zero, &one) ||
        kq_fixed_update_f32(&level, &gauge, &z, 1, 1, KQ_FIXED_BARE)) {
        return 1;
    }
    printf("compile-time sizes: %g\n", (double)kq_mean_f32(&level, 0));
    return kq_mean_f32(&level, 0) == 1.5f ? 0 : 1;
}
