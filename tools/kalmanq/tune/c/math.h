/* <math.h> of a compiled model in WebAssembly: what has an instruction there is that; the page has the rest (equations.js). */
#ifndef KQ_TUNE_MATH_H
#define KQ_TUNE_MATH_H

#define NAN __builtin_nanf("")

static inline double sqrt(double a) { return __builtin_sqrt(a); }
static inline float sqrtf(float a) { return __builtin_sqrtf(a); }
static inline double fabs(double a) { return __builtin_fabs(a); }
static inline float fabsf(float a) { return __builtin_fabsf(a); }
static inline double floor(double a) { return __builtin_floor(a); }
static inline float floorf(float a) { return __builtin_floorf(a); }
static inline double rint(double a) { return __builtin_rint(a); }
static inline float rintf(float a) { return __builtin_rintf(a); }

double sin(double a), cos(double a), tan(double a), asin(double a), acos(double a), atan(double a);
double sinh(double a), cosh(double a), tanh(double a), asinh(double a), acosh(double a), atanh(double a);
double exp(double a), expm1(double a), log(double a), log1p(double a), cbrt(double a);
double atan2(double a, double b), pow(double a, double b), fmod(double a, double b);
float sinf(float a), cosf(float a), tanf(float a), asinf(float a), acosf(float a), atanf(float a);
float sinhf(float a), coshf(float a), tanhf(float a), asinhf(float a), acoshf(float a), atanhf(float a);
float expf(float a), expm1f(float a), logf(float a), log1pf(float a), cbrtf(float a);
float atan2f(float a, float b), powf(float a, float b), fmodf(float a, float b);

#endif
