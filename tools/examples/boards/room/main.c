/* The temperature of a room in the last days, and then for a day from now. */
#include "room.h"
#include "board.h"

enum { DAY = 96 }; /* rows */

static void show_states(const room_filter *f)
{
    show(room_mean_level(f)); /* the temperature is the level, the day and the half day together */
    show(room_mean_slope(f));
    show(room_mean_day(f));
    show(room_mean_day_turned(f));
    show(room_mean_half_day(f));
    show(room_mean_half_day_turned(f));
    show_end();
}

int main(void)
{
    static room_filter f, later;
    room_start(&f);
    for (int t = 0; t < ROWS - DAY; t++) {
        if (t == 0) room_update(&f, recording[t].z);
        else room_step(&f, recording[t].z);
        show_states(&f);
    }
    later = f; /* a copy looks ahead; the filter itself goes on with the next sample */
    for (int t = 0; t < DAY; t++) {
        room_predict(&later);
        show_states(&later);
    }
    return ended(f.events || later.events);
}
