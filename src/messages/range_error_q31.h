/* A range_error of formats in words. */
#ifndef KQ_SRC_MESSAGES_RANGE_ERROR_Q31_H
#define KQ_SRC_MESSAGES_RANGE_ERROR_Q31_H

#include "kalmanq/fixed_point.h"

/* A text that grows to the right and is cut where there is no room left. */
typedef struct {
    char *at;
    size_t room, length;
} sentence;

static void say(sentence *s, const char *words)
{
    for (; *words; words++) {
        if (s->length + 1 < s->room) s->at[s->length] = *words;
        s->length++;
    }
}

static void say_number(sentence *s, int32_t number)
{
    char digits[12];
    int k = (int)sizeof digits;
    uint32_t rest = number < 0 ? 0 - (uint32_t)number : (uint32_t)number;
    digits[--k] = 0;
    do digits[--k] = (char)('0' + rest % 10);
    while ((rest /= 10) > 0);
    if (number < 0) digits[--k] = '-';
    say(s, digits + k);
}

size_t kq_range_error_text_q31(const kq_range_error_q31 *range_error, char *text, size_t length)
{
    static const char quantity[][16] = {"state ", "control ", "measurement "};
    sentence s = {.at = text, .room = text ? length : 0};
    if (range_error && (unsigned)range_error->quantity < 3) {
        say(&s, quantity[range_error->quantity]);
        say_number(&s, range_error->component);
        if (range_error->bits == 0) {
            say(&s, " is beyond its declared range");
        } else {
            say(&s, " needs ");
            say_number(&s, range_error->bits);
            say(&s, range_error->bits == 1 ? " more integer bit" : " more integer bits");
        }
    }
    if (range_error && range_error->quantity == KQ_NO_RANGE_ERROR) say(&s, "all formats fit");
    if (s.room) s.at[s.length < s.room ? s.length : s.room - 1] = 0;
    return s.length;
}

#endif
