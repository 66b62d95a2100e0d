#include "flash.h"
#include "vector.h"

int32_t vector_word_of(uint32_t bits)
{
    return bits >> 31 ? -(int32_t)(UINT32_MAX - bits) - 1 : (int32_t)bits;
}

uint32_t vector_digest(uint32_t digest, int32_t word) { return (digest ^ (uint32_t)word) * UINT32_C(16777619); }

typedef struct {
    const int32_t *expected;
    size_t count, compared;
    const vector_tap *tap;
    uint32_t digest;
    int is_digested, differs;
    vector_difference *difference;
} comparison;

static void compare_word(comparison *c, const char *quantity, int index, int32_t word)
{
    if (c->differs) return;
    const int is_more = c->compared >= c->count;
    const int32_t expected = is_more ? 0 : flash_word(c->expected + c->compared);
    if (!is_more && expected == word) {
        c->compared++;
        return;
    }
    c->differs = 1;
    c->difference->quantity = quantity;
    c->difference->index = index;
    c->difference->position += c->compared;
    c->difference->expected = expected;
    c->difference->got = word;
}

static void compare(void *to, const char *quantity, int index, int32_t word)
{
    comparison *c = to;
    if (c->tap) word = c->tap->see(c->tap->to, quantity, index, word);
    c->difference->before++;
    if (c->is_digested) c->digest = vector_digest(c->digest, word);
    else compare_word(c, quantity, index, word);
}

/* Are there `count` words at position `at`? */
static int is_part(size_t length, size_t at, int32_t count)
{
    return count >= 0 && at <= length && (uint32_t)count <= length - at;
}

/* Carries out an operation; do its outputs equal those of the case? */
static int is_as_expected(comparison *c, int32_t code, const int32_t *in, size_t inputs)
{
    const size_t before = c->difference->before;
    if (vector_operate(code, in, inputs, &(vector_sink){compare, c})) return 0;
    if (c->is_digested) compare_word(c, "digest", 0, vector_word_of(c->digest));
    if (c->differs) c->difference->before = before;
    return !c->differs && c->compared == c->count;
}

size_t vector_replay(const int32_t *words, size_t count, const vector_tap *tap,
                     vector_difference *difference)
{
    static int32_t in[VECTOR_INPUTS];
    size_t at = 1;
    *difference = (vector_difference){.code = VECTOR_END};
    const int32_t layout = count ? flash_word(words) : 0;
    if (layout != VECTOR_FULL && layout != VECTOR_DIGESTS) return 0;
    for (; at + 2 < count; difference->operation++) {
        const int32_t code = flash_word(words + at), inputs = flash_word(words + at + 1);
        *difference = (vector_difference){.operation = difference->operation, .code = code,
                                          .step = vector_steps(), .position = at, .before = difference->before};
        at += 2;
        if (!is_part(count - 1, at, inputs) || inputs > VECTOR_INPUTS) return 0;
        for (size_t k = 0; k < (size_t)inputs; k++) in[k] = flash_word(words + at++);
        const int32_t outputs = layout == VECTOR_DIGESTS ? 1 : flash_word(words + at++);
        if (!is_part(count, at, outputs)) return 0;
        comparison c = {words + at, (size_t)outputs, 0, tap, VECTOR_DIGEST_OF_NOTHING, layout == VECTOR_DIGESTS, 0,
                        difference};
        difference->position = at;
        if (!is_as_expected(&c, code, in, (size_t)inputs)) return 0;
        at += c.count;
    }
    return at + 1 == count && flash_word(words + at) == VECTOR_END ? difference->before : 0;
}
