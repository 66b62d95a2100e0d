/*
 * An ATmega2560 with 56 kB of external SRAM at 0x2200 .. 0xFFFF, which the linker is told to put
 * data at (--section-start,.data=0x802200); the stack has the 8 kB of the chip to itself.  Or a
 * smaller AVR as it is.  UART 0 is the standard output.
 *
 * The end of a program, for avr_emulator.c: GPIOR0 holds the exit status, GPIOR1 holds 0xED, and
 * the chip sleeps with interrupts off.  A jump to address 0 that is not the first is a crash: 99.
 */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdio.h>
#include <stdlib.h>

enum { ENDED = 0xED, STARTED = 0x57, CRASHED = 99 };

static int put(char c, FILE *to)
{
    (void)to;
    while (!(UCSR0A & _BV(UDRE0))) {
    }
    UDR0 = (uint8_t)c;
    return 0;
}

static FILE uart = FDEV_SETUP_STREAM(put, NULL, _FDEV_SETUP_WRITE);

/* Replaces the library's, which would wait forever */
void exit(int status)
{
    while (!(UCSR0A & _BV(UDRE0))) {
    }
    GPIOR0 = (uint8_t)status;
    GPIOR1 = ENDED;
    cli();
    for (;;) {
        sleep_enable();
        sleep_cpu();
    }
}

void abort(void) { exit(CRASHED); }

/* Before data is copied: falls through to the start-up code that follows it. */
__attribute__((naked, used, section(".init3"))) static void start_memory(void)
{
#ifdef XMCRA
    XMCRA = _BV(SRE);
#endif
    if (GPIOR2 == STARTED) {
        GPIOR0 = CRASHED;
        GPIOR1 = ENDED;
        cli();
        sleep_enable();
        sleep_cpu();
    }
    GPIOR2 = STARTED;
}

__attribute__((constructor)) static void start_uart(void)
{
    UCSR0A = _BV(U2X0);
    UBRR0 = 0;
    UCSR0B = _BV(TXEN0);
    stdout = &uart;
}
