/* replay FILE: each line of hexadecimal digits is an input of fuzz_objects.c, which stops the program where something does not hold. */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static unsigned digit(char c) { return c <= '9' ? (unsigned)(c - '0') : (unsigned)(c - 'a' + 10); }

int main(int count, char **arguments)
{
    static char line[1 << 16];
    static uint8_t bytes[sizeof line / 2];
    FILE *file = count == 2 ? fopen(arguments[1], "r") : NULL;
    int inputs = 0;
    while (file && fgets(line, sizeof line, file)) {
        const size_t size = strcspn(line, "\n") / 2;
        for (size_t k = 0; k < size; k++) bytes[k] = (uint8_t)(digit(line[2 * k]) << 4 | digit(line[2 * k + 1]));
        (void)LLVMFuzzerTestOneInput(bytes, size);
        inputs++;
    }
    printf("%d inputs\n", inputs);
    return inputs > 0 ? 0 : 1;
}
