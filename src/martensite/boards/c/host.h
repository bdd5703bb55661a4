/*
 * A board from a program in C or C++ on Linux: open the line, calibrate, arm, set references, read telemetry.
 *
 * host_open, host_calibrate and host_arm wait for the answers of the board, each for at most a second. host_set and
 * host_read never wait and allocate no memory: call host_set at least every 10 ms, because the board disarms when it
 * hears nothing. Every function returns HOST_OK or the reason of its failure.
 */
#ifndef HOST_H
#define HOST_H

#include <stdint.h>

#include "firmware.h"
#include "link.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    HOST_OK,
    HOST_LINE,        /* the line cannot be opened, is broken, or is full */
    HOST_SILENT,      /* no answer */
    HOST_FIRMWARE,    /* the board holds another firmware */
    HOST_CALIBRATION, /* the file cannot be read, or names a setting that the firmware lacks */
    HOST_REFUSED,     /* the board refused a command */
    HOST_DISARMED,    /* the board disarmed itself: see `reason` */
    HOST_STALE        /* the newest telemetry is older than FIRMWARE_STALE */
} host_result;

typedef struct {
    /* the newest telemetry, in SI */
    double time; /* of the board [s] */
    float values[FIRMWARE_VALUES];
    uint8_t flags, alarm;
    uint32_t samples;
    uint8_t reason; /* REASON_... of messages.h, if the board disarmed itself */
    /* of the link */
    int file;
    uint8_t hello, disarmed, answered, result;
    uint16_t sent, answer_to;
    uint32_t digest;
    double heard; /* monotonic time of the newest telemetry [s] */
    link_receiver line;
    link_clock clock;
} host_board;

/* Open a serial port, greet the board, and ask for telemetry of every sample. */
host_result host_open(host_board *h, const char *port);

/* Send gains and offsets from `calibration.json`, which `martensite hardware calibrate` writes. */
host_result host_calibrate(host_board *h, const char *path);

/* Let the loop on the board drive its switches; disarm and close the line. */
host_result host_arm(host_board *h);
void host_close(host_board *h);

/* Place of a setting by its name in firmware.h, or -1; set it. */
int host_find(const char *name);
host_result host_set(host_board *h, uint8_t place, float value);

/* Take all messages that have come. */
host_result host_read(host_board *h);

/* Age of the newest telemetry [s]; a result as a sentence. */
double host_age(const host_board *h);
const char *host_explain(host_result result);

#ifdef __cplusplus
}
#endif

#endif
