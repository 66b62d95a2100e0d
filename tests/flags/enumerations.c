/* Library and application are compiled with different lengths of enumerations: is what passes between
   them the same? */
#include <stdio.h>
#include <string.h>

#include "kalmanq/kalmanq.h"

int main(void)
{
    const kq_format_q31 format = {1, 0};
    const double far = 1000;
    int32_t word = 0;
    kq_range_error_q31 range_error;
    char text[64];
    memset(&range_error, 0xff, sizeof range_error);
    const kq_status status = kq_vector_prepare_q31(&word, &far, 1, &format, &range_error);
    if (status != KQ_ERR_RANGE || range_error.quantity != KQ_STATE) return 1;
    kq_range_error_text_q31(&range_error, text, sizeof text);
    printf("%s: %s\n", kq_status_text(status), text);
    return strcmp(text, "state 0 is beyond its declared range") != 0;
}
