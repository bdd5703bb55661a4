"""Boards that firmware can be written for: what stands in `boards.toml`."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from martensite.base.errors import UnknownNameError


@dataclass(frozen=True)
class Board:
    """A board: its converter, its pins, its room."""

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
    baud: int
    drive_pins: tuple[int, ...]
    channel_pins: tuple[int, ...]
    encoder_pins: tuple[int, ...]
    platformio: dict[str, str]
    """Platform and board of PlatformIO; empty where it has no part in it."""
    first_analog: int | None = None
    """Number of the pin that is printed as A0; None where pins are printed by their numbers."""

    def name_pin(self, pin: int) -> str:
        """Return a pin of a channel as it is printed on the board."""
        if self.layer == "stm32f405":
            return f"PA{pin}"
        first = self.first_analog
        return f"A{pin - first}" if first is not None and pin >= first else str(pin)

    def name_drive_pin(self, pin: int) -> str:
        """Return a pin of a switch as it is printed on the board."""
        return ("PA6", "PA7", "PB0", "PB1")[pin] if self.layer == "stm32f405" else str(pin)


@cache
def list_boards() -> dict[str, Board]:
    """Return all boards by name."""
    text = (files("martensite.boards.firmware") / "boards.toml").read_text("utf-8")
    found: dict[str, Board] = {}
    for name, table in tomllib.loads(text).items():
        numbers: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in table.items()}
        found[name] = Board(name=name, **{"platformio": {}, **numbers})
    return found


def find_board(name: str) -> Board:
    """Return a board by its name; `UnknownNameError` if there is none."""
    if name not in list_boards():
        raise UnknownNameError("board", name, list(list_boards()))
    return list_boards()[name]
