#ifndef KQ_SRC_FILTER_CHECKS_H
#define KQ_SRC_FILTER_CHECKS_H

#include "state.h"

/* Is there a whole state to be read: a filter that is ready, or a view of mean and root? */
KQ_COLD static kq_status state_check_known(const filter *f)
{
    if (!f) return KQ_ERR_NULL;
    if (f->ready || (f->plain == VIEW_OF_STATE && f->known == filter_all_known(f))) return KQ_OK;
    return KQ_ERR_NOT_READY;
}

KQ_INLINE kq_status sensor_check_fit(const filter *f, const sensor *s)
{
    const kq_status status = sensor_check(s);
    if (status) return status;
    return sensor_fits(s, f) ? KQ_OK : KQ_ERR_MISMATCH;
}

static kq_status sensor_check_for(const filter *f, const sensor *s)
{
    const kq_status status = filter_check(f);
    return status ? status : sensor_check_fit(f, s);
}

/* Of a filter that is read */
KQ_COLD static kq_status sensor_check_reading(const filter *f, const sensor *s)
{
    const kq_status status = state_check_known(f);
    return status ? status : sensor_check_fit(f, s);
}

static kq_status update_check(const filter *f, const sensor *s, const num *z, uint32_t present)
{
    const kq_status status = sensor_check_for(f, s);
    if (status) return status;
    if (!z) return KQ_ERR_NULL;
    return sensor_check_values(s, z, s->components, present);
}

/* For what is attached and reads H x of the mean */
static kq_status takes_measurements(const sensor *s, kq_status refusal)
{
    return takes_innovations(s) ? refusal : KQ_OK;
}

KQ_INLINE kq_status process_check_fit(const filter *f, const process *p)
{
    const kq_status status = process_check(p);
    if (status) return status;
    return process_fits(p, f) ? KQ_OK : KQ_ERR_MISMATCH;
}

static kq_status predict_check(const filter *f, const process *p, const num *u)
{
    kq_status status = filter_check(f);
    if (status) return status;
    status = process_check_fit(f, p);
    if (status) return status;
    return u ? process_check_controls(p, u) : KQ_OK;
}

/* Ready, or on its way to be */
static int has_state(const filter *f) { return f && (f->ready || f->attached); }

/* Is there a root, of what is known? */
static int has_root(const filter *f) { return has_state(f) || f->plain == VIEW_OF_STATE; }

static int index_is_valid(const filter *f, int i)
{
    return f && i >= 0 && i < KQ_SIZE_MAX && (f->known >> i & 1);
}

#endif
