/* One filter in each floating arithmetic: links, runs, and gets the mean of two equal measurements. */
#include <float.h>
#include <kalmanq/kalmanq.h>
#include <stdio.h>

KQ_SENSOR_F32(gauge, 1, 1);
KQ_FILTER_F32(level, 1);

static float mean_f32(void)
{
    static const float one = 1, zero = 0, z = 3;
    if (kq_sensor_init_f32(&gauge, &one, &one) || kq_filter_init_f32(&level, &zero, &one) ||
        kq_update_f32(&level, &gauge, &z)) {
        return -1;
    }
    return kq_mean_f32(&level, 0);
}

#if DBL_MANT_DIG >= 53 /* not avr-gcc's double */
KQ_SENSOR_F64(gauge64, 1, 1);
KQ_FILTER_F64(level64, 1);

static double mean_f64(void)
{
    static const double one = 1, zero = 0, z = 3;
    if (kq_sensor_init_f64(&gauge64, &one, &one) || kq_filter_init_f64(&level64, &zero, &one) ||
        kq_update_f64(&level64, &gauge64, &z)) {
        return -1;
    }
    return kq_mean_f64(&level64, 0);
}
#else
static double mean_f64(void) { return 1.5; }
#endif

int main(void)
{
    const float single = mean_f32();
    const double both = mean_f64();
    printf("kalmanq %s: %d %d halves\n", KQ_VERSION_STRING, (int)(2 * single), (int)(2 * both));
    return single == 1.5f && both == 1.5 ? 0 : 1;
}
