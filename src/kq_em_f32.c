/*
 * kalmanq in float: EM, and its public names.  A file of its own: who does not call it has nothing
 * of it.
 */
/* Of these files a part is used. */
#include "arithmetic/f32.h"

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

kq_status kq_em_assign_f32(kq_em_f32 *em, int n, int m, float *memory, size_t length)
{
    return em_assign(em, n, m, memory, length);
}

kq_status kq_em_init_f32(kq_em_f32 *em, const kq_parameters_f32 *model, const kq_em_choice *choice,
                         const kq_recording_f32 *recordings, int count)
{
    return em_init(em, model, choice, recordings, count);
}

kq_status kq_em_iterate_f32(kq_em_f32 *em) { return em_iterate(em); }

kq_status kq_em_advance_f32(kq_em_f32 *em) { return em_advance(em); }

uint32_t kq_em_remaining_f32(const kq_em_f32 *em) { return em ? em->remaining : 0; }

float kq_em_log_likelihood_f32(const kq_em_f32 *em) { return em_log_likelihood(em); }

kq_status kq_em_maximise_f32(kq_em_f32 *em) { return em_maximise(em); }

float kq_em_change_f32(const kq_em_f32 *em) { return em_change(em); }

float kq_em_distance_f32(const kq_em_f32 *em) { return em_distance(em); }

int kq_em_is_settled_f32(const kq_em_f32 *em, float tolerance)
{
    return em_is_settled(em, tolerance);
}

kq_status kq_em_gradient_f32(const kq_em_f32 *em, const kq_gradient_f32 *gradient)
{
    return em_gradient(em, gradient);
}
