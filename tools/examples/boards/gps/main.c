/* The wheel's speed 50 times a second; a GPS position that was measured LATE rows ago is taken where it belongs. */
#include "gps.h"
#include "board.h"

#include <math.h>

enum { WHEEL = 1, GPS = 2, LATE = 15 };

int main(void)
{
    static gps_delayed d;
    gps_start(&d.now);
    gps_delayed_start(&d);
    for (int t = 0; t < ROWS; t++) {
        if (t > 0) gps_delayed_predict(&d);
        if (recording[t].present & WHEEL) gps_delayed_update_wheel(&d, recording[t].z);
        if (recording[t].present & GPS) gps_delayed_update_gps(&d, recording[t].z + 1, LATE);
        show(gps_mean_position(&d.now));
        show(gps_mean_speed(&d.now));
        show(sqrtf(gps_variance_position(&d.now)));
        show_end();
    }
    return ended(d.now.events != 0);
}
