"""Result of a simulation: sampled columns in SI, with status and accuracy."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import SolveError, UnknownNameError
from martensite.base.services import import_service
from martensite.base.status import Status
from martensite.base.summary import Summary
from martensite.simulate.alarms import Alarm, RunWarnings
from martensite.simulate.compiled import name_outputs
from martensite.simulate.ledger import HeatBalance, WorkBalance
from martensite.simulate.measures.base import measure_samples, parse_measure
from martensite.simulate.measures.run_table import find_extremes, tabulate_track
from martensite.simulate.provenance import tell_conformance
from martensite.simulate.restarts import Restart, name_state
from martensite.simulate.run_report import describe_result, summarise_result
from martensite.simulate.tracing import AbstractTrace
from martensite.simulate.track import Track

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Variants:
    """Varied parameters and endings of the runs of a batch."""

    over: Mapping[str, NDArray[np.float64]]
    """Values by full parameter path, (variants,), in SI."""
    status: list[Status]
    ended: NDArray[np.float64]
    """End times [s], (variants,); NaN where unknown."""
    accuracy: NDArray[np.float64] | None = None
    """Error bounds of temperatures, fractions, stresses and coordinates by variant, (variants,).

    Bounds are fractions of the ranges; a value above the tolerance means that the tolerance was not reached. NaN
    marks runs that failed inside the envelope, and None runs on given steps.
    """
    extremes: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]] = field(
        default_factory=dict[str, "tuple[NDArray[np.float64], NDArray[np.float64]]"]
    )
    """Minimum and maximum in the steps of every variant, by column, (variants,) each, in SI."""

    def __len__(self) -> int:
        return len(self.status)

    def count_endings(self) -> str:
        """Return the number of runs by status, such as `63 ok, 1 out of envelope`."""
        names = Counter(one.name.lower().replace("_", " ") for one in self.status)
        return ", ".join(f"{count} {name}" for name, count in names.most_common())


@dataclass(frozen=True, eq=False)
class Result:
    """Columns over time, with their accuracy.

    Loops have additional columns. Batches have one row per variant, and failed variants are rows with a status.
    """

    system: Any
    """Simulated system: a `System` of one element, or a `Machine` of several."""
    waveform: Any
    """Waveform, or waveforms by drive name."""
    times: NDArray[np.float64]
    """Sample times [s], (samples,)."""
    columns: dict[str, NDArray[np.float64]]
    """Outputs by name, in SI, (samples,); for a batch (variants, samples), NaN after the end of a run."""
    status: Status
    """Worst status of all steps and variants; a failed single run raises an error."""
    status_time: float | None
    """Start of the first step with the worst status [s], where recorded."""
    steps: int
    step: float
    """Longest step taken [s]."""
    accuracy: float | None = None
    """Error bound of temperatures, fractions, stresses and coordinates, as a fraction of each range.

    None for a single pass, and for a batch (see `variants.accuracy`).
    """
    notes: Sequence[str] = ()
    """Messages of the run itself, at the start of `warnings`."""
    judged: Callable[[Result], RunWarnings] | RunWarnings = field(default_factory=RunWarnings)
    """Alarms and further warnings, or a function that returns them on first access."""
    profiles: dict[str, list[list[float]]] = field(default_factory=dict[str, list[list[float]]])
    """Values per cell by quantity of `martensite.actuators.assembly.PROFILES`, in SI.

    Empty for a uniform element.
    """
    beside: dict[str, Output] = field(default_factory=dict[str, Output])
    """Additional columns, such as the setpoint of an external controller."""
    runtime: str = ""
    """Runtime of the run: floats, C or CUDA; empty if unknown."""
    rejected: int = 0
    """Number of rejected steps."""
    heat: HeatBalance | None = None
    """Heat balance of a run with step size control.

    None on given steps, with a prescribed temperature, or with unknown stored heat (see `unbalanced`).
    """
    work: WorkBalance | None = None
    """Work balance of a run with step size control; None on given steps or with unknown stored energy."""
    unbalanced: list[str] = field(default_factory=list[str])
    """Reasons for a missing balance of heat or work, in sentences."""
    ripple: float = 0.0
    """Largest temperature error [K] of drive means over a step."""
    variants: Variants | None = None
    """Variants of a batch; None for a single run."""
    trace: AbstractTrace | None = None
    """Function that computes `track`; None if only samples are known."""
    seed: int | None = None
    """Seed of the sensor noise; None for a run without noise."""
    begin: Callable[[Result], str] | str = ""
    """Function that returns `start`, or `start` itself in a result from a file."""
    restarts: list[Restart] = field(default_factory=list["Restart"])
    """States from which another run can continue; empty if the run stopped early."""

    def __post_init__(self) -> None:
        """Convert times and columns to arrays."""
        object.__setattr__(self, "times", np.asarray(self.times, np.float64))
        object.__setattr__(self, "columns", {name: np.asarray(one, np.float64) for name, one in self.columns.items()})

    @cached_property
    def _run_warnings(self) -> RunWarnings:
        return self.judged if isinstance(self.judged, RunWarnings) else self.judged(self)

    @property
    def alarms(self) -> list[Alarm]:
        """Return exceeded limits, slack and a saturated supply, with time, duration and amount."""
        return list(self._run_warnings.alarms)

    @property
    def warnings(self) -> list[str]:
        """Return messages on exceeded limits, slack, a saturated supply and coarse steps."""
        return [*self.notes, *self._run_warnings.sentences]

    @cached_property
    def start(self) -> str:
        """Return the initial state and history in a sentence; empty without shape-memory elements."""
        return self.begin if isinstance(self.begin, str) else self.begin(self)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Return a column by name, or the times, in SI units: (samples,), of a batch (variants, samples).

        Raises:
            UnknownNameError: the column does not exist.
        """
        if name == "time":
            return self.times
        if name not in self.columns:
            raise UnknownNameError("column", name, self.columns)
        return self.columns[name]

    def plot(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        records: Iterable[Any] | None = None,
        title: str | None = None,
    ) -> Figure:
        """Return the standard figure: all quantities over time, and the loops ξ–T, ε–T, σ–ε.

        Args:
            path: file to write as well: png, svg or pdf, replaced whole or not at all.
            records: measured records, drawn over the simulation wherever they have the same
                quantity, with the RMS difference in the legend.
            title: first line of the figure; by default what was simulated.

        Raises:
            DataError: the file cannot be written, or a record holds nothing that can be compared.
        """
        if path is not None:
            import_service("save_run_figure")(self, path, records, title)
        return import_service("plot_run")(self, records, title)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result in the format of the suffix; the file is replaced completely or not at all.

        Args:
            path: `.nc` (netCDF-4 with everything, for `open_result`), or columns in SI as `.csv` or `.parquet`.

        Raises:
            DataError: the suffix is another one, or the file cannot be written.
        """
        import_service("save_run")(self, path)

    def to_xarray(self) -> xarray.Dataset:
        """Return a dataset over time [s], with units and provenance; requires the extra `xarray`."""
        return import_service("describe_run")(self).to_xarray()

    def to_pandas(self) -> pandas.DataFrame:
        """Return a table of samples by time [s]; for a batch by variant and time.

        Columns are in SI units (`attrs["units"]`).
        """
        import pandas

        index = pandas.Index(self.times, name="time")
        if self.variants is not None:
            levels: list[Any] = [range(len(self.variants)), self.times]
            index = pandas.MultiIndex.from_product(levels, names=["variant", "time"])
        columns = {name: self[name].reshape(-1) for name in self.outputs}
        table = pandas.DataFrame(columns, index=index)
        table.attrs["units"] = {name: self.unit(name) for name in self.outputs}
        return table

    def summary(self) -> Summary:
        """Summarise the run: ranges of all columns, balances, remarks and warnings."""
        return summarise_result(self)

    @property
    def energy(self) -> dict[str, HeatBalance | WorkBalance]:
        """Return the known balances of `heat` and `work`."""
        both = {"heat": self.heat, "work": self.work}
        return {name: one for name, one in both.items() if one is not None}

    def __repr__(self) -> str:
        """Return a short summary; see `summary()` for all values."""
        lines = str(self).splitlines()
        more = [f"… {len(lines) - LINES} lines more in summary()"] if len(lines) > LINES else []
        columns = ", ".join(self.outputs)
        return "\n".join([*lines[:LINES], *more, shorten(f"columns: time, {columns}", 100)])

    def _repr_html_(self) -> str:
        return import_service("render_html")(self.summary())

    def find_range(self, name: str) -> tuple[float, float]:
        """Return the minimum and maximum of a column in the run, over all variants."""
        if self.variants is None:
            low, high = self.extremes.get(name, (math.inf, -math.inf))
            low, high = float(np.fmin.reduce(self[name], initial=low)), float(np.fmax.reduce(self[name], initial=high))
            nothing = ROUNDING * max(abs(low), abs(high))
            return low if abs(low) > nothing else 0.0, high if abs(high) > nothing else 0.0
        ends = self.variants.extremes.get(name, (self[name], self[name]))
        return float(np.nanmin(ends[0])), float(np.nanmax(ends[1]))

    @cached_property
    def track(self) -> Track | None:
        """Return outputs at all accepted steps, for measures and alarms; None if only samples are known."""
        return None if self.trace is None else self.trace.compute_track()

    def __getstate__(self) -> dict[str, Any]:
        """Return the pickled data, with the track instead of its function."""
        return self.__dict__ | {"track": self.track, "trace": None}

    @cached_property
    def extremes(self) -> Mapping[str, tuple[float, float]]:
        """Return the minimum and maximum of every output in the accepted steps of a single run, in SI."""
        if self.track is None:
            return {}
        highest, lowest = find_extremes(self.track, 1)
        pairs = zip(lowest[:, 0].tolist(), highest[:, 0].tolist(), strict=True)
        return dict(zip(name_outputs(self.system), pairs, strict=True))

    def list_rows(self, names: Sequence[str] | None = None) -> tuple[Any, dict[str, Any]]:
        """Return times [s] and outputs in SI at the accepted steps of a single run, else at its samples."""
        if self.track is None:
            return self["time"], {name: self[name] for name in names or self.columns}
        wanted, places = self._place_outputs(names)
        return self.track.times, dict(zip(wanted, self.track.values.T[places], strict=True))

    def draw_curves(
        self, names: Sequence[str] | None = None, followed: Sequence[str] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Return times [s] and outputs in SI at the accepted steps of a single run, with peaks and inner points.

        Inner points of all or the `followed` outputs are on polynomials, others on straight lines.
        """
        if self.track is None:
            return self.list_rows(names)
        wanted, places = self._place_outputs(names)
        curve = self.track.choose(places).draw_curve([wanted.index(name) for name in followed or wanted])
        return curve.times, dict(zip(wanted, curve.values.T, strict=True))

    def _place_outputs(self, names: Sequence[str] | None) -> tuple[Sequence[str], list[int]]:
        """Return outputs of the system, all if None, and their indices in the track."""
        every = name_outputs(self.system)
        wanted = every if names is None else names
        return wanted, [every.index(name) for name in wanted]

    def measure(self, words: str) -> float:
        """Return a measure of a single run in SI, such as `max(temperature)`, `energy` or `rise-time`.

        It uses the accepted steps, or the samples of a result from a file.

        Raises:
            ParameterError: the measure or the output does not exist.
        """
        one = parse_measure(words)
        names = one.columns(self.system)
        if self.track is None:
            columns = {name: self[name][None] for name in names}
            return float(measure_samples(one, self.system, self["time"], columns)[0])
        places = self._place_outputs(names)[1]
        return float(one.value(tabulate_track(self.track, places, 1, one.follows_curve))[0])

    def bound(self, words: str) -> float | None:
        """Return the error bound of a measure, in its SI unit; None without an estimate.

        There is no estimate for given steps, controllers and results from a file. The bound requires another run
        with a larger tolerance.

        Raises:
            ParameterError: the measure or the output does not exist.
        """
        one = parse_measure(words)
        one.columns(self.system)
        return None if self.trace is None or self.track is None else self.trace.bound_measure(one, self.track)

    def require(self) -> Result:
        """Return this result, or raise `SolveError` for an incomplete run."""
        if self.status.failed:
            reasons = (words for words in self.warnings if words.startswith("The run stopped"))
            raise SolveError(next(reasons, self.status.sentence))
        return self

    @cached_property
    def outputs(self) -> dict[str, Output]:
        """Return the label and unit of every column; for a batch, of requested columns only."""
        outputs = self.system.outputs() | self.beside
        return outputs if self.variants is None else {name: outputs[name] for name in self.columns}

    def unit(self, name: str) -> str:
        """Return the SI unit of a column."""
        return "s" if name == "time" else self.outputs[name].unit

    @property
    def state_names(self) -> list[str]:
        """Return the names of state variables in `restarts`; empty without restarts."""
        return name_state(self.system) if self.restarts else []

    @property
    def coordinate(self) -> str:
        """Return the name of the first coordinate of the mechanism, which defines the stroke."""
        return next(iter(self.system.mechanism.outputs()))

    def range(self, name: str) -> Any:
        """Return the largest minus the smallest value of a column, in SI.

        Args:
            name: a column, or `time`.

        Returns:
            A float; for a batch an array (variants,), NaN for a variant without samples.
        """
        if self.variants is None:
            low, high = self.find_range(name)
            return high - low
        low, high = self.variants.extremes.get(name, (None, None))
        if low is not None and high is not None:
            return high - low
        rows = np.broadcast_to(self[name], (len(self.variants), len(self.times)))
        return np.fmax.reduce(rows, axis=1) - np.fmin.reduce(rows, axis=1)  # which skip NaN

    @property
    def stroke(self) -> Any:
        """Return the range of the first coordinate [m] or [rad]; for a batch an array (variants,)."""
        return self.range(self.coordinate)

    def __str__(self) -> str:
        """Return a summary of a few lines."""
        return describe_result(self)

    @property
    def conformance(self) -> dict[str, str]:
        """Return each user-defined part with the result of its conformance tests.

        Results are `conforms`, `does not conform`, or `not tried` (run `martensite conform FILE`).
        """
        return tell_conformance([self.system, self.waveform])

    def balances(self) -> list[str]:
        """Return the balances of heat and work, one line each, and reasons for missing balances."""
        sentences = [str(one) for one in (self.heat, self.work) if one is not None]
        return sentences + self.unbalanced


LINES = 6
"""Lines of the summary in `repr`."""
ROUNDING = 1e-9
"""Fraction of the largest value of a column that counts as 0."""
