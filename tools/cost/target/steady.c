/*
 * The steady-state filter's step at n, m = 4, 2 under the emulator's eye (tools/cost/steady.py):
 * the library's function and one for the size that the compiler knows, with a kinematic A, which is
 * upper triangular, and with a dense A and H.
 */
#include "library.h"

#if defined(KQ_COST_f32)
#include "kq_fixed_f32.h"
#define KQ_COST_STEADY KQ_STEADY_F32
#elif defined(KQ_COST_f64)
#include "kq_fixed_f64.h"
#define KQ_COST_STEADY KQ_STEADY_F64
#else
#include "kq_fixed_q31.h"
#define KQ_COST_STEADY KQ_STEADY_Q31
#endif
#include "steady_model.h"

EXPANDED(KQ_COST_STEADY, kinematic, 4, 2);
EXPANDED(KQ_COST_STEADY, full, 4, 2);

kq_status fixed_upper(TYPED(kq_steady) * st, const word *z)
{
    return TYPED(kq_fixed_steady_step)(st, NULL, z, 4, 2, KQ_UPPER);
}

kq_status fixed_dense(TYPED(kq_steady) * st, const word *z)
{
    return TYPED(kq_fixed_steady_step)(st, NULL, z, 4, 2, 0);
}

#ifdef KQ_COST_q31
static kq_process_q31 processes[2];
static kq_sensor_q31 sensors[2];

static int begin(void)
{
    static const kq_process_table_q31 motion[] = {
        {.states = 4, .state_format = state, .transition = A_kinematic, .noise_root = G},
        {.states = 4, .state_format = state, .transition = A_full, .noise_root = G}};
    static const kq_sensor_table_q31 radar[] = {{4, 2, 0, state, measured, H_kinematic, R},
                                                {4, 2, 0, state, measured, H_full, R}};
    int status = 0;
    for (int k = 0; k < 2 && !status; k++) {
        status = kq_process_init_q31(&processes[k], &motion[k], NULL);
        if (!status) status = kq_sensor_init_q31(&sensors[k], &radar[k], NULL);
    }
    return status;
}
#else
static TYPED(kq_process) processes[2];
static TYPED(kq_sensor) sensors[2];

static int begin(void)
{
    static word memory[2][KQ_PROCESS_LEN(4)], variances[2][2];
    static const word *const A[] = {A_kinematic, A_full}, *const H[] = {H_kinematic, H_full};
    int status = 0;
    for (int k = 0; k < 2 && !status; k++) {
        status = TYPED(kq_process_assign)(&processes[k], 4, 0, memory[k], KQ_PROCESS_LEN(4));
        if (!status) status = TYPED(kq_process_init)(&processes[k], A[k], NULL, Q);
        if (!status) status = TYPED(kq_sensor_assign)(&sensors[k], 4, 2, variances[k], 2);
        if (!status) status = TYPED(kq_sensor_init_diagonal)(&sensors[k], H[k], R);
    }
    return status;
}
#endif

int main(void)
{
    static const word x0[4];
    const unsigned ram = sizeof kinematic + sizeof kinematic_memory;
    need_ok(begin());
    need_ok(TYPED(kq_steady_init)(&kinematic, &processes[0], &sensors[0], x0, K, 1));
    need_ok(TYPED(kq_steady_init)(&full, &processes[1], &sensors[1], x0, K, 1));
    for (int t = 0; t < STEADY; t++) {
        need_ok(TYPED(kq_steady_step)(&kinematic, NULL, z));
        need_ok(TYPED(kq_steady_step)(&full, NULL, z));
    }
    cost_region(0, ram);
    need_ok(TYPED(kq_steady_step)(&kinematic, NULL, z));
    cost_region(1, ram);
    need_ok(TYPED(kq_steady_step)(&full, NULL, z));
    cost_region(2, ram);
    need_ok(fixed_upper(&kinematic, z));
    cost_region(3, ram);
    need_ok(fixed_dense(&full, z));
    cost_end();
    return 0;
}
