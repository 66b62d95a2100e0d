/* A noisy voltage at an ADC, and the level behind it, in counts. */
#include "adc.h"
#include "board.h"

#if defined __AVR__ && !defined COUNTED
#include <avr/io.h>

static int32_t sample(int t)
{
    (void)t;
    ADMUX = _BV(REFS0); /* input 0 against the supply */
    ADCSRA = _BV(ADEN) | _BV(ADSC) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0);
    while (ADCSRA & _BV(ADSC)) {
    }
    return ADC;
}
#else
static int32_t sample(int t) { return recording[t].z[0]; } /* no ADC on this emulated board */
#endif

int main(void)
{
    static adc_filter f;
    adc_start(&f);
    for (int t = 0; t < ROWS; t++) {
        const int32_t z[1] = {sample(t)};
        if (t == 0) adc_update(&f, z);
        else adc_step(&f, z);
        show(adc_mean_level(&f));
        show_end();
    }
    return ended(f.events != 0);
}
