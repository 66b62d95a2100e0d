/* The chi-square gate. */
#ifndef KQ_SRC_ROBUST_GATE_H
#define KQ_SRC_ROBUST_GATE_H

#include "losses.h"

/* The update that has been checked, with the careful path also where the sensor is a lean one: it is
   never refused. */
KQ_NOINLINE static void update_reading(filter *f, const reading *z)
{
    if (sensor_is_correlated(z->sensor)) update_correlated(f, z);
    else update_independent(f, z);
}

static int is_run_over(const loss *g)
{
    const uint16_t run = g->run ? g->run : KQ_GATE_RUN;
    return run != KQ_GATE_CLOSED && g->rejected >= run;
}

/* So many in a row are no outliers: the filter is wrong, and its P with it.  P is raised if no
   history has to undo that. */
static void gate_give_in(filter *f, loss *g, const reading *z)
{
    g->rejected = 0;
    if (is_recording(f)) update_reading(f, z);
    else update_robust(f, z->sensor, z->z, z->present, &(loss){.kind = &T(kq_loss_jump), .parameter = scaled_one});
    f->events |= KQ_EVENT_REJECTIONS;
}

/* The filter as it was, but for the NIS of what was rejected */
static void reject(filter *f, loss *g, score nis)
{
    likelihood_clear(&f->last);
    f->last.nis = nis;
    f->events |= KQ_EVENT_GATED;
    if (g->rejected < UINT16_MAX) g->rejected++;
}

/* Takes the measurement and, if it should not have been, takes it back.  memory: scratch */
static void gate_with(filter *f, loss *g, const reading *z, num *memory)
{
    const filter before = *f;
    history *h = is_recording(f) ? history_of(f) : 0;
    const history tape = h ? *h : (history){.states = 0};
    copy(memory, f->memory, FILTER_LEN(f->states));
    update_reading(f, z);
    if (!(g->limit < T(kq_nis)(f))) {
        if (f->last.count) g->rejected = 0; /* what takes nothing says nothing of the run */
        return;
    }
    const score nis = T(kq_nis)(f);
    *f = before;
    copy(f->memory, memory, FILTER_LEN(f->states));
    if (h) *h = tape;
    if (is_run_over(g)) gate_give_in(f, g, z);
    else reject(f, g, nis);
}

/* The scratch lives on the stack, in a few sizes. */
KQ_NOINLINE static void gate_to_4(filter *f, loss *g, const reading *z)
{
    num memory[FILTER_LEN(4)];
    gate_with(f, g, z, memory);
}

KQ_NOINLINE static void gate_to_9(filter *f, loss *g, const reading *z)
{
    num memory[FILTER_LEN(9)];
    gate_with(f, g, z, memory);
}

KQ_NOINLINE static void gate_to_16(filter *f, loss *g, const reading *z)
{
    num memory[FILTER_LEN(16)];
    gate_with(f, g, z, memory);
}

static kq_status gate_check(const filter *f, const loss *g)
{
    (void)f;
    return g->limit > 0 ? KQ_OK : KQ_ERR_RANGE;
}

static void update_gated(filter *f, const sensor *s, const num *z, uint32_t present, loss *g)
{
    const reading now = {s, s->noise, z, present};
    if (is_none_present(s, present)) likelihood_clear(&f->last);
    else if (f->states <= 4) gate_to_4(f, g, &now);
    else if (f->states <= 9) gate_to_9(f, g, &now);
    else gate_to_16(f, g, &now);
}

const loss_kind T(kq_loss_gate) = {.check = gate_check, .update = update_gated};

/* Of 1 .. 16 degrees of freedom, in Q24 */
static const int32_t chi_square[][KQ_SIZE_MAX] = {
    {45391487, 77261935, 104880897, 130517351, 154960355, 178587436, 201612419, 224169881,
     246350878, 268220358, 289826549, 311206414, 332389017, 353397697, 374251531, 394966349},
    {64448984, 100520095, 131109378, 159177679, 185732131, 211251779, 236007454, 260169541,
     283853342, 307141132, 330094033, 352758915, 375172649, 397364860, 419359770, 441177491},
    {111315093, 154523870, 190335280, 222746133, 253105652, 282056774, 309964215, 337058213,
     363495067, 389386620, 414816168, 439847723, 464531744, 488908840, 513012271, 536869686},
    {181656416, 231785805, 272902158, 309821945, 344184681, 376778430, 408053541, 438296070,
     467701217, 496409274, 524525123, 552129629, 579286717, 606047965, 632455715, 658545235},
    {253951773, 309047740, 354125313, 394478359, 431926607, 467351854, 501261337, 533978990,
     565726858, 596665144, 626914003, 656566347, 685695807, 714361928, 742613686, 770491951}};

score T(kq_chi_square_limit)(int m, kq_level level)
{
    const unsigned row = (unsigned)level;
    if (!size_is_valid(m) || row > (unsigned)KQ_LEVEL_9999) return not_a_score();
    return score_of_fraction(chi_square[row][m - 1]);
}

#endif
