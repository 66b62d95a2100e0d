/*
 * Start-up of a Cortex-M under an emulator with semihosting: stack, data, FPU where there is
 * one, main, and its result as the emulator's exit status.  Linked with newlib's rdimon.
 */
#include <stdint.h>
#include <stdlib.h>

extern uint32_t stack_top, data_start, data_end, data_load, bss_start, bss_end;
extern void initialise_monitor_handles(void);
int main(void);

void reset(void);

void reset(void)
{
    const uint32_t *from = &data_load;
    for (uint32_t *to = &data_start; to < &data_end; to++) *to = *from++;
    for (uint32_t *to = &bss_start; to < &bss_end; to++) *to = 0;
#ifdef __ARM_FP
    *(volatile uint32_t *)0xE000ED88 |= UINT32_C(0xF) << 20; /* CPACR: full access to the FPU */
    __asm volatile("dsb\n isb");
#endif
    initialise_monitor_handles();
    exit(main());
}

static void fault(void) { _Exit(99); }

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void)) & stack_top, reset, fault, fault, fault, fault, fault,
};

/* what newlib's start-up files would bring */
void _init(void) {}
void _fini(void) {}
