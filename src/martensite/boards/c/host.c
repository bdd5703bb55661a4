#define _DEFAULT_SOURCE /* speeds above 38400 baud, cfmakeraw */
#include "host.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "messages.h"

enum { TRIES = 5, WAIT_MS = 200, TURN_MS = 10, LONGEST_FILE = 65536 };

static double now(void) {
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static speed_t find_speed(void) {
    switch (FIRMWARE_BAUD) {
        case 500000: return B500000;
        case 921600: return B921600;
        case 1000000: return B1000000;
        default: return B115200;
    }
}

/* A frame goes out as a whole, or the line counts as broken. */
static host_result send_frame(host_board *h, uint8_t type, const uint8_t *payload, uint8_t size) {
    uint8_t frame[LINK_FRAME];
    const uint16_t length = link_encode(frame, type, h->sent, payload, size);
    ++h->sent;
    return write(h->file, frame, length) == (ssize_t)length ? HOST_OK : HOST_LINE;
}

static void take_message(host_board *h, const link_message *m) {
    const uint8_t *b = m->payload;
    if (m->type == MESSAGE_HELLO && m->size == HELLO_SIZE && b[HELLO_VERSION] == LINK_VERSION) {
        h->hello = 1;
        h->digest = link_u32(b + HELLO_DIGEST);
    } else if (m->type == MESSAGE_ANSWER && m->size == ANSWER_SIZE) {
        h->answered = 1;
        h->answer_to = link_u16(b + ANSWER_TO);
        h->result = b[ANSWER_RESULT];
    } else if (m->type == MESSAGE_DISARMED && m->size == DISARMED_SIZE) {
        h->disarmed = 1;
        h->reason = b[DISARMED_REASON];
    } else if (m->type == MESSAGE_TELEMETRY && m->size == TELEMETRY_SIZE + 4 * FIRMWARE_VALUES) {
        h->time = 1e-6 * (double)link_unwrap(&h->clock, link_u32(b + TELEMETRY_TIME));
        h->flags = b[TELEMETRY_FLAGS];
        h->alarm = b[TELEMETRY_ALARM];
        for (int i = 0; i < FIRMWARE_VALUES; ++i) h->values[i] = link_f32(b + TELEMETRY_SIZE + 4 * i);
        h->heard = now();
        ++h->samples;
    }
}

static host_result take_bytes(host_board *h) {
    uint8_t bytes[256];
    ssize_t count;
    while ((count = read(h->file, bytes, sizeof bytes)) > 0) {
        for (ssize_t i = 0; i < count; ++i) {
            link_message message;
            if (link_receive(&h->line, bytes[i], &message)) take_message(h, &message);
        }
    }
    return count < 0 && errno != EAGAIN && errno != EINTR ? HOST_LINE : HOST_OK;
}

static host_result wait_bytes(host_board *h) {
    struct pollfd one = {h->file, POLLIN, 0};
    if (poll(&one, 1, TURN_MS) < 0 && errno != EINTR) return HOST_LINE;
    return take_bytes(h);
}

static host_result command(host_board *h, uint8_t type, const uint8_t *payload, uint8_t size) {
    for (int k = 0; k < TRIES; ++k) {
        const uint16_t number = h->sent;
        const double until = now() + 1e-3 * WAIT_MS;
        h->answered = 0;
        if (send_frame(h, type, payload, size) != HOST_OK) return HOST_LINE;
        while (now() < until) {
            if (wait_bytes(h) != HOST_OK) return HOST_LINE;
            if (h->answered && h->answer_to == number) return h->result == RESULT_DONE ? HOST_OK : HOST_REFUSED;
        }
    }
    return HOST_SILENT;
}

static host_result greet(host_board *h) {
    uint8_t token[PING_SIZE];
    link_put_u32(token, FIRMWARE_DIGEST);
    for (int k = 0; k < TRIES && !h->hello; ++k) {
        const double until = now() + 1e-3 * WAIT_MS;
        if (send_frame(h, MESSAGE_PING, token, PING_SIZE) != HOST_OK) return HOST_LINE;
        while (!h->hello && now() < until)
            if (wait_bytes(h) != HOST_OK) return HOST_LINE;
    }
    if (!h->hello) return HOST_SILENT;
    return h->digest == FIRMWARE_DIGEST ? HOST_OK : HOST_FIRMWARE;
}

host_result host_open(host_board *h, const char *port) {
    struct termios line;
    uint8_t every[RATE_SIZE];
    memset(h, 0, sizeof *h);
    link_begin(&h->line);
    h->heard = now();
    h->file = open(port, O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (h->file < 0 || tcgetattr(h->file, &line) != 0) return HOST_LINE;
    cfmakeraw(&line);
    if (cfsetspeed(&line, find_speed()) != 0 || tcsetattr(h->file, TCSANOW, &line) != 0) return HOST_LINE;
    const host_result found = greet(h);
    if (found != HOST_OK) return found;
    link_put_u16(every, 1);
    return command(h, MESSAGE_RATE, every, RATE_SIZE);
}

static host_result command_set(host_board *h, int place, float value) {
    uint8_t b[SET_SIZE];
    if (place < 0) return HOST_CALIBRATION;
    b[SET_PLACE] = (uint8_t)place;
    link_put_f32(b + SET_VALUE, value);
    return command(h, MESSAGE_SET, b, SET_SIZE);
}

/* Sends the pairs of "settings": {"name": number, ...}. */
static host_result send_settings(host_board *h, char *text) {
    char *at = strstr(text, "\"settings\"");
    char *end = at ? strchr(at, '}') : NULL;
    at = at ? strchr(at, '{') : NULL;
    if (!at || !end) return HOST_CALIBRATION;
    *end = 0;
    while ((at = strchr(at, '"')) != NULL) {
        char *name = at + 1, *after = strchr(name, '"');
        char *colon = after ? strchr(after, ':') : NULL;
        if (!colon) return HOST_CALIBRATION;
        *after = 0;
        const host_result found = command_set(h, host_find(name), strtof(colon + 1, &at));
        if (found != HOST_OK) return found;
    }
    return HOST_OK;
}

host_result host_calibrate(host_board *h, const char *path) {
    static char text[LONGEST_FILE];
    FILE *file = fopen(path, "r");
    if (!file) return HOST_CALIBRATION;
    const size_t size = fread(text, 1, sizeof text - 1, file);
    (void)fclose(file);
    text[size] = 0;
    return send_settings(h, text);
}

host_result host_arm(host_board *h) {
    const uint8_t mode = MODE_LOOP;
    uint8_t word[ARM_SIZE];
    link_put_u32(word, LINK_ARM_WORD);
    const host_result chosen = command(h, MESSAGE_MODE, &mode, MODE_SIZE);
    h->disarmed = 0;
    return chosen == HOST_OK ? command(h, MESSAGE_ARM, word, ARM_SIZE) : chosen;
}

void host_close(host_board *h) {
    if (h->file >= 0) {
        (void)send_frame(h, MESSAGE_DISARM, NULL, 0);
        (void)close(h->file);
    }
    h->file = -1;
}

int host_find(const char *name) {
    for (int i = 0; i < FIRMWARE_SETTINGS; ++i)
        if (strcmp(firmware_settings[i], name) == 0) return i;
    return -1;
}

host_result host_set(host_board *h, uint8_t place, float value) {
    uint8_t b[SET_SIZE];
    b[SET_PLACE] = place;
    link_put_f32(b + SET_VALUE, value);
    return send_frame(h, MESSAGE_SET, b, SET_SIZE);
}

host_result host_read(host_board *h) {
    if (take_bytes(h) != HOST_OK) return HOST_LINE;
    if (h->disarmed) return HOST_DISARMED;
    return host_age(h) > FIRMWARE_STALE ? HOST_STALE : HOST_OK;
}

double host_age(const host_board *h) { return now() - h->heard; }

const char *host_explain(host_result result) {
    switch (result) {
        case HOST_OK: return "The board runs.";
        case HOST_LINE: return "The line to the board is broken or full: check port and cable.";
        case HOST_SILENT: return "The board does not answer: check its power and its firmware.";
        case HOST_FIRMWARE: return "The board holds another firmware: write this project to the board.";
        case HOST_CALIBRATION: return "The calibration cannot be read: run `martensite hardware calibrate`.";
        case HOST_REFUSED: return "The board refused a command: is it calibrated, and is its supply on?";
        case HOST_DISARMED: return "The board disarmed itself.";
        case HOST_STALE: return "The newest telemetry is too old: check the cable and the power of the board.";
    }
    return "Unknown result.";
}
