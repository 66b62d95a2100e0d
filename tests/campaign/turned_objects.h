/*
 * The objects beside process, sensor and filter, each at work: what `begin` makes in now.other and now.memory takes part in `step`, and
 * what it says is shown, at each step or at the end of the run.  A call that answers an error ends the run.
 */
#ifndef KALMANQ_TESTS_CAMPAIGN_TURNED_OBJECTS_H
#define KALMANQ_TESTS_CAMPAIGN_TURNED_OBJECTS_H

#include "turned.h"

enum { LATE = 3, ROWS = 20, WINDOW = 16 };

typedef struct {
    const char *name;
    int at; /* the step before which it begins */
    void (*begin)(const model *p);
    int (*step)(const model *p, int t); /* answers whether an error was answered */
    int (*end)(const model *p);         /* or NULL */
    size_t size, numbers;               /* of the object; of the coefficients that it uses */
    size_t words;                       /* of its memory */
    int most[2][2];                     /* of a hundred bits, of the object and of its memory: that mislead, that crash */
} scene;

#define TRY(call) do { if ((call) < 0) return 1; } while (0)

/* What was shown at each place of the undisturbed run; how far the one that is looked at is from that */
typedef struct {
    double mean[N], sigma[N];
} reading;
enum { NEAR, OFF, FAR, SHOWN = 400 };

static struct {
    world kept;
    num z[BEFORE + STEPS][M], u[BEFORE + STEPS][L];
    reading shown[SHOWN];
} *held; /* of the undisturbed run; not to be written while bits are turned */
static int is_twin, shown, how_far;
static unsigned seen; /* events */

static void show(const double *means, const double *sigmas, int n)
{
    need(shown < SHOWN ? KQ_OK : KQ_ERR_SIZE, "show");
    reading *r = &held->shown[shown++];
    for (int i = 0; i < n; i++) {
        if (is_twin) r->mean[i] = means[i], r->sigma[i] = sigmas[i];
        const double off = fabs(means[i] - r->mean[i]) / r->sigma[i], share = sigmas[i] / r->sigma[i];
        const int far = off <= 0.1 && fabs(share - 1) <= 0.01 ? NEAR : off <= 3 && share >= 0.5 && share <= 2 ? OFF : FAR;
        if (far > how_far) how_far = far;
    }
}

static void show_filter(const T(kq_filter) *f)
{
    double means[N], sigmas[N];
    for (int i = 0; i < f->states && i < N; i++) means[i] = mean(f, i), sigmas[i] = sigma(f, i);
    show(means, sigmas, f->states < N ? f->states : N);
    seen |= T(kq_events)(f);
}

static int moved(const model *p, int t)
{
    TRY(T(kq_predict)(&now.filter, &now.process, p->l ? held->u[t] : NULL));
    return 0;
}

static int filtered(const model *p, int t)
{
    if (moved(p, t)) return 1;
    TRY(T(kq_update)(&now.filter, &now.sensor, held->z[t]));
    return 0;
}

static int step_filter(const model *p, int t)
{
    if (filtered(p, t)) return 1;
    show_filter(&now.filter);
    return 0;
}

static void join(struct T(kq_attached) *attached) { need(T(kq_attach)(&now.filter, attached), "attach"); }

/* ------------------------------------------------------------------ the past */

static void begin_history(const model *p)
{
    need(T(kq_history_assign)(&now.other.history, p->n, now.memory, WORDS), "history");
    join(&now.other.history.attached);
}

static int end_history(const model *p)
{
    T(kq_filter) view = {0};
    (void)p;
    TRY(T(kq_smooth)(&now.other.history));
    if (T(kq_history_steps)(&now.other.history) > SHOWN / 2) return 1;
    for (size_t t = 0; t < T(kq_history_steps)(&now.other.history); t++) {
        TRY(T(kq_smoothed)(&now.other.history, t, &view));
        show_filter(&view);
    }
    return 0;
}

static void begin_lag(const model *p)
{
    need(T(kq_lag_assign)(&now.other.lag, p->n, p->m, LATE, now.memory, WORDS), "lag");
    join(&now.other.lag.attached);
}

static int step_lag(const model *p, int t)
{
    T(kq_filter) view = {0};
    if (filtered(p, t)) return 1;
    TRY(T(kq_lagged)(&now.other.lag, T(kq_lag_steps)(&now.other.lag), &view));
    show_filter(&view);
    return 0;
}

static void begin_delay(const model *p)
{
    need(T(kq_delay_assign)(&now.other.lag, p->n, p->m, LATE, now.memory, WORDS), "delay");
    join(&now.other.lag.attached);
}

/* Each third measurement comes two steps late. */
static int step_delay(const model *p, int t)
{
    if (t % 3 == 0 ? moved(p, t) : filtered(p, t)) return 1;
    if (t % 3 == 2) TRY(T(kq_update_delayed)(&now.other.lag, 2, &now.sensor, held->z[t - 2], UINT32_MAX));
    show_filter(&now.filter);
    return 0;
}

static void begin_instant(const model *p)
{
    need(T(kq_instant_assign)(&now.other.instant, p->n, p->m, now.memory, WORDS), "instant");
    join(&now.other.instant.attached);
}

static int step_instant(const model *p, int t)
{
    T(kq_filter) view = {0};
    if (filtered(p, t)) return 1;
    TRY(T(kq_instant_smooth)(&now.other.instant, &view));
    show_filter(&view);
    return 0;
}

static void begin_start(const model *p)
{
    T(kq_diffuse) *s = &now.other.start;
    need(T(kq_diffuse_assign)(s, p->n, 4, now.memory, WORDS), "start");
#if defined(KQ_TURNED_Q31)
    need(kq_diffuse_init_q31(s, &now.filter, &prior, UINT32_MAX, NULL), "start");
#else
    need(T(kq_diffuse_init)(s, &now.filter, x0, P0, UINT32_MAX), "start");
#endif
    need(T(kq_history_assign)(&now.tape, p->n, now.tape_memory, WORDS), "history");
    join(&now.tape.attached);
}

static int step_start(const model *p, int t) { return filtered(p, t); } /* means are missing at first */

static int end_start(const model *p)
{
    T(kq_filter) view = {0};
    (void)p;
    show_filter(&now.filter);
    TRY(T(kq_diffuse_smooth)(&now.other.start));
    for (size_t t = 0; t < STEPS; t++) {
        TRY(T(kq_diffuse_smoothed)(&now.other.start, t, &view));
        show_filter(&view);
    }
    return 0;
}

/* ------------------------------------------------------------------ what changes the gain */

static void begin_adaptation(const model *p)
{
    T(kq_adaptation) *a = &now.other.adaptation;
    const T(kq_adaptation_rule) rule = {KQ_ADAPT_BOTH, 50, NUMBER(0.1), NUMBER(0.001), NUMBER(1000), NUMBER(0.001), NUMBER(1000)};
#if defined(KQ_TURNED_Q31)
    need(kq_adaptation_assign_q31(a, p->n, p->m, now.numbers, NUMBERS, now.memory), "adaptation");
#else
    need(T(kq_adaptation_assign)(a, p->n, p->m, now.numbers, NUMBERS), "adaptation");
#endif
    need(T(kq_adaptation_init)(a, &now.process, &now.sensor, &rule), "adaptation");
    join(&a->attached);
}

static void begin_freeze(const model *p)
{
    need(T(kq_freeze_assign)(&now.other.freeze, p->n, p->m, now.memory, WORDS, now.numbers), "freeze");
    need(T(kq_freeze_init)(&now.other.freeze, 12), "freeze");
    join(&now.other.freeze.attached);
}

static int step_freeze(const model *p, int t)
{
    need(is_twin && t >= BEFORE && !T(kq_freeze_is_active)(&now.other.freeze) ? KQ_ERR_NOT_READY : KQ_OK, "a frozen step");
    TRY(T(kq_step)(&now.filter, &now.process, p->l ? held->u[t] : NULL, &now.sensor, held->z[t]));
    show_filter(&now.filter);
    return 0;
}

static void begin_student(const model *p)
{
    (void)p;
    now.other.loss = (T(kq_loss)){.kind = &T(kq_loss_student), .parameter = NUMBER(4), .weights = now.numbers};
}

static void begin_gate(const model *p)
{
    now.other.loss = (T(kq_loss)){.kind = &T(kq_loss_gate), .limit = T(kq_chi_square_limit)(p->m, KQ_LEVEL_9999)};
}

/* Each seventh measurement is another one: 40 steps old */
static int step_loss(const model *p, int t)
{
    if (moved(p, t)) return 1;
    TRY(T(kq_update_robust)(&now.filter, &now.sensor, held->z[t % 7 || t < 40 ? t : t - 40], UINT32_MAX, &now.other.loss));
    show_filter(&now.filter);
    return 0;
}

static void begin_steady(const model *p)
{
    num means[N];
    for (int i = 0; i < p->n; i++) means[i] = T(kq_mean)(&now.filter, i);
    need(T(kq_predict)(&now.filter, &now.process, NULL), "predict");
    need(T(kq_gain)(&now.filter, &now.sensor, now.numbers), "gain");
    need(T(kq_steady_assign)(&now.other.steady, p->n, p->m, now.memory, WORDS), "steady");
    need(T(kq_steady_init)(&now.other.steady, &now.process, &now.sensor, means, now.numbers, 1), "steady");
}

static int step_steady(const model *p, int t)
{
    double means[N], sigmas[N];
    TRY(T(kq_steady_step)(&now.other.steady, NULL, held->z[t]));
    for (int i = 0; i < p->n; i++) {
        sigmas[i] = sigma(&now.filter, i);
#if defined(KQ_TURNED_Q31)
        means[i] = value(i, kq_steady_mean_q31(&now.other.steady, i));
        seen |= kq_steady_events_q31(&now.other.steady);
#else
        means[i] = (double)T(kq_steady_mean)(&now.other.steady, i);
#endif
    }
    show(means, sigmas, p->n);
    return 0;
}

/* ------------------------------------------------------------------ statistics */

static void begin_window(const model *p)
{
    need(T(kq_consistency_assign)(&now.other.window, p->m, WINDOW, now.memory, WORDS), "window");
}

static int step_window(const model *p, int t)
{
    T(kq_consistency) *c = &now.other.window;
    const num *z = held->z[t];
    score s[7];
    if (moved(p, t)) return 1;
    TRY(T(kq_consistency_watch)(c, &now.filter, &now.sensor, z, UINT32_MAX));
    TRY(T(kq_update)(&now.filter, &now.sensor, z));
    TRY(T(kq_consistency_record)(c, &now.filter));
    TRY(T(kq_consistency_nis)(c, of_points(1), &s[0], &s[1], &s[2]));
    TRY(T(kq_consistency_innovation)(c, 0, of_points(1), &s[3], &s[4], &s[5], &s[6]));
    const double of[] = {points(s[0]), points(s[3]), points(s[5])};
    const double bounds[] = {(points(s[2]) - points(s[1])) / 2, points(s[4]), points(s[6])};
    if (t >= BEFORE) show(of, bounds, 3);
    return 0;
}

static void begin_fit(const model *p)
{
    (void)p;
#if defined(KQ_TURNED_Q31)
    need(kq_least_squares_init_q31(&now.other.fit, &now.filter, NUMBER(1), now.z), "fit");
#else
    need(T(kq_least_squares_init)(&now.other.fit, &now.filter, 1), "fit");
#endif
}

static int step_fit(const model *p, int t)
{
    (void)p;
#if defined(KQ_TURNED_Q31)
    const kq_scaled_q31 *r = now.noise;
#else
    const num *r = now.R;
#endif
    TRY(T(kq_least_squares_add)(&now.other.fit, now.H, held->z[t], r, 1));
    show_filter(&now.filter);
    return 0;
}

#if !defined(KQ_TURNED_Q31)

static num recorded[ROWS * M];
static T(kq_parameters) parameters;
static T(kq_recording) recording;

static void begin_em(const model *p)
{
    const struct { const num *at; size_t count; } from[] = {{now.A, 4}, {P0, 4}, {now.H, 2}, {now.R, 1}, {x0, 2}, {P0, 4}}; /* Q is I */
    num *at[6];
    for (int t = 0; t < ROWS; t++) recorded[t] = measured(t, 0);
    for (int k = 0; k < 6; k++) at[k] = memcpy(now.tape_memory + 4 * k, from[k].at, from[k].count * sizeof(num));
    parameters = (T(kq_parameters)){0, 0, at[0], NULL, NULL, at[1], at[2], at[3], at[4], at[5]};
    recording = (T(kq_recording)){ROWS, recorded, NULL, NULL};
    need(T(kq_em_assign)(&now.other.em, p->n, p->m, now.memory, WORDS), "em");
    need(T(kq_em_init)(&now.other.em, &parameters, NULL, &recording, 1), "em");
    need(T(kq_em_iterate)(&now.other.em), "em");
    for (int k = 0; k < ROWS; k++) need(T(kq_em_advance)(&now.other.em), "em"); /* half an E-step */
}

/* Five iterations; a sigma of a variance is taken for half of it */
static int step_em(const model *p, int t)
{
    if (t < BEFORE || t >= BEFORE + 5) return 0;
    do TRY(T(kq_em_advance)(&now.other.em));
    while (T(kq_em_remaining)(&now.other.em));
    TRY(T(kq_em_maximise)(&now.other.em));
    const double of[] = {(double)parameters.Q[0], (double)parameters.Q[p->n + 1], (double)parameters.R[0]};
    const double half[] = {(double)held->shown[shown].mean[0] / 2, held->shown[shown].mean[1] / 2, held->shown[shown].mean[2] / 2};
    const double own[] = {of[0] / 2, of[1] / 2, of[2] / 2};
    show(of, is_twin ? own : half, 3);
    return 0;
}

#endif

/* ------------------------------------------------------------------ all */

#define PLACE(of) sizeof(((object *)0)->of)

enum { EARLY = 10 };

static const scene scenes[] = {
    {"history", EARLY, begin_history, filtered, end_history, PLACE(history), 0, (size_t)LENGTH(HISTORY)(2, 1, BEFORE - EARLY + STEPS + 1, 0), {{5, 60}, {10, 2}}},
    {"lag", EARLY, begin_lag, step_lag, NULL, PLACE(lag), 0, (size_t)LENGTH(LAG)(2, 1, LATE), {{5, 55}, {1, 2}}},
    {"delay", EARLY, begin_delay, step_delay, NULL, PLACE(lag), 0, (size_t)LENGTH(LAG)(2, 1, LATE), {{5, 40}, {1, 0}}},
    {"instant", EARLY, begin_instant, step_instant, NULL, PLACE(instant), 0, (size_t)LENGTH(INSTANT)(2, 1), {{10, 60}, {5, 2}}},
    {"diffuse start", BEFORE - 1, begin_start, step_start, end_start, PLACE(start), 0, (size_t)LENGTH(DIFFUSE)(2, 4), {{10, 60}, {5, 3}}},
#if defined(KQ_TURNED_Q31)
    {"adaptation", EARLY, begin_adaptation, step_filter, NULL, PLACE(adaptation), KQ_ADAPTATION_LEN_Q31(2, 1), KQ_ROOT_LEN_Q31(2), {{5, 15}, {5, 3}}},
#else
    {"adaptation", EARLY, begin_adaptation, step_filter, NULL, PLACE(adaptation), KQ_ADAPTATION_LEN_F32(2, 1), 0, {{5, 15}, {5, 3}}},
    {"em", BEFORE, begin_em, step_em, NULL, PLACE(em), 0, (size_t)LENGTH(EM)(2, 1, ROWS), {{1, 35}, {1, 0}}},
#endif
    {"freeze", EARLY, begin_freeze, step_freeze, NULL, PLACE(freeze), 2, (size_t)LENGTH(FREEZE)(2), {{5, 35}, {20, 0}}},
    {"loss, gate", EARLY, begin_gate, step_loss, NULL, PLACE(loss), 0, 0, {{5, 30}, {0, 0}}},
    {"loss, Student", EARLY, begin_student, step_loss, NULL, PLACE(loss), 1, 0, {{5, 55}, {1, 0}}},
    {"steady", BEFORE, begin_steady, step_steady, NULL, PLACE(steady), 2, (size_t)LENGTH(STEADY)(2), {{30, 70}, {20, 0}}},
    {"consistency", EARLY, begin_window, step_window, NULL, PLACE(window), 0, (size_t)LENGTH(CONSISTENCY)(1, WINDOW), {{10, 65}, {1, 0}}},
    {"least squares", EARLY, begin_fit, step_fit, NULL, PLACE(fit), 0, 0, {{5, 35}, {0, 0}}},
};
enum { SCENES = sizeof scenes / sizeof *scenes };

static const scene alone = {"filter", BEFORE, NULL, step_filter, NULL, 0, 0, 0, {{0}}};

#endif
