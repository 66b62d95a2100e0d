/* A cart and its range finder, each feature by its own flag: linked.sh looks at what is linked. */
#include <kalmanq/kalmanq.h>

static const float A[] = {1, 0.1f, 0, 1}, G[] = {0.1f, 0, 0.1f}, H[] = {1, 0}, R[] = {0.04f};
static const float x0[] = {0, 0}, S0[] = {10, 0, 3};

KQ_PROCESS_F32(motion, 2, 0);
KQ_SENSOR_F32(ranger, 2, 1);
KQ_FILTER_F32(cart, 2);

/* What is attached to the filter */
#if defined(WITH_HISTORY)
KQ_HISTORY_F32(tape, 2, 1, 8, 0);
static kq_status attach(void) { return kq_attach_f32(&cart, &tape.attached); }
#elif defined(WITH_LAG)
KQ_LAG_F32(past, 2, 1, 8);
static kq_status attach(void) { return kq_attach_f32(&cart, &past.attached); }
#elif defined(WITH_INSTANT)
KQ_INSTANT_F32(instant, 2, 1);
static kq_status attach(void) { return kq_attach_f32(&cart, &instant.attached); }
#elif defined(WITH_START)
KQ_DIFFUSE_F32(start, 2, 0);
static const float P0[] = {100, 0, 0, 9};
static kq_status attach(void) { return kq_diffuse_init_f32(&start, &cart, x0, P0, 1); }
#elif defined(WITH_ADAPTATION)
KQ_ADAPTATION_F32(tuner, 2, 1);
static const kq_adaptation_rule_f32 rule = {KQ_ADAPT_BOTH, 500, 0.125f, 0.001f, 1000, 0.001f, 1000};
static kq_status attach(void)
{
    const kq_status status = kq_adaptation_init_f32(&tuner, &motion, &ranger, &rule);
    return status ? status : kq_attach_f32(&cart, &tuner.attached);
}
#elif defined(WITH_SETTLING)
KQ_FREEZE_F32(calm, 2, 1);
static kq_status attach(void)
{
    const kq_status status = kq_freeze_init_f32(&calm, 8);
    return status ? status : kq_attach_f32(&cart, &calm.attached);
}
#else
static kq_status attach(void) { return KQ_OK; }
#endif

int main(void)
{
    const float z = 1;
    kq_status status = kq_process_init_root_f32(&motion, A, NULL, G);
#ifdef WITH_CORRELATION
    if (!status) status = kq_sensor_init_f32(&ranger, H, R);
#elif defined WITH_INNOVATIONS
    if (!status) status = kq_sensor_init_diagonal_extended_f32(&ranger, H, R);
#elif defined LEAN
    if (!status) status = kq_sensor_init_lean_f32(&ranger, H, R);
#else
    if (!status) status = kq_sensor_init_diagonal_f32(&ranger, H, R);
#endif
    if (!status) status = kq_filter_init_root_f32(&cart, x0, S0);
    if (!status) status = attach();
    if (!status) status = kq_predict_f32(&cart, &motion, NULL);
    if (!status) status = kq_update_f32(&cart, &ranger, &z);
    if (!status) status = kq_step_f32(&cart, &motion, NULL, &ranger, &z);
#ifdef WITH_ROBUST
    static kq_loss_f32 huber = {.kind = &kq_loss_huber_f32, .parameter = 1.5f};
    if (!status) status = kq_update_robust_f32(&cart, &ranger, &z, 1, &huber);
#endif
    return status || !(kq_mean_f32(&cart, 0) > 0) || !(kq_sigma_f32(&cart, 0) < 10);
}
