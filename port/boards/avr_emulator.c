/*
 * avr_emulator PROGRAM: runs an ELF file on an emulated ATmega2560 with external SRAM (libsimavr),
 * prints what UART 0 sends, and ends with the program's exit status, signalled as avr.c says.
 * Anything else is a crash: 99, and so are more than 10^10 cycles, or KQ_AVR_CYCLES millions.
 * avr_emulator --part PROGRAM: on an ATmega328P with its own memory.  Input 0 of its ADC has the
 * voltages that the file KQ_AVR_VOLTAGES lists in millivolts, the next one at each conversion.
 */
#include <signal.h>
#include <simavr/avr_adc.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GPIOR0 = 0x3E, GPIOR1 = 0x4A, ENDED = 0xED, CRASHED = 99 };
enum { RAM_START = 0x200, RAM_END = 0xFFFF, PAINT = 0xA5, PAINTED = 32 };
enum { SUPPLY = 5000 }; /* mV */

static FILE *voltages; /* at the ADC */

static void print(struct avr_irq_t *irq, uint32_t value, void *unused)
{
    (void)irq, (void)unused;
    putchar((int)value);
}

/* The emulator's own log: errors only, not mixed with what the program prints */
static void log_errors(struct avr_t *avr, const int level, const char *format, va_list arguments)
{
    (void)avr;
    if (level == LOG_ERROR) vfprintf(stderr, format, arguments);
}

/* A conversion begins */
static void set_voltage(struct avr_irq_t *irq, uint32_t value, void *board)
{
    struct avr_t *avr = board;
    unsigned millivolts = 0;
    (void)irq, (void)value;
    if (voltages && fscanf(voltages, "%u", &millivolts) == 1) {
        avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0), millivolts);
    }
}

static void connect_adc(avr_t *avr)
{
    const char *file = getenv("KQ_AVR_VOLTAGES");
    voltages = file ? fopen(file, "r") : NULL;
    avr->vcc = avr->avcc = SUPPLY;
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_OUT_TRIGGER),
                            set_voltage, avr);
}

static avr_t *board_with(const char *program, int is_part)
{
    static elf_firmware_t firmware;
    avr_t *avr = avr_make_mcu_by_name(is_part ? "atmega328p" : "atmega2560");
    if (!avr || elf_read_firmware(program, &firmware)) return NULL;
    if (!is_part) avr->ramend = RAM_END;
    avr_init(avr);
    firmware.frequency = 16000000;
    avr_load_firmware(avr, &firmware);
    if (is_part) connect_adc(avr);

    uint32_t flags = 0; /* not to the console, no sleep while the UART is polled */
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), print,
                            NULL);
    if (!is_part) memset(avr->data + RAM_START, PAINT, PAINTED);
    return avr;
}

/* Of the larger board; a part's programs look after their own. */
static int stack_has_overflowed(const avr_t *avr)
{
    for (int k = 0; avr->ramend == RAM_END && k < PAINTED; k++) {
        if (avr->data[RAM_START + k] != PAINT) return 1;
    }
    return 0;
}

static int crashed(const avr_t *avr, const char *how)
{
    printf("\n%s at %#lx\n", how, (unsigned long)avr->pc);
    return CRASHED;
}

static int run(avr_t *avr, unsigned long long cycles)
{
    int state = cpu_Running;
    while (state != cpu_Done && state != cpu_Crashed) {
        state = avr_run(avr);
        if (avr->cycle > cycles) return crashed(avr, "cycle limit reached");
        if (avr->pc >= avr->codeend) return crashed(avr, "left the code");
    }
    if (state == cpu_Crashed || avr->data[GPIOR1] != ENDED) return crashed(avr, "crash");
    if (stack_has_overflowed(avr)) return crashed(avr, "the stack has overflowed");
    return avr->data[GPIOR0];
}

int main(int count, char **arguments)
{
    const char *millions = getenv("KQ_AVR_CYCLES");
    avr_global_logger_set(log_errors);
    const int is_part = count == 3 && !strcmp(arguments[1], "--part");
    avr_t *avr = count == 2 + is_part ? board_with(arguments[1 + is_part], is_part) : NULL;
    if (!avr) {
        fprintf(stderr, "avr_emulator [--part] PROGRAM\n");
        return CRASHED;
    }
    return run(avr, 1000000 * (millions ? strtoull(millions, NULL, 10) : 10000));
}
