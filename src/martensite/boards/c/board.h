/*
 * What a board must be able to do. Everything else of the firmware is the same on all boards.
 */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Clock, serial line, PWM (off), inputs. */
void board_begin(void);

/* Microseconds since then; wraps after 71.6 minutes. */
uint32_t board_micros(void);

/* The next byte from the host, or -1. */
int board_read(void);

/* Bytes that can be sent without waiting; then send them. */
uint16_t board_room(void);
void board_write(const uint8_t *bytes, uint16_t size);

/* Share of the time, 0 to 1, for which the switch of a drive is closed; 0 is off. What it is in steps of the timer. */
float board_drive(uint8_t drive, float duty);

/* What a channel reads now: steps of a converter, or counts of an encoder. */
float board_channel(uint8_t channel);

/*
 * What a channel reads while the switch of a drive is closed, APP_SETTLE_US after the switch closed or later. BOARD_OPEN
 * if the switch is off: what the channel reads then. BOARD_SHORT if the pulse is too short: *steps stays.
 */
enum { BOARD_OPEN, BOARD_SHORT, BOARD_PULSE };
uint8_t board_pulse_channel(uint8_t channel, uint8_t drive, float *steps);

/* Start the watchdog; called once, after board_begin. */
void board_guard(void);

/* The watchdog begins anew; called only by a turn that has sampled and checked. */
void board_feed(void);

/* Stand-alone operation: bytes that stay without power; whether a byte can be written now; a switch that is closed. */
uint8_t board_load(uint8_t address);
uint8_t board_can_store(void);
void board_store(uint8_t address, uint8_t byte);
uint8_t board_switch(void);

/* Cause of the newest reset: a RESET_ of messages.h. */
uint8_t board_reset_cause(void);

#ifdef __cplusplus
}
#endif

#endif
