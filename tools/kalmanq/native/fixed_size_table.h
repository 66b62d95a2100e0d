/* The text of fixed_size_<T>.c: SIZES lists n, PAIRS lists n and m; q31 has its own, it is more code. */
#ifndef SIZES
#define SIZES(of) of(1) of(2) of(3) of(4) of(5) of(6)
#define PAIRS(of)                                                                                  \
    of(1, 1) of(1, 2) of(2, 1) of(2, 2) of(3, 1) of(3, 2) of(3, 3) of(4, 1) of(4, 2) of(4, 3)      \
    of(5, 1) of(5, 2) of(5, 3) of(6, 1) of(6, 2) of(6, 3)
#endif

#define PREDICT(n)                                                                                 \
    static kq_status predict_##n(filter *f, const process *p, const num *u)                        \
    {                                                                                              \
        return T(kq_fixed_predict)(f, p, u, n, 0, 0);                                              \
    }                                                                                              \
    static kq_status predict_upper_##n(filter *f, const process *p, const num *u)                  \
    {                                                                                              \
        return T(kq_fixed_predict)(f, p, u, n, 0, KQ_FIXED_UPPER);                                 \
    }

#define UPDATE(n, m)                                                                               \
    static kq_status update_##n##_##m(filter *f, const sensor *s, const num *z)                    \
    {                                                                                              \
        return T(kq_fixed_update)(f, s, z, n, m, 0);                                               \
    }                                                                                              \
    static int calm_##n##_##m(const T(kq_calm) *k, filter *f, const process *p, const num *u,      \
                              const sensor *s, const num *z, num *e)                               \
    {                                                                                              \
        return calm_step(k, f, p, u, s, z, e, n, m);                                               \
    }

SIZES(PREDICT)
PAIRS(UPDATE)

T(kq_kernels) T(kq_kernels_for)(int n, int m, int is_upper)
{
    T(kq_kernels) made = {T(kq_predict), T(kq_update), T(kq_calm_any)};
#define CHOOSE_PREDICT(size)                                                                       \
    if (n == (size)) made.predict = is_upper ? predict_upper_##size : predict_##size;
#define CHOOSE_UPDATE(states, components)                                                          \
    if (n == (states) && m == (components)) {                                                      \
        made.update = update_##states##_##components;                                              \
        made.calm = calm_##states##_##components;                                                  \
    }
    SIZES(CHOOSE_PREDICT)
    PAIRS(CHOOSE_UPDATE)
    return made;
}
