"""Time limit of the watchdog of a board: one and a half sample times, as its clock allows.

On AVR the watchdog of the chip has the times 15 ms times a power of 2. On the STM32F405 SysTick counts milliseconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from martensite.base.errors import InputError
from martensite.boards.firmware.boards import Board

SAMPLES = 1.5
"""Time limit over the sample time."""
SHORTEST, MOST_CODE = 0.015, 9
"""Shortest time of an AVR [s], and code of its longest."""


@dataclass(frozen=True)
class Watchdog:
    """Time limit between two samples."""

    milliseconds: int
    code: int
    """Code of the time on AVR; else 0."""
    real: bool
    """False for a board whose firmware has no watchdog."""


def choose_watchdog(period: float, board: Board) -> Watchdog:
    """Return the watchdog of a board for a sample time [s].

    Raises:
        InputError: the sample time is too long for the watchdog.
    """
    wanted = SAMPLES * period
    if not board.avr:
        return Watchdog(math.ceil(1e3 * wanted - 1e-6), 0, board.layer == "stm32f405")
    for code in range(MOST_CODE + 1):
        limit = SHORTEST * 2**code
        if limit >= wanted * (1.0 - 1e-9):
            return Watchdog(round(1e3 * limit), code, True)
    raise InputError(
        f"A sample time of {period:g} s is too long for the watchdog of {board.title}: choose at most "
        f"{SHORTEST * 2**MOST_CODE / SAMPLES:.3g} s."
    )
