/*
 * Bytes as calls: every object of f32 or f64 (KQ_FUZZ_F64), 1 to 16 states, attached, used and detached in any order, with numbers
 * from ordinary to absurd.  For libFuzzer, and for replay.c, which runs the recorded inputs every day, under the sanitizers.
 *
 * What must hold after every call: a refused one has changed nothing; the filter is intact; a mean or sigma that is not finite has its
 * event, and so has a correlation above 1; a step is predict and update.  Memory has exactly the lengths that the headers say.
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kalmanq/kalmanq.h"

#ifdef KQ_FUZZ_F64
typedef double num;
#define K(name) kq_##name##_f64
#define LENGTH(name) KQ_##name##_LEN_F64
#define ROUNDING 1e-6 /* of a correlation: from a covariance that is rounded */
#define TINY 0x1p-200  /* a sigma below it is noise to the arithmetic (process.h) */
#else
typedef float num;
#define K(name) kq_##name##_f32
#define LENGTH(name) KQ_##name##_LEN_F32
#define ROUNDING 1e-3
#define TINY 0x1p-60
#endif

enum { MOST = KQ_SIZE_MAX, SQUARE = MOST * MOST, STEPS = 12, LAG = 3, WINDOW = 4, OBJECTS = 7, SENSORS = 3 };

static const uint8_t *at, *end;

static unsigned byte(void) { return at < end ? *at++ : 0; }

static unsigned below(unsigned count) { return byte() % count; }

static num number(void)
{
    static const num absurd[] = {0, 1, -1, (num)1e-30, (num)1e30, (num)-1e-18, (num)1e18, (num)1e-6, 1000, (num)0x1p-100, (num)0x1p60, (num)-0x1p60};
    const unsigned kind = byte();
    if (kind == 255) return (num)(byte() & 1 ? NAN : INFINITY);
    if (kind >= 240) return absurd[below(sizeof absurd / sizeof *absurd)];
    if (kind >= 220) return 0;
    return (num)ldexp((double)kind - 110, -(int)below(12));
}

static void numbers(num *to, int count)
{
    for (int k = 0; k < count; k++) to[k] = number();
}

/* A covariance F F' of n, of some rank; or anything, which is refused */
static void covariance(num *P, int n)
{
    num F[SQUARE];
    const int rank = (int)below((unsigned)n + 1);
    if (byte() > 250) {
        numbers(P, n * n);
        return;
    }
    numbers(F, n * rank);
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            num sum = 0;
            for (int k = 0; k < rank; k++) sum += F[i * rank + k] * F[j * rank + k];
            P[i * n + j] = P[j * n + i] = sum;
        }
}

/* Memory of exactly so many words, gone after the input */
static void *kept[64];
static int count_kept;

static num *words(size_t count)
{
    num *made = calloc(count ? count : 1, sizeof *made);
    if (!made || count_kept == 64) abort();
    return kept[count_kept++] = made;
}

static struct {
    int n, l, m[SENSORS];
    num A[2][SQUARE], B[SQUARE], Q[SQUARE], H[SENSORS][SQUARE], R[SENSORS][SQUARE], x0[MOST], P0[SQUARE], gain[SQUARE];
    K(process) process[2], scaled;
    K(sensor) sensor[SENSORS];
    K(filter) filter, twin, ahead;
    K(history) history;
    K(lag) lag, delay;
    K(instant) instant;
    K(adaptation) adaptation;
    K(freeze) freeze;
    K(diffuse) diffuse;
    K(consistency) consistency;
    K(loss) gate;
    num weights[MOST];
} own;

static void fail(const char *what, int line)
{
    fprintf(stderr, "fuzz_objects.c:%d: %s (n = %d)\n", line, what, own.n);
    abort();
}

#define DEMAND(good) ((good) ? (void)0 : fail(#good, __LINE__))

/* ------------------------------------------------------------------ what must hold */

static K(filter) before;
static num memory_before[KQ_FILTER_LEN_F32(MOST)];

static void note(void)
{
    before = own.filter;
    memcpy(memory_before, own.filter.memory, sizeof(num) * (size_t)LENGTH(FILTER)(own.n));
}

/* A refused call has changed nothing */
static kq_status judged(kq_status status)
{
    DEMAND(strcmp(kq_status_text(status), "unknown status") != 0 && status != KQ_ERR_ARITHMETIC);
    if (status < 0) {
        DEMAND(memcmp(&before, &own.filter, sizeof before) == 0);
        DEMAND(memcmp(memory_before, own.filter.memory, sizeof(num) * (size_t)LENGTH(FILTER)(own.n)) == 0);
    }
    return status;
}

static void sane_of(const K(filter) * f, int is_smoothed)
{
    num P[SQUARE];
    const int n = f->states, is_told = (K(events)(f) & (KQ_EVENT_OVERFLOW | KQ_EVENT_SATURATED)) != 0;
    if (K(covariance)(f, P) != KQ_OK) return; /* of a view that has no covariance, or a filter without a start */
    for (int i = 0; i < n; i++) {
        const num sigma = K(sigma)(f, i);
        DEMAND(sigma >= 0 && (isfinite(sigma) || is_told) && (isfinite(K(mean)(f, i)) || is_told));
        for (int j = 0; j < i; j++) {
            DEMAND(P[i * n + j] == P[j * n + i]);
            const double other = (double)K(sigma)(f, j), most = (double)sigma * other * (1 + ROUNDING) + TINY * ((double)sigma + other + 1);
            DEMAND(is_told || fabs((double)P[i * n + j]) <= most);
        }
    }
}

static void sane(const K(filter) * f) { sane_of(f, 0); }

/* ------------------------------------------------------------------ objects */

static void make_models(void)
{
    const int n = own.n = (int)below(MOST) + 1, l = own.l = (int)below(3);
    for (int k = 0; k < 2; k++) {
        numbers(own.A[k], n * n);
        for (int i = 0; byte() < 200 && i < n; i++) own.A[k][i * n + i] = 1;
    }
    numbers(own.B, n * l);
    covariance(own.Q, n);
    for (int k = 0; k < 2; k++) {
        DEMAND(K(process_assign)(&own.process[k], n, l, words(KQ_PROCESS_LEN((size_t)n)), KQ_PROCESS_LEN((size_t)n)) == KQ_OK);
        (void)!K(process_init)(&own.process[k], own.A[k], l ? own.B : NULL, own.Q);
    }
    DEMAND(K(process_assign)(&own.scaled, n, l, words(KQ_PROCESS_LEN((size_t)n)), KQ_PROCESS_LEN((size_t)n)) == KQ_OK);
}

static void make_sensors(void)
{
    for (int k = 0; k < SENSORS; k++) {
        const int m = own.m[k] = (int)below(k ? 4 : MOST) + 1;
        K(sensor) *s = &own.sensor[k];
        numbers(own.H[k], m * own.n);
        covariance(own.R[k], m);
        DEMAND(K(sensor_assign)(s, own.n, m, words((size_t)KQ_SENSOR_LEN(m)), (size_t)KQ_SENSOR_LEN(m)) == KQ_OK);
        for (int c = 0; c < m && k; c++) own.R[k][c] = own.R[k][c * m + c]; /* variances */
        (void)!(k == 0 ? K(sensor_init)(s, own.H[k], own.R[k]) : k == 1 ? K(sensor_init_lean)(s, own.H[k], own.R[k])
                                                                        : K(sensor_init_diagonal)(s, own.H[k], own.R[k]));
    }
}

static void make_filters(void)
{
    const int n = own.n;
    const size_t length = (size_t)LENGTH(FILTER)(n);
    DEMAND(K(filter_assign)(&own.filter, n, words(length), length) == KQ_OK);
    DEMAND(K(filter_assign)(&own.twin, n, words(length), length) == KQ_OK);
    DEMAND(K(filter_assign)(&own.ahead, n, words(length), length) == KQ_OK);
    numbers(own.x0, n);
    covariance(own.P0, n);
    note();
    (void)!judged(K(filter_init)(&own.filter, own.x0, own.P0));
}

static void make_objects(void)
{
    const int n = own.n, m = own.m[0];
    size_t length = LENGTH(HISTORY)(n, m, below(STEPS) + 1, below(3));
    DEMAND(K(history_assign)(&own.history, n, words(length), length) == KQ_OK);
    length = LENGTH(LAG)(n, m, LAG);
    DEMAND(K(lag_assign)(&own.lag, n, m, LAG, words(length), length) == KQ_OK);
    DEMAND(K(delay_assign)(&own.delay, n, m, LAG, words(length), length) == KQ_OK);
    length = LENGTH(INSTANT)(n, m);
    DEMAND(K(instant_assign)(&own.instant, n, m, words(length), length) == KQ_OK);
    length = (size_t)LENGTH(ADAPTATION)(n, own.m[1]);
    DEMAND(K(adaptation_assign)(&own.adaptation, n, own.m[1], words(length), length) == KQ_OK);
    const K(adaptation_rule) rule = {(kq_adapted)below(3), 100, (num)0.1, (num)0.001, 1000, (num)0.001, 1000};
    (void)!K(adaptation_init)(&own.adaptation, &own.process[0], &own.sensor[1], &rule);
    DEMAND(K(freeze_assign)(&own.freeze, n, own.m[0], words((size_t)KQ_TRIANGLE(n)), (size_t)KQ_TRIANGLE(n), own.gain) == KQ_OK);
    (void)!K(freeze_init)(&own.freeze, (int)below(19));
    length = LENGTH(DIFFUSE)(n, 3);
    DEMAND(K(diffuse_assign)(&own.diffuse, n, 3, words(length), length) == KQ_OK);
    length = (size_t)LENGTH(CONSISTENCY)(own.m[0], WINDOW);
    DEMAND(K(consistency_assign)(&own.consistency, own.m[0], WINDOW, words(length), length) == KQ_OK);
}

static struct K(attached) * object(void)
{
    struct K(attached) *of[OBJECTS] = {&own.history.attached, &own.lag.attached, &own.delay.attached, &own.instant.attached,
        &own.adaptation.attached, &own.freeze.attached, &own.diffuse.attached};
    return of[below(OBJECTS)];
}

/* ------------------------------------------------------------------ calls */

static void update(unsigned how)
{
    const unsigned k = below(SENSORS);
    const K(sensor) *s = &own.sensor[k];
    const K(process) *p = &own.process[below(8) == 7];
    num z[MOST], u[MOST];
    const uint32_t present = byte() < 200 ? UINT32_MAX : byte();
    numbers(z, own.m[k]), numbers(u, own.l);
    if (how == 0) (void)!judged(K(update)(&own.filter, s, z));
    if (how == 1) (void)!judged(K(update_subset)(&own.filter, s, z, present));
    if (how == 2) (void)!judged(K(update_robust)(&own.filter, s, z, present, &own.gate));
    if (how == 3) (void)!judged(K(predict)(&own.filter, p, own.l ? u : NULL));
    if (how == 4) (void)!K(consistency_watch)(&own.consistency, &own.filter, s, z, present);
    if (how == 5) (void)!K(update_delayed)(&own.delay, below(LAG + 1), s, z, present);
    if (how != 6) return;
    const int is_alone = !own.filter.attached && K(filter_copy)(&own.twin, &own.filter) == KQ_OK;
    const kq_status status = judged(K(step)(&own.filter, p, own.l ? u : NULL, s, z));
    if (!is_alone || status < 0) return; /* a step is predict and update, bit for bit */
    DEMAND(K(predict)(&own.twin, p, own.l ? u : NULL) >= 0 && K(update)(&own.twin, s, z) >= 0);
    DEMAND(memcmp(own.twin.memory, own.filter.memory, sizeof(num) * (size_t)LENGTH(FILTER)(own.n)) == 0);
    DEMAND(K(events)(&own.twin) == K(events)(&own.filter));
}

static void change(void)
{
    static const struct K(loss_kind) *const kinds[] = {&K(loss_huber), &K(loss_student), &K(loss_jump), &K(loss_gate)};
    const unsigned k = below(SENSORS);
    num d[MOST];
    switch (below(7)) {
    case 0: numbers(own.A[1], own.n * own.n), (void)!K(process_change_transition)(&own.process[1], own.A[1]); break;
    case 1: numbers(own.H[k], own.m[k] * own.n), (void)!K(sensor_change_measurement)(&own.sensor[k], own.H[k]); break;
    case 2: own.gate = (K(loss)){.kind = kinds[below(sizeof kinds / sizeof *kinds)], .parameter = number(), .weights = own.weights, .limit = number(), .run = (uint16_t)below(4)}; break;
    case 3: (void)!K(process_scale_noise)(&own.scaled, &own.process[0], number()); break;
    case 4: numbers(d, own.n), (void)!judged(K(move)(&own.filter, d)); break;
    case 5: (void)!judged(K(forget)(&own.filter, number())); break;
    default: numbers(own.x0, own.n), (void)!judged(K(filter_init)(&own.filter, own.x0, own.P0));
    }
}

static void smooth(void)
{
    K(filter) view;
    num q[STEPS];
    const unsigned how = below(4);
    const kq_status status = how == 0 ? K(smooth)(&own.history) : how == 1 ? K(smooth_states)(&own.history)
        : how == 2 && K(history_steps)(&own.history) <= STEPS ? K(smooth_reweighted)(&own.history, &own.scaled, &own.process[0], 4, q)
                                                           : K(smooth_step)(&own.history, NULL, NULL);
    for (size_t t = 0; status >= 0 && t < K(history_steps)(&own.history); t++)
        if (K(smoothed)(&own.history, t, &view) == KQ_OK) sane_of(&view, 1);
}

static void look(void)
{
    K(filter) view;
    num S[SQUARE], e[MOST], z[MOST], f[4];
    const unsigned k = below(SENSORS);
    switch (below(8)) {
    case 0: smooth(); break;
    case 1: if (K(lagged)(&own.lag, below(LAG + 2), &view) == KQ_OK) sane_of(&view, 1); break;
    case 2: if (K(instant_smooth)(&own.instant, &view) == KQ_OK) sane_of(&view, 1); break;
    case 3: if (K(forecast)(&own.filter, &own.process[0], NULL, below(5), &own.ahead) >= 0) sane(&own.ahead); break;
    case 4: (void)!K(measurement)(&own.filter, &own.sensor[k], e, S), (void)!K(gain)(&own.filter, &own.sensor[k], S); break;
    case 5: numbers(z, own.m[k]), (void)!K(innovation)(&own.filter, &own.sensor[k], z, e), K(events_clear)(&own.filter); break;
    case 6: (void)!K(consistency_record)(&own.consistency, &own.filter), (void)!K(consistency_nis)(&own.consistency, 2, f, f + 1, f + 2); break;
    default:
        if (K(diffuse_smooth)(&own.diffuse) >= 0)
            for (size_t t = 0; t < 3; t++)
                if (K(diffuse_smoothed)(&own.diffuse, t, &view) == KQ_OK) sane_of(&view, 1);
    }
}

static void begin_unknown(void)
{
    note();
    (void)!judged(K(diffuse_init)(&own.diffuse, &own.filter, own.x0, own.P0, byte() | byte() << 8));
}

static void learn_all(void)
{
    const size_t length = LENGTH(EM)(own.n, own.m[1], 4);
    num z[4 * MOST];
    K(em) em;
    memset(&em, 0, sizeof em);
    K(parameters) model = {0, 0, own.A[1], NULL, NULL, own.Q, own.H[1], own.R[0], own.x0, own.P0};
    const kq_em_choice choice = {below(64), (kq_em_form)below(3), (kq_em_form)below(3), NULL, NULL};
    const K(recording) recording = {below(4) + 1, z, NULL, NULL};
    if (own.m[1] != own.m[0]) return; /* R is of the first one */
    numbers(z, 4 * own.m[1]);
    DEMAND(K(em_assign)(&em, own.n, own.m[1], words(length), length) == KQ_OK);
    if (K(em_init)(&em, &model, &choice, &recording, 1) < 0) return;
    for (int k = 0; k < 3; k++) (void)!K(em_iterate)(&em);
}

static void solve(void)
{
    const size_t length = LENGTH(STEADY_SOLVE)(own.n, own.m[1]);
    num P[2][SQUARE], gains[2][SQUARE];
    const K(steady_solution) out = {P[0], P[1], gains[0], gains[1]};
    (void)!K(steady_solve)(&own.process[0], &own.sensor[1], words(length), length, &out);
}

static void call(void)
{
    static int rare;
    note();
    const unsigned op = below(32);
    if (op < 4) update(3);
    else if (op < 14) update(op % 7);
    else if (op < 17) change();
    else if (op < 20) (void)!judged(K(attach)(&own.filter, object())) /* what was attached goes */;
    else if (op < 22) (void)!K(detach)(object());
    else if (op < 29) look();
    else if (op < 30) begin_unknown();
    else if (rare++ % 4 == 0 && count_kept < 60) op == 30 ? learn_all() : solve();
    if (own.filter.ready) DEMAND(K(filter_check)(&own.filter) == KQ_OK);
    sane(&own.filter);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    at = data, end = data + size;
    memset(&own, 0, sizeof own);
    own.gate.kind = &K(loss_gate);
    make_models(), make_sensors(), make_filters(), make_objects();
    for (int k = 0; k < 60 && at < end; k++) call();
    while (count_kept) free(kept[--count_kept]);
    return 0;
}
