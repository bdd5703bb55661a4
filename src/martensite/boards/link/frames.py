"""Frames on the line: COBS, a number, a CRC-32; counters of lost, doubled, late and garbled frames.

    frame = COBS(type, number, payload, check), 0

as in `link.h` of the firmware. 16-bit numbers count the frames of each direction. A frame is accepted if its check is
right and its number is larger than all before.

Sources: Cheshire and Baker (1999), IEEE/ACM Trans. Networking 7; CRC-32 of IEEE 802.3.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

from cobs import cobs

from martensite.base.errors import DataError, InputError
from martensite.boards.link.messages import MOST, Message, unpack_message

HEAD, CHECK = struct.Struct("<BH"), struct.Struct("<I")
LONGEST = HEAD.size + MOST + CHECK.size + 1
"""Largest number of bytes before the end of a frame."""
LATE = 32
"""Number of remembered frame numbers before the newest."""
WRAP = 1 << 16


def encode_frame(code: int, number: int, payload: bytes) -> bytes:
    """Return a frame with its end.

    Raises:
        InputError: the payload is too long.
    """
    if len(payload) > MOST:
        raise InputError(f"A payload has at most {MOST} bytes, but this one has {len(payload)}.")
    plain = HEAD.pack(code, number % WRAP) + payload
    return cobs.encode(plain + CHECK.pack(zlib.crc32(plain))) + b"\0"


@dataclass
class LinkCounts:
    """Counters of received and lost messages."""

    good: int = 0
    garbled: int = 0
    """Frames with a wrong check, or invalid frames."""
    lost: int = 0
    """Missing numbers."""
    doubled: int = 0
    """Rejected repeated frames."""
    reordered: int = 0
    """Rejected late frames."""
    unknown: int = 0
    """Good frames with an unknown message, from another version."""

    def describe(self) -> str:
        """Describe the rejected and missing frames."""
        return f"{self.lost} lost, {self.garbled} garbled, {self.doubled} doubled, {self.reordered} late"


@dataclass
class FrameReader:
    """Reader of messages from bytes; it never raises."""

    counts: LinkCounts = field(default_factory=LinkCounts)
    _buffer: bytearray = field(default_factory=bytearray)
    _newest: int | None = None
    _window: int = 0

    def restart(self) -> None:
        """Reset the frame number after a restart of the other end."""
        self._newest = None

    def feed(self, data: bytes) -> Iterator[Message]:
        """Yield the messages that these bytes complete."""
        *whole, rest = data.split(b"\0")
        for piece in whole:
            self._keep(piece)
            frame, self._buffer = bytes(self._buffer), bytearray()
            if frame:
                yield from self._read_frame(frame)
        self._keep(rest)

    def _keep(self, piece: bytes) -> None:
        room = LONGEST + 1 - len(self._buffer)  # one more than any frame has: it then fails
        self._buffer += piece[: max(room, 0)]

    def _read_frame(self, frame: bytes) -> Iterator[Message]:
        plain = _unstuff_frame(frame)
        if plain is None:
            self.counts.garbled += 1
            return
        code, number = HEAD.unpack_from(plain)
        if not self._take(number):
            return
        self.counts.good += 1
        try:
            yield unpack_message(code, plain[HEAD.size : -CHECK.size], number)
        except DataError:
            self.counts.unknown += 1

    def _take(self, number: int) -> bool:
        """Return whether a number comes after all others, and count missing, late or doubled frames."""
        if self._newest is None:
            self._newest, self._window = number, (1 << LATE) - 1  # earlier frames do not count
            return True
        ahead = (number - self._newest) % WRAP
        if 0 < ahead < WRAP // 2:
            self.counts.lost += ahead - 1
            self._window = ((self._window << ahead) | 1) % (1 << LATE) if ahead < LATE else 1
            self._newest = number
            return True
        behind = -ahead % WRAP
        if 0 < behind < LATE and not self._window >> behind & 1:
            self._window |= 1 << behind
            self.counts.reordered += 1
            self.counts.lost = max(self.counts.lost - 1, 0)  # it was counted as lost
        else:
            self.counts.doubled += 1
        return False


def _unstuff_frame(frame: bytes) -> bytes | None:
    """Return the bytes of a frame, or None for a wrong check."""
    if len(frame) > LONGEST:
        return None
    try:
        plain = cobs.decode(frame)
    except cobs.DecodeError:
        return None
    if len(plain) < HEAD.size + CHECK.size:
        return None
    (check,) = CHECK.unpack_from(plain, len(plain) - CHECK.size)
    return plain if zlib.crc32(plain[: -CHECK.size]) == check else None


@dataclass
class BoardClock:
    """A 32-bit clock in microseconds, which wraps after 71.6 minutes, without wraps."""

    _last: int = 0
    _wraps: int = 0

    def unwrap(self, micros: int) -> int:
        """Return the time since the start of the board [us]."""
        if micros < self._last:
            self._wraps += 1
        self._last = micros
        return (self._wraps << 32) | micros
