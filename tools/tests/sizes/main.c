/* The filter of track.c, a few rows: it has to be where it was measured. */
#include "track.h"

int main(void)
{
    static const float first[TRACK_MEASUREMENTS] = {10, 20};
    if (track_init() || track_update(first, TRACK_ALL)) return 1;
    for (int t = 1; t < 20; t++) {
        const float z[TRACK_MEASUREMENTS] = {10 + (float)t, 20};
        if (track_step(z, TRACK_ALL)) return 2;
    }
    const float x = kq_mean_f32(track_filter(), TRACK_X), vx = kq_mean_f32(track_filter(), TRACK_VX);
    return x > 28 && x < 30 && vx > 0.8f && vx < 1.2f ? 0 : 3;
}
