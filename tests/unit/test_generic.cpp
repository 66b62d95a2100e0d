/* The overloads of C++ */
#include "test_generic.c"
