/* A level that drifts, and a gauge with noise: one state. */
#include <kalmanq/kalmanq.h>

KQ_PROCESS_F32(drift, 1, 0); /* 1 state, no control */
KQ_SENSOR_F32(gauge, 1, 1);  /* 1 state, 1 component */
KQ_FILTER_F32(level, 1);

static kq_status start(void)
{
    static const float one = 1, q = 0.01f, r = 4, x0 = 0, P0 = 1e6f;
    kq_status status = kq_process_init_f32(&drift, &one, NULL, &q);
    if (!status) status = kq_sensor_init_f32(&gauge, &one, &r);
    if (!status) status = kq_filter_init_f32(&level, &x0, &P0);
    return status;
}
/* program */
#include <stdio.h>

int main(void)
{
    static const float z[] = {511, 514, 509, 512, 510};
    kq_status status = start();
    for (int i = 0; i < 5 && !status; i++) status = kq_step_f32(&level, &drift, NULL, &gauge, &z[i]);
    if (status) printf("%s\n", kq_status_text(status));
    printf("%.2f +- %.2f\n", (double)kq_mean_f32(&level, 0), (double)kq_sigma_f32(&level, 0));
    return status != KQ_OK;
}
