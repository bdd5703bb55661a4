"""Hardware in the loop: the plant and the sensors of a scenario here, its controllers on a board.

In every period the board gets the readings that our sensors make, their ages and the references, and answers with the
signals that the plant then follows: the same order as on a bench in one piece, so that the two may be compared. The
board's own switches stay open meanwhile.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import InputError, SolveError
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import list_drives
from martensite.control.loop.parts import Controllers, Observers
from martensite.control.loop.realtime import list_reads
from martensite.control.loop.run import noise_waveforms, reference_waveforms
from martensite.kernels import floats
from martensite.kernels.nested import NestedShape
from martensite.simulate.drive_waveforms import by_name
from martensite.simulate.lanes import Lanes
from martensite_hardware.link.host import BoardLink
from martensite_hardware.link.messages import BoardFlags

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario

WAIT = 1.0
"""How long a sample is waited for [s], of the board's or the host's clock."""


@dataclass(frozen=True, eq=False)
class HilRun:
    """A plant under a board."""

    times: NDArray[Any]
    """[s]"""
    outputs: dict[str, NDArray[np.float64]]
    """Of the plant, by name."""
    signals: dict[str, NDArray[np.float64]]
    """That the board gave, by drive."""
    told: dict[str, NDArray[np.float64]]
    """What else its telemetry held."""
    lost: int
    """Frames of the board that never came."""

    def to_text(self) -> str:
        """As a table: times, outputs of the plant, signals of the board; all in SI."""
        columns = {"time": self.times} | self.outputs | {f"board {name}": one for name, one in self.signals.items()}
        rows = [",".join(columns), *(",".join(f"{x:.9g}" for x in row) for row in zip(*columns.values(), strict=True))]
        return "\n".join([*rows, ""])


def open_plant(bench: Bench) -> Bench:
    """A bench without its controllers, observers and supervisor."""
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
    """Run the plant of a scenario under a board that holds its loop.

    Args:
        scenario: whose loop was written for the board.
        link: to the board.
        firmware: what `firmware.json` of it says.
        word: `ARM`, said by a person.
        duration: [s]; by default that of the scenario.
        watch: called after every period with the share that is done.

    Raises:
        InputError: the scenario has no loop, or the board holds another firmware.
        SolveError: the board does not answer, stops, or the plant cannot be solved.
    """
    bench = scenario.bench
    if bench is None:
        raise InputError("There is no loop in this scenario.")
    hello = link.greet()
    if hello.values["digest"] != firmware["digest"]:
        raise InputError("The board holds another firmware than this project; write it anew.")
    link.command("rate", every=0)
    link.choose_mode("emulated")
    link.arm(word)
    try:
        return _run_periods(scenario, bench, link, firmware, duration or scenario.duration, watch)
    finally:
        link.send("disarm")


def _run_periods(
    scenario: Scenario,
    bench: Bench,
    link: BoardLink,
    firmware: dict[str, Any],
    duration: float,
    watch: Callable[[float], None] | None,
) -> HilRun:
    plant, period = open_plant(bench), bench.period
    given = by_name(bench.plant, scenario.waveform) | noise_waveforms(bench, duration, scenario.seed)
    followed, reads = list(reference_waveforms(bench).values()), list_reads(bench)
    drives = [drive.name for drive in list_drives(plant)]
    driven = [drive.name for drive in bench.plant.drives()]
    names = [row["name"] for row in firmware["telemetry"]]
    signals = dict.fromkeys(driven, 0.0)

    def gather(k: int, now: dict[str, float]) -> list[float]:
        return [
            now[name] if name in now else given[name].value(k * period) if name in given else 0.0 for name in drives
        ]

    first = gather(0, {name: 0.0 for name in driven if name not in given})
    shape, lane = NestedShape(plant.init(floats, *first)), Lanes(plant, 1)
    lane.reset(np.array(first)[:, None])
    rows, told, seen = list[Sequence[float]](), list[Sequence[float]](), list[Sequence[float]]()
    count = int(duration / period + 1e-6)
    for k in range(count + 1):
        state = shape.rebuild(lane.state[:, 0].tolist())
        sensed = dict(zip(bench.sensors.members(), state.sensors, strict=True))
        readings = [number for name in reads for number in (sensed[name].reading, sensed[name].age)]
        values = _ask_board(link, k, [*readings, *(one.value(k * period) for one in followed)])
        told.append(values)
        signals = dict(zip(driven, values[firmware["readings"] :], strict=False))
        rows.append([signals[name] for name in driven])
        inputs = np.array(gather(k + 1, signals))[:, None]
        seen.append(lane.observe(inputs)[:, 0].tolist())
        if k < count:
            lane.advance(inputs[None], period, shown=False)
            if (status := lane.status[0]).failed:
                raise SolveError(f"The plant failed at {k * period:.6g} s: {status.sentence}")
        if watch is not None:
            watch(k / count)
    columns, heard = np.array(seen).T, np.array(told).T
    return HilRun(
        period * np.arange(count + 1, dtype=float),
        dict(zip(plant.outputs(), columns, strict=True)),
        dict(zip(driven, np.array(rows).T, strict=True)),
        dict(zip(names, heard, strict=True)),
        link.reader.counts.lost,
    )


def _ask_board(link: BoardLink, k: int, numbers: Sequence[float]) -> Sequence[float]:
    """Telemetry of one emulated sample."""
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


def compare_runs(scenario: Scenario, found: HilRun) -> list[tuple[str, str, float, float]]:
    """How far a run under a board is from the run here: name, unit, largest difference, share of range."""
    run = scenario.run()
    rows: list[tuple[str, str, float, float]] = []
    for name, column in found.outputs.items():
        if name in run.columns:
            own = np.asarray(run.columns[name])[: len(column)]
            far, span = float(np.max(np.abs(column[: len(own)] - own))), float(np.ptp(own))
            rows.append((name, run.unit(name), far, far / span if span > 0.0 else 0.0))
    return rows
