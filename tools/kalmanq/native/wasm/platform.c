/* What is taken of a C library, of a WebAssembly module that has none; memory, memcpy and memset are those of tune/c/memory.c. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "fixed_size.h"
#include "tune.h"

void *memmove(void *to, const void *from, size_t size)
{
    unsigned char *a = to;
    const unsigned char *b = from;
    if (a < b) return memcpy(to, from, size);
    while (size--) a[size] = b[size];
    return to;
}

int memcmp(const void *a, const void *b, size_t size)
{
    const unsigned char *p = a, *q = b;
    for (; size--; p++, q++) {
        if (*p != *q) return *p < *q ? -1 : 1;
    }
    return 0;
}

/* Exact but where the result is subnormal, which is rounded once */
double ldexp(double a, int exponent)
{
    union { uint64_t bits; double value; } power;
    for (; exponent > 1023; exponent -= 1023) a *= 0x1p1023;
    for (; exponent < -968; exponent += 968) a *= 0x1p-968;
    power.bits = (uint64_t)(exponent + 1023) << 52;
    return a * power.value;
}

/* q31 has the library's own functions alone: a page is sooner there. */
int kq_calm_find_q31(kq_calm_q31 *k, const kq_filter_q31 *f, const kq_process_q31 *p, const kq_sensor_q31 *s, const int32_t *next)
{
    (void)k, (void)f, (void)p, (void)s, (void)next;
    return 0;
}

kq_kernels_q31 kq_kernels_for_q31(int n, int m, int is_upper)
{
    (void)n, (void)m, (void)is_upper;
    return (kq_kernels_q31){kq_predict_q31, kq_update_q31, 0};
}
