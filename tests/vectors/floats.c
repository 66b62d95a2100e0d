#include "floats.h"
#include "vector.h"

#include <string.h>

#ifdef VECTOR_PRINT
#include <stdio.h>
#endif

#ifdef KQ_FALSIFY_MODEL
enum { FALSIFIED = 1 };
#else
enum { FALSIFIED = 0 };
#endif

#ifndef VECTOR_TOPICS
#define VECTOR_TOPICS 7
#endif

enum { PARTS = sizeof(num) / sizeof(uint32_t), MOST_BLOCKS = 40 };

model M;
num scale;
K(process) process;
K(sensor) sensor;
K(filter) filter;
static num process_memory[KQ_PROCESS_LEN(MOST_STATES)], sensor_memory[KQ_SENSOR_LEN(MOST_COMPONENTS)];
static num filter_memory[LEN(FILTER)(MOST_STATES)];

static uint32_t digest; /* since the last check */
static struct {
    const char *quantity;
    uint32_t digest; /* of its checks */
} blocks[MOST_BLOCKS];
static int block_count;

static uint32_t add_word(uint32_t to, uint32_t word) { return vector_digest(to, vector_word_of(word)); }

void put_word(uint32_t word)
{
    digest = add_word(digest, word);
#ifdef VECTOR_PRINT
    printf("%08lx\n", (unsigned long)word);
#endif
}

void put(num value)
{
    uint32_t parts[PARTS];
    memcpy(parts, &value, sizeof value);
    for (int k = 0; k < PARTS; k++) put_word(parts[k]);
}

void put_all(const num *values, int count)
{
    for (int k = 0; k < count; k++) put(values[k]);
}

void put_readings(const K(filter) * view, int n)
{
    for (int i = 0; i < n; i++) {
        put(K(mean)(view, i));
        put(K(mean_low)(view, i));
        put(K(sigma)(view, i));
    }
}

K(filter) smoothed_view(const K(history) * h, size_t t)
{
    K(filter) view;
    const kq_status shown = K(smoothed)(h, t, &view);
    (void)shown;
    return view;
}

void put_covariance(const K(filter) * view, int n, num *P)
{
    put_status(K(covariance)(view, P));
    put_all(P, n * n);
}

void put_filter(const K(filter) * f, int n, num *P)
{
    put_readings(f, n);
    put_covariance(f, n, P);
    put_word(K(events)(f));
    put_word((uint32_t)K(taken)(f));
    put(K(nis)(f));
    put(K(log_likelihood)(f));
}

void put_status(kq_status status) { put_word((uint32_t)(int32_t)status); }

/* The last one is never reached: it would differ. */
static int block_of(const char *quantity)
{
    int block = 0;
    while (block < block_count && strcmp(blocks[block].quantity, quantity) != 0) block++;
    if (block == block_count && block < MOST_BLOCKS - 1) block_count++;
    return block;
}

void check(const char *quantity, int step)
{
    (void)step;
#ifdef VECTOR_PRINT
    printf("%s, %d: %08lx\n", quantity, step, (unsigned long)digest);
#endif
    const int block = block_of(quantity);
    if (!blocks[block].quantity) blocks[block].digest = VECTOR_DIGEST_OF_NOTHING;
    blocks[block].quantity = quantity;
    blocks[block].digest = add_word(blocks[block].digest, digest);
    digest = VECTOR_DIGEST_OF_NOTHING;
}

void make(const model_case *c)
{
    model_make(&M, c);
    if (FALSIFIED) M.A[0] += M.A[0] * (sizeof(num) == 4 ? (num)0x1p-22 : (num)0x1p-50); /* two or three of the last bits */
    scale = c->scale;
    put_status(K(process_assign)(&process, M.n, M.l, process_memory, LENGTH(process_memory)));
    put_status(K(sensor_assign)(&sensor, M.n, M.m, sensor_memory, LENGTH(sensor_memory)));
    put_status(K(filter_assign)(&filter, M.n, filter_memory, LENGTH(filter_memory)));
}

/* ------------------------------------------------------------------ operations */

static const struct {
    const char *name;
    void (*run)(const model_case *c);
} operations[] = {
    {"filter", VECTOR_TOPICS & 1 ? run_filter : NULL},
    {"beyond", VECTOR_TOPICS & 2 ? run_beyond : NULL},
    {"nonlinear", VECTOR_TOPICS & 4 ? run_nonlinear : NULL},
};

static int is_operation(int32_t operation) { return operation > 0 && operation <= 3 && operations[operation - 1].run; }

const char *vector_name(int32_t operation) { return is_operation(operation) ? operations[operation - 1].name : "?"; }

int vector_steps(void) { return 0; }

int vector_operate(int32_t operation, const int32_t *in, size_t count, const vector_sink *sink)
{
    model_case c;
    if (!is_operation(operation) || !model_case_of(&c, in, count)) return -1;
    if (operation > 1 && (c.n > BEYOND_STATES || c.m > BEYOND_COMPONENTS)) return -1;
    digest = VECTOR_DIGEST_OF_NOTHING;
    block_count = 0;
    memset(blocks, 0, sizeof blocks);
    operations[operation - 1].run(&c);
    for (int k = 0; k < block_count; k++) {
        sink->put(sink->to, blocks[k].quantity, 0, vector_word_of(blocks[k].digest));
    }
    return 0;
}
