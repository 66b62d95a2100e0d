/* Rows of numbers as text */
#ifndef KALMANQ_NATIVE_PRINTING_H
#define KALMANQ_NATIVE_PRINTING_H

#include <stddef.h>
#include <stdint.h>

enum { KQ_PRINTED_MOST = 26 }; /* characters of a number, with what follows it */

/* Lines of `columns` numbers with commas between them, values row after row, as printf's %.*g has them with digits[column] (1 to 17)
   significant digits; NaN: nothing.  text: rows x columns x KQ_PRINTED_MOST.  Answers its length. */
size_t kq_print_rows(size_t rows, size_t columns, const double *values, const int32_t *digits, char *text);

#endif
