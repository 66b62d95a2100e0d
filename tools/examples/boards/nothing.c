/* What an example's program is without its filter: boards.py counts the difference. */
#include "board.h"

int example(void);
int example(void)
{
    for (int t = 0; t < ROWS; t++) show(recording[t].z[0]);
    return 0;
}
