"""Running a sweep for the command line: plan, store, chunks, and what came of it."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.cli.sweep_show import Swept
from martensite.cli.waiting import spinner, sweep_bar

if TYPE_CHECKING:
    from martensite.io.scenario import Scenario
    from martensite.io.sweeps.job import Wanted
    from martensite.sweep.backends.base import AbstractBackend


@dataclass(frozen=True)
class Chosen:
    """How a sweep is run, which does not change what comes out."""

    out: Path
    backend: str
    workers: int
    scheduler: str | None
    part: str | None
    """Part of the chunks, `i/N`."""
    modules: tuple[str, ...]
    force: bool


def swept(scenario: Scenario, wanted: Wanted, chosen: Chosen) -> Swept:
    """Run what is missing of a sweep.

    Raises:
        InputError: an axis, an option or the store is wrong.
    """
    from martensite.io.sweeps.job import SweepJob, prepared, spec_of
    from martensite.io.sweeps.store import Store, create
    from martensite.sweep.running import run_chunks, share_of

    backend = _backend(chosen)
    if chosen.force and chosen.out.exists():
        Store(chosen.out).made()  # nothing but a sweep is removed
        shutil.rmtree(chosen.out)
    with spinner(f"preparing {scenario.title}"):
        plan, wanted = prepared(scenario, _as_before(wanted, chosen.out))
        spec = spec_of(scenario, wanted, chosen.modules)
        store = create(chosen.out, plan, spec)
    job, part = SweepJob(chosen.out.resolve(), json.dumps(spec)), share_of(plan.chunks, chosen.part)
    with sweep_bar(scenario.title) as tell:
        progress = run_chunks(job, part, store.made(), backend, tell)
    return Swept(plan, store, progress, part)


def _as_before(wanted: Wanted, path: Path) -> Wanted:
    """With the step and the runtime that a store was begun with, where none are asked for."""
    from dataclasses import replace

    from martensite.io.sweeps.store import Store

    if not path.exists():
        return wanted
    known = Store(path).spec
    return replace(
        wanted, step=wanted.step or known["step"], runtime=wanted.runtime or known["runtime"]
    )


def _backend(chosen: Chosen) -> AbstractBackend:
    from martensite.errors import InputError
    from martensite.sweep.backends.base import BACKENDS

    made = BACKENDS[chosen.backend]
    fields = getattr(made, "__dataclass_fields__", {})
    given = {"workers": chosen.workers or None, "scheduler": chosen.scheduler}
    for name, value in given.items():
        if value is not None and name not in fields:
            raise InputError(f"Option `--{name}` has no effect on the backend `{chosen.backend}`.")
    return made(**{name: value for name, value in given.items() if value is not None})
