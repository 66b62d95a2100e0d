/* A of the vehicle beside its increment */
#include "../../tools/examples/gps_imu.c"
#include "jacobian.h"

static void moved(const float *x, float *y)
{
    imu reading = {0.3f, -0.2f};
    increment(&reading, x, y);
    for (int i = 0; i < N; i++) y[i] += x[i];
}

int main(void)
{
    const float x[] = {2, -3, 5, 0.7f, 0.1f, -0.05f};
    write_jacobian(x);
    const int faults = faults_of(moved, x, N, A, N, "A");
    puts(faults ? "FAIL" : "OK");
    return faults > 0;
}
