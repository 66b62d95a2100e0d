/* The functions for compile-time sizes, as tables: one row for every n and m of the tests. */
#ifndef KALMANQ_TESTS_FIXED_H
#define KALMANQ_TESTS_FIXED_H

/* FIXED_SIZES(T, num, options, suffix): three functions for each of the sizes, one control */
#define FIXED_SIZE(T, num, n, m, options, suffix)                                                  \
    static kq_status predict_##n##_##m##_##suffix(kq_filter_##T *f, const kq_process_##T *p,       \
                                                  const num *u)                                    \
    {                                                                                              \
        return kq_fixed_predict_##T(f, p, u, n, 1, options);                                          \
    }                                                                                              \
    static kq_status update_##n##_##m##_##suffix(kq_filter_##T *f, const kq_sensor_##T *s,         \
                                                 const num *z)                                     \
    {                                                                                              \
        return kq_fixed_update_##T(f, s, z, n, m, options);                                        \
    }                                                                                              \
    static kq_status step_##n##_##m##_##suffix(kq_filter_##T *f, const kq_process_##T *p,          \
                                               const num *u, const kq_sensor_##T *s, const num *z) \
    {                                                                                              \
        return kq_fixed_step_##T(f, p, u, s, z, n, m, 1, options);                                    \
    }

#define FIXED_SIZES(T, num, options, suffix)                                                       \
    FIXED_SIZE(T, num, 1, 1, options, suffix)                                                      \
    FIXED_SIZE(T, num, 2, 1, options, suffix)                                                      \
    FIXED_SIZE(T, num, 3, 2, options, suffix)                                                      \
    FIXED_SIZE(T, num, 4, 2, options, suffix)

/* The steady-state filter's step, with a dense and with an upper triangular A */
#define FIXED_STEADY(T, num, n, m)                                                                 \
    static kq_status steady_##n##_##m##_dense(kq_steady_##T *st, const num *u, const num *z)       \
    {                                                                                              \
        return kq_fixed_steady_step_##T(st, u, z, n, m, 1, 0);                                        \
    }                                                                                              \
    static kq_status steady_##n##_##m##_upper(kq_steady_##T *st, const num *u, const num *z)       \
    {                                                                                              \
        return kq_fixed_steady_step_##T(st, u, z, n, m, 1, KQ_FIXED_UPPER);                                 \
    }

#define FIXED_ROW(n, m, suffix)                                                                    \
    {                                                                                              \
        n, m, predict_##n##_##m##_##suffix, update_##n##_##m##_##suffix, step_##n##_##m##_##suffix \
    }
#define FIXED_ROWS(suffix)                                                                         \
    FIXED_ROW(1, 1, suffix), FIXED_ROW(2, 1, suffix), FIXED_ROW(3, 2, suffix),                     \
        FIXED_ROW(4, 2, suffix)

#endif
