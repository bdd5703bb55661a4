/* Runs the loop of a board with a constant reference: example PORT CALIBRATION REFERENCE VALUE SECONDS */
#define _DEFAULT_SOURCE /* nanosleep */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "host.h"

static int end(host_board *h, host_result result) {
    printf("%u samples; %s\n", (unsigned)h->samples, host_explain(result));
    host_close(h);
    return result == HOST_OK ? 0 : 1;
}

int main(int count, char **words) {
    static host_board board;
    if (count != 6) {
        fprintf(stderr, "example PORT CALIBRATION REFERENCE VALUE SECONDS\n");
        return 2;
    }
    const int place = host_find(words[3]);
    const float value = strtof(words[4], NULL);
    if (place < 0) {
        fprintf(stderr, "The firmware has no setting `%s`.\n", words[3]);
        return 2;
    }
    host_result found = host_open(&board, words[1]);
    if (found == HOST_OK) found = host_calibrate(&board, words[2]);
    if (found == HOST_OK) found = host_arm(&board);
    const struct timespec turn = {0, 10000000};
    for (int left = (int)(100.0 * strtod(words[5], NULL)); left > 0 && found == HOST_OK; --left) {
        found = host_set(&board, (uint8_t)place, value);
        if (found == HOST_OK) found = host_read(&board);
        (void)nanosleep(&turn, NULL);
    }
    for (int i = 0; i < FIRMWARE_VALUES; ++i) printf("%s %g\n", firmware_values[i], (double)board.values[i]);
    return end(&board, found);
}
