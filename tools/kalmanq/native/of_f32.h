/* Names of f32 for a text of all arithmetics: number has any size, score is of a NIS or a likelihood */
#undef K
#undef num
#undef number
#undef score
#define K(name) kq_##name##_f32
#define num float
#define number float
#define score float
