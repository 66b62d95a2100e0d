/* A flight is filtered row by row.  On the ground the tape is smoothed: every row given the whole flight. */
#include "rocket.h"
#include "board.h"

KQ_HISTORY_F32(tape, ROCKET_STATES, ROCKET_MEASUREMENTS, ROWS, 0);

static void show_states(const kq_filter_f32 *f)
{
    for (int i = 0; i < ROCKET_STATES; i++) show(kq_mean_f32(f, i));
    for (int i = 0; i < ROCKET_STATES; i++) show(kq_sigma_f32(f, i));
    show_end();
}

static kq_status fly(void)
{
    kq_status status = rocket_init();
    if (!status) status = kq_attach_f32(rocket_filter(), &tape.attached);
    if (!status) status = rocket_update(recording[0].z, ROCKET_ALL);
    for (int t = 1; t < ROWS && !status; t++) status = rocket_step(recording[t].z, ROCKET_ALL);
    return status;
}

int main(void)
{
    kq_status status = fly();
    if (!status) status = kq_smooth_f32(&tape);
    for (size_t t = 0; t < ROWS && !status; t++) {
        kq_filter_f32 then;
        status = kq_smoothed_f32(&tape, t, &then);
        if (!status) show_states(&then);
    }
    return ended(status);
}
