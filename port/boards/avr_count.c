/*
 * Counts what an ATmega328P executes within calls, with simavr: instructions and cycles, exact.
 * It is an ATmega1284P, the same but for its memory, with 64 kB of RAM: what does not fit is
 * counted, too.
 *   avr_count ELF DATA REGION FAILED END FUNCTION...
 * DATA: where the variables end.  REGION, FAILED, END: addresses of the marks (program.h).
 * FUNCTION: for every region, in their order, the address of the function that it is about; 0 where
 * there is none: such a region lasts until the next mark.
 * Prints "region R INSTRUCTIONS CYCLES STACK" for each region, followed by lines
 * "at ADDRESS TIMES"; the last line is "end".
 */
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WORDS = 1 << 16, RAM_END = 0xffff, RETURN_ADDRESS = 2 };
enum { LOW_PORT = 0x3d, HIGH_PORT = 0x3e, PORTS = 0x20 };

static const uint64_t longest = UINT64_C(20000000000); /* cycles */

static unsigned times[WORDS]; /* of each word of the flash */
static int half_written;
static int data_end; /* of the variables; the stack must stay above */

static unsigned address(const char *text) { return (unsigned)strtoul(text, NULL, 0); }

static int stack_pointer(const avr_t *avr)
{
    return avr->data[PORTS + LOW_PORT] | avr->data[PORTS + HIGH_PORT] << 8;
}

/* In r25:r24 */
static unsigned first_argument(const avr_t *avr)
{
    return (unsigned)(avr->data[24] | avr->data[25] << 8);
}

/* Is the next instruction `out port, register`? */
static int writes(const avr_t *avr, int port)
{
    const int code = avr->flash[avr->pc] | avr->flash[avr->pc + 1] << 8;
    return (code & 0xf800) == 0xb800 && ((code >> 5 & 0x30) | (code & 0xf)) == port;
}

/* Code writes the stack pointer's high byte first: until the low byte follows, it points
   nowhere. */
static void one(avr_t *avr)
{
    if (writes(avr, HIGH_PORT)) half_written = 1;
    else if (writes(avr, LOW_PORT)) half_written = 0;
    avr->pc = avr_run_one(avr);
    if (avr->state != cpu_Running || avr->cycle > longest) {
        fprintf(stderr, "avr_count: stopped at 0x%x\n", (unsigned)avr->pc);
        exit(1);
    }
    if (!half_written && stack_pointer(avr) < data_end) {
        fprintf(stderr, "avr_count: the stack runs into the variables\n");
        exit(1);
    }
}

static void run_to(avr_t *avr, unsigned place)
{
    do one(avr);
    while (avr->pc != place);
}

/* From the function's first instruction to its return, which leaves the stack as the caller had it;
   or, where there is an end, to that */
static void count_call(avr_t *avr, unsigned region, unsigned end)
{
    const int top = stack_pointer(avr) + (end ? 0 : RETURN_ADDRESS);
    const uint64_t start = avr->cycle;
    uint64_t count = 0;
    int lowest = top;
    memset(times, 0, sizeof times);
    while (end ? avr->pc != end : half_written || stack_pointer(avr) < top) {
        times[avr->pc / 2]++;
        count++;
        one(avr);
        if (!half_written && stack_pointer(avr) < lowest) lowest = stack_pointer(avr);
    }
    printf("region %u %llu %llu %d\n", region, (unsigned long long)count,
           (unsigned long long)(avr->cycle - start), top - lowest);
    for (unsigned k = 0; k < WORDS; k++) {
        if (times[k]) printf("at %u %u\n", 2 * k, times[k]);
    }
}

/* Out of the function that has just been entered */
static void run_back(avr_t *avr)
{
    const int top = stack_pointer(avr) + RETURN_ADDRESS;
    while (stack_pointer(avr) < top) one(avr);
}

static avr_t *machine(const char *path)
{
    elf_firmware_t firmware;
    memset(&firmware, 0, sizeof firmware);
    if (elf_read_firmware(path, &firmware)) exit(1);
    avr_t *avr = avr_make_mcu_by_name("atmega1284p");
    if (!avr) exit(1);
    avr->ramend = RAM_END;
    avr_init(avr);
    avr->log = LOG_ERROR;
    avr_load_firmware(avr, &firmware);
    return avr;
}

int main(int count, char **arguments)
{
    if (count < 7) return 2;
    avr_t *avr = machine(arguments[1]);
    const unsigned region = address(arguments[3]), failed = address(arguments[4]),
                   end = address(arguments[5]);
    for (one(avr); stack_pointer(avr) == 0;) one(avr);
    data_end = (int)(address(arguments[2]) & 0xffff); /* the linker puts data at 0x800000 */
    while (avr->pc != end) {
        if (avr->pc == failed) {
            fprintf(stderr, "avr_count: a call answered %d\n", (int16_t)first_argument(avr));
            return 1;
        }
        if (avr->pc != region) {
            one(avr);
            continue;
        }
        const unsigned which = first_argument(avr);
        if (which + 6 >= (unsigned)count) return 2;
        const unsigned function = address(arguments[6 + which]);
        if (function) run_to(avr, function);
        else run_back(avr);
        count_call(avr, which, function ? 0 : region);
    }
    printf("end\n");
    return 0;
}
