/*
 * Random models through every function of the q31 arithmetic, under the sanitizers and over the
 * checked number layer, with what must hold checked after every call; and tables with random bits
 * turned over, which are refused or run without harm.
 *
 *     fuzz_q31 [models [seed [first]]]
 *
 * A model depends on the seed and its own number only.  What goes wrong stops the program, and says
 * which model it was: `fuzz_q31 1 seed number` runs that one alone.
 */
#include <signal.h>
#include <unistd.h>

#include "invariants.h"
#include "sites.h"

#define STEPS 60

/* What rounding may make of P_s <= P_f, in variances: a root is exact to about n 2^-29 an
   operation, and a step may have hundreds of them. */
#define LEEWAY 0x1p-16

/* Where the run is: for the last words of a program that stops */
static long current, current_seed;

typedef struct {
    model m;
    kq_filter_q31 filter, ahead;
    kq_history_q31 history;
    unsigned events;                    /* that were cleared */
    int calm;                           /* measurements near what the state implies */
    int taped;                          /* a history is attached, */
    int steps;                          /* of so many steps */
    kq_scaled_q31 *filtered[STEPS + 1]; /* P before each predict */
} run;

static size_t filter_words(int n) { return (size_t)KQ_FILTER_LEN_Q31(n); }

/* ------------------------------------------------------------------ refused calls */

/* A call with words out of range leaves the filter as it is, byte for byte. */
static void check_refusal(run *r, const kq_process_q31 *p, const kq_sensor_q31 *s, int32_t *u,
                          int32_t *z)
{
    kq_filter_q31 *f = &r->filter, before = *f;
    int32_t memory[KQ_FILTER_LEN_Q31(KQ_SIZE_MAX)];
    const size_t bytes = filter_words(f->states) * sizeof(int32_t);
    const int c = between(0, s->components - 1);
    const int32_t range = s->measurement_format[c].range, good = z[c];
    memcpy(memory, f->memory, bytes);
    z[c] = chance(0.2) || range == INT32_MAX ? INT32_MIN : chance(0.5) ? range + 1 : -range - 1;
    demand(kq_update_q31(f, s, z) == KQ_ERR_RANGE, "z out of range", z[c]);
    demand(kq_step_q31(f, p, u, s, z) == KQ_ERR_RANGE, "z out of range", z[c]);
    demand(kq_update_subset_q31(f, s, z, UINT32_C(1) << c) == KQ_ERR_RANGE, "z in subset", z[c]);
    z[c] = good;
    if (p->controls) {
        const int32_t driven = u[0];
        u[0] = INT32_MIN;
        demand(kq_predict_q31(f, p, u) == KQ_ERR_RANGE, "u out of range", u[0]);
        u[0] = driven;
    }
    demand(memcmp(&before, f, sizeof before) == 0, "a refused call changed the filter", 0);
    demand(memcmp(memory, f->memory, bytes) == 0, "a refused call changed the memory", 0);
}

/* ------------------------------------------------------------------ calls that read */

static void check_forecast(run *r, const kq_process_q31 *p)
{
    const int steps = between(0, 4);
    int32_t *u = malloc(sizeof *u * (size_t)(steps * p->controls + 1));
    for (int k = 0; k < steps * p->controls; k++) {
        u[k] = random_word(p->control_format[k % p->controls].range);
    }
    must(kq_forecast_q31(&r->filter, p, chance(0.7) ? u : NULL, (size_t)steps, &r->ahead), "forecast");
    check_filter(&r->ahead);
    free(u);
}

static void check_sensor_readers(const kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z)
{
    const int n = f->states, m = s->components;
    kq_scaled_q31 *K = malloc(sizeof *K * (size_t)(n * m)),
                  *S = malloc(sizeof *S * (size_t)(m * m));
    int32_t *e = malloc(sizeof *e * (size_t)m);
    must(kq_gain_q31(f, s, K), "gain");
    check_scaled(K, n * m, "gain: not normalised");
    must(kq_measurement_q31(f, s, e, S), "measurement");
    check_scaled(S, m * m, "S: not normalised");
    for (int c = 0; c < m; c++) {
        demand(S[c * m + c].mantissa >= 0, "innovation variance < 0", c);
        demand(e[c] != KQ_NOT_A_VALUE_Q31, "measurement is not a word", c);
    }
    must(kq_innovation_q31(f, s, z, e), "innovation");
    for (int c = 0; c < m; c++) demand(e[c] != KQ_NOT_A_VALUE_Q31, "innovation is not a word", c);
    free(K), free(S), free(e);
}

/* ------------------------------------------------------------------ calls that move */

static void note_filtered(run *r)
{
    if (!r->taped || r->steps > STEPS) return;
    must(kq_covariance_q31(&r->filter, r->filtered[r->steps - 1]), "covariance");
}

static void random_words(int32_t *words, const kq_format_q31 *format, int count)
{
    for (int k = 0; k < count; k++) words[k] = random_word(format[k].range);
}

/* A measurement near the state, so that the filter is not always far off */
static void likely_words(const kq_filter_q31 *f, const kq_sensor_q31 *s, int32_t *z)
{
    must(kq_measurement_q31(f, s, z, NULL), "measurement");
    for (int c = 0; c < s->components; c++) {
        const int32_t range = s->measurement_format[c].range;
        const int64_t near = (int64_t)z[c] + random_word(chance(0.5) ? 100000 : 10);
        z[c] = near > range ? range : near < -range ? -range : (int32_t)near;
    }
}

static void clear_events(run *r)
{
    r->events |= kq_events_q31(&r->filter);
    kq_events_clear_q31(&r->filter);
    demand(kq_events_q31(&r->filter) == 0, "events are not cleared", 0);
}

static void random_call(run *r)
{
    kq_process_q31 *p = &r->m.process[chance(0.1)];
    kq_sensor_q31 *s = &r->m.sensor[between(0, r->m.sensors - 1)];
    kq_filter_q31 *f = &r->filter;
    int32_t *u = malloc(sizeof *u * (size_t)(p->controls + 1));
    int32_t *z = malloc(sizeof *z * (size_t)s->components);
    random_words(u, p->control_format, p->controls);
    for (int k = 0; r->calm && k < p->controls; k++) u[k] /= 1 << 16;
    if (r->calm || chance(0.2)) likely_words(f, s, z);
    else random_words(z, s->measurement_format, s->components);
    if (chance(0.1)) check_refusal(r, p, s, u, z);
    if (chance(0.1)) check_forecast(r, p);
    if (chance(0.1)) check_sensor_readers(f, s, z);
    if (chance(0.05)) clear_events(r);
    note_filtered(r);
    switch (between(0, 5)) {
    case 0:
    case 1: must(kq_predict_q31(f, p, chance(0.8) ? u : NULL), "predict"), r->steps++; break;
    case 2:
    case 3: must(kq_update_q31(f, s, z), "update"); break;
    case 4: must(kq_update_subset_q31(f, s, z, (uint32_t)random_bits()), "subset"); break;
    default: must(kq_step_q31(f, p, chance(0.8) ? u : NULL, s, z), "step"), r->steps++;
    }
    check_filter(f);
    must(kq_process_check_q31(p), "kq_process_check_q31");
    must(kq_sensor_check_q31(s), "kq_sensor_check_q31");
    free(u), free(z);
}

/* The other process's transition, another sensor's row: taken, or refused by its sums. */
static void change_models(run *r)
{
    model *m = &r->m;
    const kq_status process =
        kq_process_change_transition_q31(&m->process[0], m->process_table[1].transition, NULL);
    demand(process == KQ_OK || process == KQ_ERR_RANGE || process == KQ_ERR_COEFFICIENT,
           "change_transition", process);
    kq_sensor_q31 *last = &m->sensor[m->sensors - 1];
    if (last->components > m->sensor[0].components) return;
    must(kq_sensor_change_measurement_q31(last, m->sensor[0].measurement, NULL), "change_measurement");
}

/* ------------------------------------------------------------------ smoothing */

/* A smoothed step: a mean within its word, a covariance, not above the filtered one */
static void check_smoothed(const run *r, size_t t)
{
    const kq_history_q31 *h = &r->history;
    const int n = r->m.n;
    kq_scaled_q31 P[KQ_SIZE_MAX * KQ_SIZE_MAX];
    kq_filter_q31 view;
    must(kq_smoothed_q31(h, t, &view), "smoothed");
    for (int i = 0; i < n; i++) {
        demand(kq_mean_q31(&view, i) != KQ_NOT_A_VALUE_Q31, "smoothed mean", i);
        demand(kq_sigma_q31(&view, i) >= 0, "smoothed sigma", i);
    }
    must(kq_covariance_q31(&view, P), "smoothed covariance");
    check_covariance(P, n);
    check_not_above(P, r->filtered[t], n, LEEWAY);
}

static void check_smoothed_noises(const kq_history_q31 *h)
{
    kq_scaled_q31 mean, variance;
    for (int k = 0; kq_smoothed_measurement_noise_q31(h, k, &mean, &variance) == KQ_OK; k++) {
        check_scaled(&mean, 1, "noise mean: not normalised");
        check_scaled(&variance, 1, "noise variance: not normalised");
        demand(variance.mantissa >= 0, "noise variance < 0", variance.mantissa);
    }
}

static void smooth_by_steps(run *r)
{
    kq_history_q31 *h = &r->history;
    const int n = r->m.n;
    const size_t square = (size_t)(n * n), steps = kq_history_steps_q31(h);
    kq_smooth_extras_q31 extras = {malloc(sizeof(kq_scaled_q31) * square),
                                   malloc(sizeof(kq_scaled_q31) * (size_t)n),
                                   malloc(sizeof(kq_scaled_q31) * square)};
    for (size_t t = steps; t-- > 0;) {
        must(kq_smooth_step_q31(h, NULL, &extras), "smooth_step");
        check_smoothed(r, t);
        check_smoothed_noises(h);
        if (t == steps - 1) continue;
        check_scaled(extras.lag_one, n * n, "lag_one: not normalised");
        check_scaled(extras.noise_mean, n, "noise_mean: not normalised");
        check_covariance(extras.noise_covariance, n);
        seen.calls++;
    }
    free(extras.lag_one), free(extras.noise_mean), free(extras.noise_covariance);
}

static void smooth_states(run *r)
{
    kq_history_q31 *h = &r->history;
    must(kq_smooth_states_q31(h), "smooth_states");
    for (size_t t = 0; t < kq_history_steps_q31(h); t++) {
        kq_filter_q31 view;
        must(kq_smoothed_q31(h, t, &view), "smoothed");
        for (int i = 0; i < r->m.n; i++) {
            demand(kq_mean_q31(&view, i) != KQ_NOT_A_VALUE_Q31, "smoothed mean", i);
        }
    }
    seen.calls++;
}

static void smooth(run *r)
{
    kq_history_q31 *h = &r->history;
    note_filtered(r);
    r->taped = 0;
    clear_events(r);
    if (r->events & KQ_EVENT_HISTORY_FULL) {
        demand(kq_smooth_q31(h) == KQ_ERR_HISTORY_FULL, "a full history was smoothed", 0);
        return;
    }
    switch (between(0, 2)) {
    case 0: smooth_by_steps(r); break;
    case 1: smooth_states(r); break;
    default:
        must(kq_smooth_q31(h), "smooth");
        for (size_t t = 0; t < kq_history_steps_q31(h); t++) check_smoothed(r, t);
        seen.calls++;
    }
}

static void attach(run *r)
{
    const int n = r->m.n;
    const int length = (int)KQ_HISTORY_LEN_Q31(n, between(1, 12), between(1, STEPS), between(0, 9));
    must(kq_history_assign_q31(&r->history, n, TAKE(int32_t, length), (size_t)length), "history");
    must(kq_attach_q31(&r->filter, &r->history.attached), "attach");
    for (int t = 0; t <= STEPS; t++) {
        if (!r->filtered[t]) r->filtered[t] = TAKE(kq_scaled_q31, n * n);
    }
    r->steps = 1;
    r->taped = 1;
}

/* ------------------------------------------------------------------ one model */

static void begin(run *r)
{
    const int n = r->m.n, length = KQ_FILTER_LEN_Q31(n);
    must(kq_filter_assign_q31(&r->filter, n, TAKE(int32_t, length), (size_t)length), "filter");
    must(kq_filter_assign_q31(&r->ahead, n, TAKE(int32_t, length), (size_t)length), "ahead");
    must(kq_filter_init_q31(&r->filter, &r->m.prior, NULL), "filter_init");
    check_filter(&r->filter);
}

/* As many calls as the history of STEPS steps can take, then smoothed; then a few more */
static void calls_and_smoothing(run *r)
{
    if (chance(0.8)) attach(r);
    const int calls = between(5, STEPS);
    for (int k = 0; k < calls; k++) random_call(r);
    if (!r->taped) return;
    smooth(r);
    for (int k = 0; k < 5; k++) random_call(r);
}

/* One process alone for long: what grows has to be held. */
static void predict_for_long(run *r)
{
    for (int k = 0; k < 2500; k++) {
        must(kq_predict_q31(&r->filter, &r->m.process[0], NULL), "predict");
        if (k % 100 == 0) check_filter(&r->filter);
    }
    check_filter(&r->filter);
    for (int k = 0; k < 20; k++) random_call(r);
}

/* One sensor alone for long: what shrinks stays a covariance. */
static void measure_for_long(run *r)
{
    const kq_sensor_q31 *s = &r->m.sensor[0];
    int32_t z[KQ_SIZE_MAX];
    for (int k = 0; k < 500; k++) {
        likely_words(&r->filter, s, z);
        must(kq_update_q31(&r->filter, s, z), "update");
        if (k % 50 == 0) check_filter(&r->filter);
    }
    check_filter(&r->filter);
}

/* A scale is within its limits, 2^-20 and 2^20. */
static void check_scale(kq_scaled_q31 scale)
{
    demand(scale.mantissa >= 1 << 30, "a scale is not normalised, or not positive", 0);
    const int is_most = scale.exponent == -10 && scale.mantissa == 1 << 30;
    demand(scale.exponent >= -50 && (scale.exponent < -10 || is_most), "limits of a scale", 0);
}

/* The noise scales of one process and one sensor learnt from anything: refused, where the noise
   times the limits is none of a table's, or without harm. */
static void adapt(run *r)
{
    static const kq_scaled_q31 least = {1 << 30, -50}, most = {1 << 30, -10}, step = {1 << 30, -31};
    const kq_sensor_q31 *s = &r->m.sensor[0];
    const int n = r->m.n, m = s->components, length = KQ_ADAPTATION_LEN_Q31(n, m);
    const kq_adaptation_rule_q31 rule = {(kq_adapted)between(KQ_ADAPT_BOTH, KQ_ADAPT_SENSOR),
                                         between(10, 50),
                                         step,
                                         least,
                                         most,
                                         least,
                                         most};
    kq_adaptation_q31 a;
    int32_t z[KQ_SIZE_MAX];
    must(kq_filter_init_q31(&r->filter, &r->m.prior, NULL), "filter_init");
    must(kq_adaptation_assign_q31(&a, n, m, TAKE(kq_scaled_q31, length), (size_t)length,
                                  TAKE(int32_t, KQ_ROOT_LEN_Q31(n))),
         "adaptation");
    const kq_status status = kq_adaptation_init_q31(&a, &r->m.process[0], s, &rule);
    demand(status == KQ_OK || status == KQ_ERR_COEFFICIENT, "adaptation_init", status);
    if (!status) must(kq_attach_q31(&r->filter, &a.attached), "adaptation_attach");
    for (int k = 0; !status && k < 100; k++) {
        if (r->calm) likely_words(&r->filter, s, z);
        else random_words(z, s->measurement_format, m);
        const uint32_t present = chance(0.5) ? UINT32_MAX : (uint32_t)random_bits();
        must(kq_update_subset_q31(&r->filter, s, z, present), "adaptation, update");
        if (chance(0.8)) {
            const kq_process_q31 *p = &r->m.process[chance(0.1)]; /* the other one teaches nothing */
            must(kq_predict_q31(&r->filter, p, NULL), "adaptation, predict");
        }
        kq_scaled_q31 scale_q, scale_r;
        must(kq_adaptation_scales_q31(&a, &scale_q, &scale_r), "adaptation_scales");
        check_scale(scale_q);
        check_scale(scale_r);
        check_filter(&r->filter);
    }
    if (!status) must(kq_detach_q31(&a.attached), "adaptation_detach");
}

static void run_model(run *r)
{
    begin(r);
    calls_and_smoothing(r);
    if (chance(0.2)) change_models(r);
    if (chance(0.1)) must(kq_filter_init_q31(&r->filter, &r->m.prior, NULL), "filter_init");
    for (int k = 0; k < 5; k++) random_call(r);
    if (chance(0.02)) predict_for_long(r);
    if (chance(0.05)) measure_for_long(r);
    if (chance(0.2)) adapt(r);
    clear_events(r);
    seen.saturated += (r->events & KQ_EVENT_SATURATED) != 0;
    seen.models++;
}

/* ------------------------------------------------------------------ corrupted tables */

static void flip(void *bytes, size_t size, int bits)
{
    for (; bits > 0; bits--) {
        const size_t at = (size_t)(random_bits() % (8 * size));
        ((unsigned char *)bytes)[at / 8] ^= (unsigned char)(1u << at % 8);
    }
}

/* Some bits of an array of `count` entries that are in use */
#define FLIP(array, count) flip((void *)(array), sizeof *(array) * (size_t)(count), between(1, 3))

/* One or two places; the pointers stay, and where they point to is as long as any size needs. */
static void corrupt(model *m)
{
    kq_process_table_q31 *p = &m->process_table[0];
    kq_sensor_table_q31 *s = &m->sensor_table[0];
    kq_prior_table_q31 *x = &m->prior;
    const int n = m->n, c = s->components, l = p->controls, correlated = s->correlated;
    for (int k = between(1, 2); k > 0; k--) {
        switch (between(0, 13)) {
        case 0: FLIP(p->transition, n * n); break;
        case 1: FLIP(p->control, n * l + 1); break;
        case 2: FLIP(p->noise_root, KQ_ROOT_LEN_Q31(n)); break;
        case 3: FLIP(p->state_format, n); break;
        case 4: FLIP(p->control_format, l + 1); break;
        case 5: flip(&p->states, sizeof p->states, 1); break;
        case 6: flip(&p->controls, sizeof p->controls, 1); break;
        case 7: FLIP(s->measurement, c * n); break;
        case 8: FLIP(s->measurement_format, c); break;
        case 9: FLIP(s->noise, correlated ? KQ_TRIANGLE(c) : c); break;
        case 10: flip(&s->components, sizeof s->components, 1); break;
        case 11: flip(&s->correlated, sizeof s->correlated, 1); break;
        case 12: FLIP(x->mean, n); break;
        default: FLIP(x->root, KQ_ROOT_LEN_Q31(n));
        }
    }
}

static void run_corrupted(run *r)
{
    model *m = &r->m;
    corrupt(m);
    const int length = KQ_FILTER_LEN_Q31(m->n);
    kq_status status = kq_process_init_q31(&m->process[0], &m->process_table[0], NULL);
    if (!status) status = kq_sensor_init_q31(&m->sensor[0], &m->sensor_table[0], NULL);
    must(kq_filter_assign_q31(&r->filter, m->n, TAKE(int32_t, length), (size_t)length), "filter");
    must(kq_filter_assign_q31(&r->ahead, m->n, TAKE(int32_t, length), (size_t)length), "ahead");
    if (!status) status = kq_filter_init_q31(&r->filter, &m->prior, NULL);
    if (!status && m->process[0].states != m->n) status = KQ_ERR_MISMATCH;
    if (!status && m->sensor[0].states != m->n) status = KQ_ERR_MISMATCH;
    if (status) {
        seen.refused_tables++;
        return;
    }
    check_filter(&r->filter);
    calls_and_smoothing(r);
    seen.accepted_tables++;
}

/* ------------------------------------------------------------------ the program */

static void last_words(int number)
{
    (void)number;
    char text[64];
    const int length =
        snprintf(text, sizeof text, "model: fuzz_q31 1 %ld %ld\n", current_seed, current);
    if (write(STDERR_FILENO, text, (size_t)length) != length) _exit(3);
    signal(SIGABRT, SIG_DFL);
}

const char *__asan_default_options(void);
const char *__ubsan_default_options(void);
const char *__asan_default_options(void) { return "abort_on_error=1"; }
const char *__ubsan_default_options(void) { return "abort_on_error=1:print_stacktrace=1"; }

static void run_number(long number)
{
    run r;
    memset(&r, 0, sizeof r);
    current = number;
    random_state = (uint64_t)current_seed * UINT64_C(0x9e3779b97f4a7c15) ^ (uint64_t)number << 20;
    (void)random_bits();
    room_is_largest = chance(0.2);
    r.calm = chance(0.6);
    random_model(&r.m);
    for (int i = 0; r.calm && i < r.m.n; i++) ((int32_t *)r.m.prior.mean)[i] /= 1 << 12;
    if (room_is_largest) run_corrupted(&r);
    else run_model(&r);
    give_back();
}

int main(int argc, char **argv)
{
    const long count = argc > 1 ? atol(argv[1]) : 2000, first = argc > 3 ? atol(argv[3]) : 0;
    current_seed = argc > 2 ? atol(argv[2]) : 1;
    signal(SIGABRT, last_words);
    for (long k = 0; k < count; k++) run_number(first + k);
    if (getenv("KALMANQ_BOUNDS")) checked_report(atof(getenv("KALMANQ_BOUNDS")));
    printf("models %ld, corrupted tables refused %ld, accepted %ld, calls %ld, models with a "
           "saturated state %ld, worst row norm / 2^30 %.12f, smoothed above filtered %.3g\n",
           seen.models, seen.refused_tables, seen.accepted_tables, seen.calls, seen.saturated,
           seen.worst_norm, seen.worst_growth);
    return 0;
}
