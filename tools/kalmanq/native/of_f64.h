/* Names of f64, as of_f32.h has those of f32 */
#undef K
#undef num
#undef number
#undef score
#define K(name) kq_##name##_f64
#define num double
#define number double
#define score double
