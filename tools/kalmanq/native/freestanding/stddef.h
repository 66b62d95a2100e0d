/* For the declarations that Python binds: cffi knows the types. */
#ifndef KALMANQ_NATIVE_STDDEF_H
#define KALMANQ_NATIVE_STDDEF_H
#define NULL 0
#endif
