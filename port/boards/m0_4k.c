/*
 * Start-up of a small Cortex-M under an emulator with semihosting, without a C library's: stack,
 * data, main, and its result as the emulator's exit status.  putchar is the emulator's console.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum { WRITE_CHARACTER = 0x03, EXIT_EXTENDED = 0x20, APPLICATION_EXIT = 0x20026 };

extern uint32_t stack_top, data_start, data_end, data_load, bss_start, bss_end;
int main(void);

void reset(void);

static void call(uint32_t operation, const void *argument)
{
    register uint32_t r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = argument;
    __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

int putchar(int c)
{
    const char text = (char)c;
    call(WRITE_CHARACTER, &text);
    return c;
}

void exit(int status)
{
    const uint32_t reason[] = {APPLICATION_EXIT, (uint32_t)status};
    for (;;) call(EXIT_EXTENDED, reason);
}

void reset(void)
{
    const uint32_t *from = &data_load;
    for (uint32_t *to = &data_start; to < &data_end; to++) *to = *from++;
    for (uint32_t *to = &bss_start; to < &bss_end; to++) *to = 0;
    exit(main());
}

static void fault(void) { exit(99); }

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void)) & stack_top, reset, fault, fault, fault, fault, fault,
};
