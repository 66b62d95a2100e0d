/* Do an object, the words given with it and a filter fit together?  In fixed point. */
#ifndef KQ_SRC_MODEL_UNITS_Q31_H
#define KQ_SRC_MODEL_UNITS_Q31_H

#include "../arithmetic/q31.h"
#include "types.h"

static int formats_agree(const kq_format_q31 *a, const kq_format_q31 *b, int count)
{
    for (int i = 0; i < count && a != b; i++) {
        if (a[i].fraction != b[i].fraction) return 0;
    }
    return 1;
}

/* Words within their declared ranges */
KQ_KERNEL kq_status ranges_check(const num *words, const kq_format_q31 *format, int count,
                                 uint32_t present)
{
    KQ_UNROLL
    for (int c = 0; c < count; c++) {
        if (!(present >> c & 1)) continue;
        if (magnitude(words[c]) > (uint32_t)format[c].range) return KQ_ERR_RANGE;
    }
    return KQ_OK;
}

/* Of the addresses that a step follows */
KQ_COLD static uint32_t process_addresses(const process *p)
{
    uint32_t seal = seal_address(0, p->noise_root);
    seal = seal_address(seal, p->transition);
    seal = seal_address(seal, p->control);
    return seal_address(seal_address(seal, p->state_format), p->control_format);
}

static int process_fits(const process *p, const filter *f)
{
    return p->states == f->states && formats_agree(p->state_format, f->state_format, p->states);
}

/* Have the two as many states, in the same formats?  recorded: NULL if there is none */
static int processes_agree(const process *p, const process *recorded)
{
    return !recorded || formats_agree(p->state_format, recorded->state_format, p->states);
}

KQ_KERNEL kq_status controls_check(const process *p, const num *u, int l)
{
    return ranges_check(u, p->control_format, l, UINT32_MAX);
}

static kq_status process_check_controls(const process *p, const num *u)
{
    return controls_check(p, u, p->controls);
}

static int sensor_is_correlated(const sensor *s) { return s->correlated; }

/* Of the addresses that a step follows */
KQ_COLD static uint32_t sensor_addresses(const sensor *s)
{
    uint32_t seal = seal_address(s->states | (uint32_t)s->components << 8, s->noise);
    seal = seal_address(seal, s->measurement);
    seal = seal_address(seal, s->kind);
    seal = seal_address(seal_join(seal, s->correlated), s->state_format);
    return seal_address(seal, s->measurement_format);
}

/* Of the addresses that a step follows */
KQ_COLD static uint32_t filter_addresses(const filter *f)
{
    const uint32_t seal = seal_address(f->states | (uint32_t)f->known << 8, f->memory);
    return seal_address(seal_address(seal, f->attached), f->state_format);
}

static int sensor_fits(const sensor *s, const filter *f)
{
    return s->states == f->states && formats_agree(s->state_format, f->state_format, s->states);
}

/* z of m components, of which `present` are read */
KQ_KERNEL kq_status sensor_check_values(const sensor *s, const num *z, int m, uint32_t present)
{
    return ranges_check(z, s->measurement_format, m, present);
}

KQ_KERNEL int sensor_check_together(const sensor *s, const num *z, int m)
{
    return sensor_check_values(s, z, m, UINT32_MAX) != KQ_OK;
}

/* What a history's views show is in the formats of the filter that it recorded, which may be gone. */
KQ_INLINE void history_keep_formats(history *h, const filter *f) { h->state_format = f->state_format; }

KQ_INLINE void view_take_formats(filter *view, const history *h) { view->state_format = h->state_format; }

KQ_INLINE void view_share_formats(filter *view, const filter *f) { view->state_format = f->state_format; }

/* Do two objects of the same number of states have the same formats, seen at once? */
KQ_KERNEL int process_is_of(const process *p, const filter *f)
{
    return p->state_format == f->state_format;
}

KQ_KERNEL int sensor_is_of(const sensor *s, const filter *f)
{
    return s->state_format == f->state_format;
}

/* The table has U; the decorrelation is made of it at every update. */
KQ_INLINE int noise_is_of_others(const sensor *s, uint32_t present)
{
    (void)present;
    return s->correlated;
}

/* A variance in the unit of component c, squared */
static scaled physical_variance(const sensor *s, int c, scaled variance)
{
    return scaled_shift(variance, -2 * s->measurement_format[c].fraction);
}

#endif
