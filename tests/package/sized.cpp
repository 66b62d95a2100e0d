// sized.hpp: a model with all of its calls, and with KQ_PLAIN the same by the objects and names of generic.h.  With
// KQ_WRONG=1 .. 13 one size is wrong, and it must not compile.
#include <kalmanq/kalmanq.h>
#include <kalmanq/sized.hpp>

namespace {
const float A[] = {1, 0.5f, 0, 1}, B[] = {0.125f, 0.5f}, Q[] = {0.1f, 0, 0, 0.2f};
const float H[] = {1, 0}, H2[] = {1, 0, 0.5f, 1}, R[] = {1}, r2[] = {1, 2}, x0[] = {0, 0}, P0[] = {4, 0, 0, 4};
#ifdef KQ_PLAIN
KQ_PROCESS_F32(motion, 2, 0);
KQ_PROCESS_F32(driven, 2, 1);
KQ_SENSOR_F32(ranger, 2, 1);
KQ_SENSOR_F32(both, 2, 2);
KQ_FILTER_F32(cart, 2);
#else
kalmanq::Process<float, 2> motion;
kalmanq::Process<float, 2, 1> driven;
kalmanq::Sensor<float, 2, 1> ranger;
kalmanq::Sensor<float, 2, 2> both;
kalmanq::Filter<float, 2> cart;
#endif
}

extern "C" kq_status start()
{
#ifdef KQ_PLAIN
    kq_status status = kq_process_init(&motion, A, nullptr, Q);
    if (!status) status = kq_process_init(&driven, A, B, Q);
    if (!status) status = kq_sensor_init(&ranger, H, R);
    if (!status) status = kq_sensor_init_lean_f32(&both, H2, r2);
    if (!status) status = kq_filter_init(&cart, x0, P0);
#else
    kq_status status = motion.init(A, Q);
    if (!status) status = driven.init(A, B, Q);
    if (!status) status = ranger.init(H, R);
    if (!status) status = both.init_lean(H2, r2);
    if (!status) status = cart.init(x0, P0);
#endif
    return status;
}

extern "C" kq_status run(const float (&z)[1], const float (&z2)[2], const float (&u)[1], float (&e)[2], float (&P)[4])
{
#ifdef KQ_PLAIN
    kq_status status = kq_step(&cart, &motion, nullptr, &ranger, z);
    if (!status) status = kq_step(&cart, &driven, u, &both, z2);
    if (!status) status = kq_predict(&cart, &motion, nullptr);
    if (!status) status = kq_innovation(&cart, &both, z2, e);
    if (!status) status = kq_update(&cart, &ranger, z);
    if (!status) status = kq_predict(&cart, &driven, u);
    if (!status) status = kq_update_subset(&cart, &both, z2, 2);
    if (!status) status = kq_update(&cart, &ranger, &z2[1]);
    if (!status) status = kq_step(&cart, &motion, nullptr, &ranger, &z2[1]);
    if (!status) status = kq_step(&cart, &driven, u, &ranger, &z2[1]);
    if (!status) status = kq_covariance(&cart, P);
#else
    kq_status status = cart.step(motion, ranger, z);
    if (!status) status = cart.step(driven, u, both, z2);
    if (!status) status = cart.predict(motion);
    if (!status) status = cart.innovation(both, z2, e);
    if (!status) status = cart.update(ranger, z);
    if (!status) status = cart.predict(driven, u);
    if (!status) status = cart.update_subset(both, z2, 2);
    if (!status) status = cart.update(ranger, &z2[1]);
    if (!status) status = cart.step(motion, ranger, &z2[1]);
    if (!status) status = cart.step(driven, u, ranger, &z2[1]);
    if (!status) status = cart.covariance(P);
#endif
    return status;
}

#ifdef KQ_WRONG
kq_status wrong(kalmanq::Filter<double, 2> &other)
{
    static const float three[] = {1, 2, 3}, one[] = {1};
    static const double one64[] = {1};
    (void)three, (void)one, (void)one64, (void)other;
#if KQ_WRONG == 1
    return cart.update(ranger, three);
#elif KQ_WRONG == 2
    return cart.step(driven, ranger, one); // the control is missing
#elif KQ_WRONG == 3
    return cart.predict(motion, one); // there is none
#elif KQ_WRONG == 4
    return motion.init(A, B, Q);
#elif KQ_WRONG == 5
    return ranger.init(three, R);
#elif KQ_WRONG == 6
    return other.update(ranger, one64); // another arithmetic
#elif KQ_WRONG == 7
    static kalmanq::Sensor<float, 3, 1> of_three_states;
    return cart.update(of_three_states, one);
#elif KQ_WRONG == 8
    return motion.init({1, 0, 0, 1}, Q); // A is kept: a temporary array would be gone
#elif KQ_WRONG == 9
    return ranger.init({1, 0}, R);
#elif KQ_WRONG == 10
    return cart.update(both, &three[1]); // two components
#elif KQ_WRONG == 11
    return cart.update(ranger, &one64[0]);
#elif KQ_WRONG == 12
    return cart.step(motion, ranger, three);
#else
    static kalmanq::Filter<float, 17> large;
    return kq_predict(&large, &motion, nullptr);
#endif
}
#endif

#ifndef KQ_PART
#include <string.h>

int main()
{
    const float z[] = {1}, z2[] = {1.5f, 0.25f}, u[] = {0.5f};
    float e[2], P[4];
    for (int k = 0; k < 20; k++)
        if (start() || run(z, z2, u, e, P) || kq_mean(&cart, 0) <= 0 || kq_events(&cart)) return 1;
    // against the same by C's own objects
    KQ_PROCESS_F32(of_c, 2, 0);
    KQ_SENSOR_F32(sensor_of_c, 2, 1);
    KQ_FILTER_F32(filter_of_c, 2);
    if (kq_process_init(&of_c, A, nullptr, Q) || kq_sensor_init(&sensor_of_c, H, R) || kq_filter_init(&filter_of_c, x0, P0)) return 2;
    if (start() || kq_step(&cart, &motion, nullptr, &ranger, z) || kq_step(&filter_of_c, &of_c, nullptr, &sensor_of_c, z)) return 3;
    float P_of_c[4];
    if (kq_covariance(&cart, P) || kq_covariance(&filter_of_c, P_of_c)) return 4;
    return kq_mean(&cart, 1) == kq_mean(&filter_of_c, 1) && !memcmp(P, P_of_c, sizeof P) ? 0 : 5;
}
#endif
