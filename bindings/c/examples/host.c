/* The example on a host: `replay SAMPLES FRAMES`. */
#include "replay.h"

#include <stdio.h>

static FILE *input;
static FILE *output;

int io_read(void *buffer, size_t bytes) {
    return fread(buffer, 1, bytes, input) == bytes;
}

int io_write(const void *buffer, size_t bytes) {
    return fwrite(buffer, 1, bytes, output) == bytes;
}

int main(int count, char **arguments) {
    if (count != 3) {
        fprintf(stderr, "usage: replay SAMPLES FRAMES\n");
        return 2;
    }
    input = fopen(arguments[1], "rb");
    output = fopen(arguments[2], "wb");
    if (input == NULL || output == NULL) {
        fprintf(stderr, "a file cannot be opened\n");
        return 2;
    }
    int step = replay();
    if (fclose(output) != 0 || step != 0) {
        fprintf(stderr, "step %d of the replay failed\n", step);
        return 1;
    }
    return 0;
}
