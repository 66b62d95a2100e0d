/* Names with the size, the arithmetic or both in them; N and M are the size being compiled, T is
   f32, f64 or q31. */
#ifndef KALMANQ_COST_NAMES_H
#define KALMANQ_COST_NAMES_H

#define JOIN2(a, b) a##_##b
#define JOIN3(a, b, c) a##_##b##_##c
#define WITH_TYPE(name, type) JOIN2(name, type)
#define WITH_SIZE(name, n, m) JOIN3(name, n, m)

#define TYPED(name) WITH_TYPE(name, T)    /* kq_predict: kq_predict_f32 */
#define SIZED(name) WITH_SIZE(name, N, M) /* A: A_4_2 */

/* What a user calls: the library, or functions of his own that are compiled for one size. */
#ifdef KQ_COST_FIXED
#define CALLED(name) SIZED(user_##name)
#else
#define CALLED(name) TYPED(kq_##name)
#endif

/* Known sizes among the modules are the steady-state filter's alone. */
#ifdef KQ_COST_MODULES
#define FILTER_CALLED(name) TYPED(kq_##name)
#else
#define FILTER_CALLED(name) CALLED(name)
#endif

/* A macro whose arguments are themselves macros */
#define EXPANDED(macro, ...) macro(__VA_ARGS__)

#endif
