/* The library's file, where the build of a MicroPython module finds it. */
#include "../../src/kq_filter_f32.c"
