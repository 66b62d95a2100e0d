/* A cart and its range finder, each feature by its own flag: linked.sh looks at what is linked. */
#include <kalmanq/kalmanq.h>

static const float A[] = {1, 0.1f, 0, 1}, G[] = {0.1f, 0, 0.1f}, H[] = {1, 0}, R[] = {0.04f};
static const float x0[] = {0, 0}, S0[] = {10, 0, 3};

KQ_PROCESS_F32(motion, 2, 0);
KQ_SENSOR_F32(ranger, 2, 1);
KQ_FILTER_F32(cart, 2);
#ifdef WITH_HISTORY
KQ_HISTORY_F32(tape, 2, 1, 8, 0);
#endif

int main(void)
{
    const float z = 1;
    kq_status status = kq_process_init_root_f32(&motion, A, NULL, G);
#ifdef WITH_CORRELATION
    if (!status) status = kq_sensor_init_f32(&ranger, H, R);
#elif defined LEAN
    if (!status) status = kq_sensor_init_lean_f32(&ranger, H, R);
#else
    if (!status) status = kq_sensor_init_diagonal_f32(&ranger, H, R);
#endif
    if (!status) status = kq_filter_init_root_f32(&cart, x0, S0);
#ifdef WITH_HISTORY
    if (!status) status = kq_history_attach_f32(&tape, &cart);
#endif
    if (!status) status = kq_step_f32(&cart, &motion, NULL, &ranger, &z);
    return status || !(kq_mean_f32(&cart, 0) > 0) || !(kq_sigma_f32(&cart, 0) < 10);
}
