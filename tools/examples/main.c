/* The command line of every example: PROGRAM [SEED [OPTION...]] */
#include "simulation.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    uint64_t seed = 1;
    if (argc > 1) {
        char *end;
        errno = 0;
        seed = strtoull(argv[1], &end, 10);
        if (*end || errno || argv[1][0] < '0' || argv[1][0] > '9') {
            refuse(argv[1], "a seed, a whole number below 2^64");
        }
    }
    simulate(seed, argc > 2 ? argc - 2 : 0, argv + 2);
    if (fflush(stdout) == 0 && !ferror(stdout)) return 0;
    fprintf(stderr, "the rows could not all be written\n");
    return 1;
}
