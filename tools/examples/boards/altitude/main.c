/* 50 times a second the accelerometer moves the estimate; 10 times a second the barometer corrects it. */
#include "altitude.h"
#include "board.h"

int main(void)
{
    static altitude_filter f;
    altitude_start(&f);
    for (int t = 0; t < ROWS; t++) {
        if (t > 0) altitude_predict(&f, recording[t - 1].u);
        if (recording[t].present) altitude_update(&f, recording[t].z); /* refuses what is 4 sigma off */
        show(altitude_mean_altitude(&f));
        show(altitude_mean_climb(&f));
        show(altitude_mean_offset(&f));
        show_end();
    }
    return ended((f.events & ~ALTITUDE_GATED) != 0);
}
