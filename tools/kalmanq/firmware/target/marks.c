/* What a program for a target tells the emulator.  Each has a text of its own, or the compiler would merge them. */
void cost_region(unsigned region);
void cost_failed(int status);
void cost_end(void);

void cost_region(unsigned region) { __asm__ volatile("" : : "r"(region)); }

void cost_failed(int status)
{
    for (;;) __asm__ volatile("" : : "r"(status));
}

void cost_end(void)
{
    for (;;) __asm__ volatile("");
}
