"""Sweeps from Python, as the command `martensite sweep` makes them."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.base import units
from martensite.base.errors import DataError, InputError, ParameterError
from martensite.base.interrupts import rescue_answer
from martensite.base.registry import import_modules
from martensite.design.sweep.backends.base import BACKENDS, AbstractBackend, Report
from martensite.design.sweep.job import MEASURES, SweepJob, SweepRequest, build_spec, prepare_plan
from martensite.design.sweep.plan import CHUNK, SweepPlan
from martensite.design.sweep.store import Store, create_store
from martensite.scenario.scenario import Scenario, load

if TYPE_CHECKING:
    import xarray


@dataclass
class Progress:
    """Progress of a sweep."""

    runs: int
    """Runs in all requested chunks."""
    before: int
    """Runs of earlier sweeps."""
    status: Counter[int] = field(default_factory=Counter[int])
    """New runs by status."""
    seconds: float = 0.0
    """CPU time of the new chunks."""
    remarks: list[str] = field(default_factory=list[str])

    @property
    def new_runs(self) -> int:
        """Return the number of new runs."""
        return self.status.total()

    @property
    def done(self) -> int:
        """Return the number of all finished runs."""
        return self.before + self.new_runs

    def note(self, report: Report) -> None:
        """Count a chunk."""
        self.status.update(report.status)
        self.seconds += report.seconds
        self.remarks.extend(report.remarks)


Tell = Callable[[Progress], None]


def run_chunks(
    job: SweepJob, wanted: Sequence[int], done: set[int], backend: AbstractBackend, tell: Tell | None = None
) -> Progress:
    """Run the requested chunks that are missing.

    Args:
        job: runs a chunk and stores it.
        wanted: numbers of requested chunks.
        done: numbers of finished chunks.
        backend: executor of the chunks.
        tell: called after every chunk.

    Raises:
        InterruptError: the sweep was interrupted; finished chunks are kept.
        StoppedError: the sweep cannot continue; finished chunks are kept.
    """
    there = [chunk for chunk in wanted if chunk in done]
    runs = sum(len(job.rows(chunk)) for chunk in wanted)
    progress = Progress(runs, sum(len(job.rows(chunk)) for chunk in there))
    missing = [chunk for chunk in wanted if chunk not in done]

    def say_kept() -> str:
        return (
            f"Interrupted when {progress.done:,} of {runs:,} runs were there. They are kept: the same command goes "
            "on from there."
        )

    with rescue_answer(say_kept):
        if tell:
            tell(progress)
        with closing(backend.run(job, missing)) as reports:
            for report in reports:
                progress.note(report)
                if tell:
                    tell(progress)
    return progress


def parse_share(chunks: int, part: str | None) -> range:
    """Return the chunks of part i of N of a sweep, written `i/N` with i from 1; by default all chunks.

    Raises:
        ParameterError: the text is malformed, or i is out of range.
    """
    if part is None:
        return range(chunks)
    first, slash, count = part.partition("/")
    if not (slash and first.strip().isdecimal() and count.strip().isdecimal()):
        raise ParameterError(f"A part of a sweep is written `1/16`, not `{part}`.")
    i, total = int(first), int(count)
    if not 1 <= i <= total:
        raise ParameterError(f"Part `{part}` must be between 1/{total} and {total}/{total}.")
    return range(i - 1, chunks, total)


FEW_CHUNKS = 2
"""Number of chunks that run faster than processes start."""


@dataclass(frozen=True)
class SweepExecution:
    """Execution of a sweep, without influence on its results."""

    backend: str | None = None
    """Executor; None for several processes, or this process for a few chunks."""
    workers: int = 0
    scheduler: str | None = None
    part: str | None = None
    """Part of the chunks, `i/N`."""
    modules: tuple[str, ...] = ()
    """Modules with registered parts of the user."""
    force: bool = False
    """Replace an existing store."""

    def make_backend(self, chunks: int, runtime: str | None) -> AbstractBackend:
        """Return the backend for a number of chunks.

        Raises:
            InputError: the name is unknown, or an option has no effect on the backend.
        """
        backend = BACKENDS[self._name(chunks, runtime)]
        fields = getattr(backend, "__dataclass_fields__", {})
        given = {"workers": self.workers or None, "scheduler": self.scheduler}
        for name, value in given.items():
            if value is not None and name not in fields:
                raise InputError(f"Option `--{name}` has no effect on the backend `{backend.registered_name}`.")
        return backend(**{name: value for name, value in given.items() if value is not None})

    def _name(self, chunks: int, runtime: str | None) -> str:
        if self.backend:
            return self.backend
        if self.scheduler:
            return "dask"
        few = chunks <= FEW_CHUNKS and not self.workers
        return "serial" if few or runtime == "cuda" else "processes"


@dataclass(frozen=True)
class PlannedSweep:
    """Sweep with its store."""

    plan: SweepPlan
    store: Store
    job: SweepJob
    part: range
    """Requested chunks."""
    backend: AbstractBackend
    remarks: tuple[str, ...] = ()
    """Remarks on the store."""

    def run(self, tell: Tell | None = None) -> Progress:
        """Run the missing chunks; `tell` is called after each.

        Raises:
            StoppedError: the sweep cannot continue, or was interrupted; finished chunks are kept.
        """
        progress = run_chunks(self.job, self.part, self.store.list_finished_chunks(), self.backend, tell)
        progress.remarks[:0] = self.remarks
        return progress


def begin_sweep(scenario: Scenario, wanted: SweepRequest, path: Path, how: SweepExecution) -> PlannedSweep:
    """Plan a sweep, and create or open its store.

    The whole request is checked before files are removed or written.

    Raises:
        InputError: an axis, an option or the store is invalid.
    """
    how.make_backend(0, wanted.runtime)
    if how.force and how.part:
        raise InputError("`--force` would remove what other parts have made; leave it out.")
    parse_share(1 << 30, how.part)
    if not path.absolute().parent.is_dir():
        raise DataError(f"There is no folder `{path.parent}` to write `{path.name}` into.")
    old = Store(path) if path.exists() else None
    if old:
        old.require_sweep()  # nothing else is opened, or removed
        if not how.force:  # the step and the runtime that it was begun with
            spec = old.spec
            wanted = replace(wanted, step=wanted.step or spec["step"], runtime=wanted.runtime or spec["runtime"])
    plan, wanted = prepare_plan(scenario, wanted)
    spec = build_spec(scenario, wanted, how.modules)
    if old and how.force:
        shutil.rmtree(path)
    store = create_store(path, plan, spec)
    damaged = store.discard_damaged()
    job, part = SweepJob(path.resolve(), json.dumps(spec)), parse_share(plan.chunks, how.part)
    backend = how.make_backend(len(set(part) - store.list_finished_chunks()), wanted.runtime)
    count = "1 chunk was" if len(damaged) == 1 else f"{len(damaged):,} chunks were"
    remarks = (f"{count} damaged and had to be made again.",) if damaged else ()
    return PlannedSweep(plan, store, job, part, backend, remarks)


def run_sweep(
    scenario: Scenario | str | Path,
    *,
    over: Sequence[str],
    out: str | Path,
    sample: str = "grid",
    measures: Sequence[str] = MEASURES,
    traces: Sequence[tuple[str, int]] = (),
    seed: int = 0,
    step: float | str | None = None,
    runtime: str | None = None,
    precision: str = "float64",
    chunk: int = CHUNK,
    backend: str | None = None,
    workers: int = 0,
    scheduler: str | None = None,
    part: str | None = None,
    modules: Sequence[str] = (),
    force: bool = False,
    tell: Tell | None = None,
) -> xarray.Dataset:
    """Run variants of a scenario into a Zarr store, and open it.

    A repeated call continues an unfinished sweep.

    Args:
        scenario: scenario or its file.
        over: varied parameters, such as `diameter=0.1..0.5 mm:9` or `length=250 mm +- 2 %`.
        out: folder of the store.
        sample: grid, or a design with a number of runs, such as `sobol:1024`.
        measures: one value per run, such as `stroke` or `max(stress)`.
        traces: stored outputs over time, each with a number of samples.
        seed: seed of the sample.
        step: longest of equal steps [s], by default the tolerance of the scenario with error control of each run.
        runtime: c, cuda or floats, by default c with a compiler.
        precision: float64, or float32 on CUDA.
        chunk: number of runs that are computed and written together; a GPU needs many thousands.
        backend: processes, serial or dask, by default serial for a few chunks or on CUDA, else processes. A script with
            another backend than serial needs `if __name__ == "__main__":`.
        workers: number of processes; 0 for one per core.
        scheduler: address of a Dask scheduler.
        part: part I of N of the chunks, `I/N`, for job arrays.
        modules: modules or .py files with registered parts of your own.
        force: replace an existing store.
        tell: called with the `Progress` after every chunk.

    Returns:
        All runs as `open_sweep` returns them; missing and failed runs are NaN.

    Raises:
        InputError: an argument is invalid.
        StoppedError: the sweep stopped; finished chunks are kept.
    """
    from martensite.design.sweep.reading import open_sweep

    import_modules(modules)
    scenario = scenario if isinstance(scenario, Scenario) else load(scenario)
    length = units.parse_quantity(step, "s") if isinstance(step, str) else step
    wanted = SweepRequest(tuple(over), sample, tuple(measures), tuple(traces), seed, chunk, length, runtime, precision)
    how = SweepExecution(backend, workers, scheduler, part, tuple(modules), force)
    begin_sweep(scenario, wanted, Path(out), how).run(tell)
    return open_sweep(out)
