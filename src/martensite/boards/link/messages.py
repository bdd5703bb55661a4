"""Messages between host and board: types and fields in one table.

Fields are numbers, least significant byte first; a message may end with any number of repeated fields (`values`). The
header of the firmware, `messages.h`, is generated from the same table. `VERSION` changes with the table; both ends send
it.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import Any, NamedTuple

from martensite.base.errors import DataError, InputError, suggest_name

VERSION = 2
MOST = 120
"""Largest number of bytes of a payload."""
ARM_WORD = int.from_bytes(b"ARM!", "little")
"""Required content of `arm`."""
CODES = {"u8": "B", "u16": "H", "u32": "I", "f32": "f"}
"""Code in `struct` by kind of field."""


class Mode(IntEnum):
    """Source of the signals of a board."""

    IDLE = 0
    LOOP = 1
    """Exported loop on the readings of the board."""
    WAVEFORM = 2
    EMULATED = 3
    """Exported loop on readings from the host, one sample each."""


class BoardFlags(IntFlag):
    """State of a board, in every telemetry."""

    ARMED = 1
    GUARDED = 2
    BROWN_OUT = 4
    OVERRUN = 8
    STOPPED = 16
    """The loop could not be solved; signals are off until it restarts."""
    EMULATED = 32


class BoardAnswer(IntEnum):
    """Answer of a board to a command."""

    DONE = 0
    UNKNOWN = 1
    """Unknown message, or another length."""
    REFUSED = 2
    OUT_OF_RANGE = 3
    FULL = 4
    FIXED = 5
    """The number is a constant in flash."""
    BUSY = 6
    """The board still writes; ask again."""


class DisarmReason(IntEnum):
    """Reason why a board disarmed itself."""

    ASKED = 0
    SILENCE = 1
    GUARD = 2
    BROWN_OUT = 3
    LOOP = 4
    TIME = 5
    CURRENT = 6
    OVERRUN = 7
    """A sample was late by a period or more."""
    PIN = 8
    """The switch of stand-alone operation was opened."""


class ResetCause(IntEnum):
    """Cause of the newest reset of a board."""

    UNKNOWN = 0
    POWER_ON = 1
    BROWN_OUT = 2
    WATCHDOG = 3
    PIN = 4
    FAULT = 5
    """Fault of the processor, unexpected interrupt, or overflow of the stack."""


class Message(NamedTuple):
    """One message of a board or its host."""

    name: str
    values: Mapping[str, Any]
    """Values by field; repeated fields are a tuple."""
    number: int = 0


@dataclass(frozen=True)
class MessageKind:
    """A kind of message."""

    name: str
    code: int
    about: str
    fields: Mapping[str, str]
    """Kind by name of field, see `CODES`."""
    repeated: str = ""
    """Name of the repeated f32 field."""

    @property
    def layout(self) -> struct.Struct:
        """Return the layout of the fields before the repeated field."""
        return struct.Struct("<" + "".join(CODES[kind] for kind in self.fields.values()))

    def pack(self, values: Mapping[str, Any]) -> bytes:
        """Return the payload.

        Raises:
            InputError: a field is missing, unknown, or does not fit.
        """
        for name in (*self.fields, *filter(None, [self.repeated])):
            if name not in values:
                raise InputError(f"Message `{self.name}` needs `{name}`.")
        for name in values:
            if name not in self.fields and name != self.repeated:
                raise InputError(f"Message `{self.name}` has no field `{name}`. {suggest_name(name, self.fields)}")
        rest: Sequence[float] = values[self.repeated] if self.repeated else ()
        try:
            payload = self.layout.pack(*(values[name] for name in self.fields)) + struct.pack(f"<{len(rest)}f", *rest)
        except (struct.error, OverflowError) as error:
            raise InputError(f"Message `{self.name}` cannot hold {dict(values)}: {error}.") from None
        if len(payload) > MOST:
            raise InputError(f"Message `{self.name}` would have {len(payload)} bytes; {MOST} is the most.")
        return payload

    def unpack(self, payload: bytes) -> dict[str, Any]:
        """Return the fields of a payload; raise `DataError` for a wrong length."""
        size = self.layout.size
        more, odd = divmod(len(payload) - size, 4)
        if more < 0 or odd or (more and not self.repeated):
            raise DataError(f"A message `{self.name}` cannot have {len(payload)} bytes.")
        values = dict(zip(self.fields, self.layout.unpack_from(payload), strict=True))
        if self.repeated:
            values[self.repeated] = struct.unpack_from(f"<{more}f", payload, size)
        return values


KINDS = {
    one.name: one
    for one in (
        MessageKind("ping", 0x01, "is anybody there", {"token": "u32"}),
        MessageKind("arm", 0x02, "let signals pass", {"word": "u32"}),
        MessageKind("disarm", 0x03, "all signals off", {}),
        MessageKind("mode", 0x04, "what makes the signals", {"mode": "u8"}),
        MessageKind("set", 0x05, "a setting: a reference, a gain, a calibration", {"place": "u8", "value": "f32"}),
        MessageKind("read", 0x06, "a setting is asked for", {"place": "u8"}),
        MessageKind("level", 0x07, "the next level of a waveform", {"drive": "u8", "micros": "u32", "value": "f32"}),
        MessageKind("sample", 0x08, "readings of an emulated sample", {"time": "u32"}, "readings"),
        MessageKind("rate", 0x09, "telemetry once in so many samples; 0 for none", {"every": "u16"}),
        MessageKind("store", 0x0A, "keep the calibration without power", {}),
        MessageKind(
            "hello",
            0x81,
            "who answers a ping",
            {"token": "u32", "version": "u8", "digest": "u32", "time": "u32", "reset": "u8"},
        ),
        MessageKind("answer", 0x82, "how a command ended", {"to": "u16", "result": "u8", "room": "u8"}),
        MessageKind("telemetry", 0x83, "a sample", {"time": "u32", "flags": "u8", "alarm": "u8"}, "values"),
        MessageKind("setting", 0x84, "a setting that was asked for", {"place": "u8", "value": "f32"}),
        MessageKind("disarmed", 0x85, "signals are off", {"time": "u32", "reason": "u8"}),
    )
}
BY_CODE = {one.code: one for one in KINDS.values()}


def pack_message(name: str, **values: Any) -> tuple[int, bytes]:
    """Return type and payload of a message.

    Raises:
        InputError: the message is unknown, or its fields do not fit.
    """
    if name not in KINDS:
        raise InputError(f"There is no message `{name}`. {suggest_name(name, KINDS)}")
    return KINDS[name].code, KINDS[name].pack(values)


def unpack_message(code: int, payload: bytes, number: int = 0) -> Message:
    """Return a message from type and payload; raise `DataError` for an unknown type."""
    if code not in BY_CODE:
        raise DataError(f"There is no message of type {code:#04x}.")
    return Message(BY_CODE[code].name, BY_CODE[code].unpack(payload), number)


def print_header() -> str:
    """Return the text of `messages.h`: types, lengths and places of fields."""
    rows = ["/* Messages of the link, printed by martensite. Types, lengths and places of fields. */"]
    rows += ["#ifndef MESSAGES_H", "#define MESSAGES_H", "", f"#define LINK_VERSION {VERSION}"]
    rows += [f"#define LINK_ARM_WORD {ARM_WORD:#x}UL", ""]
    for one in KINDS.values():
        rows += [f"/* {one.name}: {one.about} */", "enum {", *_print_places(one), "};"]
    for prefix, words in {
        "MODE": Mode,
        "FLAG": BoardFlags,
        "RESULT": BoardAnswer,
        "REASON": DisarmReason,
        "RESET": ResetCause,
    }.items():
        rows += ["enum {", *(f"    {prefix}_{word.name} = {word.value}," for word in words), "};"]
    return "\n".join([*rows, "", "#endif", ""])


def _print_places(kind: MessageKind) -> Iterator[str]:
    name, place = kind.name.upper(), 0
    yield f"    MESSAGE_{name} = {kind.code:#04x},"
    for field, code in kind.fields.items():
        yield f"    {name}_{field.upper()} = {place}, /* {code} */"
        place += struct.calcsize(f"<{CODES[code]}")
    yield f"    {name}_SIZE = {place}" + (f" /* then {kind.repeated}, f32 */" if kind.repeated else "")
