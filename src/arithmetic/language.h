/* The library's files are C: a compiler of C++ says so, and nothing else. */
#ifndef KQ_SRC_ARITHMETIC_LANGUAGE_H
#define KQ_SRC_ARITHMETIC_LANGUAGE_H

#ifdef __cplusplus
#include <kalmanq/compile_this_file_as_C> /* does not exist: compilation stops here */
#endif

#endif
