#include "vector.h"

#include <kalmanq/adaptation.h>
#include <kalmanq/consistency.h>
#include <kalmanq/extended.h>
#include <kalmanq/instant.h>
#include <kalmanq/lag.h>
#include <kalmanq/least_squares.h>
#include <kalmanq/robust.h>
#include <kalmanq/diffuse.h>
#include <kalmanq/steady.h>

enum { SLOTS = 2, NUMBERS = 1024, MOST = KQ_SIZE_MAX };

/* The tables of a process and of a sensor: the library refers to them. */
typedef struct {
    kq_process_q31 process;
    kq_format_q31 control_format[MOST];
    kq_scaled_q31 *transition;
    int32_t noise_root[KQ_ROOT_LEN_Q31(MOST)];
    int controls;
} process_slot;

typedef struct {
    kq_sensor_q31 sensor;
    kq_format_q31 measurement_format[MOST];
    kq_scaled_q31 *measurement;
    int components;
} sensor_slot;

static struct {
    int n, step;
    kq_format_q31 state_format[MOST];
    process_slot process[SLOTS];
    sensor_slot sensor[SLOTS];
    kq_scaled_q31 numbers[NUMBERS]; /* coefficients of the slots, one behind the other */
    size_t used;
    kq_filter_q31 filter, ahead;
    int32_t filter_memory[KQ_FILTER_LEN_Q31(MOST)], ahead_memory[KQ_FILTER_LEN_Q31(MOST)];
    kq_history_q31 history;
    kq_lag_q31 lag;
    kq_instant_q31 instant;
    kq_filter_q31 shown; /* by one of the two, last */
    kq_steady_q31 steady;
    const kq_scaled_q31 *gains; /* of the updates */
    size_t gain_count;
    kq_freeze_q31 lazy;
    kq_loss_q31 gate;
    kq_least_squares_q31 fit;
    kq_format_q31 fit_format;
    kq_consistency_q31 window;
    kq_diffuse_q31 start;
    kq_adaptation_q31 adaptation;
    kq_scaled_q31 out[3][MOST * MOST];
} machine;

/* Apart, as an object has at most 32 kB where a pointer has 16 bits.  What is recorded begins at
   its front; what is kept until the next VECTOR_STATES is taken from its end. */
static int32_t history_memory[VECTOR_HISTORY_WORDS];
static size_t kept;

/* ------------------------------------------------------------------ what goes in */

typedef struct {
    const int32_t *at;
    size_t left;
    int bad; /* more was asked for than there is, or a number was out of its range */
} words_in;

static const int32_t *take(words_in *in, size_t count)
{
    static const int32_t nothing[KQ_ROOT_LEN_Q31(MOST)];
    if (in->bad || count > in->left) {
        in->bad = 1;
        return nothing;
    }
    const int32_t *words = in->at;
    in->at += count;
    in->left -= count;
    return words;
}

static int32_t take_word(words_in *in, int32_t least, int32_t most)
{
    const int32_t word = *take(in, 1);
    if (word < least || word > most) in->bad = 1;
    return in->bad ? least : word;
}

static int take_number(words_in *in, int least, int most)
{
    return (int)take_word(in, least, most);
}

static void take_formats(words_in *in, kq_format_q31 *format, int count)
{
    const int32_t *words = take(in, 2 * (size_t)count);
    for (int i = 0; i < count && !in->bad; i++) {
        format[i] = (kq_format_q31){.range = words[2 * i], .fraction = words[2 * i + 1]};
    }
}

static void take_scaled(words_in *in, kq_scaled_q31 *numbers, int count)
{
    const int32_t *words = take(in, 2 * (size_t)count);
    for (int k = 0; k < count && !in->bad; k++) {
        numbers[k] = (kq_scaled_q31){.mantissa = words[2 * k], .exponent = words[2 * k + 1]};
    }
}

/* Memory for numbers and for words that stays until the next VECTOR_STATES */
static kq_scaled_q31 *keep_numbers(words_in *in, size_t count)
{
    kq_scaled_q31 *numbers = machine.numbers + machine.used;
    if (count > NUMBERS - machine.used) in->bad = 1;
    if (in->bad) return machine.numbers;
    machine.used += count;
    return numbers;
}

static int32_t *keep_words(words_in *in, size_t count)
{
    if (count > VECTOR_HISTORY_WORDS - kept) in->bad = 1;
    if (in->bad) return history_memory;
    kept += count;
    return history_memory + VECTOR_HISTORY_WORDS - kept;
}

/* Is there room for so many words before those that are kept? */
static int has_room(size_t words) { return words <= VECTOR_HISTORY_WORDS - kept; }

static kq_scaled_q31 *keep_scaled(words_in *in, int count)
{
    kq_scaled_q31 *numbers = keep_numbers(in, (size_t)count);
    take_scaled(in, numbers, count);
    return numbers;
}

/* A mask of components; -1: all */
static uint32_t take_present(words_in *in)
{
    const int32_t present = take_word(in, -1, (INT32_C(1) << MOST) - 1);
    return present < 0 ? UINT32_MAX : (uint32_t)present;
}

static process_slot *take_process(words_in *in)
{
    return &machine.process[take_number(in, 0, SLOTS - 1)];
}
static sensor_slot *take_sensor(words_in *in)
{
    return &machine.sensor[take_number(in, 0, SLOTS - 1)];
}

/* What an update takes */
typedef struct {
    const sensor_slot *slot;
    uint32_t present;
    const int32_t *z;
} reading;

static reading take_reading(words_in *in)
{
    reading r = {.slot = take_sensor(in)};
    r.present = take_present(in);
    r.z = take(in, (size_t)r.slot->components);
    return r;
}

/* 0 or 1, and `count` words behind the 1; NULL for the 0 */
static const int32_t *take_controls(words_in *in, int count)
{
    return take_number(in, 0, 1) ? take(in, (size_t)count) : NULL;
}

static int is_complete(const words_in *in) { return !in->bad && in->left == 0; }

/* ------------------------------------------------------------------ what comes out */

static void put_words(const vector_sink *sink, const char *quantity, const int32_t *words,
                      int count)
{
    for (int k = 0; k < count; k++) sink->put(sink->to, quantity, k, words[k]);
}

static void put_word(const vector_sink *sink, const char *quantity, int32_t word)
{
    put_words(sink, quantity, &word, 1);
}

/* Upper word, then lower word */
static void put_score(const vector_sink *sink, const char *quantity, int64_t score)
{
    const uint64_t bits = (uint64_t)score;
    put_words(sink, quantity,
              (const int32_t[]){vector_word_of((uint32_t)(bits >> 32)),
                                vector_word_of((uint32_t)(bits & UINT32_MAX))},
              2);
}

static void put_scaled(const vector_sink *sink, const char *quantity, const kq_scaled_q31 *numbers,
                       int count)
{
    for (int k = 0; k < count; k++) {
        sink->put(sink->to, quantity, 2 * k, numbers[k].mantissa);
        sink->put(sink->to, quantity, 2 * k + 1, numbers[k].exponent);
    }
}

/* The upper triangle, row by row */
static void put_symmetric(const vector_sink *sink, const char *quantity, const kq_scaled_q31 *P,
                          int n)
{
    for (int i = 0, k = 0; i < n; i++) {
        for (int j = i; j < n; j++, k++) {
            sink->put(sink->to, quantity, 2 * k, P[i * n + j].mantissa);
            sink->put(sink->to, quantity, 2 * k + 1, P[i * n + j].exponent);
        }
    }
}

static void put_symmetric_status(const vector_sink *sink, kq_status status, int n)
{
    put_word(sink, "covariance status", status);
    if (!status) put_symmetric(sink, "smoothed covariance", machine.out[0], n);
}

static void put_memory(const vector_sink *sink, const kq_filter_q31 *f)
{
    const int n = machine.n;
    put_words(sink, "mean", f->memory, n);
    put_words(sink, "low", f->memory + n, n);
    put_words(sink, "root", f->memory + 2 * n, KQ_TRIANGLE(n));
    put_words(sink, "root exponent", f->memory + 2 * n + KQ_TRIANGLE(n), n);
}

/* All that predict and update change.  While a start has unknowns left, what is one number of the whole state is not in the
   vectors, nor is sigma, which put_start has. */
static void put_filter_of(const vector_sink *sink, const kq_filter_q31 *f, int is_known)
{
    put_word(sink, "events", (int32_t)kq_events_q31(f));
    put_word(sink, "taken", is_known ? kq_taken_q31(f) : -1);
    put_score(sink, "NIS", is_known ? kq_nis_q31(f) : KQ_NOT_A_SCORE_Q31);
    for (int i = 0; i < machine.n; i++) {
        sink->put(sink->to, "sigma", i, is_known ? kq_sigma_q31(f, i) : KQ_NOT_A_VALUE_Q31);
    }
    put_memory(sink, f);
}

static void put_filter(const vector_sink *sink, const kq_filter_q31 *f) { put_filter_of(sink, f, 1); }

/* All that can be read of a filter */
static void put_reading(const vector_sink *sink, const kq_filter_q31 *f)
{
    const int n = machine.n;
    for (int i = 0; i < n; i++) sink->put(sink->to, "rounded mean", i, kq_mean_q31(f, i));
    for (int i = 0; i < n; i++) sink->put(sink->to, "rounded low", i, kq_mean_low_q31(f, i));
    for (int i = 0; i < n; i++) sink->put(sink->to, "sigma", i, kq_sigma_q31(f, i));
    put_word(sink, "covariance status", kq_covariance_q31(f, machine.out[0]));
    put_symmetric(sink, "covariance", machine.out[0], n);
    put_score(sink, "log-likelihood of the last update", kq_log_likelihood_last_q31(f));
    put_score(sink, "log-likelihood", kq_log_likelihood_q31(f));
}

static void put_status(const vector_sink *sink, kq_status status)
{
    put_word(sink, "status", status);
}

/* Of a call that moves the filter by so many steps */
static int put_moved(const vector_sink *sink, kq_status status, int steps)
{
    put_status(sink, status);
    put_filter(sink, &machine.filter);
    machine.step += steps;
    return 0;
}

static void put_range_error(const vector_sink *sink, const kq_range_error_q31 *range_error)
{
    const int32_t words[3] = {(int32_t)range_error->quantity, range_error->component, range_error->bits};
    put_words(sink, "range_error", words, 3);
}

/* ------------------------------------------------------------------ models */

static int set_states(words_in *in, const vector_sink *sink)
{
    (void)sink;
    const int n = take_number(in, 1, MOST);
    take_formats(in, machine.state_format, n);
    if (!is_complete(in)) return -1;
    machine.n = n;
    machine.used = 0;
    kept = 0;
    machine.gain_count = 0;
    machine.step = 0;
    for (int k = 0; k < SLOTS; k++) {
        machine.process[k] = (process_slot){.controls = 0};
        machine.sensor[k] = (sensor_slot){.components = 0};
    }
    return 0;
}

static int set_process(words_in *in, const vector_sink *sink)
{
    const int n = machine.n;
    process_slot *slot = take_process(in);
    const int l = take_number(in, 0, MOST);
    take_formats(in, slot->control_format, l);
    slot->transition = keep_scaled(in, n * n);
    kq_scaled_q31 *control = keep_scaled(in, n * l);
    const int32_t *root = take(in, (size_t)KQ_ROOT_LEN_Q31(n));
    if (!is_complete(in)) return -1;
    for (int k = 0; k < KQ_ROOT_LEN_Q31(n); k++) slot->noise_root[k] = root[k];
    slot->controls = l;
    kq_range_error_q31 range_error = {KQ_STATE, 0, 0};
    put_status(sink, kq_process_init_q31(
                         &slot->process,
                         &(kq_process_table_q31){.states = n,
                                                 .controls = l,
                                                 .state_format = machine.state_format,
                                                 .control_format = l ? slot->control_format : 0,
                                                 .transition = slot->transition,
                                                 .control = l ? control : 0,
                                                 .noise_root = slot->noise_root},
                         &range_error));
    put_range_error(sink, &range_error);
    return 0;
}

static int set_sensor(words_in *in, const vector_sink *sink)
{
    const int n = machine.n;
    sensor_slot *slot = take_sensor(in);
    const int m = take_number(in, 1, MOST), correlated = take_number(in, 0, 1);
    take_formats(in, slot->measurement_format, m);
    slot->measurement = keep_scaled(in, m * n);
    kq_scaled_q31 *noise = keep_scaled(in, correlated ? KQ_TRIANGLE(m) : m);
    if (!is_complete(in)) return -1;
    slot->components = m;
    kq_range_error_q31 range_error = {KQ_STATE, 0, 0};
    put_status(sink, kq_sensor_init_q31(
                         &slot->sensor,
                         &(kq_sensor_table_q31){.states = n,
                                                .components = m,
                                                .correlated = correlated,
                                                .state_format = machine.state_format,
                                                .measurement_format = slot->measurement_format,
                                                .measurement = slot->measurement,
                                                .noise = noise},
                         &range_error));
    put_range_error(sink, &range_error);
    return 0;
}

static int set_prior(words_in *in, const vector_sink *sink)
{
    const int n = machine.n;
    const int32_t *mean = take(in, (size_t)n), *root = take(in, (size_t)KQ_ROOT_LEN_Q31(n));
    if (!is_complete(in)) return -1;
    kq_range_error_q31 range_error = {KQ_STATE, 0, 0};
    kq_filter_q31 *f = &machine.filter;
    kq_status status = kq_filter_assign_q31(f, n, machine.filter_memory, KQ_FILTER_LEN_Q31(MOST));
    if (!status) {
        status = kq_filter_init_q31(
            f,
            &(kq_prior_table_q31){
                .states = n, .state_format = machine.state_format, .mean = mean, .root = root},
            &range_error);
    }
    put_status(sink, status);
    put_range_error(sink, &range_error);
    if (!status) put_filter(sink, f);
    machine.step = 0;
    return 0;
}

static int change_transition(words_in *in, const vector_sink *sink)
{
    process_slot *slot = take_process(in);
    if (!slot->transition) return -1;
    take_scaled(in, slot->transition, machine.n * machine.n);
    if (!is_complete(in)) return -1;
    put_status(sink, kq_process_change_transition_q31(&slot->process, slot->transition, NULL));
    return 0;
}

/* A Jacobian says what is beyond its range. */
static int change_measurement_as(words_in *in, const vector_sink *sink, int is_jacobian)
{
    sensor_slot *slot = take_sensor(in);
    kq_range_error_q31 range_error = {KQ_STATE, 0, 0};
    if (!slot->measurement) return -1;
    take_scaled(in, slot->measurement, slot->components * machine.n);
    if (!is_complete(in)) return -1;
    put_status(sink, kq_sensor_change_measurement_q31(&slot->sensor, slot->measurement,
                                                      is_jacobian ? &range_error : NULL));
    if (is_jacobian) put_range_error(sink, &range_error);
    return 0;
}

static int change_measurement(words_in *in, const vector_sink *sink)
{
    return change_measurement_as(in, sink, 0);
}

/* ------------------------------------------------------------------ the filter */

static int predict(words_in *in, const vector_sink *sink)
{
    process_slot *slot = take_process(in);
    const int32_t *u = take_controls(in, slot->controls);
    if (!is_complete(in)) return -1;
    return put_moved(sink, kq_predict_q31(&machine.filter, &slot->process, u), 1);
}

/* All components by the plain call, others by that with a mask */
static kq_status update_by(const reading *r)
{
    kq_filter_q31 *f = &machine.filter;
    return r->present == UINT32_MAX ? kq_update_q31(f, &r->slot->sensor, r->z)
                                    : kq_update_subset_q31(f, &r->slot->sensor, r->z, r->present);
}

static int update(words_in *in, const vector_sink *sink)
{
    const reading r = take_reading(in);
    if (!is_complete(in)) return -1;
    return put_moved(sink, update_by(&r), 0);
}

static int step(words_in *in, const vector_sink *sink)
{
    process_slot *process = take_process(in);
    sensor_slot *sensor = take_sensor(in);
    const int32_t *u = take_controls(in, process->controls);
    const int32_t *z = take(in, (size_t)sensor->components);
    if (!is_complete(in)) return -1;
    return put_moved(sink, kq_step_q31(&machine.filter, &process->process, u, &sensor->sensor, z), 1);
}

static int read_filter(words_in *in, const vector_sink *sink)
{
    if (!is_complete(in)) return -1;
    put_reading(sink, &machine.filter);
    return 0;
}

static void put_implied(const vector_sink *sink, const kq_filter_q31 *f, const sensor_slot *slot)
{
    int32_t implied[MOST] = {0};
    const int m = slot->components;
    put_status(sink, kq_measurement_q31(f, &slot->sensor, implied, machine.out[0]));
    put_words(sink, "implied measurement", implied, m);
    put_scaled(sink, "innovation covariance", machine.out[0], m * m);
}

static int look(words_in *in, const vector_sink *sink)
{
    const sensor_slot *slot = take_sensor(in);
    const int m = slot->components;
    const int32_t *z = take(in, (size_t)m);
    if (!is_complete(in)) return -1;
    const kq_filter_q31 *f = &machine.filter;
    int32_t e[MOST] = {0};
    put_implied(sink, f, slot);
    put_status(sink, kq_innovation_q31(f, &slot->sensor, z, e));
    put_words(sink, "innovation", e, m);
    put_status(sink, kq_gain_q31(f, &slot->sensor, machine.out[0]));
    put_scaled(sink, "gain", machine.out[0], machine.n * m);
    return 0;
}

static int forecast(words_in *in, const vector_sink *sink)
{
    const process_slot *process = take_process(in);
    const sensor_slot *sensor = take_sensor(in);
    const int steps = take_number(in, 0, 1000);
    const int32_t *u = take_controls(in, steps * process->controls);
    if (!is_complete(in)) return -1;
    kq_filter_q31 *ahead = &machine.ahead;
    kq_status status =
        kq_filter_assign_q31(ahead, machine.n, machine.ahead_memory, KQ_FILTER_LEN_Q31(MOST));
    if (!status) status = kq_forecast_q31(&machine.filter, &process->process, u, (size_t)steps, ahead);
    put_status(sink, status);
    put_filter(sink, ahead);
    put_reading(sink, ahead);
    put_implied(sink, ahead, sensor);
    return 0;
}

static int clear_events(words_in *in, const vector_sink *sink)
{
    if (!is_complete(in)) return -1;
    kq_events_clear_q31(&machine.filter);
    put_word(sink, "events", (int32_t)kq_events_q31(&machine.filter));
    return 0;
}

/* ------------------------------------------------------------------ a long run */

static uint32_t next_draw(uint32_t draw) /* Marsaglia's xorshift */
{
    draw ^= draw << 13;
    draw ^= draw >> 17;
    draw ^= draw << 5;
    return draw;
}

/* A draw as a signed word, shifted right with its sign */
static int32_t noise_of(uint32_t draw, int shift)
{
    const int32_t half = (int32_t)(draw >> 1 >> shift);
    return draw & 1 ? -half : half;
}

static int32_t held(int64_t word, int32_t range)
{
    return (int32_t)(word > range ? range : word < -range ? -range : word);
}

/* What the filter expects, with noise of the generator: data that need no room in the case */
static void draw_measurement(int32_t *z, const sensor_slot *slot, uint32_t *draw, int shift)
{
    const kq_status status = kq_measurement_q31(&machine.filter, &slot->sensor, z, NULL);
    for (int c = 0; status && c < slot->components; c++) z[c] = 0;
    for (int c = 0; c < slot->components; c++) {
        *draw = next_draw(*draw);
        z[c] = held((int64_t)z[c] + noise_of(*draw, shift), slot->measurement_format[c].range);
    }
}

static uint32_t digest_filter(uint32_t digest)
{
    const kq_filter_q31 *f = &machine.filter;
    for (int k = 0; k < KQ_FILTER_LEN_Q31(machine.n); k++) digest = vector_digest(digest, f->memory[k]);
    return vector_digest(digest, vector_word_of((uint32_t)(kq_nis_q31(f) & UINT32_MAX)));
}

static int run(words_in *in, const vector_sink *sink)
{
    const process_slot *process = take_process(in);
    const sensor_slot *sensor = take_sensor(in);
    const int steps = take_number(in, 1, 10000);
    uint32_t draw = (uint32_t)take_word(in, 1, INT32_MAX), digest = VECTOR_DIGEST_OF_NOTHING;
    const int shift = take_number(in, 0, 30);
    if (!is_complete(in)) return -1;
    int32_t z[MOST] = {0};
    kq_status status = KQ_OK;
    for (int t = 0; t < steps && !status; t++) {
        status = kq_predict_q31(&machine.filter, &process->process, NULL);
        draw_measurement(z, sensor, &draw, shift);
        draw = next_draw(draw);
        if (!status) {
            status = kq_update_subset_q31(&machine.filter, &sensor->sensor, z, draw >> 16);
        }
        digest = digest_filter(digest);
    }
    put_status(sink, status);
    put_word(sink, "digest", vector_word_of(digest));
    put_filter(sink, &machine.filter);
    machine.step += steps;
    return 0;
}

/* ------------------------------------------------------------------ the smoother */

static int attach(words_in *in, const vector_sink *sink)
{
    const size_t words = (size_t)take_number(in, 0, VECTOR_HISTORY_WORDS);
    if (!is_complete(in) || !has_room(words)) return -1;
    kq_history_q31 *h = &machine.history;
    kq_status status = kq_history_assign_q31(h, machine.n, history_memory, words);
    if (!status) status = kq_attach_q31(&machine.filter, &h->attached);
    put_status(sink, status);
    return 0;
}

/* What smoothers show, component by component */
static void put_view(const vector_sink *sink, const kq_filter_q31 *view)
{
    for (int i = 0; i < machine.n; i++) {
        sink->put(sink->to, "smoothed mean", i, kq_mean_q31(view, i));
        sink->put(sink->to, "smoothed low", i, kq_mean_low_q31(view, i));
        sink->put(sink->to, "smoothed sigma", i, kq_sigma_q31(view, i));
    }
}

static kq_filter_q31 smoothed_view(size_t t)
{
    kq_filter_q31 view;
    const kq_status shown = kq_smoothed_q31(&machine.history, t, &view); /* refused: it reads NaN */
    (void)shown;
    return view;
}

static void put_smoothed(const vector_sink *sink, size_t t, int with_sigma)
{
    const kq_filter_q31 view = smoothed_view(t);
    const int n = machine.n;
    for (int i = 0; i < n; i++) sink->put(sink->to, "smoothed mean", i, kq_mean_q31(&view, i));
    for (int i = 0; i < n; i++) sink->put(sink->to, "smoothed low", i, kq_mean_low_q31(&view, i));
    for (int i = 0; i < n && with_sigma; i++) {
        sink->put(sink->to, "smoothed sigma", i, kq_sigma_q31(&view, i));
    }
}

/* Of every measurement of the step, up to the one that is refused */
static void put_reading_noise(const vector_sink *sink)
{
    for (int k = 0;; k++) {
        kq_scaled_q31 moments[2];
        const kq_status status =
            kq_smoothed_measurement_noise_q31(&machine.history, k, &moments[0], &moments[1]);
        put_status(sink, status);
        if (status) return;
        put_scaled(sink, "measurement noise", moments, 2);
    }
}

/* Lag-one covariance and process noise; the last step, done first, has none */
static void put_extras(const vector_sink *sink, int what)
{
    const int n = machine.n;
    if (what & VECTOR_LAG_ONE) put_scaled(sink, "lag-one", machine.out[0], n * n);
    if (what & VECTOR_NOISE) {
        put_scaled(sink, "process noise", machine.out[1], n);
        put_symmetric(sink, "process noise covariance", machine.out[2], n);
    }
}

static int smooth(words_in *in, const vector_sink *sink)
{
    const int process = take_number(in, -1, SLOTS - 1), what = take_number(in, 0, 15);
    if (!is_complete(in)) return -1;
    kq_history_q31 *h = &machine.history;
    const kq_smooth_extras_q31 extras = {what & VECTOR_LAG_ONE ? machine.out[0] : NULL,
                                         what & VECTOR_NOISE ? machine.out[1] : NULL,
                                         what & VECTOR_NOISE ? machine.out[2] : NULL};
    const kq_process_q31 *p = process < 0 ? NULL : &machine.process[process].process;
    const kq_status status = kq_smooth_step_q31(h, p, &extras);
    put_status(sink, status);
    if (status) return 0;
    const size_t t = (size_t)h->step;
    put_word(sink, "step", (int32_t)t);
    if (t + 1 < kq_history_steps_q31(h)) put_extras(sink, what);
    put_smoothed(sink, t, 1);
    if (what & VECTOR_COVARIANCE) {
        const kq_filter_q31 view = smoothed_view(t);
        put_word(sink, "covariance status", kq_covariance_q31(&view, machine.out[0]));
        put_symmetric(sink, "smoothed covariance", machine.out[0], machine.n);
    }
    if (what & VECTOR_READING_NOISE) put_reading_noise(sink);
    return 0;
}

static void put_all_smoothed(const vector_sink *sink, int with_sigma)
{
    const size_t steps = kq_history_steps_q31(&machine.history);
    for (size_t t = 0; t < steps; t++) put_smoothed(sink, t, with_sigma);
}

static int smooth_whole(words_in *in, const vector_sink *sink)
{
    const int states_only = take_number(in, 0, 1);
    if (!is_complete(in)) return -1;
    kq_history_q31 *h = &machine.history;
    const kq_status status = states_only ? kq_smooth_states_q31(h) : kq_smooth_q31(h);
    put_status(sink, status);
    if (!status) put_all_smoothed(sink, !states_only);
    return 0;
}

/* ------------------------------------------------------------------ operations */

#include "operations_adaptation.inc"
#include "operations_extended.inc"
#include "operations_on_line.inc"
#include "operations_robust.inc"
#include "operations_diffuse.inc"
#include "operations_statistics.inc"
#include "operations_steady.inc"

/* What there are operations for beside filter and smoother: all but where flash has no room for it
   (tests/target/CMakeLists.txt) */
#ifndef VECTOR_TOPICS
#define VECTOR_TOPICS 127
#endif
enum { ON_LINE = 1, ROBUST = 2, START = 4, STATISTICS = 8, STEADY = 16, ADAPTATION = 32, EXTENDED = 64 };
#define IF(topic, act) ((VECTOR_TOPICS) & (topic) ? (act) : NULL)

/* By their codes (README.md) */
static const struct {
    const char *name;
    int (*act)(words_in *in, const vector_sink *sink);
} operations[] = {
    [1] = {"states", set_states},
    [2] = {"process", set_process},
    [3] = {"sensor", set_sensor},
    [4] = {"prior", set_prior},
    [5] = {"history", attach},
    [6] = {"predict", predict},
    [7] = {"update", update},
    [8] = {"step", step},
    [9] = {"read", read_filter},
    [10] = {"look", look},
    [11] = {"forecast", forecast},
    [12] = {"change of transition", change_transition},
    [13] = {"change of measurement", change_measurement},
    [14] = {"clear events", clear_events},
    [15] = {"smooth", smooth},
    [16] = {"smooth all", smooth_whole},
    [17] = {"run", run},
    [18] = {"lag", IF(ON_LINE, attach_lag)},
    [19] = {"predict of the lag", IF(ON_LINE, predict_lag)},
    [20] = {"smooth the lag", IF(ON_LINE, smooth_lag)},
    [21] = {"point", IF(ON_LINE, attach_point)},
    [22] = {"predict of the point", IF(ON_LINE, predict)},
    [23] = {"smooth the point", IF(ON_LINE, smooth_point)},
    [24] = {"gains", IF(STEADY, make_gains)},
    [25] = {"steady-state filter", IF(STEADY, set_steady)},
    [26] = {"step of the steady-state filter", IF(STEADY, step_steady)},
    [27] = {"move", IF(EXTENDED, move)},
    [28] = {"switch", IF(STEADY, set_settling)},
    [29] = {"step of the switch", IF(STEADY, step_settling)},
    [30] = {"release of the switch", IF(STEADY, release_settling)},
    [31] = {"gate", IF(ROBUST, set_gate)},
    [32] = {"gated update", IF(ROBUST, update_gated)},
    [33] = {"weighted update", IF(ROBUST, update_weighted)},
    [34] = {"jump update", IF(ROBUST, update_jump)},
    [35] = {"scaled noise", IF(ROBUST, scale_noise)},
    [36] = {"extended update", IF(EXTENDED, update_extended)},
    [37] = {"smooth reweighted", IF(ROBUST, smooth_reweighted)},
    [38] = {"fade", IF(STATISTICS, fade)},
    [39] = {"least squares", IF(STATISTICS, set_fit)},
    [40] = {"rows of least squares", IF(STATISTICS, add_to_fit)},
    [41] = {"consistency", IF(STATISTICS, set_window)},
    [42] = {"watched update", IF(STATISTICS, update_watched)},
    [43] = {"statistics of the window", IF(STATISTICS, read_window)},
    [44] = {"unknown start", IF(START, set_start)},
    [45] = {"history of the start", IF(START, attach)},
    [46] = {"predict of the start", IF(START, predict_start)},
    [47] = {"update of the start", IF(START, update_start)},
    [48] = {"smooth the start", IF(START, smooth_start)},
    [49] = {"adaptation", IF(ADAPTATION, set_adaptation)},
    [50] = {"adapted predict", IF(ADAPTATION, predict)},
    [51] = {"adapted update", IF(ADAPTATION, update_adapted)},
    [52] = {"history of linearised steps", IF(EXTENDED, attach_extended)},
    [53] = {"Jacobian of the process", IF(EXTENDED, change_process_jacobian)},
    [54] = {"Jacobian of the sensor", IF(EXTENDED, change_sensor_jacobian)},
    [55] = {"extended predict", IF(EXTENDED, predict_extended)},
    [56] = {"lag for what is late", IF(ON_LINE, attach_delay)},
    [57] = {"late update", IF(ON_LINE, update_delayed)},
};

enum { OPERATIONS = sizeof operations / sizeof operations[0] };

static int is_operation(int32_t operation)
{
    return operation > VECTOR_END && operation < OPERATIONS && operations[operation].act;
}

const char *vector_name(int32_t operation)
{
    return is_operation(operation) ? operations[operation].name : "?";
}

int vector_steps(void) { return machine.step; }

int vector_operate(int32_t operation, const int32_t *in, size_t count, const vector_sink *sink)
{
    if (!is_operation(operation)) return -1;
    words_in words = {in, count, 0};
    return operations[operation].act(&words, sink);
}
