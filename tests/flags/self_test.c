/* Prints what the self tests answer, in f32, f64 and q31; with an argument, while rounding is upward. */
#include <fenv.h>
#include <stdio.h>

#include "kalmanq/self_test.h"

int main(int count, char **arguments)
{
    (void)arguments;
    if (count > 1 && fesetround(FE_UPWARD) != 0) return 1;
    const int f32 = kq_self_test_f32(), f64 = kq_self_test_f64(), q31 = kq_self_test_q31();
    if (fesetround(FE_TONEAREST) != 0) return 1;
    printf("%d %d %d\n", f32, f64, q31);
    return 0;
}
