"""An AVR under simavr in lock-step: its time advances while it is read, so runs are reproducible on any machine."""

from __future__ import annotations

import struct
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

from martensite.base.errors import SolveError
from martensite.boards.emulators.toolchains import MCUS, build_simavr_line
from martensite.boards.firmware.boards import find_board

ASKED, ANSWERED, MARKS = struct.Struct("<I8H8H8BH"), struct.Struct("<Q2HfBH"), struct.Struct("<16I")

POWER = (1 << 32) - 1
"""Cycles that stand for switching off and on."""


@dataclass
class SimavrBoard:
    """A board under simavr as a port; `now` is its own time."""

    elf: Path
    board: str
    baud: int
    folder: Path
    turn: float = 0.5e-3
    """Time that passes in a read [s]."""
    volts: list[float] = field(default_factory=lambda: [0.0] * 8)
    """Voltages at A0 to A7 while the switches are open [V]."""
    pulses: list[float] = field(default_factory=lambda: [0.0] * 8)
    """Voltages at A0 to A7 that a closed switch adds [V]."""
    switches: list[int] = field(default_factory=lambda: [0] * 8)
    """Switch, 0 or 1, that adds these voltages."""
    lag: float = 1e-6
    """Time constant of the amplifiers [s]."""
    cycles: int = 0
    duties: tuple[float, float] = (0.0, 0.0)
    """Duty cycles of the pins of timer 1."""
    frequency: float = 0.0
    """Frequency of timer 1 [Hz]."""
    marks: tuple[int, ...] = ()
    """Largest number of cycles between GPIOR0 = k and GPIOR0 = 0."""
    _waiting: bytearray = field(default_factory=bytearray)

    def __post_init__(self) -> None:
        program = build_simavr_line(self.folder)
        bits = (5, 6) if self.board == "mega2560" else (1, 2)
        words = [program, self.elf, MCUS[self.board][0], f"{self.clock:.0f}", self.baud, *bits, self.lag * self.clock]
        self._process = subprocess.Popen(list(map(str, words)), stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    @property
    def clock(self) -> float:
        """Return the clock frequency [Hz]."""
        return find_board(self.board).clock

    def now(self) -> float:
        """Return the time since the reset [s]."""
        return self.cycles / self.clock

    def write(self, data: bytes) -> int:
        """Send bytes to the board, which gets them as time advances."""
        self._waiting += data
        return len(data)

    def read(self, size: int = 1) -> bytes:
        """Return the output of the board after another `turn`."""
        return self.run(self.turn)

    def run(self, seconds: float) -> bytes:
        """Advance by a time [s] and return the output of the board.

        Raises:
            SolveError: the processor has crashed, or simavr has ended.
        """
        pipe_in, pipe_out = self._process.stdin, self._process.stdout
        if pipe_in is None or pipe_out is None:
            raise SolveError("simavr has no pipes.")
        data, self._waiting = bytes(self._waiting), bytearray()
        try:
            levels = [self._count_millivolts(one) for one in (*self.volts, *self.pulses)]
            pipe_in.write(ASKED.pack(round(seconds * self.clock), *levels, *self.switches, len(data)) + data)
            pipe_in.flush()
            answer = ANSWERED.unpack(pipe_out.read(ANSWERED.size))
            self.cycles, first, second, self.frequency, crashed, count = answer
            output = pipe_out.read(count)
            self.marks = MARKS.unpack(pipe_out.read(MARKS.size))
        except (OSError, struct.error):
            raise SolveError("simavr has ended; does the firmware fit the board?") from None
        self.duties = first / 65535.0, second / 65535.0
        if crashed:
            raise SolveError(f"The processor crashed {self.now():.6g} s after its reset.")
        return output

    def cycle_power(self) -> None:
        """Switch the board off and on again; only the EEPROM keeps its content."""
        self.run(POWER / self.clock)

    def _count_millivolts(self, volts: float) -> int:
        return round(1e3 * min(max(volts, 0.0), find_board(self.board).volts))

    def close(self) -> None:
        """End the emulator."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()
