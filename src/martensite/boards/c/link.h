/*
 * Frames between a board and its host, for both ends: C99, no allocation, no library but memcpy.
 *
 *     frame = COBS(type, number, payload, check), 0
 *
 * type: 1 byte, of messages.h; number: 2 bytes, counts the frames of each direction from 0 on and
 * wraps; payload: up to LINK_MOST bytes; check: CRC-32 of what stands before it (IEEE 802.3, as
 * zlib and Ethernet have it). All numbers least byte first. A frame ends with the only byte 0.
 *
 * Sources: Cheshire and Baker (1999), Consistent Overhead Byte Stuffing; IEEE 802.3, clause 3.2.9.
 */
#ifndef LINK_H
#define LINK_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    LINK_MOST = 120,                  /* bytes of a payload */
    LINK_PLAIN = 3 + LINK_MOST + 4,   /* of a frame before it is stuffed; below 254, so one code byte more */
    LINK_FRAME = LINK_PLAIN + 2       /* on the line */
};

/* What a receiver has seen; lost, doubled, reordered and garbled frames are all found by it. */
typedef struct {
    uint32_t good;      /* frames taken */
    uint32_t garbled;   /* that failed their check, or were too long or too short */
    uint32_t lost;      /* numbers that never came */
    uint32_t doubled;   /* that came again; they are not taken */
    uint32_t reordered; /* that came late, after a later one; they are not taken */
} link_counts;

typedef struct {
    uint8_t bytes[LINK_FRAME];
    uint8_t filled, spilt; /* spilt: longer than any frame, up to its end */
    uint8_t begun;         /* a first frame has come */
    uint16_t newest;       /* its number */
    uint32_t window;       /* bit k: the frame `newest - k` has come */
    link_counts counts;
} link_receiver;

typedef struct {
    uint8_t type;
    uint8_t size;
    uint16_t number;
    const uint8_t *payload; /* valid until the next byte is given to the receiver */
} link_message;

/* The check of bytes. */
uint32_t link_check(const uint8_t *bytes, uint16_t size);

/* A frame of a message, into out[LINK_FRAME]; its length, or 0 if the payload is too long. */
uint16_t link_encode(uint8_t *out, uint8_t type, uint16_t number, const uint8_t *payload, uint8_t size);

/* Nothing received yet; counts begin at 0. */
void link_begin(link_receiver *r);

/* The other end begins anew: its numbers do, and what was counted stays. */
void link_restart(link_receiver *r);

/* One byte from the line; 1 if it ends a frame that is good and new, which is then in *m. */
int link_receive(link_receiver *r, uint8_t byte, link_message *m);

/* Numbers of a payload, least byte first. */
uint16_t link_u16(const uint8_t *b);
uint32_t link_u32(const uint8_t *b);
float link_f32(const uint8_t *b);
void link_put_u16(uint8_t *b, uint16_t x);
void link_put_u32(uint8_t *b, uint32_t x);
void link_put_f32(uint8_t *b, float x);

/* A clock of 32 bits in microseconds, which wraps after 71.6 minutes, as one that does not. */
typedef struct {
    uint32_t last;
    uint32_t wraps;
} link_clock;
uint64_t link_unwrap(link_clock *c, uint32_t micros);

#ifdef __cplusplus
}
#endif

#endif
