/* The public functions of processes and sensors in floating point, made of matrices. */
#ifndef KQ_SRC_MODEL_API_FLOAT_H
#define KQ_SRC_MODEL_API_FLOAT_H

#include "continuous_float.h"
#include "correlated_float.h"
#include "intact.h"
#include "matrices_float.h"

KQ_COLD kq_status T(kq_process_assign)(process *p, int n, int l, num *memory, size_t length)
{
    if (!p || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || l < 0 || l > KQ_SIZE_MAX) return KQ_ERR_SIZE;
    if (length < (size_t)KQ_PROCESS_LEN(n)) return KQ_ERR_MEMORY;
    *p = (process){.states = (uint8_t)n,
                   .controls = (uint8_t)l,
                   .length = (uint16_t)(length < UINT16_MAX ? length : UINT16_MAX),
                   .memory = memory};
    return KQ_OK;
}

KQ_COLD kq_status T(kq_process_init)(process *p, const num *A, const num *B, const num *Q)
{
    kq_status status = process_check_model(p, A, B);
    if (status) return status;
    if (!Q) return KQ_ERR_NULL;
    status = state_covariance_check(Q, p->states);
    if (!status) status = root_or_refuse(p->memory, Q, p->states);
    if (!status) process_set_model(p, A, B);
    return status;
}

KQ_COLD kq_status T(kq_process_init_factor)(process *p, const num *A, const num *B, const num *F,
                                            int r)
{
    num W[KQ_SIZE_MAX * KQ_SIZE_MAX];
    kq_status status = process_check_model(p, A, B);
    if (status) return status;
    if (r < 0 || r > KQ_SIZE_MAX) return KQ_ERR_SIZE;
    if (r && !F) return KQ_ERR_NULL;
    if (r) status = factor_check(F, p->states, r);
    if (status) return status;
    if (r) copy(W, F, p->states * r);
    root_of_factor(p->memory, W, p->states, r);
    process_set_model(p, A, B);
    return KQ_OK;
}

KQ_COLD kq_status T(kq_process_init_root)(process *p, const num *A, const num *B, const num *G)
{
    kq_status status = process_check_model(p, A, B);
    if (status) return status;
    if (!G) return KQ_ERR_NULL;
    status = root_check(G, p->states);
    if (status) return status;
    copy(p->memory, G, KQ_TRIANGLE(p->states));
    process_set_model(p, A, B);
    return KQ_OK;
}

KQ_COLD kq_status T(kq_process_change_transition)(process *p, const num *A)
{
    const kq_status status = process_check(p);
    if (status) return status;
    if (!A) return KQ_ERR_NULL;
    if (!all_finite(A, p->states * p->states)) return KQ_ERR_NOT_FINITE;
    process_set_transition(p, A);
    return KQ_OK;
}

KQ_COLD kq_status T(kq_sensor_assign)(sensor *s, int n, int m, num *memory, size_t length)
{
    if (!s || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || !size_is_valid(m)) return KQ_ERR_SIZE;
    if (length < KQ_SENSOR_DIAGONAL_LEN((size_t)m)) return KQ_ERR_MEMORY;
    const size_t most = KQ_SENSOR_LEN((size_t)m);
    *s = (sensor){.states = (uint8_t)n,
                  .components = (uint8_t)m,
                  .length = (uint8_t)(length < most ? length : most),
                  .memory = memory};
    return KQ_OK;
}

KQ_COLD kq_status T(kq_sensor_init)(sensor *s, const num *H, const num *R)
{
    const int m = s ? s->components : 0;
    kq_status status = sensor_check_model(s, H, R, KQ_SENSOR_LEN(m));
    if (status) return status;
    status = covariance_check(R, m);
    if (status) return status;
    if (is_diagonal(R, m)) {
        sensor_set_diagonal(s, &T(kq_sensor_independent), H, R, m + 1);
        return KQ_OK;
    }
    status = root_or_refuse(s->memory, R, m);
    if (status) return status;
    decorrelate(s->memory, m);
    sensor_set_correlated(s, H, R);
    return KQ_OK;
}

kq_status T(kq_sensor_init_diagonal)(sensor *s, const num *H, const num *r)
{
    return sensor_init_diagonal(s, &T(kq_sensor_independent), H, r);
}

kq_status T(kq_sensor_init_lean)(sensor *s, const num *H, const num *r)
{
    return sensor_init_diagonal(s, &T(kq_sensor_lean), H, r);
}

KQ_COLD kq_status T(kq_sensor_change_measurement)(sensor *s, const num *H)
{
    const kq_status status = sensor_check(s);
    if (status) return status;
    if (!H) return KQ_ERR_NULL;
    if (!all_finite(H, s->components * s->states)) return KQ_ERR_NOT_FINITE;
    sensor_set_measurement(s, H);
    return KQ_OK;
}

#endif
