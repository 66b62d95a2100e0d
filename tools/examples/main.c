/* The command line of every example: PROGRAM [SEED [OPTION...]] */
#include "simulation.h"

#include <stdlib.h>

int main(int argc, char **argv)
{
    uint64_t seed = 1;
    if (argc > 1) {
        char *end;
        seed = strtoull(argv[1], &end, 10);
        if (*end || argv[1][0] < '0' || argv[1][0] > '9') refuse(argv[1], "a seed, a whole number");
    }
    simulate(seed, argc > 2 ? argc - 2 : 0, argv + 2);
    return 0;
}
