/* Do an object, the numbers given with it and a filter fit together?  In floating point. */
#ifndef KQ_SRC_MODEL_UNITS_FLOAT_H
#define KQ_SRC_MODEL_UNITS_FLOAT_H

#include "types.h"

/* One sum tells it: of zeros, where all are numbers. */
KQ_SHARED int all_finite(const num *a, int count)
{
    num total = 0;
    for (; count > 0; count--, a++) total += *a - *a;
    return total == 0;
}

/* Of the addresses that a step follows */
KQ_COLD static uint32_t process_addresses(const process *p)
{
    uint32_t seal = seal_address(0, p->noise_root);
    seal = seal_address(seal, p->transition);
    seal = seal_address(seal, p->control);
    return seal_join(seal_address(seal, p->memory), p->length);
}

static int process_fits(const process *p, const filter *f) { return p->states == f->states; }

static int processes_agree(const process *p, const process *recorded)
{
    (void)p, (void)recorded;
    return 1;
}

KQ_KERNEL kq_status controls_check(const process *p, const num *u, int l)
{
    (void)p;
    KQ_UNROLL
    for (int k = 0; k < l; k++) {
        if (!num_is_finite(u[k])) return KQ_ERR_NOT_FINITE;
    }
    return KQ_OK;
}

static kq_status process_check_controls(const process *p, const num *u)
{
    return controls_check(p, u, p->controls);
}

static int sensor_is_correlated(const sensor *s) { return s->covariance != 0; }

/* Of the addresses that a step follows */
KQ_COLD static uint32_t sensor_addresses(const sensor *s)
{
    uint32_t seal = seal_address(s->states | (uint32_t)s->components << 8, s->noise);
    seal = seal_address(seal, s->measurement);
    seal = seal_address(seal, s->kind);
    seal = seal_address(seal, s->covariance);
    return seal_join(seal_address(seal, s->memory), s->length);
}

/* Of the addresses that a step follows */
KQ_COLD static uint32_t filter_addresses(const filter *f)
{
    return seal_address(seal_address(f->states | (uint32_t)f->known << 8, f->memory), f->attached);
}

static int sensor_fits(const sensor *s, const filter *f) { return s->states == f->states; }

/* z of m components, of which `present` are read */
KQ_KERNEL kq_status sensor_check_values(const sensor *s, const num *z, int m, uint32_t present)
{
    (void)s;
    KQ_UNROLL
    for (int c = 0; c < m; c++) {
        if (present >> c & 1 && !num_is_finite(z[c])) return KQ_ERR_NOT_FINITE;
    }
    return KQ_OK;
}

/* Is z finite?  In one sum, so that a finite z whose sum is not counts as none. */
KQ_KERNEL int sensor_check_together(const sensor *s, const num *z, int m)
{
    num total = 0;
    (void)s;
    KQ_UNROLL
    for (int c = 0; c < m; c++) total = c ? total + z[c] : z[c];
    return !num_is_finite(total);
}

/* Formats are q31's alone. */
KQ_INLINE void history_keep_formats(history *h, const filter *f) { (void)h, (void)f; }

KQ_INLINE void view_take_formats(filter *view, const history *h) { (void)view, (void)h; }

KQ_INLINE void view_share_formats(filter *view, const filter *f) { (void)view, (void)f; }

/* Do two objects of the same number of states have the same units?  They always do. */
KQ_KERNEL int process_is_of(const process *p, const filter *f)
{
    (void)p, (void)f;
    return 1;
}

KQ_KERNEL int sensor_is_of(const sensor *s, const filter *f)
{
    (void)s, (void)f;
    return 1;
}

/* Is the sensor's noise as it stands not that of the components present? */
KQ_INLINE int noise_is_of_others(const sensor *s, uint32_t present)
{
    const uint32_t all = (UINT32_C(1) << s->components) - 1;
    return s->covariance && (present & all) != all;
}

/* A variance in the unit of component c, squared */
static num physical_variance(const sensor *s, int c, num variance)
{
    (void)s, (void)c;
    return variance;
}

#endif
