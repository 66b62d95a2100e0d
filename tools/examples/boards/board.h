/*
 * What an example has of its board: the rows of its recording, and a line for its results.  On yours these are sensors
 * and a radio.  recording.h is data.csv, written by boards.py.
 */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "recording.h"

#ifdef COUNTED /* tools/cost counts instructions: no output */
static volatile number shown;
static inline void show(number value) { shown = value; }
static inline void show_end(void) {}
static inline int ended(int failed) { return failed; }
#else

/* The bits of a number: the host compares the last of them, too. */
static inline void show(number value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int shift = 28; shift >= 0; shift -= 4) putchar("0123456789abcdef"[bits >> shift & 15]);
    putchar(' ');
}

static inline void show_end(void) { putchar('\n'); }

/* The last line of a program that has done what it should */
static inline int ended(int failed)
{
    for (const char *text = failed ? "failed\n" : "OK\n"; *text; text++) putchar(*text);
    return failed;
}
#endif

#endif
