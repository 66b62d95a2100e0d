/* An example on an emulated core, which has no command line */
#include "simulation.h"

#include <stdio.h>

int main(void)
{
    simulate(1, 0, NULL);
    puts("OK");
    return 0;
}
