"""Replay of a log: readings of the model of a scenario under the signals of a board."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError, InputError, SolveError
from martensite.boards.firmware.settings import name_duty
from martensite.boards.hil import open_plant
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import MEASURED
from martensite.simulate.lanes import Lanes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.scenario.scenario import Scenario


@dataclass(frozen=True, eq=False)
class ReplayedReading:
    """A measured and a modelled reading."""

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
        """Return 1 - rms of the difference over the standard deviation of the reading."""
        about = float(np.std(self.measured))
        return 1.0 - self.rms / about if about > 0.0 else float("nan")


@dataclass(frozen=True, eq=False)
class Replay:
    """A log compared with the model."""

    times: NDArray[np.float64]
    readings: list[ReplayedReading]

    def plot(self) -> Figure:
        """Return a figure of every reading, measured and modelled."""
        from martensite.show.figures.style import make_figure, use_style

        with use_style():
            figure = make_figure(7.0, 1.0 + 2.0 * len(self.readings))
            for k, one in enumerate(self.readings):
                axes = figure.add_subplot(len(self.readings), 1, k + 1)
                axes.plot(self.times, one.measured, label="measured")
                axes.plot(self.times, one.modelled, label="model")
                axes.set(ylabel=f"{one.name} [{one.unit}]")
                axes.legend(loc="best")
            figure.axes[-1].set(xlabel="time [s]")
        return figure


def replay_log(scenario: Scenario, path: Path) -> Replay:
    """Return the readings of a log, and of the model of a scenario under the signals of the log.

    The plant starts in the steady state; sensors have no noise.

    Raises:
        InputError: the scenario has no loop, or the log lacks its signals or readings.
        DataError: the log cannot be read, or is too short.
        SolveError: the model fails.
    """
    from martensite.logs.lab_files import read_lab_file

    if scenario.bench is None:
        raise InputError("A replay needs the sensors of a loop, which this scenario has not.")
    plant, record = open_plant(scenario.bench), read_lab_file(path).record
    columns = {name: np.asarray(column, float) for name, column in record.columns.items()}
    drives = [drive.name for drive in scenario.bench.plant.drives()]
    columns |= {name: columns[name_duty(name)] for name in drives if name_duty(name) in columns}
    missing = [name for name in ("time", *drives) if name not in columns]
    if missing:
        raise InputError(f"The log has no column `{missing[0]}`; it has {', '.join(columns)}.")
    times = columns["time"]
    if len(times) < 3:
        raise DataError(f"`{path}` holds {len(times)} samples, which are too few.")
    modelled = _simulate_readings(plant, times, {name: columns[name] for name in drives}, scenario.bench.period)
    outputs, sensors = plant.outputs(), scenario.bench.sensors.members()
    readings = [
        ReplayedReading(name, outputs[MEASURED + name].unit, columns[name], modelled[MEASURED + name])
        for name in sensors
        if name in columns
    ]
    if not readings:
        raise InputError(f"The log has none of the readings {', '.join(sensors)}.")
    return Replay(times, readings)


def _simulate_readings(
    plant: Bench, times: NDArray[Any], signals: Mapping[str, NDArray[Any]], period: float
) -> dict[str, NDArray[Any]]:
    """Return the outputs of a plant under signals; lost samples hold the signal."""
    lane = Lanes(plant, 1)
    inputs = np.array([signals.get(name, np.zeros(len(times))) for name in lane.drives])
    lane.reset(np.zeros((len(lane.drives), 1)))
    rows = [lane.observe(inputs[:, :1])[:, 0]]
    for k, count in enumerate(np.maximum(np.rint(np.diff(times) / period), 1).astype(int)):
        step = np.broadcast_to(inputs[None, :, k, None], (int(count), len(lane.drives), 1))
        rows.append(lane.advance(step, period)[-1, :, 0])
    if (status := lane.status[0]).failed:
        raise SolveError(f"The model fails under the signals of the log: {status.sentence}")
    return dict(zip(lane.names, np.array(rows).T, strict=True))
