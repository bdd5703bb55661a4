"""Hardware in the loop: simulated plant and sensors of a scenario, controllers on a board.

In every period the board gets the readings, their ages and the references, and returns the signals of the plant, in the
order of a bench, so that both can be compared. The switches of the board stay open.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import InputError, SolveError
from martensite.boards.link.host import BoardLink
from martensite.boards.link.messages import BoardFlags
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import list_drives
from martensite.control.loop.parts import Controllers, Observers
from martensite.control.loop.realtime import list_reads
from martensite.control.loop.run import noise_waveforms, reference_waveforms
from martensite.kernels import floats
from martensite.kernels.nested import NestedShape
from martensite.signals.base import AbstractWaveform
from martensite.simulate.drive_waveforms import by_name
from martensite.simulate.lanes import Lanes

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario

WAIT = 1.0
"""Time limit of a sample [s], on the clock of the board or of the host."""


@dataclass(frozen=True, eq=False)
class HilRun:
    """A run of a plant under a board."""

    times: NDArray[Any]
    """[s]"""
    outputs: dict[str, NDArray[np.float64]]
    """Outputs of the plant, by name."""
    signals: dict[str, NDArray[np.float64]]
    """Signals of the board, by drive."""
    telemetry: dict[str, NDArray[np.float64]]
    """Further columns of the telemetry."""
    lost_frames: int

    def to_text(self) -> str:
        """Return the run as a table: times, outputs of the plant, signals of the board; all in SI."""
        columns = {"time": self.times} | self.outputs | {f"board {name}": one for name, one in self.signals.items()}
        rows = [",".join(columns), *(",".join(f"{x:.9g}" for x in row) for row in zip(*columns.values(), strict=True))]
        return "\n".join([*rows, ""])


def open_plant(bench: Bench) -> Bench:
    """Return a bench without controllers, observers and supervisor."""
    return bench.with_parts(controllers=Controllers(), observers=Observers(), supervisor=None)


def run_hil(
    scenario: Scenario,
    link: BoardLink,
    firmware: dict[str, Any],
    *,
    word: str,
    duration: float | None = None,
    watch: Callable[[float], None] | None = None,
) -> HilRun:
    """Run the plant of a scenario under a board with its loop.

    Args:
        scenario: scenario of the loop.
        link: link to the board.
        firmware: content of its `firmware.json`.
        word: `ARM`, given by a person.
        duration: duration [s]; default: that of the scenario.
        watch: called after every period with the completed fraction.

    Raises:
        InputError: the scenario has no loop, or the board has another firmware.
        SolveError: the board does not answer or stops, or the plant cannot be solved.
    """
    bench = scenario.bench
    if bench is None:
        raise InputError("There is no loop in this scenario.")
    seconds = scenario.duration if duration is None else duration
    plant = HilPlant.begin(scenario, bench, seconds)  # compiled before the board waits for it
    link.greet(firmware["digest"])
    link.command("rate", every=0)
    link.choose_mode("emulated")
    link.arm(word)
    telemetry, signals, outputs = list[Sequence[float]](), list[Sequence[float]](), list[Sequence[float]]()
    try:
        for k in range(plant.count + 1):
            telemetry.append(_ask_board(link, k, plant.read_inputs(k)))
            signals.append(telemetry[-1][firmware["readings"] :][: len(plant.driven)])
            outputs.append(plant.advance(k, dict(zip(plant.driven, signals[-1], strict=True))))
            if watch is not None:
                watch(k / plant.count)
    finally:
        link.send("disarm")
    columns, commands, columns_told = (np.array(rows).T for rows in (outputs, signals, telemetry))
    return HilRun(
        bench.period * np.arange(plant.count + 1, dtype=float),
        dict(zip(plant.lane.names, columns, strict=True)),
        dict(zip(plant.driven, commands, strict=True)),
        dict(zip([row["name"] for row in firmware["telemetry"]], columns_told, strict=True)),
        link.reader.counts.lost,
    )


@dataclass(frozen=True, eq=False)
class HilPlant:
    """A plant with its sensors, and the inputs of an external loop."""

    bench: Bench
    lane: Lanes
    shape: NestedShape
    waveforms: Mapping[str, AbstractWaveform]
    """Noise, and drives without a controller, by drive."""
    driven: list[str]
    count: int

    @classmethod
    def begin(cls, scenario: Scenario, bench: Bench, duration: float) -> HilPlant:
        """Return the plant in the steady state."""
        plant, driven = open_plant(bench), [drive.name for drive in bench.plant.drives()]
        waveforms = by_name(bench.plant, scenario.waveform) | noise_waveforms(bench, duration, scenario.seed)
        drives = [drive.name for drive in list_drives(plant)]
        first = [waveforms[name].value(0.0) if name in waveforms else 0.0 for name in drives]
        created = cls(
            bench,
            Lanes(plant, 1),
            NestedShape(plant.init(floats, *first)),
            waveforms,
            driven,
            int(duration / bench.period + 1e-6),
        )
        created.lane.reset(np.array(first)[:, None])
        return created

    def read_inputs(self, k: int) -> list[float]:
        """Return the inputs of the loop in sample k: readings with ages, references, modes, and free signals."""
        state = self.shape.rebuild(self.lane.state[:, 0].tolist())
        sensed = dict(zip(self.bench.sensors.members(), state.sensors, strict=True))
        time, controlled = k * self.bench.period, self.bench.controllers.members()
        readings = [number for name in list_reads(self.bench) for number in (sensed[name].reading, sensed[name].age)]
        followed = [one.value(time) for one in reference_waveforms(self.bench).values()]
        free = [name for name in self.driven if name not in controlled]
        return [*readings, *followed, *(self._play(name, time) for name in free)]

    def advance(self, k: int, signals: Mapping[str, float]) -> list[float]:
        """Return the outputs in sample k under signals, and advance the plant to the next sample.

        Raises:
            SolveError: the plant cannot be solved.
        """
        time = (k + 1) * self.bench.period
        values = [signals[name] if name in signals else self._play(name, time) for name in self.lane.drives]
        inputs = np.array(values)[:, None]
        outputs = self.lane.observe(inputs)[:, 0].tolist()
        if k < self.count:
            self.lane.advance(inputs[None], self.bench.period, shown=False)
            if (status := self.lane.status[0]).failed:
                raise SolveError(f"The plant failed at {time - self.bench.period:.6g} s: {status.sentence}")
        return outputs

    def _play(self, name: str, time: float) -> float:
        return self.waveforms[name].value(time) if name in self.waveforms else 0.0


def _ask_board(link: BoardLink, k: int, numbers: Sequence[float]) -> Sequence[float]:
    """Return the telemetry of one emulated sample."""
    until = link.now() + WAIT
    link.send("sample", time=k, readings=numbers)
    while link.now() < until:
        for message in link.receive():
            if message.name == "telemetry" and message.values["time"] == k:
                flags = BoardFlags(message.values["flags"])
                if BoardFlags.STOPPED in flags:
                    raise SolveError(f"The loop on the board stopped in sample {k}.")
                return message.values["values"]
            if message.name == "disarmed":
                raise SolveError(f"The board disarmed in sample {k}, reason {message.values['reason']}.")
    raise SolveError(f"The board does not answer in sample {k}.")


def compare_runs(scenario: Scenario, board_run: HilRun) -> list[tuple[str, str, float, float]]:
    """Return the differences between a run under a board and a simulation: name, unit, largest, fraction of range."""
    run = scenario.run()
    rows: list[tuple[str, str, float, float]] = []
    for name, column in board_run.outputs.items():
        if name in run.columns:
            reference = np.asarray(run.columns[name])[: len(column)]
            far, span = float(np.max(np.abs(column[: len(reference)] - reference))), float(np.ptp(reference))
            rows.append((name, run.unit(name), far, far / span if span > 0.0 else 0.0))
    return rows
