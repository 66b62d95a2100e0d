/* One text for the two arithmetics of floating point. */
#include "varying.h"

#define FLOATING(T, num)                                                                                               \
    kq_status kq_processes_init_##T(size_t count, kq_process_##T *processes, int n, int l, num *memory, const num *A,  \
                                    const num *B, const num *Q, const num *F, int r, size_t *done)                     \
    {                                                                                                                  \
        const size_t square = (size_t)n * (size_t)n, length = KQ_PROCESS_LEN((size_t)n);                               \
        for (*done = 0; *done < count; ++*done) {                                                                      \
            const size_t k = *done;                                                                                    \
            const num *b = B ? B + k * (size_t)n * (size_t)l : NULL;                                                   \
            kq_process_##T *p = processes + k;                                                                         \
            kq_status status = kq_process_assign_##T(p, n, l, memory + k * length, length);                            \
            if (status) return status;                                                                                 \
            status = Q ? kq_process_init_##T(p, A + k * square, b, Q + k * square)                                     \
                       : kq_process_init_factor_##T(p, A + k * square, b, F + k * (size_t)n * (size_t)r, r);           \
            if (status) return status;                                                                                 \
        }                                                                                                              \
        return KQ_OK;                                                                                                  \
    }                                                                                                                  \
    kq_status kq_sensors_init_##T(size_t count, kq_sensor_##T *sensors, int n, int m, num *memory, const num *H,       \
                                  const num *R, const num *r, size_t *done)                                            \
    {                                                                                                                  \
        const size_t size = (size_t)m, length = KQ_SENSOR_LEN(size);                                                   \
        for (*done = 0; *done < count; ++*done) {                                                                      \
            const size_t k = *done;                                                                                    \
            const num *h = H + k * size * (size_t)n;                                                                   \
            kq_status status = kq_sensor_assign_##T(sensors + k, n, m, memory + k * length, length);                   \
            if (status) return status;                                                                                 \
            status = R ? kq_sensor_init_##T(sensors + k, h, R + k * size * size)                                       \
                       : kq_sensor_init_diagonal_##T(sensors + k, h, r + k * size);                                    \
            if (status) return status;                                                                                 \
        }                                                                                                              \
        return KQ_OK;                                                                                                  \
    }

FLOATING(f32, float)
FLOATING(f64, double)
