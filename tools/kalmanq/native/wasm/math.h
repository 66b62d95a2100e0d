/* What the library takes of <math.h>, where there is no C library: WebAssembly has the root as an instruction. */
#ifndef KQ_NATIVE_WASM_MATH_H
#define KQ_NATIVE_WASM_MATH_H

#define NAN __builtin_nanf("")

static inline double sqrt(double a) { return __builtin_sqrt(a); }
static inline float sqrtf(float a) { return __builtin_sqrtf(a); }

double ldexp(double a, int exponent);

#endif
