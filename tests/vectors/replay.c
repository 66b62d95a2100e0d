/*
 * Replays every case and prints a line for each.  Of the first operation that differs it prints every
 * output, as it is here.
 *   VECTOR_PRINT  prints the outputs of all operations, so that two machines can be compared by diff
 *   KQ_FALSIFY    makes outputs and vectors wrong by one bit; each must be found
 *   KQ_FALSIFY_MODEL   the models of floats are wrong in their last bits (floats.h); each operation must differ
 */
#include "cases.h"
#include "vector.h"

#include <stdio.h>

#ifdef KQ_FALSIFY

enum { ROOM = 1 << 14, FALSIFIED = 25 };

static size_t left; /* outputs before the wrong one */

static int32_t falsify(void *to, const char *quantity, int index, int32_t word)
{
    (void)to;
    (void)quantity;
    (void)index;
    return left-- == 0 ? word ^ 1 : word;
}

/* Is an output that is wrong by its last bit found, in its operation and, in layout 1, at its place? */
static int is_wrong_output_found(const vector_case *v, size_t which)
{
    vector_difference d;
    left = which;
    if (vector_replay(v->words, v->count, &(vector_tap){falsify, NULL}, &d) || !d.quantity) return 0;
    const int is_place = v->words[0] == VECTOR_DIGESTS || d.expected == (d.got ^ 1);
    const size_t first = d.before, operation = d.operation;
    left = first; /* the first output of the operation that was found: it must be the same operation again */
    vector_replay(v->words, v->count, &(vector_tap){falsify, NULL}, &d);
    return is_place && first <= which && d.operation == operation;
}

/* Position of the `which`-th word that is expected, counted around */
static size_t expected_at(const vector_case *v, size_t which)
{
    size_t total = 0;
    for (int pass = 0; pass < 2; pass++) {
        size_t before = 0;
        for (size_t at = 1; at + 2 < v->count;) {
            at += 2 + (size_t)v->words[at + 1];
            const size_t outputs = v->words[0] == VECTOR_DIGESTS ? 1 : (size_t)v->words[at++];
            if (pass && which % total < before + outputs) return at + which % total - before;
            before += outputs;
            at += outputs;
        }
        total = before;
    }
    return 0;
}

/* Is an expected word that is wrong by its last bit found, there and nowhere else? */
static int is_wrong_vector_found(const vector_case *v, size_t position)
{
    static int32_t words[ROOM];
    vector_difference d;
    if (v->count > ROOM) return 0;
    for (size_t k = 0; k < v->count; k++) words[k] = v->words[k];
    words[position] ^= 1;
    return vector_replay(words, v->count, NULL, &d) == 0 && d.quantity && d.position == position &&
           d.expected == words[position] && d.got == v->words[position];
}

static int replay_case(const vector_case *v)
{
    int missed = 0;
    vector_difference d;
    const size_t outputs = vector_replay(v->words, v->count, NULL, &d);
    for (size_t j = 0; j < FALSIFIED; j++) {
        const size_t which = outputs ? 7919 * j % outputs : 0, position = expected_at(v, 7919 * j);
        if (outputs && is_wrong_output_found(v, which) && is_wrong_vector_found(v, position)) continue;
        printf("%s: a wrong bit is not found, in output %lu or word %lu\n", v->name, (unsigned long)which,
               (unsigned long)position);
        missed = 1;
    }
    return missed;
}

#elif defined(KQ_FALSIFY_MODEL)

enum { ROOM = 64 };

/* The operation that begins at `at`, as a case of its own: is it found to differ? */
static int is_found(const vector_case *v, size_t at, size_t count)
{
    int32_t words[ROOM] = {v->words[0]};
    vector_difference d;
    if (count + 2 > ROOM) return 0;
    for (size_t k = 0; k < count; k++) words[1 + k] = v->words[at + k];
    return vector_replay(words, count + 2, NULL, &d) == 0 && d.quantity;
}

static int replay_case(const vector_case *v)
{
    int missed = 0;
    for (size_t at = 1, operation = 0, count; at + 2 < v->count; at += count, operation++) {
        count = 2 + (size_t)v->words[at + 1];
        count += 1 + (size_t)v->words[at + count]; /* layout 1 */
        if (is_found(v, at, count)) continue;
        printf("%s: operation %lu: a wrong model is not found\n", v->name, (unsigned long)operation);
        missed = 1;
    }
    return missed;
}

#else

static vector_difference now;

/* Prints what comes out of operation `*to`; of all, where it is NULL. */
static int32_t show(void *to, const char *quantity, int index, int32_t word)
{
    const size_t *only = to;
    if (!only || *only == now.operation) {
        printf("  %lu %s: %s[%d] %ld\n", (unsigned long)now.operation, vector_name(now.code), quantity, index,
               (long)word);
    }
    return word;
}

static void print_difference(const vector_case *v)
{
    printf("%s: operation %lu (%s) after %d predicts: ", v->name, (unsigned long)now.operation,
           vector_name(now.code), now.step);
    if (!now.quantity) {
        printf("these words are no case\n");
        return;
    }
    printf("%s[%d]: expected %ld, got %ld (word %lu)\n", now.quantity, now.index, (long)now.expected,
           (long)now.got, (unsigned long)now.position);
    size_t only = now.operation;
    vector_replay(v->words, v->count, &(vector_tap){show, &only}, &now);
}

static int replay_case(const vector_case *v)
{
#ifdef VECTOR_PRINT
    printf("%s\n", v->name);
    const vector_tap tap = {show, NULL};
    const size_t compared = vector_replay(v->words, v->count, &tap, &now);
#else
    const size_t compared = vector_replay(v->words, v->count, NULL, &now);
#endif
    if (compared) printf("%-12s %5lu outputs compared\n", v->name, (unsigned long)compared);
    else print_difference(v);
    return !compared;
}

#endif

int main(void)
{
    int bad = 0;
    for (int k = 0; k < vector_case_count; k++) bad |= replay_case(&vector_cases[k]);
    printf("%s\n", bad ? "FAIL" : "OK");
    return bad;
}
