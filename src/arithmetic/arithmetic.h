/* The arithmetic that an instance has chosen (kq_*_<T>.c include theirs first); an editor that looks at a
   header by itself sees float. */
#ifndef KQ_SRC_ARITHMETIC_ARITHMETIC_H
#define KQ_SRC_ARITHMETIC_ARITHMETIC_H

#ifndef T
#include "f32.h"
#endif

#endif
