/*
 * Programs that a runner of tests must not take for a test that has passed, and one that it must:
 * HOW is GOOD, ENDLESS, ENDLESS_AFTER_REPORT, CRASH, CRASH_AFTER_REPORT, SILENT, FAILING or
 * FAILING_AFTER_REPORT.
 */
#include <stdio.h>

enum {
    GOOD,
    SILENT,
    ENDLESS,
    CRASH,
    FAILING,
    AFTER_REPORT,
    ENDLESS_AFTER_REPORT = AFTER_REPORT + ENDLESS,
    CRASH_AFTER_REPORT = AFTER_REPORT + CRASH,
    FAILING_AFTER_REPORT = AFTER_REPORT + FAILING
};

static void (*volatile nowhere)(void);

int main(void)
{
    volatile int how = HOW;
    if (how == GOOD || how >= AFTER_REPORT) {
        puts("OK");
        fflush(stdout);
    }
    if (how % AFTER_REPORT == CRASH) nowhere();
    while (how % AFTER_REPORT == ENDLESS) {
    }
    return how % AFTER_REPORT == FAILING;
}
