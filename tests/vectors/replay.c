/*
 * Replays every golden vector and prints a line for each; the first difference, if there is one.
 * With KQ_FALSIFY defined: the same vectors with one output bit wrong; each must be found.
 */
#include "cases.h"
#include "vector.h"

#include <stdio.h>

#ifdef KQ_FALSIFY

enum { ROOM = 1 << 14, FALSIFIED = 25 };

/* Position of the `which`-th output word, counted around; 0 if the case holds none */
static size_t output_at(const vector_case *v, size_t which)
{
    size_t total = 0;
    for (int pass = 0; pass < 2; pass++) {
        size_t before = 0;
        for (size_t at = 1; at + 2 < v->count;) {
            at += 2 + (size_t)v->words[at + 1];
            const size_t outputs = (size_t)v->words[at++];
            if (pass && which % total < before + outputs) return at + which % total - before;
            before += outputs;
            at += outputs;
        }
        total = before;
        if (total == 0) return 0;
    }
    return 0;
}

/* Is a word that is wrong by its last bit found, there and nowhere else? */
static int is_found(const vector_case *v, size_t position)
{
    static int32_t words[ROOM];
    vector_difference d;
    if (v->count > ROOM) return 0;
    for (size_t k = 0; k < v->count; k++) words[k] = v->words[k];
    words[position] ^= 1;
    return vector_replay(words, v->count, &d) == 0 && d.quantity && d.position == position &&
           d.expected == words[position] && d.got == v->words[position];
}

static int replay_all(void)
{
    int missed = 0;
    for (int k = 0; k < vector_case_count; k++) {
        const vector_case *v = &vector_cases[k];
        for (size_t j = 0; j < FALSIFIED; j++) {
            const size_t position = output_at(v, 7919 * j);
            if (position && is_found(v, position)) continue;
            printf("%s: a wrong bit in word %lu is not found\n", v->name, (unsigned long)position);
            missed = 1;
        }
    }
    return missed;
}

#else

static void print_difference(const vector_case *v, const vector_difference *d)
{
    printf("%s: operation %lu (%s) after %d predicts: ", v->name, (unsigned long)d->operation,
           vector_name(d->code), d->step);
    if (!d->quantity) {
        printf("these words are no case\n");
        return;
    }
    printf("%s[%d]: expected %ld, got %ld (word %lu)\n", d->quantity, d->index, (long)d->expected,
           (long)d->got, (unsigned long)d->position);
}

static int replay_all(void)
{
    int bad = 0;
    for (int k = 0; k < vector_case_count; k++) {
        const vector_case *v = &vector_cases[k];
        vector_difference difference;
        const size_t compared = vector_replay(v->words, v->count, &difference);
        if (compared) {
            printf("%-12s %5lu of %5lu words compared\n", v->name, (unsigned long)compared,
                   (unsigned long)v->count);
        } else {
            print_difference(v, &difference);
            bad = 1;
        }
    }
    return bad;
}

#endif

int main(void)
{
    const int bad = replay_all();
    printf("%s\n", bad ? "FAIL" : "OK");
    return bad;
}
