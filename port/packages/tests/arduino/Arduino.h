/* A stand-in for Arduino.h: what the examples use of it.  On a host the sketch runs, on an AVR it links. */
#pragma once
#include <stdint.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

void setup();
void loop();
enum { A0 = 14 };
inline int analogRead(int) { return 511; }
inline void delay(unsigned long) {}
inline unsigned long millis() { static unsigned long now; return now += 3; } /* time passes by looking at it */
inline long random(long end) { static uint32_t state = 1; return long((state = state * 1664525u + 1013904223u) >> 8) % end; }

struct Printer {
    void begin(long) {}
#ifdef __AVR__ /* a port that nothing optimises away */
    static void put(float x) { *(volatile float *)0x100 = x; }
    void print(const char *) {}
    void print(double x) { put(x); }
    void println(const char *) {}
    void println(double x) { put(x); }
#else
    void print(const char *text) { printf("%s", text); }
    void print(double x) { printf("%.2f", x); }
    void println(const char *text) { printf("%s\n", text); }
    void println(double x) { printf("%.2f\n", x); }
#endif
};
static Printer Serial __attribute__((unused));

#ifndef KQ_ROWS
#define KQ_ROWS 1
#endif
int main()
{
    setup();
    for (int row = 0; row < KQ_ROWS; row++) loop();
}
