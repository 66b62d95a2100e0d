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
    kq_misfit_q31 misfit;
    char text[64];
    memset(&misfit, 0xff, sizeof misfit);
    const kq_status status = kq_vector_prepare_q31(&word, &far, 1, &format, &misfit);
    if (status != KQ_ERR_RANGE || misfit.quantity != KQ_STATE) return 1;
    kq_misfit_text_q31(&misfit, text, sizeof text);
    printf("%s: %s\n", kq_status_text(status), text);
    return strcmp(text, "state 0 is beyond its declared range") != 0;
}
