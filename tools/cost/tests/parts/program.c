/*
 * A filter on a small part: 45 measurements, on an AVR by its ADC, else recorded ones; with LEAN of
 * constant tables and a lean sensor, with RECORD and a smoother.  Prints a line for each estimate, its
 * words in hexadecimal, and how deep the stack has been.  tables.h is host.c's.
 */
#include "stack.h"

#include <kalmanq/kalmanq.h>
#include <stdio.h>
#include <string.h>

#include "tables.h"

#ifdef PART_f32
#define TYPED(name) name##_f32
typedef float word;
KQ_FILTER_F32(filter, N);
#ifdef LEAN
static const kq_process_f32 process = KQ_PROCESS_TABLE(N, 0, A, NULL, G);
static const kq_sensor_f32 sensor = KQ_SENSOR_LEAN_TABLE_F32(N, 1, H, R);

static kq_status begin(void)
{
    static const float x0[N];
    return kq_filter_init_root_f32(&filter, x0, S0);
}
#else
KQ_PROCESS_F32(process, N, 0);
KQ_SENSOR_DIAGONAL_F32(sensor, N, 1);

static kq_status begin(void)
{
    static const float x0[N];
    const kq_status status = kq_process_init_f32(&process, A, NULL, Q);
    return status ? status : kq_filter_init_f32(&filter, x0, P0);
}

static kq_status begin_sensor(int is_reference)
{
    static const float none;
    return kq_sensor_init_diagonal_f32(&sensor, H, is_reference ? &none : R);
}
#endif
#else
#define TYPED(name) name##_q31
typedef int32_t word;
KQ_FILTER_Q31(filter, N);
#ifdef LEAN
static const kq_process_q31 process = KQ_PROCESS_TABLE_Q31(N, 0, state, NULL, A, NULL, G);
static const kq_sensor_q31 sensor = KQ_SENSOR_LEAN_TABLE_Q31(N, 1, state, measured, H, R);

static kq_status begin(void)
{
    static const int32_t x0[N];
    static const kq_prior_table_q31 prior = {N, state, x0, S0};
    return kq_filter_init_q31(&filter, &prior, NULL);
}
#else
static kq_process_q31 process;
static kq_sensor_q31 sensor;

static kq_status begin(void)
{
    static const int32_t x0[N];
    static const kq_process_table_q31 table = {
        .states = N, .state_format = state, .transition = A, .noise_root = G};
    static const kq_prior_table_q31 prior = {N, state, x0, S0};
    const kq_status status = kq_process_init_q31(&process, &table, NULL);
    return status ? status : kq_filter_init_q31(&filter, &prior, NULL);
}

static kq_status begin_sensor(int is_reference)
{
    static const kq_scaled_q31 none = {0, 0};
    static const kq_sensor_table_q31 table = {N, 1, 0, state, measured, H, R},
                                     reference = {N, 1, 0, state, measured, H, &none};
    return kq_sensor_init_diagonal_q31(&sensor, is_reference ? &reference : &table, NULL);
}
#endif
#endif

#ifdef LEAN
static kq_status begin_sensor(int is_reference)
{
    (void)is_reference;
    return KQ_OK;
}
#endif

#if defined RECORD && defined PART_f32
KQ_HISTORY_F32(tape, N, 1, STEPS, 0);
#elif defined RECORD
KQ_HISTORY_Q31(tape, N, 1, STEPS, 0);
#endif

/* ------------------------------------------------------------------ in and out */

#ifdef __AVR__
static int16_t measurement(int t)
{
    (void)t;
    ADMUX = _BV(REFS0); /* input 0 against the supply */
    ADCSRA = _BV(ADEN) | _BV(ADSC) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0);
    while (ADCSRA & _BV(ADSC)) {
    }
    return (int16_t)ADC;
}
#else
static int16_t measurement(int t) { return recorded[t]; }
#endif

static void print(const char *text)
{
    while (*text) putchar(*text++);
}

static void print_bits(uint32_t bits)
{
    putchar(' ');
    for (int shift = 28; shift >= 0; shift -= 4) putchar("0123456789abcdef"[bits >> shift & 15]);
}

static void print_word(word value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    print_bits(bits);
}

/* ------------------------------------------------------------------ the run */

static kq_status step(int t)
{
    const int16_t count = measurement(t);
    const word z = count;
    kq_status status = t < 2 ? begin_sensor(t == 0) : KQ_OK;
    if (!status && t > 0) status = TYPED(kq_predict)(&filter, &process, NULL);
    if (!status) status = TYPED(kq_update)(&filter, &sensor, &z);
    print("step");
    print_bits((uint32_t)count);
    for (int i = 0; i < N; i++) {
        print_word(TYPED(kq_mean)(&filter, i));
        print_word(TYPED(kq_sigma)(&filter, i));
    }
    putchar('\n');
    return status;
}

#ifdef RECORD
static kq_status look_back(void)
{
    kq_status status = TYPED(kq_smooth)(&tape);
    for (int t = STEPS - 1; t >= 0 && !status; t--) {
        TYPED(kq_filter) view;
        status = TYPED(kq_smoothed)(&tape, (size_t)t, &view);
        print("past");
        for (int i = 0; i < N; i++) {
            print_word(TYPED(kq_mean)(&view, i));
            print_word(TYPED(kq_sigma)(&view, i));
        }
        putchar('\n');
    }
    return status;
}
#endif

int main(void)
{
    const uint8_t *top = stack_pointer();
    stack_paint();
    kq_status status = begin();
#ifdef RECORD
    if (!status) status = TYPED(kq_attach)(&filter, &tape.attached);
#endif
    for (int t = 0; t < STEPS && !status; t++) status = step(t);
#ifdef RECORD
    if (!status) status = look_back();
#endif
    print("stack");
    print_bits(stack_depth(top));
    if (stack_is_full()) print("\nthe stack has run into the variables\n");
    else print(status ? "\na call has failed\n" : "\nOK\n");
    return status || stack_is_full();
}
