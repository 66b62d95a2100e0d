/* A misfit of formats in words. */
#ifndef KQ_SRC_MESSAGES_MISFIT_Q31_H
#define KQ_SRC_MESSAGES_MISFIT_Q31_H

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

size_t kq_misfit_text_q31(const kq_misfit_q31 *misfit, char *text, size_t length)
{
    static const char quantity[][16] = {"state ", "control ", "measurement "};
    sentence s = {.at = text, .room = text ? length : 0};
    if (misfit && (unsigned)misfit->quantity < 3) {
        say(&s, quantity[misfit->quantity]);
        say_number(&s, misfit->component);
        if (misfit->bits == 0) {
            say(&s, " is beyond its declared range");
        } else {
            say(&s, " needs ");
            say_number(&s, misfit->bits);
            say(&s, misfit->bits == 1 ? " more integer bit" : " more integer bits");
        }
    }
    if (misfit && misfit->quantity == KQ_ALL_FIT) say(&s, "all formats fit");
    if (s.room) s.at[s.length < s.room ? s.length : s.room - 1] = 0;
    return s.length;
}

#endif
