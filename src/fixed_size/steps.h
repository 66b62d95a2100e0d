/*
 * The steps for sizes that the compiler knows.  Where something is not as they need it (an error, a
 * history to record on, a correlated R, formats that are not the same table, on a copy what is
 * unusual), they answer NOT_PLAIN and have changed nothing: the function for run-time sizes does the
 * work, or says what is wrong.
 */
#ifndef KQ_SRC_FIXED_SIZE_STEPS_H
#define KQ_SRC_FIXED_SIZE_STEPS_H

#include "../smoother/smoother.h"
#include "../steady/steady.h"
#include "options.h"

enum { NOT_PLAIN = 1 }; /* no kq_status */

KQ_KERNEL int filter_is_plain(const filter *f, int n) { return f->plain == n; }

/* flags: PROCESS_ROUNDED or 0 */
KQ_KERNEL int process_has_shape(const process *p, int n, int options, int flags)
{
    if (options & KQ_FIXED_UPPER) return p->plain == (n | PROCESS_UPPER | flags);
    return (p->plain & ~PROCESS_UPPER) == (n | flags);
}

KQ_KERNEL int process_has_size(const process *p, int n, int options)
{
    return process_has_shape(p, n, options, 0) || process_has_shape(p, n, options, PROCESS_ROUNDED);
}

KQ_KERNEL int sensor_is_plain(const sensor *s, const filter *f, int n, int m)
{
    return s->plain == (n | m << 8) && sensor_is_of(s, f);
}

/* l controls, or none */
KQ_KERNEL int controls_are_plain(const process *p, const num *u, int l)
{
    return !u || (p->controls == l && !controls_check(p, u, l));
}

/* What the step reads beside the filter */
typedef struct {
    const process *process;
    const num *u; /* NULL: no control */
    const sensor *sensor;
    const num *z;
} fixed_inputs;

/* The sizes and what is asked for, all constants */
typedef struct {
    int n, m, l, options;
    int predicts, updates;
} fixed_task;

/* A copy of the mean, to predict from; answers whether the process is as it was said to be.  That it
   is one whose A is rounded is seen here, so that others do not pay for the question. */
KQ_KERNEL int fixed_copy_mean(num *t, num *x, const process *p, fixed_task task)
{
    mean_copy(t, x, task.n);
    if (KQ_MOSTLY(process_has_shape(p, task.n, task.options, 0))) return 1;
    if (!process_has_shape(p, task.n, task.options, PROCESS_ROUNDED)) return 0;
    const scaled *A = p->transition;
    KQ_READ_APART(A);
    mean_take_rests(x, A, t, task.n);
    return 1;
}

/* How far a state in registers reaches.  An update does not take a mean that is not a number, since its innovation
   is none, either; so the mean is looked at only where no update follows. */
KQ_KERNEL extent fixed_extent(const num *x, fixed_task task)
{
    const int n = task.n;
    const num *S = x + MEAN_PLANES * n;
    extent far = extent_of(*S);
    KQ_UNROLL
    for (int k = 1; k < KQ_TRIANGLE(n); k++) far = extent_join(far, extent_of(S[k]));
    KQ_UNROLL
    for (int i = 0; i < n && !task.updates; i++) far = extent_join(far, mean_extent(x, n, i));
    return far;
}

/* A state that is yet to be held within its numbers, and how far it reaches, but for a mean that an update looks at
   (fixed_extent); scratch begins with the copy of the mean. */
KQ_KERNEL int fixed_predict_with(num *x, const fixed_inputs *in, fixed_task task, num *scratch,
                                 extent *far)
{
    const int n = task.n, shape = task.options & KQ_FIXED_UPPER ? SHAPE_UPPER : SHAPE_DENSE;
    num *S = x + MEAN_PLANES * n;
    const num *u = task.l ? in->u : 0;
    if (!fixed_copy_mean(scratch, x, in->process, task)) return NOT_PLAIN;
    const extent of_mean = predict_mean_of(x, in->process, u, task.l, scratch, n, shape);
    const extent of_root = predict_root_of(S, S, in->process, scratch, scratch + n * ROW_LEN(n), n, shape);
    renormalise(S, n);
    *far = task.updates && !mean_widens ? of_root : extent_join(of_mean, of_root);
    return KQ_OK;
}

KQ_KERNEL int fixed_predict_to_4(num *x, const fixed_inputs *in, fixed_task task, extent *far)
{
    num scratch[PREDICT_SCRATCH(4)];
    return fixed_predict_with(x, in, task, scratch, far);
}

KQ_KERNEL int fixed_predict_to_9(num *x, const fixed_inputs *in, fixed_task task, extent *far)
{
    num scratch[PREDICT_SCRATCH(9)];
    return fixed_predict_with(x, in, task, scratch, far);
}

KQ_KERNEL int fixed_predict_to_16(num *x, const fixed_inputs *in, fixed_task task, extent *far)
{
    num scratch[PREDICT_SCRATCH(16)];
    return fixed_predict_with(x, in, task, scratch, far);
}

/* Nothing has changed where it answers NOT_PLAIN. */
KQ_KERNEL int fixed_predict_state(num *x, const fixed_inputs *in, fixed_task task, extent *far)
{
    if (task.n <= 4) return fixed_predict_to_4(x, in, task, far);
    if (task.n <= 9) return fixed_predict_to_9(x, in, task, far);
    return fixed_predict_to_16(x, in, task, far);
}

/* The unusual measurement and those that follow it: the library takes them, and what it keeps of the
   likelihood is joined.  A copy of a filter is left as one that is not ready; a mean beyond its word the
   library leaves as it is (FILTER_OPEN). */
static void take_rest(filter *f, const reading *z, int c, int mode)
{
    if (f->states <= states_in_registers) {
        f->ready = 0;
        return;
    }
    const likelihood before = f->last;
    const likelihood_run run = f->run;
    if (mean_widens) filter_set_ready(f, f->ready | FILTER_OPEN);
    const kq_status status = T(kq_update_subset)(f, z->sensor, z->z, ~UINT32_C(0) << c);
    if (mean_widens) filter_set_ready(f, f->ready & ~FILTER_OPEN);
    f->run = run;
    if (status || mode == MODE_BARE) f->last = before;
    else likelihood_join(&f->last, &before);
}

/* From an unusual component on, take_rest takes all. */
KQ_KERNEL void fixed_take(filter *f, const reading *z, int n, int m, int mode)
{
    for (int c = 0; c < m; c++) {
        if (KQ_MOSTLY(take_component(f, z, c, n, mode))) continue;
        take_rest(f, z, c, mode);
        return;
    }
}

/* fixed_take with every component compiled for itself */
KQ_KERNEL void fixed_take_unrolled(filter *f, const reading *z, int n, int m, int mode)
{
    KQ_UNROLL
    for (int c = 0; c < m; c++) {
        if (KQ_MOSTLY(take_component(f, z, c, n, mode))) continue;
        take_rest(f, z, c, mode);
        return;
    }
}

KQ_KERNEL void fixed_update_state(filter *f, const fixed_inputs *in, fixed_task task)
{
    const reading now = {in->sensor, in->sensor->noise, in->z, UINT32_MAX};
    const int mode = task.options & KQ_FIXED_BARE ? MODE_BARE : MODE_PLAIN;
    if (mode != MODE_BARE) likelihood_clear(&f->last);
    if (task.n <= states_unrolled) fixed_take_unrolled(f, &now, task.n, task.m, mode);
    else fixed_take(f, &now, task.n, task.m, mode);
    settle(f, task.n);
}

/* The library looks at what rounding has done. */
KQ_COLD KQ_NOINLINE static void fixed_watch(filter *f, const process *p, const sensor *s)
{
    if (p && f->last.count > 0) watch_transition(f, p, f->last.count);
    if (s->kind->watch) s->kind->watch(f, s);
}

/* Answers whether a look is due. */
KQ_KERNEL int fixed_run_add(filter *f)
{
    const int32_t before = f->run.count >> WATCH_PERIOD_FIXED;
    likelihood_run_add(&f->run, &f->last);
    return f->run.count >> WATCH_PERIOD_FIXED != before;
}

KQ_KERNEL void copy_unrolled(num *to, const num *from, int n)
{
    KQ_UNROLL
    for (int k = 0; k < MEAN_PLANES * n + ROOT_LEN(n); k++) to[k] = from[k];
}

/* On a copy, which is in registers: nothing of the model can be changed by what is written to it.
   Where something is unusual it is forgotten, and the filter is as it was. */
KQ_KERNEL int fixed_run_copy(filter *f, const fixed_inputs *in, fixed_task task)
{
    num state[MEAN_PLANES * 4 + ROOT_LEN(4)];
    const num *S = state + MEAN_PLANES * task.n;
    int watches = 0;
    filter copy = {.states = (uint8_t)task.n, .ready = FILTER_READY, .memory = state};
    copy_unrolled(state, f->memory, task.n);
    if (task.predicts) {
        extent far;
        if (fixed_predict_state(state, in, task, &far)) return NOT_PLAIN;
        KQ_IN_ORDER;
        if (!KQ_MOSTLY(state_is_within(S, task.n, fixed_extent(state, task)))) return NOT_PLAIN;
    }
    if (task.updates) {
        fixed_update_state(&copy, in, task);
        if (!KQ_MOSTLY(copy.ready == FILTER_READY)) return NOT_PLAIN;
        if (!(task.options & KQ_FIXED_BARE)) {
            f->last = copy.last;
            watches = fixed_run_add(f);
        }
    }
    copy_unrolled(f->memory, state, task.n);
    if (watches) fixed_watch(f, in->process, in->sensor);
    filter_note(f, copy.events);
    return KQ_OK;
}

KQ_KERNEL int fixed_run_in_place(filter *f, const fixed_inputs *in, fixed_task task)
{
    num *S = f->memory + MEAN_PLANES * task.n;
    if (task.updates && sensor_check_together(in->sensor, in->z, task.m)) return NOT_PLAIN;
    if (task.predicts) {
        extent far;
        if (fixed_predict_state(f->memory, in, task, &far)) return NOT_PLAIN;
        filter_note(f, state_saturated(f->memory, S, task.n, far));
    }
    if (task.updates) {
        fixed_update_state(f, in, task);
        if (!(task.options & KQ_FIXED_BARE) && fixed_run_add(f)) fixed_watch(f, in->process, in->sensor);
    }
    return KQ_OK;
}

KQ_KERNEL int fixed_run(filter *f, const fixed_inputs *in, fixed_task task)
{
    if (task.n <= states_in_registers) return fixed_run_copy(f, in, task);
    return fixed_run_in_place(f, in, task);
}

KQ_KERNEL int fixed_predict(filter *f, const process *p, const num *u, int n, int l, int options)
{
    const fixed_inputs in = {.process = p, .u = u};
    if (!f || !p) return NOT_PLAIN;
    if (!filter_is_plain(f, n) || !process_is_of(p, f)) return NOT_PLAIN;
    if (!controls_are_plain(p, u, l)) return NOT_PLAIN;
    return fixed_run(f, &in, (fixed_task){n, 0, l, options, 1, 0});
}

KQ_KERNEL int fixed_update(filter *f, const sensor *s, const num *z, int n, int m, int options)
{
    const fixed_inputs in = {.sensor = s, .z = z};
    if (!f || !s || !z) return NOT_PLAIN;
    if (!filter_is_plain(f, n) || !sensor_is_plain(s, f, n, m)) return NOT_PLAIN;
    return fixed_run(f, &in, (fixed_task){n, m, 0, options, 0, 1});
}

KQ_KERNEL int fixed_step(filter *f, const process *p, const num *u, const sensor *s, const num *z,
                         int n, int m, int l, int options)
{
    const fixed_inputs in = {p, u, s, z};
    if (!f || !p || !s || !z) return NOT_PLAIN;
    if (!filter_is_plain(f, n) || !sensor_is_plain(s, f, n, m)) return NOT_PLAIN;
    if (!process_is_of(p, f) || !controls_are_plain(p, u, l)) return NOT_PLAIN;
    return fixed_run(f, &in, (fixed_task){n, m, l, options, 1, 1});
}

KQ_KERNEL int steady_is_plain(const steady *st, int n, int m, int options)
{
    if (!st) return 0;
    if (options & KQ_FIXED_UPPER) return st->plain == (n | PROCESS_UPPER | m << 8);
    return (st->plain & ~PROCESS_UPPER) == (n | m << 8);
}

KQ_KERNEL int fixed_steady_step(steady *st, const num *u, const num *z, int n, int m, int l,
                                int options)
{
    if (!steady_is_plain(st, n, m, options) || !z) return NOT_PLAIN;
    if (measured_check(st->sensor, z, m)) return NOT_PLAIN;
    if (!controls_are_plain(st->process, u, l)) return NOT_PLAIN;
    const int shape = options & KQ_FIXED_UPPER ? SHAPE_UPPER : SHAPE_DENSE;
    return steady_step_now(st, l ? u : 0, z, n, m, l, shape) ? KQ_OK : NOT_PLAIN;
}

/* From the smoothed state a step later to that of the record, in the place of it.  What is kept
   from step to step, a and T, stays where it is; the rest is in the scratch.  Answers the events.
 */
KQ_KERNEL unsigned fixed_smooth_in(num *scratch, const history *h, num *state, const process *m,
                                   int n, int shape)
{
    const workspace kept = workspace_at(h->memory, n);
    workspace v = workspace_at(scratch, n);
    v.a = kept.a;
    v.T = kept.T;
    predict_root_of(v.predicted, state + MEAN_PLANES * n, m, v.W, v.pq, n, shape);
    const unsigned events = theta_times_root_of(m, &v, n, shape);
    take_coordinates(&v, n);
    return events | smoothed_state(state, v.a, v.T, n);
}

KQ_KERNEL unsigned fixed_smooth_to_4(const history *h, num *state, const process *m, int n,
                                    int shape)
{
    num scratch[HISTORY_WORKSPACE_LEN(4)];
    return fixed_smooth_in(scratch, h, state, m, n, shape);
}

KQ_KERNEL unsigned fixed_smooth_to_6(const history *h, num *state, const process *m, int n,
                                    int shape)
{
    num scratch[HISTORY_WORKSPACE_LEN(6)];
    return fixed_smooth_in(scratch, h, state, m, n, shape);
}

KQ_KERNEL unsigned fixed_smooth_to_9(const history *h, num *state, const process *m, int n,
                                    int shape)
{
    num scratch[HISTORY_WORKSPACE_LEN(9)];
    return fixed_smooth_in(scratch, h, state, m, n, shape);
}

KQ_KERNEL unsigned fixed_smooth_to_16(const history *h, num *state, const process *m, int n,
                                     int shape)
{
    num scratch[HISTORY_WORKSPACE_LEN(16)];
    return fixed_smooth_in(scratch, h, state, m, n, shape);
}

/* One step of a history that is being smoothed already, its noises not asked for */
KQ_KERNEL int fixed_smooth_step(history *h, const process *p, const smooth_extras *extras, int n,
                                int options)
{
    if (!h || extras || h->states != n) return NOT_PLAIN;
    if (h->phase != HISTORY_SMOOTHING || h->step == 0) return NOT_PLAIN;
    const process *m = p ? p : h->process, *before;
    if (!process_has_size(m, n, options) || (!p && !history_knows_process(h))) return NOT_PLAIN;
    if (p && !processes_agree(p, h->process)) return NOT_PLAIN;
    const int shape = options & KQ_FIXED_UPPER ? SHAPE_UPPER : SHAPE_DENSE;
    num *state = history_pop_predict(h, &before, n);
    h->process = before;
    if (n <= 4) history_note(h, fixed_smooth_to_4(h, state, m, n, shape));
    else if (n <= 6) history_note(h, fixed_smooth_to_6(h, state, m, n, shape));
    else if (n <= 9) history_note(h, fixed_smooth_to_9(h, state, m, n, shape));
    else history_note(h, fixed_smooth_to_16(h, state, m, n, shape));
    keep_state(h, state, n);
    h->step--;
    undo_updates(h, n, 0);
    return KQ_OK;
}

#endif
