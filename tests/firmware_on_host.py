"""The firmware as a library of this machine: `app.c` with a clock, a line and pins that a test controls.

Time advances only while the board is read, so a run is exact and takes as long as its turns.
"""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

from martensite.boards.firmware.project import Firmware
from martensite.boards.link.frames import encode_frame
from martensite.boards.link.messages import pack_message

PER_MS = 50
"""Bytes of a line of 500 kbaud in a millisecond."""
BOARD = """
#include "app.h"
#include "board.h"
#include "loop.h"
#include "settings.h"
static uint32_t now, cost;
static uint8_t in[1 << 16], out[1 << 16];
static uint32_t in_from, in_to, out_size, sampled, longest;
static float duties[APP_DRIVES], levels[APP_CHANNELS];
void board_begin(void) {}
uint32_t board_micros(void) { return now; }
int board_read(void) {
    if (in_from == in_to) return -1;
    now += 5; /* a byte takes its time */
    return in[in_from++ & 0xffffu];
}
uint16_t board_room(void) { return 255; }
void board_write(const uint8_t *bytes, uint16_t size) {
    now += 20u * size; /* as a line of 500 kbaud without a queue */
    for (uint16_t i = 0; i < size && out_size < sizeof out; ++i) out[out_size++] = bytes[i];
}
float board_drive(uint8_t drive, float duty) { return duties[drive] = duty; }
float board_channel(uint8_t channel) {
    if (channel == 0) {
        if (sampled && now - sampled > longest) longest = now - sampled;
        sampled = now;
    }
    return levels[channel];
}
uint8_t board_pulse_channel(uint8_t channel, uint8_t drive, float *steps) {
    *steps = board_channel(channel);
    return duties[drive] > 0.0f ? BOARD_PULSE : BOARD_OPEN;
}
static uint8_t eeprom[256], closed, cause = 1;
void board_guard(void) {}
void board_feed(void) {}
uint8_t board_reset_cause(void) { return cause; }
uint8_t board_load(uint8_t address) { return eeprom[address]; }
uint8_t board_can_store(void) { return 1; }
void board_store(uint8_t address, uint8_t byte) { eeprom[address] = byte; }
uint8_t board_switch(void) { return closed; }
void test_switch(uint8_t is_closed) { closed = is_closed; }
void test_cause(uint8_t of_reset) { cause = of_reset; }
void test_begin(uint32_t at) { now = at; in_from = in_to = out_size = sampled = longest = 0; app_begin(); }
void test_push(const uint8_t *bytes, uint32_t size) {
    for (uint32_t i = 0; i < size; ++i) in[in_to++ & 0xffffu] = bytes[i];
}
void test_turn(uint32_t micros) { now += micros; app_turn(); }
void test_run(uint32_t micros, uint32_t turn) {
    const uint32_t begin = now;
    while (now - begin < micros) test_turn(turn);
}
uint32_t test_take(uint8_t *bytes) {
    const uint32_t size = out_size;
    for (uint32_t i = 0; i < size; ++i) bytes[i] = out[i];
    out_size = 0;
    return size;
}
uint32_t test_now(void) { return now; }
uint32_t test_longest(void) { return longest; }
float test_duty(uint8_t drive) { return duties[drive]; }
void test_level(uint8_t channel, float steps) { levels[channel] = steps; }
"""


class HostBoard:
    """A port to the firmware."""

    def __init__(self, firmware: Firmware, folder: Path, *, start: int = 0, turn: int = 200) -> None:
        firmware.write(folder)
        (folder / "board_test.c").write_text(BOARD, "utf-8")
        sources = ["app.c", "alone_mode.c", "link.c", "loop.c", "board_test.c"]
        words = ["cc", "-std=c99", "-O1", "-shared", "-fPIC", *sources, "-lm", "-o", "board.so"]
        subprocess.run(words, cwd=folder, check=True)
        self.c: Any = ctypes.CDLL(str(folder / "board.so"))
        self.c.test_duty.restype = ctypes.c_float
        self.turn, self._room, self._time, self._last = turn, (ctypes.c_uint8 * (1 << 16))(), 0, start
        self.c.test_begin(ctypes.c_uint32(start))

    def now(self) -> float:
        """Time since the start [s]."""
        micros = self.c.test_now() % (1 << 32)
        self._time += (micros - self._last) % (1 << 32)
        self._last = micros
        return 1e-6 * self._time

    def restart(self) -> None:
        """Begin again, as after a reset."""
        self.c.test_begin(ctypes.c_uint32(self.c.test_now()))

    def set_channel(self, channel: int, steps: float) -> None:
        """Set the reading of a converter."""
        self.c.test_level(channel, ctypes.c_float(steps))

    def duty(self, drive: int = 0) -> float:
        """Return the duty cycle of a switch."""
        return float(self.c.test_duty(drive))

    def longest_gap(self) -> float:
        """Return the longest time between two samples so far [s]."""
        return 1e-6 * self.c.test_longest()

    def write(self, data: bytes) -> int:
        self.c.test_push(data, len(data))
        return len(data)

    def read(self, size: int = 1) -> bytes:
        """What the board has sent after another millisecond."""
        return self.run(1e-3)

    def run(self, seconds: float, turn: int | None = None) -> bytes:
        """Advance by a time [s] with turns of `turn` microseconds."""
        until, output = self.now() + seconds, b""
        while (now := self.now()) < until:
            micros = min(1_000_000, max(1, round(1e6 * (until - now))))
            self.c.test_run(micros, self.turn if turn is None else turn)
            output += bytes(self._room[: self.c.test_take(self._room)])
        return output

    def close(self) -> None:
        pass


def flood(name: str, **values: float) -> Callable[[], bytes]:
    """Return a line that is full of a message."""
    waiting, number = bytearray(), iter(range(1 << 30))

    def fill() -> bytes:
        while len(waiting) < PER_MS:
            code, payload = pack_message(name, **values)
            waiting.extend(encode_frame(code, next(number) % 65536, payload))
        sent = bytes(waiting[:PER_MS])
        del waiting[:PER_MS]
        return sent

    return fill
