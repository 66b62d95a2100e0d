/* Loops over states are unrolled, scratch is in registers as far as they reach. */
#define KQ_UNROLL _Pragma("GCC unroll 16")
#define KQ_APART static inline __attribute__((always_inline))

enum { KQ_UPPER = 1, KQ_BARE = 2 };
