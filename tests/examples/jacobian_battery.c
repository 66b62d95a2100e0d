/* The slope of the open-circuit voltage beside the curve */
#include "../../tools/examples/battery.c"
#include "jacobian.h"

static void voltage(const float *s, float *v) { *v = ocv(*s); }

int main(void)
{
    int faults = 0;
    for (int k = 4; k <= 10; k++) { /* below, the curve bends within a difference */
        const float s = (float)k / 10, slope = ocv_slope(s);
        faults += faults_of(voltage, &s, 1, &slope, 1, "slope");
    }
    puts(faults ? "FAIL" : "OK");
    return faults > 0;
}
