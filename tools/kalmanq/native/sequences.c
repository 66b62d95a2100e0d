/* Whole sequences in one call: one text for the three arithmetics. */
#include "sequences.h"

#include <math.h>
#include <string.h>

#include "fixed_size.h"

/* mean_words, root_words: of a filter's memory, which has the mean and after it the root */

#define PLACES 8 /* roots that are kept: the longest cycle that is seen */

static int count_of(uint32_t present)
{
    int count = 0;
    for (; present; present &= present - 1) count++;
    return count;
}

#include "of_f32.h"
#define nothing_taken {.determinant = 1}
#define sum_of_scores(a, b) ((a) + (b))
/* det S, whose factors are within 1/2 .. 1 */
#define multiply(all, one) \
    do { \
        const num both = (all)->determinant * (one)->determinant; \
        const int is_low = both < 0.5f; \
        (all)->determinant = is_low ? 2 * both : both; \
        (all)->exponent += (one)->exponent - is_low; \
    } while (0)
#define SCALE_NOISE(q, weight) K(process_scale_noise)((q)->target, (q)->process, weight)
#define lost (0.0f / 0.0f)
#define is_lost(word) ((word) != (word))
#define no_number lost
#define double_of(number) ((double)(number))
#define no_score lost
#define mean_words(n) (2 * (n))
#define root_words(n) KQ_TRIANGLE(n)
#include "sequence.h"
#undef lost
#undef mean_words

#include "of_f64.h"
#define lost (0.0 / 0.0)
#define mean_words(n) (n)
#include "sequence.h"
#undef nothing_taken
#undef sum_of_scores
#undef multiply
#undef SCALE_NOISE
#undef lost
#undef is_lost
#undef no_number
#undef double_of
#undef no_score
#undef mean_words
#undef root_words

/* A mantissa that no number has: NaN on the host */
static const kq_scaled_q31 no_number = {INT32_MIN, 0};

/* Each 2^61 at most, as the core has them */
static int64_t sum_of_scores(int64_t a, int64_t b)
{
    const int64_t most = INT64_C(1) << 61;
    return a + b < most ? a + b : most;
}

/* Mantissas within 2^30 .. 2^31 */
static void multiply(kq_likelihood_q31 *all, const kq_likelihood_q31 *one)
{
    const int64_t both = (int64_t)all->determinant.mantissa * one->determinant.mantissa;
    const int shift = both >> 61 ? 31 : 30;
    all->determinant = (kq_scaled_q31){(int32_t)(both >> shift), all->determinant.exponent + one->determinant.exponent + shift};
}

#include "of_q31.h"
#define nothing_taken {.determinant = {INT32_C(1) << 30, -30}}
#define SCALE_NOISE(q, weight) K(process_scale_noise)((q)->target, (q)->process, (q)->root, weight)
#define lost KQ_NOT_A_VALUE_Q31
#define is_lost(word) ((word) == KQ_NOT_A_VALUE_Q31)
#define double_of(number) ldexp((number).mantissa, (number).exponent)
#define no_score KQ_NOT_A_SCORE_Q31
#define mean_words(n) (2 * (n))
#define root_words(n) KQ_ROOT_LEN_Q31(n)
#include "sequence.h"
