/* The gyro turns the attitude 100 times a second; accelerometer and magnetometer correct it 10 times a second. */
#include "attitude.h"
#include "board.h"

int main(void)
{
    static attitude_filter f;
    attitude_start(&f);
    for (int t = 0; t < ROWS; t++) {
        if (t > 0) attitude_predict(&f, recording[t - 1].u);
        if (recording[t].present) {
            attitude_update_accelerometer(&f, recording[t].z);
            attitude_update_magnetometer(&f, recording[t].z + 3);
        }
        show(attitude_mean_q_w(&f));
        show(attitude_mean_q_x(&f));
        show(attitude_mean_q_y(&f));
        show(attitude_mean_q_z(&f));
        show_end();
    }
    return ended(f.events != 0);
}
