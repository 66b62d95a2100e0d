/* For the declarations that Python binds: cffi knows the types. */
#ifndef KALMANQ_NATIVE_STDINT_H
#define KALMANQ_NATIVE_STDINT_H
#define INT32_MAX 2147483647
#define SIZE_MAX 18446744073709551615U
#define UINT64_MAX 18446744073709551615U
#endif
