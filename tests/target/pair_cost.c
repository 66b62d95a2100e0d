/*
 * Instructions of one predict + one full update on the emulated core: run many of them at
 * steady operation and read the cycle counter, which counts instructions under -icount.
 * Prints, by semihosting, "n m instructions" a line.
 */
#include <kalmanq/kalmanq.h>
#include <stdio.h>

enum { REPEAT = 2000, NS_PER_TICK = 40 }; /* the board's clock: 25 MHz */

#define SYST_CSR (*(volatile uint32_t *)0xE000E010)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018)

static float A[81], H[27], Q[81], P0[81], x0[9], R[3];
static float process_memory[KQ_PROCESS_LEN(9)], sensor_memory[3];
static float filter_memory[KQ_FILTER_LEN_F32(9)];

/* m axes of position, velocity, (acceleration) at 10 Hz, dense Q */
static void make_model(int n, int m)
{
    const float dt = 0.1f;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            A[i * n + j] = j == i ? 1 : j == i + m ? dt : j == i + 2 * m ? dt * dt / 2 : 0;
            Q[i * n + j] = j == i ? 0.02f : 0.001f;
            P0[i * n + j] = j == i ? 10 : 0;
        }
    }
    for (int c = 0; c < m; c++) {
        for (int j = 0; j < n; j++) H[c * n + j] = j == c;
        R[c] = 0.5f;
    }
}

static kq_status run(kq_filter_f32 *f, const kq_process_f32 *p, const kq_sensor_f32 *s, int steps)
{
    static const float z[3] = {1, 2, 3};
    kq_status status = KQ_OK;
    for (int t = 0; t < steps && !status; t++) {
        status = kq_predict_f32(f, p, 0);
        if (!status) status = kq_update_f32(f, s, z);
    }
    return status;
}

static unsigned measure(int n, int m)
{
    kq_process_f32 p;
    kq_sensor_f32 s;
    kq_filter_f32 f;
    make_model(n, m);
    if (kq_process_assign_f32(&p, n, 0, process_memory, sizeof process_memory / 4) ||
        kq_process_init_f32(&p, A, 0, Q) || kq_sensor_assign_f32(&s, n, m, sensor_memory, 3) ||
        kq_sensor_init_diagonal_f32(&s, H, R) ||
        kq_filter_assign_f32(&f, n, filter_memory, sizeof filter_memory / 4) ||
        kq_filter_init_f32(&f, x0, P0)) {
        return 0;
    }
    if (run(&f, &p, &s, 20)) return 0;
    SYST_RVR = 0xFFFFFF;
    SYST_CVR = 0;
    SYST_CSR = 5;
    const uint32_t start = SYST_CVR;
    if (run(&f, &p, &s, REPEAT)) return 0;
    const uint32_t ticks = (start - SYST_CVR) & 0xFFFFFF;
    return (ticks * NS_PER_TICK + REPEAT / 2) / REPEAT;
}

int main(void)
{
    static const int sizes[][2] = {{1, 1}, {2, 1}, {3, 1}, {4, 2}, {6, 3}, {9, 3}};
    for (unsigned k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        printf("%d %d %u\n", sizes[k][0], sizes[k][1], measure(sizes[k][0], sizes[k][1]));
    }
    return 0;
}
