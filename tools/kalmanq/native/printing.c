#include "printing.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define FAST 9 /* digits that a double's product with a power of ten determines, but next to a half */
static const double TENS[] = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13};

static char *whole(char *to, uint64_t value)
{
    char made[20];
    int count = 0;
    do made[count++] = (char)('0' + value % 10);
    while (value /= 10);
    while (count) *to++ = made[--count];
    return to;
}

/* `digits` digits of value, of which the first `before` stand before the point; less than 1: so many zeros come first.  Without
   zeros at the end */
static char *fixed(char *to, uint64_t value, int digits, int before)
{
    char made[FAST];
    for (int k = digits; k-- > 0; value /= 10) made[k] = (char)('0' + value % 10);
    while (digits > 1 && digits > before && made[digits - 1] == '0') digits--;
    if (before < 1) {
        *to++ = '0';
        *to++ = '.';
        for (int k = before; k < 0; k++) *to++ = '0';
    }
    for (int k = 0; k < digits; k++) {
        if (k > 0 && k == before) *to++ = '.';
        *to++ = made[k];
    }
    return to;
}

/* NULL: it is for printf */
static char *quickly(char *to, double value, int digits)
{
    const double size = fabs(value);
    if (size < (digits < 15 ? TENS[digits < FAST ? digits : FAST] : 1e15) && size == floor(size) && !(value == 0 && signbit(value))) {
        if (value < 0) *to++ = '-';
        return whole(to, (uint64_t)size);
    }
    if (digits > FAST || !(size >= 1e-4 && size < TENS[digits] - 1)) return NULL;
    int before = 1; /* digits before the point, as value would have them */
    while (before < digits && size >= TENS[before]) before++;
    while (size < 1 && before > -3 && size * TENS[1 - before] < 1) before--;
    const double scaled = size * TENS[digits - before], rest = scaled - floor(scaled);
    if (fabs(rest - 0.5) < 1e-5) return NULL; /* printf says to which side */
    uint64_t rounded = (uint64_t)floor(scaled) + (rest > 0.5);
    if ((double)rounded >= TENS[digits]) {
        rounded /= 10;
        before++;
    }
    if ((double)rounded < TENS[digits - 1]) return NULL;
    if (value < 0) *to++ = '-';
    return fixed(to, rounded, digits, before);
}

size_t kq_print_rows(size_t rows, size_t columns, const double *values, const int32_t *digits, char *text)
{
    char *to = text;
    for (size_t k = 0; k < rows * columns; k++) {
        const size_t column = k % columns;
        char *end = isnan(values[k]) ? to : quickly(to, values[k], digits[column]);
        to = end ? end : to + snprintf(to, KQ_PRINTED_MOST, "%.*g", (int)digits[column], values[k]);
        *to++ = column + 1 < columns ? ',' : '\n';
    }
    return (size_t)(to - text);
}
