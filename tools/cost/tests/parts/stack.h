/*
 * How deep the stack has been: what lies between the variables and the stack is painted, and what
 * is no longer painted was the stack's.  A frame's end that was never written is not seen.
 */
#ifndef KALMANQ_TESTS_STACK_H
#define KALMANQ_TESTS_STACK_H

#include <stdint.h>

enum { STACK_PAINT = 0xa5 };

#ifdef __AVR__
#include <avr/io.h>
extern uint8_t _end;
#define STACK_LIMIT (&_end)
/* The next free byte, above which lies what is in use */
static inline uint8_t *stack_pointer(void) { return (uint8_t *)SP + 1; }
#else
extern uint8_t end;
#define STACK_LIMIT (&end)
static inline uint8_t *stack_pointer(void)
{
    uint8_t *at;
    __asm volatile("mov %0, sp" : "=r"(at));
    return at;
}
#endif

__attribute__((noinline)) static void stack_paint(void)
{
    for (volatile uint8_t *p = STACK_LIMIT; p < stack_pointer(); p++) *p = STACK_PAINT;
}

/* Has it been everywhere, and so perhaps in the variables? */
static inline int stack_is_full(void) { return *(volatile uint8_t *)STACK_LIMIT != STACK_PAINT; }

/* Bytes below `top` */
__attribute__((noinline)) static unsigned stack_depth(const uint8_t *top)
{
    const volatile uint8_t *p = STACK_LIMIT;
    while (p < top && *p == STACK_PAINT) p++;
    return (unsigned)(top - p);
}

#endif
