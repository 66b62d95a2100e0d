/*
 * Where the cases are.  A pointer of C does not reach an AVR's flash: its constants are copied to
 * RAM, unless they are read word by word, as here, from the lower 64 kB.
 */
#ifndef KALMANQ_FLASH_H
#define KALMANQ_FLASH_H

#include <stdint.h>

#ifdef __AVR__

#include <avr/pgmspace.h>

#define FLASH PROGMEM

static inline int32_t flash_word(const int32_t *at) { return (int32_t)pgm_read_dword(at); }

#else

#define FLASH

static inline int32_t flash_word(const int32_t *at) { return *at; }

#endif

#endif
