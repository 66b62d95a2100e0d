/* For the declarations that Python binds. */
#ifndef KALMANQ_NATIVE_LIMITS_H
#define KALMANQ_NATIVE_LIMITS_H
#define INT_MAX 2147483647
#endif
