"""A whole rig that is emulated: a board under simavr, and the plant of a scenario at its pins.

The duty at a pin heats the wire; what the wiring list puts between wire and converter gives the voltages that the
converter reads, in its own steps. Board and plant go on together, a turn at a time, however long this machine takes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from martensite.base.errors import SolveError
from martensite.boards.emulators.avr import SimavrBoard
from martensite.boards.firmware.boards import find_board
from martensite.boards.firmware.channels import BoardInputs, plan_inputs
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
    """Time that board and plant go on in a read [s]."""
    seed: int = 0
    """Seed of the noise of the sensors."""
    _inputs: BoardInputs = field(init=False)

    def __post_init__(self) -> None:
        """The plant at rest."""
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
        """Return the bytes for the board."""
        return self.board.write(data)

    def read(self, size: int = 1) -> bytes:
        """Return the output of the board in another turn."""
        return self.run(self.turn)

    def run(self, seconds: float) -> bytes:
        """Let both go on [s]; what the board sent meanwhile.

        Raises:
            SolveError: the plant cannot be solved, or the processor crashed.
        """
        found = b""
        for _ in range(max(1, round(seconds / self.turn))):
            self._set_volts()
            found += self.board.run(self.turn)
            rows = self._lane.advance(np.array(self._duties())[None, :, None], self.turn)
            self.truth = dict(zip(self._lane.names, rows[0, :, 0].tolist(), strict=True))
            if (status := self._lane.status[0]).failed:
                raise SolveError(f"The plant failed {self.now():.6g} s after the reset: {status.sentence}")
        return found

    def close(self) -> None:
        """End it."""
        self.board.close()

    def _duties(self) -> tuple[float, ...]:
        return self.board.duties[: len(self._plant.drives())]

    def _look(self) -> dict[str, float]:
        """All that is true now; electrical outputs as means over the pulses, as the filters of the wiring give them."""
        values = self._lane.observe(np.array(self._duties())[:, None])
        return dict(zip(self._lane.names, values[:, 0].tolist(), strict=True))

    def _set_volts(self) -> None:
        """Voltages at the converter, by the nominal gains of the wiring list."""
        own = find_board(self.board.board)
        for k, one in enumerate(self._inputs.channels):
            if one.pin >= 0:
                value = self._find_value(k) / one.gain + one.offset
                self.board.volts[one.pin - (own.first_analog or 0)] = value * own.volts / own.steps

    def _find_value(self, k: int) -> float:
        """Return the value of channel k, in SI."""
        reading = next((one for one in self._inputs.readings if k in (one.channel, one.other)), None)
        if reading is None:
            return self._inputs.supply
        mounted = self._bench.sensors.members()[reading.name]
        noise = float(self._rng.standard_normal())
        if not reading.ratio:
            return self.truth[mounted.sees()[0]] + float(mounted.sensor.noise) * noise
        (actuator,) = self._plant.actuators().values()
        ohms = self.truth["resistance"]
        if not isinstance(actuator.source, AbstractSwitch):
            raise SolveError("The source of the plant is no switch.")
        current = self._duties()[0] * actuator.source.closed_current(floats, ohms)
        if k == reading.channel:
            return current * ohms * (1.0 + float(getattr(mounted.sensor, "relative_noise", 0.0)) * noise)
        return current


def start_rig(scenario: Scenario, elf: Path, board: str, folder: Path) -> EmulatedRig:
    """Return a board of a firmware with the plant of its scenario; the program that holds it is made in the folder."""
    return EmulatedRig(scenario, SimavrBoard(elf, board, find_board(board).baud, folder))
