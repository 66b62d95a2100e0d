/* The speed of a wheel.  A row without a signal is a predict without an update. */
#include "wheel.h"
#include "board.h"

int main(void)
{
    static wheel_filter f;
    wheel_start(&f);
    for (int t = 0; t < ROWS; t++) {
        if (t == 0) wheel_update(&f, recording[t].z);
        else if (recording[t].present) wheel_step(&f, recording[t].z);
        else wheel_predict(&f);
        show(wheel_mean_speed(&f));
        show(wheel_mean_acceleration(&f));
        show_end();
    }
    return ended(f.events != 0);
}
