/* The wheel's speed 50 times a second; a GPS position that was measured LATE rows ago is taken where it belongs. */
#include "gps.h"
#include "board.h"

enum { WHEEL = 1, GPS = 2, LATE = 15 };

int main(void)
{
    kq_status status = gps_init();
    for (int t = 0; t < ROWS && !status; t++) {
        if (t > 0) status = gps_predict();
        if (!status && recording[t].present & WHEEL) status = gps_update_wheel(recording[t].z, 1);
        if (!status && recording[t].present & GPS) status = gps_update_gps(recording[t].z + 1, 1, LATE);
        for (int i = 0; i < GPS_STATES; i++) show(kq_mean_f32(gps_filter(), i));
        for (int i = 0; i < GPS_STATES; i++) show(kq_sigma_f32(gps_filter(), i));
        show_end();
    }
    return ended(status);
}
