/* What the page of `kalmanq tune` calls: no C library is there. */
#include "tune.h"

#include <math.h>
#include <string.h>

static kq_tune request;

kq_tune *tune_request(void) { return &request; }

static kq_status refused(kq_tune *of, tune_part part, kq_status status)
{
    if (!of->part) of->part = (int32_t)part; /* the first says it */
    return status;
}

static int is_correlated(const kq_tune *of)
{
    for (int i = 0; i < of->m; i++) {
        for (int j = 0; j < of->m; j++) {
            if (i != j && of->R[i * of->m + j] != 0) return 1;
        }
    }
    return 0;
}

/* Has no A anything below its diagonal? */
static int are_upper(const kq_tune *of)
{
    const int n = of->n;
    for (int k = 0; k < of->processes * n * n; k++) {
        if (k % n < k / n % n && of->A[k] != 0) return 0;
    }
    return 1;
}

#include "of_f32.h"
#define has_low_words 1
#include "tune_types.h"
#include "tune_float.h"
#include "tune_late.h"
#include "tune_run.h"
#undef has_low_words
#undef has_exact_variance

#include "of_f64.h"
#define has_low_words 0
#include "tune_types.h"
#include "tune_float.h"
#include "tune_late.h"
#include "tune_run.h"
#undef has_low_words
#undef has_exact_variance

#include "of_q31.h"
#define has_low_words 1
#define has_exact_variance 1
#include "tune_types.h"
#include "tune_fixed.h"
#include "tune_late.h"
#include "tune_run.h"

double tune_limit(int m, int level) { return kq_chi_square_limit_f64(m, (kq_level)level); }

kq_status tune_run(void)
{
    void *mark = tune_mark();
    request.part = TUNE_NOTHING;
    request.row = request.component = -1;
    request.events = request.bits = 0;
    const kq_status status = request.arithmetic == TUNE_F32   ? kq_tune_f32(&request)
                             : request.arithmetic == TUNE_F64 ? kq_tune_f64(&request)
                                                              : kq_tune_q31(&request);
    tune_release(mark);
    return status;
}
