/* What try.py's filter is in C: its first line. */
#include <stdio.h>
#include <string.h>

#include "kalmanq/filter.h"

KQ_PROCESS_F32(process, 2, 1);
KQ_SENSOR_F32(sensor, 2, 2);
KQ_FILTER_F32(filter, 2);

static unsigned long bits(float x)
{
    uint32_t word;
    memcpy(&word, &x, sizeof word);
    return word;
}

int main(void)
{
    static const float A[] = {1, 0.125f, 0, 0.9375f}, B[] = {0.0078125f, 0.125f}, Q[] = {0.03125f, 0.015625f, 0.015625f, 0.0625f};
    static const float H[] = {1, 0, 0.5f, 1}, R[] = {0.5f, 0.125f, 0.125f, 0.25f};
    static const float x0[] = {1, -1}, P0[] = {2, 0.5f, 0.5f, 3}, u[] = {0.25f};
    int bad = kq_process_init_f32(&process, A, B, Q) || kq_sensor_init_f32(&sensor, H, R) ||
        kq_filter_init_f32(&filter, x0, P0);
    for (int k = 0; k < 100; k++) {
        const float part = (float)(k * 37 % 11) / 8, both[] = {part, -part}, one[] = {0, part};
        if (k % 5 == 3)
            bad |= kq_predict_f32(&filter, &process, u) || kq_update_subset_f32(&filter, &sensor, one, 2);
        else
            bad |= kq_step_f32(&filter, &process, u, &sensor, both) != KQ_OK;
    }
    printf("f32 %08lx %08lx %08lx %08lx %u\n", bits(kq_mean_f32(&filter, 0)), bits(kq_mean_f32(&filter, 1)),
        bits(kq_sigma_f32(&filter, 0)), bits(kq_sigma_f32(&filter, 1)), kq_events_f32(&filter));
    return bad;
}
