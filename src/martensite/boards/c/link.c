#include "link.h"

#include <string.h>

enum { HEAD = 3, CHECK = 4, LATE = 32 /* numbers that a window remembers */ };

#if defined(__AVR__)
#include <avr/pgmspace.h>
#define IN_FLASH PROGMEM
#define FROM_FLASH(place) pgm_read_dword(place)
#else
#define IN_FLASH
#define FROM_FLASH(place) (*(place))
#endif

/* CRC-32 by half bytes: 64 bytes of table instead of 1024. */
static const uint32_t table[16] IN_FLASH = {
    0x00000000u, 0x1db71064u, 0x3b6e20c8u, 0x26d930acu, 0x76dc4190u, 0x6b6b51f4u, 0x4db26158u, 0x5005713cu,
    0xedb88320u, 0xf00f9344u, 0xd6d6a3e8u, 0xcb61b38cu, 0x9b64c2b0u, 0x86d3d2d4u, 0xa00ae278u, 0xbdbdf21cu,
};

uint32_t link_check(const uint8_t *bytes, uint16_t size) {
    uint32_t crc = 0xffffffffu;
    for (uint16_t i = 0; i < size; ++i) {
        crc ^= bytes[i];
        crc = FROM_FLASH(&table[crc & 15u]) ^ (crc >> 4);
        crc = FROM_FLASH(&table[crc & 15u]) ^ (crc >> 4);
    }
    return ~crc;
}

uint16_t link_u16(const uint8_t *b) { return (uint16_t)(b[0] | (uint16_t)(b[1] << 8)); }

uint32_t link_u32(const uint8_t *b) { return (uint32_t)link_u16(b) | ((uint32_t)link_u16(b + 2) << 16); }

float link_f32(const uint8_t *b) {
    const uint32_t bits = link_u32(b);
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

void link_put_u16(uint8_t *b, uint16_t x) {
    b[0] = (uint8_t)(x & 0xffu);
    b[1] = (uint8_t)(x >> 8);
}

void link_put_u32(uint8_t *b, uint32_t x) {
    link_put_u16(b, (uint16_t)(x & 0xffffu));
    link_put_u16(b + 2, (uint16_t)(x >> 16));
}

void link_put_f32(uint8_t *b, float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    link_put_u32(b, bits);
}

/* Stuffs in place: out[1 .. size] holds the plain bytes, out[0] is free. Below 254 bytes one code is enough. */
static uint16_t stuff(uint8_t *out, uint16_t size) {
    uint16_t code = 0;
    for (uint16_t i = 1; i <= size; ++i)
        if (out[i] == 0) {
            out[code] = (uint8_t)(i - code);
            code = i;
        }
    out[code] = (uint8_t)(size + 1 - code);
    out[size + 1] = 0;
    return (uint16_t)(size + 2);
}

/* The plain bytes of in[0 .. size-1], in place from in[1] on; their number, or 0 if it is no COBS. */
static uint8_t unstuff(uint8_t *in, uint8_t size) {
    uint8_t next = 0;
    while (next < size) {
        const uint8_t code = in[next];
        if (code == 0 || code > size - next) return 0;
        in[next] = 0;
        next = (uint8_t)(next + code);
    }
    return (uint8_t)(size - 1);
}

uint16_t link_encode(uint8_t *out, uint8_t type, uint16_t number, const uint8_t *payload, uint8_t size) {
    if (size > LINK_MOST) return 0;
    out[1] = type;
    link_put_u16(out + 2, number);
    if (size) memcpy(out + 1 + HEAD, payload, size);
    link_put_u32(out + 1 + HEAD + size, link_check(out + 1, (uint16_t)(HEAD + size)));
    return stuff(out, (uint16_t)(HEAD + size + CHECK));
}

void link_begin(link_receiver *r) { memset(r, 0, sizeof *r); }

void link_restart(link_receiver *r) { r->begun = 0; }

/* Whether a number is new and not before one that has come; counts what is missing, late or double. */
static int take(link_receiver *r, uint16_t number) {
    if (!r->begun) {
        r->begun = 1;
        r->newest = number;
        r->window = 0xffffffffu; /* what may have come before is not waited for */
        return 1;
    }
    const uint16_t ahead = (uint16_t)(number - r->newest);
    if (ahead == 0) {
        ++r->counts.doubled;
        return 0;
    }
    if (ahead < 0x8000u) {
        r->counts.lost += (uint32_t)(ahead - 1u);
        r->window = ahead < LATE ? (r->window << ahead) | 1u : 1u;
        r->newest = number;
        return 1;
    }
    const uint16_t behind = (uint16_t)(0u - ahead);
    if (behind < LATE && !(r->window >> behind & 1u)) {
        r->window |= (uint32_t)1 << behind;
        ++r->counts.reordered;
        if (r->counts.lost) --r->counts.lost; /* it was taken for lost */
    } else {
        ++r->counts.doubled;
    }
    return 0;
}

static int end_frame(link_receiver *r, link_message *m) {
    const uint8_t spilt = r->spilt, filled = r->filled;
    r->spilt = r->filled = 0;
    if (!filled && !spilt) return 0; /* two ends in a row: nothing between them */
    const uint8_t size = spilt ? 0 : unstuff(r->bytes, filled);
    const uint8_t *plain = r->bytes + 1;
    if (size < HEAD + CHECK || link_check(plain, (uint16_t)(size - CHECK)) != link_u32(plain + size - CHECK)) {
        ++r->counts.garbled;
        return 0;
    }
    const uint16_t number = link_u16(plain + 1);
    if (!take(r, number)) return 0;
    ++r->counts.good;
    m->type = plain[0];
    m->size = (uint8_t)(size - HEAD - CHECK);
    m->number = number;
    m->payload = plain + HEAD;
    return 1;
}

int link_receive(link_receiver *r, uint8_t byte, link_message *m) {
    if (byte == 0) return end_frame(r, m);
    if (r->filled < LINK_FRAME - 1) {
        r->bytes[r->filled++] = byte;
    } else {
        r->spilt = 1;
    }
    return 0;
}

uint64_t link_unwrap(link_clock *c, uint32_t micros) {
    if (micros < c->last) ++c->wraps;
    c->last = micros;
    return ((uint64_t)c->wraps << 32) | micros;
}
