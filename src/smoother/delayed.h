/*
 * A measurement of the state of k steps ago, exact: as if it had come in time.
 *
 * Of the coordinates of a slot it is f'xi = e less noise of variance r.  A map xi = J xi_later + d + E zeta
 * makes of that one of the later coordinates:
 *     f <- J'f,    e <- e - f'd,    r <- r + |E'f|^2
 * So it goes from slot to slot up to the newest coordinates, which are the filter's.  Each state on the way
 * takes it as the filter would have, by n rotations of (u; xi), u being the noise over sqrt(r), to (nu; xi').
 * The map between two states has rotations at both ends:
 *     zeta, then xi_later, with u     the columns of E and J, and one of u, which ends as that of nu_later
 *     xi with its own u               the rows of J and E, and one of u, which ends as that of nu: it is known
 * That of the slot before k begins with coordinates that have taken it, as at an update in time (map_take).
 * All of it is orthogonal.  So the maps stay what they were, of entries of 1 at most, and the next late
 * measurement, of any step, finds the joint law that this one has left.
 */
#ifndef KQ_SRC_SMOOTHER_DELAYED_H
#define KQ_SRC_SMOOTHER_DELAYED_H

#include "lag.h"

/* A scalar measurement of the coordinates of one state */
typedef struct {
    scaled f[KQ_SIZE_MAX];
    scaled r, e, s; /* its noise; its innovation and the variance of it, given the data of that state */
} late_scalar;

/* The same of what a map begins with.  noise: E'f, n */
static void late_through(late_scalar *later, scaled *noise, const late_scalar *m, backward_map map, int n)
{
    num row[ROW_LEN(KQ_SIZE_MAX)], word[ROW_LEN(1)];
    row_fitted(row, m->f, n);
    row_set_exponent(word, 1, row_exponent(row, n));
    for (int i = 0; i < 2 * n; i++) {
        sum total = 0;
        for (int k = 0; k < n; k++) total = add_product(total, map.columns[i * n + k], row[k]);
        word[0] = unit_of(total);
        *(i < n ? later->f + i : noise + i - n) = row_entry(word, 1, 0);
    }
    later->e = scaled_minus(m->e, mean_part(m->f, map.shift, n, 0));
    later->r = scaled_plus(m->r, square_of(noise, n));
    later->s = scaled_plus(later->r, square_of(later->f, n));
}

/* ------------------------------------------------------------------ a map */

/* The row of u beside those of a map: its entries, that of the later u, and its mean */
typedef struct {
    num entries[2 * KQ_SIZE_MAX], last, mean[COORDINATE_PLANES];
} noise_row;

/* As unit_turn: a row of a map, its columns being n numbers, and u */
KQ_KERNEL void unit_turn_row(num *restrict row, num *restrict u, num c, num s, int n)
{
    for (int j = 0; j < 2 * n; j++, row += n, u++) {
        num old = *row;
        unit_turn_entry(&old, u, c, s);
        *row = old;
    }
}

/* The columns: E by `noise`, J by the later measurement, then nu_later into the shift.  Answers the events. */
static unsigned late_turn_columns(backward_map map, noise_row *u, const scaled *noise, scaled r,
                                  const late_scalar *later, int n)
{
    scaled both[2 * KQ_SIZE_MAX];
    num row[ROW_LEN(2 * KQ_SIZE_MAX)], along[KQ_SIZE_MAX], c, s;
    for (int i = 0; i < n; i++) {
        both[i] = noise[i];
        both[n + i] = later->f[i];
        along[i] = 0;
    }
    row_fitted(row, both, 2 * n);
    rotor state;
    rotor_begin(&state, r, later->s, row, 2 * n);
    for (int i = 0; i < 2 * n; i++) {
        const int column_at = i < n ? n + i : i - n;
        u->entries[column_at] = 0;
        if (is_no_turn(row[i])) continue;
        unit_rotation(&state, row[i], &c, &s);
        unit_turn(map.columns + column_at * n, along, c, s, n);
        unit_turn_entry(u->entries + column_at, &u->last, c, s);
    }
    const scaled nu = unit_innovation(&state, later->e, later->s);
    unsigned events = coordinate_move(u->mean, 1, 0, u->last, nu);
    for (int k = 0; k < n; k++) events |= coordinate_move(map.shift, n, k, along[k], nu);
    return events;
}

/* The rows, by the measurement of what the map ends with.  Answers the events. */
static unsigned late_turn_rows(backward_map map, noise_row *u, const late_scalar *m, int n)
{
    unsigned events = 0;
    num row[ROW_LEN(KQ_SIZE_MAX)], c, s;
    wide mean = coordinate_get(u->mean, 1, 0);
    row_fitted(row, m->f, n);
    rotor state;
    rotor_begin(&state, m->r, m->s, row, n);
    for (int i = 0; i < n; i++) {
        if (is_no_turn(row[i])) continue;
        unit_rotation(&state, row[i], &c, &s);
        unit_turn_row(map.columns + i, u->entries, c, s, n);
        events |= coordinate_turn(map.shift, n, i, &mean, turn_number(c), scaled_negative(turn_number(s)));
    }
    return events;
}

/* Answers the events. */
static unsigned late_turn_map(backward_map map, const scaled *noise, const late_scalar *m, const late_scalar *later,
                              int n)
{
    noise_row u;
    u.last = num_one;
    for (int k = 0; k < COORDINATE_PLANES; k++) u.mean[k] = 0;
    const unsigned events = late_turn_columns(map, &u, noise, m->r, later, n);
    return events | late_turn_rows(map, &u, m, n);
}

/* ------------------------------------------------------------------ a state */

/* Of numbers of any size: the rotations of a root that is I, which the state's is multiplied by then */
KQ_COLD KQ_NOINLINE static void late_take_apart(filter *f, const late_scalar *m, int sharp)
{
    scaled memory[LOW_NOISE_PARTS * KQ_SIZE_MAX];
    num U[ROOT_LEN(KQ_SIZE_MAX)], a[COORDINATE_PLANES * KQ_SIZE_MAX];
    unsigned events = 0;
    const int n = f->states;
    const low_noise_work w = low_noise_work_at(memory, n);
    const scaled weight = scaled_over(m->e, m->s);
    for (int k = 0; k < KQ_TRIANGLE(n); k++) U[k] = 0;
    for (int k = 0; k < n; k++) {
        root_set_unit(U, n, k);
        w.f[k] = m->f[k];
    }
    rotate_root_apart(U, m->f, m->r, 0, &w, sharp, n);
    for (int k = 0; k < n; k++) {
        wide moved;
        events |= coordinate_of(&moved, scaled_times(w.b[k], weight));
        events |= coordinate_set(a, n, k, moved);
    }
    filter_note(f, events | smoothed_state(f->memory, a, U, n));
}

/* A measurement of f's coordinates into mean and root.  Answers whether it is far sharper than what was known. */
static int late_take(filter *f, const late_scalar *m)
{
    const int n = f->states, sharp = scaled_is_less(m->r, low_noise_share(m->s));
    if (is_weak(m->r, m->s)) {
        take_weak(f, &(weak_scalar){0, m->f, m->r, m->s}, scaled_over(m->e, m->s), 0);
    } else if (is_blunt(m->r, m->s, m->e)) {
        num row[ROW_LEN(KQ_SIZE_MAX)], *S = filter_root(f);
        row_fitted(row, m->f, n);
        rotor end;
        rotate_root(&end, S, row, m->r, m->s, n);
        move_mean(f, row, S, rotor_weight(&end, m->e, m->s), n);
    } else {
        late_take_apart(f, m, sharp);
    }
    settle(f, n);
    return sharp;
}

/* ------------------------------------------------------------------ all of it */

/* Decorrelated component c as a measurement of the coordinates of `then`.  Answers what rounding makes of the variance
   of one without noise, or 0. */
static scaled late_scalar_of(late_scalar *m, const filter *then, const reading *z, int c)
{
    scaled buffer[KQ_SIZE_MAX], spare[FLOOR_PARTS * KQ_SIZE_MAX];
    const int n = then->states;
    const scaled *h = scalar_row(z, c, buffer);
    scaled floor = project_with_floor(then, z, c, h, spare);
    for (int i = 0; i < n; i++) m->f[i] = spare[i];
    m->r = scalar_noise(z, c);
    m->e = scalar_innovation(then, z, c);
    const int has_noise = scaled_is_less(num_tiny, m->r);
    const scaled last_bits = mean_resolution(h, n);
    if (!has_noise && scaled_is_less(m->r, last_bits)) m->r = last_bits;
    m->s = scaled_plus(m->r, square_of(m->f, n)); /* >= r, which the rotations rely on */
    if (has_noise) return (scaled){0};
    const scaled before = scaled_times(scaled_of_count(64), rounding_before(then, z, c, spare)); /* as is_redundant */
    if (scaled_is_less(scaled_one, before)) floor = scaled_times(before, floor);
    return scaled_plus(floor, scaled_times(scaled_of_count(3), m->r)); /* one r is left of it by the first of two */
}

/* What it says of the present, nothing being changed; is it to be taken?  If not, there is an event.  An ordinary one
   with noise (floor 0) says something as long as its numbers are no more than that. */
static int late_counts(filter *f, T(kq_lag) *lag, uint32_t k, const late_scalar *m, scaled floor)
{
    scaled noise[KQ_SIZE_MAX];
    late_scalar at[2] = {*m};
    if (scaled_is_zero(floor) && is_blunt(m->r, m->s, m->e)) return 1;
    for (uint32_t age = k; age > 0; age--) {
        late_through(at + 1, noise, at, lag_map(lag, age, f->states), f->states);
        at[0] = at[1];
    }
    const int known = !scaled_is_less(num_zero_variance, at->s) || !scaled_is_less(floor, at->s);
    if (known) f->events |= KQ_EVENT_REDUNDANT;
    else if (variance_overflows(m->s) || likelihood_overflows(at->e, at->s)) f->events |= KQ_EVENT_OVERFLOW;
    else return 1;
    return 0;
}

/* The map of what is older begins with the coordinates that m is of, as at an update in time.  Answers the events. */
static unsigned late_take_older(backward_map map, const late_scalar *m, int n)
{
    num record[ROW_RECORD_LEN(KQ_SIZE_MAX)];
    row_fitted(record, m->f, n);
    store_row_record(record + ROW_LEN(n), m->r, m->e, m->s);
    return map_take(map, record, n);
}

/* What an update tells of one that was taken */
static void late_tell(filter *f, const reading *z, int c, const late_scalar *m, int sharp)
{
    const scaled nis = scaled_times(m->e, scaled_over(m->e, m->s));
    likelihood_add(&f->last, nis, physical_variance(z->sensor, c, m->s));
    if (!sharp) return;
    filter_set_ready(f, f->ready | FILTER_LOW_NOISE | FILTER_NARROW);
    if (scaled_is_less(num_most_sure, nis)) f->events |= KQ_EVENT_CONTRADICTION;
}

/* The states and the maps from slot k to the filter, and the filter.  Its numbers may have left what is representable
   on the way: then the lag ends. */
static void late_take_all(filter *f, T(kq_lag) *lag, uint32_t k, const reading *z, int c, late_scalar *m)
{
    const int n = f->states;
    scaled noise[KQ_SIZE_MAX];
    late_scalar other, *later = &other;
    filter then = *f;
    then.events = 0;
    if (k < lag->steps) filter_note(&then, late_take_older(lag_map(lag, k + 1, n), m, n));
    for (uint32_t age = k; age > 0; age--) {
        const backward_map map = lag_map(lag, age, n);
        late_scalar *const done = m;
        late_through(later, noise, m, map, n);
        filter_note(&then, late_turn_map(map, noise, m, later, n));
        then.memory = lag_slot(lag, age, n);
        (void)late_take(&then, m);
        m = later;
        later = done;
    }
    filter_note(f, then.events);
    if (!likelihood_overflows(m->e, m->s)) {
        late_tell(f, z, c, m, late_take(f, m));
        return;
    }
    f->events |= KQ_EVENT_OVERFLOW;
    history_end(f);
}

static void update_late(filter *f, T(kq_lag) *lag, uint32_t k, const reading *z)
{
    late_scalar m;
    filter then = *f;
    then.memory = lag_slot(lag, k, f->states);
    likelihood_clear(&f->last);
    map_take_tape(lag_map(lag, 1, f->states), &lag->tape, f->states);
    for (int c = 0; c < z->sensor->components; c++) {
        if (!(z->present >> c & 1)) continue;
        const scaled floor = late_scalar_of(&m, &then, z, c);
        if (late_counts(f, lag, k, &m, floor)) late_take_all(f, lag, k, z, c, &m);
    }
    update_end(f);
}

static kq_status late_check(const T(kq_lag) *lag, size_t k, const sensor *s, const num *z, uint32_t present)
{
    kq_status status = lag ? on_line_check(&lag->tape) : KQ_ERR_NULL;
    if (status) return status;
    if (lag->head != LAG_APART) return KQ_ERR_MISMATCH;
    status = update_check(lag->tape.filter, s, z, present);
    if (!status) status = takes_measurements(s, KQ_ERR_MISMATCH);
    return status || k <= lag->steps ? status : KQ_ERR_SIZE;
}

kq_status T(kq_update_delayed)(T(kq_lag) *lag, size_t k, const sensor *s, const num *z, uint32_t present)
{
    const kq_status status = late_check(lag, k, s, z, present);
    if (status) return status;
    filter *f = lag->tape.filter;
    const uint32_t all = (UINT32_C(1) << s->components) - 1;
    if (k == 0 || !(present & all)) return update_present(f, s, z, present);
    scaled noise[KQ_TRIANGLE(KQ_SIZE_MAX)];
    reading now = {s, s->noise, z, present};
    if (noise_is_of_others(s, present)) {
        noise_of_present(noise, s, present);
        now.noise = noise;
    }
    update_late(f, lag, (uint32_t)k, &now);
    return KQ_OK;
}

/* ------------------------------------------------------------------ the object */

/* A lag that keeps its maps apart */
static void delay_move(filter *f, const process *p, const num *u)
{
    T(kq_lag) *lag = (T(kq_lag) *)f->attached;
    const int n = f->states;
    const workspace v = workspace_at(lag->tape.memory, n);
    if (lag->steps) map_take_tape(lag_map(lag, 1, n), &lag->tape, n);
    lag->tape.used = 0; /* of the oldest step there is no map */
    lag->tape.records = 0;
    predict_by_map(f, p, u, lag_open(lag, f, n), &v, n);
}

static kq_status delay_predict(filter *f, const process *p, const num *u)
{
    return on_line_predict(f, p, u, delay_move);
}

static kq_status delay_attach(filter *f, attached *object)
{
    T(kq_lag) *lag = (T(kq_lag) *)object;
    return lag->most ? lag_begin(lag, f, &T(kq_delay_hooks), 0, LAG_APART) : KQ_ERR_SIZE;
}

const hooks T(kq_delay_hooks) = {.attach = delay_attach, .predict = delay_predict, .step = step_attached,
                                 KQ_RECORDS_ROWS};

kq_status T(kq_delay_assign)(T(kq_lag) *lag, int n, int m, size_t most, num *memory, size_t length)
{
    if (lag && memory && most == 0) return KQ_ERR_SIZE;
    return lag_assign(lag, n, m, most, memory, length, &T(kq_delay_hooks));
}

#endif
