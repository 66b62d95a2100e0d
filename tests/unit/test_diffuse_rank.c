/* The unknown start beside exact arithmetic, in floating point. */
#include "arithmetic.h"

#define S(name) K(name)

PROCESS(process, KQ_SIZE_MAX, 0);
SENSOR(sensor, KQ_SIZE_MAX, 1);
FILTER(filter, KQ_SIZE_MAX);
START(start, KQ_SIZE_MAX, 0);

static void put_model(int n, const double *a, const double *h)
{
    static num A[KQ_SIZE_MAX * KQ_SIZE_MAX], Q[KQ_SIZE_MAX * KQ_SIZE_MAX];
    static num H[KQ_SIZE_MAX];
    static const num R[] = {1};
    for (int k = 0; k < n * n; k++) {
        A[k] = N(a[k]);
        Q[k] = k % (n + 1) ? 0 : N(0.0625);
    }
    for (int k = 0; k < n; k++) H[k] = N(h[k]);
    ASSERT_OK(K(process_assign)(&process, n, 0, process_memory, COUNT(process_memory)));
    ASSERT_OK(K(process_init)(&process, A, NULL, Q));
    ASSERT_OK(K(sensor_assign)(&sensor, n, 1, sensor_memory, COUNT(sensor_memory)));
    ASSERT_OK(K(sensor_init)(&sensor, H, R));
}

static void begin(int n)
{
    static const num x0[KQ_SIZE_MAX];
    ASSERT_OK(K(filter_assign)(&filter, n, filter_memory, COUNT(filter_memory)));
    ASSERT_OK(K(diffuse_assign)(&start, n, 0, start_memory, COUNT(start_memory)));
    ASSERT_OK(K(diffuse_init)(&start, &filter, x0, NULL, UINT32_MAX));
}

static void take(double z)
{
    const num word = N(z);
    ASSERT_OK(K(update)(&filter, &sensor, &word));
}

static int is_determined(int i) { return !isnan(K(mean)(&filter, i)); }

static void advance(void) { ASSERT_OK(K(predict)(&filter, &process, NULL)); }

#include "diffuse_patterns.h"

SUITE(diffuse_rank, NULL) { run_diffuse_patterns(); }
