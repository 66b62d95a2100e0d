/* Names of q31, as of_f32.h has those of f32 */
#undef K
#undef num
#undef number
#undef score
#define K(name) kq_##name##_q31
#define num int32_t
#define number kq_scaled_q31
#define score int64_t
