/* H of the target, and its wrapped innovation, beside range and bearing */
#include "../../tools/examples/range_bearing.c"
#include "jacobian.h"

static void expected(const float *x, float *y)
{
    float z[] = {0, 3}; /* a bearing on the other side of -pi .. pi */
    innovation(z, x, y);
    for (int j = 0; j < M; j++) y[j] = z[j] - y[j];
}

int main(void)
{
    const float beside[] = {-3, -0.001f, 0.5f, 1}, ahead[] = {1.5f, 2, 0, 0};
    int faults = 0;
    write_jacobian(beside);
    faults += faults_of(expected, beside, N, H, M, "H beside");
    write_jacobian(ahead);
    faults += faults_of(expected, ahead, N, H, M, "H ahead");
    puts(faults ? "FAIL" : "OK");
    return faults > 0;
}
