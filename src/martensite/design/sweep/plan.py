"""Plan of a sweep: runs, chunks, and stored results of every run.

A chunk is a range of runs that depends only on the plan and its number, so it can be computed anywhere, in any order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from martensite.base.errors import MartensiteError, ParameterError
from martensite.base.parameters import Parametrised, describe_structure
from martensite.base.status import Status
from martensite.design.sweep.sampling.samples import AbstractDesign
from martensite.search.free_numbers import FreeNumber
from martensite.simulate.accuracy import FEW
from martensite.simulate.ensembles import Ensemble, Numbers
from martensite.simulate.measures.base import AbstractMeasure, list_needed
from martensite.simulate.variants import NAMES, VariantSetup

Kind = TypeVar("Kind")
ENDED, ACCURACY = "ended", "accuracy"
DETAILS = {
    ENDED: ("s", "time at which a run ended"),
    ACCURACY: ("1", "how far what is judged may be off, as a share of its range"),
}
"""Further columns of every run: unit and meaning."""
CHUNK = 512
"""Default number of runs in a chunk: about a second of work, and one file per column."""


@dataclass(frozen=True)
class SweepTrace:
    """Stored output over time."""

    output: str
    samples: int


@dataclass(frozen=True, eq=False)
class SweepPiece:
    """Stored results of some runs."""

    values: Numbers
    """Varied parameters, (runs, axes), in SI."""
    scalars: dict[str, Numbers]
    """One value per run, by measure or one of `DETAILS`."""
    traces: dict[str, Numbers]
    """(runs, samples) by output."""
    status: np.ndarray
    """(runs,)"""

    @staticmethod
    def join(pieces: Sequence[SweepPiece]) -> SweepPiece:
        """Return the results of several pieces."""
        first = pieces[0]
        return SweepPiece(
            np.concatenate([p.values for p in pieces]),
            {n: np.concatenate([p.scalars[n] for p in pieces]) for n in first.scalars},
            {n: np.concatenate([p.traces[n] for p in pieces]) for n in first.traces},
            np.concatenate([p.status for p in pieces]),
        )


@dataclass(frozen=True, eq=False)
class SweepPlan:
    """Sweep that is ready to run."""

    course: VariantSetup
    """System, waveforms, length and step; the outputs are chosen here."""
    axes: tuple[FreeNumber, ...]
    design: AbstractDesign
    measures: Mapping[str, AbstractMeasure]
    """Measures by their text."""
    traces: tuple[SweepTrace, ...] = ()
    chunk: int = CHUNK

    def __post_init__(self) -> None:
        """Raise `ParameterError` if the plan cannot be run."""
        if not self.axes:
            raise ParameterError("A sweep needs varied parameters. Add `--over`.")
        names = [one.target.name for one in self.axes]
        twice = next((n for n in names if names.count(n) > 1), None)
        if twice:
            raise ParameterError(f"`{twice}` is varied twice.")
        if not (self.measures or self.traces):
            raise ParameterError("A sweep needs at least one output to store from every run; name one.")
        if self.chunk < 1:
            raise ParameterError(f"A chunk must have at least one run, not {self.chunk}.")
        self._check_axes()

    def _check_axes(self) -> None:
        """Raise an error if an axis has an invalid end, or changes the size of the program."""
        system = self.course.system
        for one in self.axes:
            part = system if one.target.drive is None else self.course.waveforms[one.target.drive]
            leaf = next(leaf for leaf in part.leaves() if leaf.path == one.target.path)
            for number in one.extremes():
                leaf.declared.convert(leaf.owner, one.target.name, number)
                if _count_bytes(part, one.target.path, number) != describe_structure(part):
                    raise ParameterError(
                        f"`{one.target.name}` decides how large the program is and cannot be "
                        "varied; run one sweep for each value."
                    )

    @cached_property
    def size(self) -> int:
        """Return the number of runs."""
        return self.design.size(self.axes)

    @property
    def chunks(self) -> int:
        """Return the number of chunks."""
        return -(-self.size // self.chunk)

    def rows(self, chunk: int) -> range:
        """Return the runs of a chunk."""
        return range(chunk * self.chunk, min((chunk + 1) * self.chunk, self.size))

    def cautions(self) -> list[str]:
        """Return sentences about allowed but unusual requests."""
        totals_on_device = self.course.runtime == "cuda" and self.course.controlled and self._ready.measuring.totalled
        if self.measures and self.course.runtime == "cuda" and not totals_on_device:
            name = NAMES[self.course.runtime]
            return [
                f"On {name}, measures are computed from {self.course.samples:,} stored samples: a pulse between two of "
                "them is missed. The runtime `c` computes measures from all steps."
            ]
        return []

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """Return all necessary outputs."""
        trace_outputs = (trace.output for trace in self.traces)
        return tuple(dict.fromkeys((*list_needed(self.measures.values(), self.course.system), *trace_outputs)))

    @cached_property
    def times(self) -> Numbers:
        """Return the sample times of every run [s]."""
        return np.array(self._ready.times)

    def trace_times(self, trace: SweepTrace) -> Numbers:
        """Return the sample times of a trace [s]."""
        return self.times[self._places(trace)]

    def compute(self, rows: range) -> SweepPiece:
        """Compute some runs."""
        values = self.values(rows)
        system, signals = self.by_owner([np.ascontiguousarray(column) for column in values.T])
        return self._collect_results(values, self._ready.run(system, signals))

    def values(self, rows: range) -> Numbers:
        """Return the varied parameters of some runs, (runs, axes), in SI."""
        return self.design.values(self.axes, rows.start, len(rows))

    def by_owner(self, columns: Sequence[Kind]) -> tuple[dict[str, Kind], dict[str, dict[str, Kind]]]:
        """Split values by axis: by path in the system, and by drive and path in waveforms."""
        system: dict[str, Kind] = {}
        signals: dict[str, dict[str, Kind]] = {}
        for one, column in zip(self.axes, columns, strict=True):
            drive = one.target.drive
            table = system if drive is None else signals.setdefault(drive, {})
            table[one.target.path] = column
        return system, signals

    def make_lost_piece(self, rows: range) -> SweepPiece:
        """Return the stored results of lost runs."""
        lost = Ensemble.empty(self.outputs, len(rows), len(self.times), Status.LOST, len(self.measures))
        return self._collect_results(self.values(rows), lost)

    def try_measures(self) -> None:
        """Raise `InputError` if a measure fails on an empty run."""
        times = self.times
        self._ready.measuring.measure_samples(times.tolist(), np.zeros((len(self.outputs), len(times), 1)))

    @cached_property
    def _ready(self) -> VariantSetup:
        """Return the setup with outputs and measures; without traces it has few samples."""
        samples = self.course.samples
        if self.course.controlled and self.course.runtime != "cuda" and not self.traces:
            samples = min(samples, FEW)
        measures = tuple(self.measures.values())
        return replace(self.course, outputs=self.outputs, measures=measures, samples=samples)

    def _collect_results(self, values: Numbers, ran: Ensemble) -> SweepPiece:
        """Return the measures and traces; a failed run has no measures."""
        bad = ran.status >= Status.UNSOLVED
        scalars = {words: np.where(bad, np.nan, row) for words, row in zip(self.measures, ran.numbers, strict=True)}
        scalars |= {ENDED: ran.ended, ACCURACY: ran.accuracy}
        traces = {t.output: ran.columns[t.output][:, self._places(t)] for t in self.traces}
        return SweepPiece(values, scalars, traces, ran.status)

    def _places(self, trace: SweepTrace) -> np.ndarray:
        """Return the samples of a trace: both ends, and evenly between them."""
        last = len(self.times) - 1
        return np.unique(np.round(np.linspace(0, last, min(trace.samples, last + 1))).astype(int))


def _count_bytes(part: Parametrised, path: str, number: float) -> tuple[Any, ...]:
    """Return the structure with another number; the nominal one if a check refuses the number."""
    try:
        return describe_structure(part.with_values({path: number}))
    except MartensiteError:  # a refused run is a row of the sweep
        return describe_structure(part)
