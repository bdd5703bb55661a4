"""An emulated rig: a board under simavr with the plant of a scenario at its pins.

The duty cycle at a pin heats the wire. The parts of the wiring list give the voltages at the converter: a channel of a
switched wire has its voltage during the pulses only, and follows them with the lag of its amplifier. Board and plant
advance together, independent of the speed of the host.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from martensite.base.errors import SolveError
from martensite.boards.emulators.avr import SimavrBoard
from martensite.boards.firmware.boards import find_board
from martensite.boards.firmware.channels import BoardInputs, find_port, plan_inputs
from martensite.boards.firmware.circuit import AMPLIFIER_LAG
from martensite.kernels import floats
from martensite.physics.electrical.base import AbstractSwitch
from martensite.simulate.lanes import Lanes

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario


@dataclass
class EmulatedRig:
    """A port to a board whose wire is simulated."""

    scenario: Scenario
    board: SimavrBoard
    turn: float = 1e-3
    """Time step of board and plant in a read [s]."""
    seed: int = 0
    _inputs: BoardInputs = field(init=False)

    def __post_init__(self) -> None:
        bench = self.scenario.bench
        if bench is None:
            raise SolveError("A rig needs the sensors of a loop.")
        self._bench, self._plant = bench, bench.plant
        self._inputs = plan_inputs(bench, find_board(self.board.board))
        self._lane = Lanes(self._plant, 1)
        self._lane.reset()
        self._rng = np.random.default_rng(self.seed)
        self.truth = self._look()

    def now(self) -> float:
        """Return the time since the reset of the board [s]."""
        return self.board.now()

    def write(self, data: bytes) -> int:
        """Send bytes to the board."""
        return self.board.write(data)

    def read(self, size: int = 1) -> bytes:
        """Return the output of the board in another turn."""
        return self.run(self.turn)

    def run(self, seconds: float) -> bytes:
        """Advance board and plant by a time [s] and return the output of the board.

        Raises:
            SolveError: the plant cannot be solved, or the processor crashed.
        """
        output = b""
        for _ in range(max(1, round(seconds / self.turn))):
            self._set_volts()
            output += self.board.run(self.turn)
            rows = self._lane.advance(np.array(self._duties())[None, :, None], self.turn)
            self.truth = dict(zip(self._lane.names, rows[0, :, 0].tolist(), strict=True))
            if (status := self._lane.status[0]).failed:
                raise SolveError(f"The plant failed {self.now():.6g} s after the reset: {status.sentence}")
        return output

    def close(self) -> None:
        """End the emulator."""
        self.board.close()

    def _duties(self) -> tuple[float, ...]:
        return self.board.duties[: len(self._plant.drives())]

    def _look(self) -> dict[str, float]:
        """Return all true values; electrical outputs are rms values over the pulses."""
        values = self._lane.observe(np.array(self._duties())[:, None])
        return dict(zip(self._lane.names, values[:, 0].tolist(), strict=True))

    def _set_volts(self) -> None:
        """Set the voltages at the converter from the nominal gains of the wiring list."""
        board = find_board(self.board.board)
        for k, one in enumerate(self._inputs.channels):
            if one.pin >= 0:
                pin, step = one.pin - (board.first_analog or 0), board.volts / board.steps
                value = self._find_value(k) * step / one.gain
                self.board.volts[pin] = one.offset * step + (value if one.drive < 0 else 0.0)
                self.board.pulses[pin] = value if one.drive >= 0 else 0.0
                self.board.switches[pin] = max(one.drive, 0)

    def _find_value(self, k: int) -> float:
        """Return the value of channel k in SI, of a switched wire while its switch is closed."""
        reading = next((one for one in self._inputs.readings if k in (one.channel, one.other)), None)
        if reading is None:
            return self._inputs.supply
        mounted = self._bench.sensors.members()[reading.name]
        noise = float(self._rng.standard_normal())
        if not reading.ratio:
            return self.truth[mounted.sees()[0]] + float(mounted.sensor.noise) * noise
        port = find_port(self._bench, reading.name)
        ohms = self.truth[self._plant.label(port, "resistance")]
        source = self._plant.actuators()[port].source
        if not isinstance(source, AbstractSwitch):
            raise SolveError("The source of the plant is no switch.")
        current = float(source.closed_current(floats, ohms))
        if k == reading.channel:
            return current * ohms * (1.0 + float(getattr(mounted.sensor, "relative_noise", 0.0)) * noise)
        return current


def start_rig(scenario: Scenario, elf: Path, board: str, folder: Path) -> EmulatedRig:
    """Return a board of a firmware with the plant of its scenario; the emulator program is compiled in the folder."""
    return EmulatedRig(scenario, SimavrBoard(elf, board, find_board(board).baud, folder, lag=AMPLIFIER_LAG))
