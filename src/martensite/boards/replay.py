"""A log through the model: what the scenario says its sensors would have read under the signals that the board gave."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError, InputError, SolveError
from martensite.boards.firmware.settings import name_duty
from martensite.boards.hil import open_plant
from martensite.control.loop.names import MEASURED
from martensite.simulate.lanes import Lanes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.scenario.scenario import Scenario


@dataclass(frozen=True, eq=False)
class ReplayedReading:
    """A reading of a log beside that of the model."""

    name: str
    unit: str
    measured: NDArray[np.float64]
    modelled: NDArray[np.float64]

    @property
    def rms(self) -> float:
        """Return the root mean square of the difference."""
        return float(np.sqrt(np.mean((self.measured - self.modelled) ** 2)))

    @property
    def fit(self) -> float:
        """1 - rms of the difference over that of the reading about its mean; 1 if they are the same."""
        about = float(np.std(self.measured))
        return 1.0 - self.rms / about if about > 0.0 else float("nan")


@dataclass(frozen=True, eq=False)
class Replay:
    """A log beside the model."""

    times: NDArray[np.float64]
    readings: list[ReplayedReading]

    def plot(self) -> Figure:
        """Return every reading, measured and modelled."""
        from martensite.show.figures.style import make_figure, use_style

        with use_style():
            figure = make_figure(7.0, 1.0 + 2.0 * len(self.readings))
            for k, one in enumerate(self.readings):
                axes = figure.add_subplot(len(self.readings), 1, k + 1)
                axes.plot(self.times, one.measured, label="measured")
                axes.plot(self.times, one.modelled, label="model")
                axes.set(ylabel=f"{one.name} [{one.unit}]")
                axes.legend(loc="best")
            axes.set(xlabel="time [s]")
        return figure


def replay_log(scenario: Scenario, path: Path) -> Replay:
    """Return the readings of a log, and what the model of a scenario says under the signals of the log.

    The plant begins at rest where the log does; sensors make no noise.

    Raises:
        InputError: the scenario has no loop, or the log not its signals or none of its readings.
        DataError: the log cannot be read, or is too short.
        SolveError: the model fails.
    """
    from martensite.logs.lab_files import read_lab_file

    if scenario.bench is None:
        raise InputError("A replay needs the sensors of a loop, which this scenario has not.")
    plant, record = open_plant(scenario.bench), read_lab_file(path).record
    known = {name: np.asarray(column, float) for name, column in record.columns.items()}
    drives = [drive.name for drive in scenario.bench.plant.drives()]
    known |= {name: known[name_duty(name)] for name in drives if name_duty(name) in known}
    missing = [name for name in ("time", *drives) if name not in known]
    if missing:
        raise InputError(f"The log has no column `{missing[0]}`; it has {', '.join(known)}.")
    times = known["time"]
    if len(times) < 3:
        raise DataError(f"`{path}` holds {len(times)} samples, which are too few.")
    period = scenario.bench.period
    counts = np.maximum(np.rint(np.diff(times) / period), 1).astype(int)  # lost samples: the signal was held
    lane = Lanes(plant, 1)
    signals = np.array([known[name] for name in drives])
    given = np.zeros((len(lane.drives), len(times)))
    for k, name in enumerate(lane.drives):
        if name in drives:
            given[k] = signals[drives.index(name)]
    lane.reset(np.zeros((len(lane.drives), 1)))
    rows = [lane.observe(given[:, :1])[:, 0]]
    for k, count in enumerate(counts):
        step = np.broadcast_to(given[None, :, k, None], (int(count), len(lane.drives), 1))
        rows.append(lane.advance(step, period)[-1, :, 0])
    if (status := lane.status[0]).failed:
        raise SolveError(f"The model fails under the signals of the log: {status.sentence}")
    table, outputs = np.array(rows), plant.outputs()
    found = [
        ReplayedReading(name, outputs[MEASURED + name].unit, known[name], table[:, lane.names.index(MEASURED + name)])
        for name in scenario.bench.sensors.members()
        if name in known
    ]
    if not found:
        raise InputError(f"The log has none of the readings {', '.join(scenario.bench.sensors.members())}.")
    return Replay(times, found)
