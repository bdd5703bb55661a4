"""Boards with firmware, from `boards.toml`."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from martensite.base.errors import UnknownNameError

LARGER = "a larger board, such as mega2560 or stm32f405"
"""Advice for a firmware that does not fit."""


@dataclass(frozen=True)
class Board:
    """A board: converter, pins, memory."""

    name: str
    title: str
    layer: str
    """Layer between the board and the firmware: `arduino` or `stm32f405`."""
    clock: float
    """[Hz]"""
    ram: int
    """[bytes]"""
    flash: int
    """[bytes]"""
    steps: int
    """Steps of the converter."""
    volts: float
    """Full scale of the converter [V]."""
    hold: float
    """Longest time from the start of a conversion to the held input [s]; 0 if it cannot start in a pulse."""
    pwm: tuple[float, float]
    """Lowest and highest frequency of the pulses [Hz]."""
    baud: int
    drive_pins: tuple[int, ...]
    channel_pins: tuple[int, ...]
    encoder_pins: tuple[int, ...]
    platformio: dict[str, str]
    """Platform and board of PlatformIO; empty without PlatformIO."""
    arm_pin: int | None = None
    """Pin of the switch of stand-alone operation; None for boards without stand-alone operation."""
    first_analog: int | None = None
    """Pin that is labelled A0; None for boards with numbered pins."""

    @property
    def avr(self) -> bool:
        """Return whether the processor is an AVR."""
        return self.platformio.get("platform") == "atmelavr"

    def name_pin(self, pin: int) -> str:
        """Return the label of a channel pin."""
        if self.layer == "stm32f405":
            return f"PA{pin}"
        first = self.first_analog
        return f"A{pin - first}" if first is not None and pin >= first else str(pin)

    def name_drive_pin(self, pin: int) -> str:
        """Return the label of a switch pin."""
        return ("PA6", "PA7", "PB0", "PB1")[pin] if self.layer == "stm32f405" else str(pin)


@cache
def list_boards() -> dict[str, Board]:
    """Return all boards by name."""
    text = (files("martensite.boards.firmware") / "boards.toml").read_text("utf-8")
    boards: dict[str, Board] = {}
    for name, table in tomllib.loads(text).items():
        numbers: dict[str, Any] = {"platformio": {}}
        numbers |= {k: tuple(v) if isinstance(v, list) else v for k, v in table.items()}
        boards[name] = Board(name=name, **numbers)
    return boards


def find_board(name: str) -> Board:
    """Return a board by name; raise `UnknownNameError` if it does not exist."""
    if name not in list_boards():
        raise UnknownNameError("board", name, list(list_boards()))
    return list_boards()[name]
