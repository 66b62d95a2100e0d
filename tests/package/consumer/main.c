/* One filter in each arithmetic: links, runs, and gets the mean of two equal measurements. */
#include <kalmanq/kalmanq.h>
#include <stdio.h>

KQ_SENSOR_F32(gauge, 1, 1);
KQ_FILTER_F32(level, 1);
KQ_SENSOR_F64(gauge64, 1, 1);
KQ_FILTER_F64(level64, 1);

int main(void)
{
    static const float one = 1, zero = 0, z = 3;
    static const double one64 = 1, zero64 = 0, z64 = 3;
    if (kq_sensor_init_f32(&gauge, &one, &one) || kq_filter_init_f32(&level, &zero, &one) ||
        kq_update_f32(&level, &gauge, &z)) {
        return 1;
    }
    if (kq_sensor_init_f64(&gauge64, &one64, &one64) ||
        kq_filter_init_f64(&level64, &zero64, &one64) || kq_update_f64(&level64, &gauge64, &z64)) {
        return 1;
    }
    printf("kalmanq %s: %g %g\n", KQ_VERSION_STRING, (double)kq_mean_f32(&level, 0),
           kq_mean_f64(&level64, 0));
    return kq_mean_f32(&level, 0) == 1.5f && kq_mean_f64(&level64, 0) == 1.5 ? 0 : 1;
}
