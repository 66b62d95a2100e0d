/*
 * Reads models, solves their Riccati equations and prints what comes of it, for test_steady.py.
 *
 * Read:     n m, then A, H, Q, R by rows, and so on to the end
 * Printed:  a line for each arithmetic, f64 then f32: the status, P- and K by rows, G, all to 17
 * digits
 */
#include <kalmanq/kalmanq.h>
#include <stdio.h>

enum { N = KQ_SIZE_MAX, SQUARE = N * N };

static double A[SQUARE], H[SQUARE], Q[SQUARE], R[SQUARE];

static int read_numbers(double *a, int count)
{
    for (int k = 0; k < count; k++) {
        if (scanf("%lf", &a[k]) != 1) return 0;
    }
    return 1;
}

static void print_numbers(const double *a, int count)
{
    for (int k = 0; k < count; k++) printf(" %.17g", a[k]);
}

static void solve_f64(int n, int m)
{
    static double memory[KQ_STEADY_SOLVE_LEN_F64(N, N)], P[SQUARE], K[SQUARE], G[SQUARE];
    static double process_memory[KQ_PROCESS_LEN(N)], sensor_memory[KQ_SENSOR_LEN(N)];
    const kq_steady_solution_f64 out = {P, NULL, K, G};
    kq_process_f64 p;
    kq_sensor_f64 s;
    kq_status status = kq_process_assign_f64(&p, n, 0, process_memory, KQ_PROCESS_LEN(N));
    if (!status) status = kq_process_init_f64(&p, A, NULL, Q);
    if (!status) status = kq_sensor_assign_f64(&s, n, m, sensor_memory, KQ_SENSOR_LEN(N));
    if (!status) status = kq_sensor_init_f64(&s, H, R);
    if (!status) status = kq_steady_solve_f64(&p, &s, memory, KQ_STEADY_SOLVE_LEN_F64(N, N), &out);
    printf("%d", (int)status);
    if (!status) {
        print_numbers(P, n * n);
        print_numbers(K, n * m);
        print_numbers(G, n * n);
    }
    printf("\n");
}

static void narrow(float *to, const double *from, int count)
{
    for (int k = 0; k < count; k++) to[k] = (float)from[k];
}

static void print_floats(const float *a, int count)
{
    for (int k = 0; k < count; k++) printf(" %.17g", (double)a[k]);
}

static void solve_f32(int n, int m)
{
    static float memory[KQ_STEADY_SOLVE_LEN_F32(N, N)], P[SQUARE], K[SQUARE], G[SQUARE];
    static float process_memory[KQ_PROCESS_LEN(N)], sensor_memory[KQ_SENSOR_LEN(N)];
    static float a[SQUARE], h[SQUARE], q[SQUARE], r[SQUARE];
    const kq_steady_solution_f32 out = {P, NULL, K, G};
    kq_process_f32 p;
    kq_sensor_f32 s;
    narrow(a, A, n * n);
    narrow(h, H, m * n);
    narrow(q, Q, n * n);
    narrow(r, R, m * m);
    kq_status status = kq_process_assign_f32(&p, n, 0, process_memory, KQ_PROCESS_LEN(N));
    if (!status) status = kq_process_init_f32(&p, a, NULL, q);
    if (!status) status = kq_sensor_assign_f32(&s, n, m, sensor_memory, KQ_SENSOR_LEN(N));
    if (!status) status = kq_sensor_init_f32(&s, h, r);
    if (!status) status = kq_steady_solve_f32(&p, &s, memory, KQ_STEADY_SOLVE_LEN_F32(N, N), &out);
    printf("%d", (int)status);
    if (!status) {
        print_floats(P, n * n);
        print_floats(K, n * m);
        print_floats(G, n * n);
    }
    printf("\n");
}

int main(void)
{
    int n, m;
    while (scanf("%d %d", &n, &m) == 2) {
        if (n < 1 || n > N || m < 1 || m > N) return 2;
        if (!read_numbers(A, n * n) || !read_numbers(H, m * n)) return 2;
        if (!read_numbers(Q, n * n) || !read_numbers(R, m * m)) return 2;
        solve_f64(n, m);
        solve_f32(n, m);
    }
    return 0;
}
