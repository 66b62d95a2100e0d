/* A and H of the attitude's error beside what an error does to it */
#include "../../tools/examples/attitude.c"
#include "jacobian.h"

static const float gyro[] = {1.5f, -2.5f, 2}, start_bias[] = {0.02f, -0.01f, 0.03f};
static const attitude from = {{0.8f, 0.2f, -0.4f, 0.4f}, {0.02f, -0.01f, 0.03f}};

/* The rotation that leads from a to b */
static void difference(const float a[4], const float b[4], float v[3])
{
    v[0] = 2 * (a[0] * b[1] - a[1] * b[0] - a[2] * b[3] + a[3] * b[2]);
    v[1] = 2 * (a[0] * b[2] - a[2] * b[0] - a[3] * b[1] + a[1] * b[3]);
    v[2] = 2 * (a[0] * b[3] - a[3] * b[0] - a[1] * b[2] + a[2] * b[1]);
}

static void move(attitude *a)
{
    float angle[3];
    for (int i = 0; i < 3; i++) angle[i] = (gyro[i] - a->bias[i]) * seconds;
    turn(a->quaternion, angle);
}

/* The error after 10 ms, of that before */
static void moved_error(const float *e, float *to)
{
    attitude nominal = from, real = corrected(from, e);
    move(&nominal);
    move(&real);
    difference(nominal.quaternion, real.quaternion, to);
    for (int i = 0; i < 3; i++) to[3 + i] = real.bias[i] - nominal.bias[i];
}

/* What the sensors show of an attitude with that error */
static void shown(const float *e, float *z)
{
    const attitude real = corrected(from, e);
    to_body(real.quaternion, up_of_world, z);
    to_body(real.quaternion, field_of_world, z + 3);
}

int main(void)
{
    float rate[3], z[M], e[M];
    int faults = 0;
    for (int i = 0; i < 3; i++) rate[i] = gyro[i] - start_bias[i];
    write_transition(rate);
    faults += faults_of(moved_error, zero, N, A, N, "A");
    now = from;
    shown(zero, z);
    compare(up_of_world, z, e, H);
    compare(field_of_world, z + 3, e + 3, H + 3 * N);
    faults += faults_of(shown, zero, N, H, M, "H");
    for (int i = 0; i < M; i++) faults += fabsf(e[i]) > 1e-6f;
    puts(faults ? "FAIL" : "OK");
    return faults > 0;
}
