/* The charge of a cell, from its voltage while a known current flows. */
#include "battery.h"
#include "board.h"

int main(void)
{
    static battery_device f;
    kq_status status = battery_start(&f);
    for (int t = 0; t < ROWS && !status; t++) {
        if (t > 0) status = battery_predict(&f, recording[t - 1].u);
        if (!status) status = battery_update(&f, recording[t].z, recording[t].u);
        show(battery_mean_charge(&f));
        show(battery_mean_polarisation(&f));
        show_end();
    }
    return ended(status || f.events != 0);
}
