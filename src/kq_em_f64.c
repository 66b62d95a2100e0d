/*
 * kalmanq in double: EM, and its public names.  A file of its own: who does not call it has nothing
 * of it.
 */
#include "arithmetic/has_double.h"

#if KQ_HAS_DOUBLE
/* Of these files a part is used. */
#include "arithmetic/f64.h"

#include "arithmetic/root.h"

#include "model/process.h"
#include "model/advance.h"
#include "filter/rotate.h"

#include "model/units.h"
#include "model/sensor.h"
#include "filter/likelihood.h"
#include "filter/filter.h"

#include "model/factor.h"
#include "model/definitions.h"
#include "filter/prior.h"

#include "filter/tape.h"

/* Predict and update are the library's. */


#include "smoother/whitened.h"
#include "smoother/smoother.h"

#include "em/sums.h"
#include "em/expect.h"
#include "em/filter.h"
#include "em/model.h"
#include "em/maximise.h"
#include "em/em.h"

kq_status kq_em_assign_f64(kq_em_f64 *em, int n, int m, double *memory, size_t length)
{
    return em_assign(em, n, m, memory, length);
}

kq_status kq_em_init_f64(kq_em_f64 *em, const kq_parameters_f64 *model, const kq_em_choice *choice,
                         const kq_recording_f64 *recordings, int count)
{
    return em_init(em, model, choice, recordings, count);
}

kq_status kq_em_iterate_f64(kq_em_f64 *em) { return em_iterate(em); }

kq_status kq_em_advance_f64(kq_em_f64 *em) { return em_advance(em); }

uint32_t kq_em_remaining_f64(const kq_em_f64 *em) { return em ? em->remaining : 0; }

double kq_em_log_likelihood_f64(const kq_em_f64 *em) { return em_log_likelihood(em); }

kq_status kq_em_maximise_f64(kq_em_f64 *em) { return em_maximise(em); }

double kq_em_change_f64(const kq_em_f64 *em) { return em_change(em); }

double kq_em_distance_f64(const kq_em_f64 *em) { return em_distance(em); }

int kq_em_is_settled_f64(const kq_em_f64 *em, double tolerance)
{
    return em_is_settled(em, tolerance);
}

kq_status kq_em_gradient_f64(const kq_em_f64 *em, const kq_gradient_f64 *gradient)
{
    return em_gradient(em, gradient);
}

#endif
