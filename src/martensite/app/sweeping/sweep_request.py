"""Request for a sweep, in the syntax of the command; its errors; its duration.

{"text": TOML, "changes": {…}, "over": ["diameter=0.1..0.5 mm:9"], "sample": "grid",
 "measures": ["stroke"], "seed": 0, "step": "20 ms", "runtime": "c", "workers": 0}

A chunk takes about half a second, for smooth progress and quick cancellation.
"""

from __future__ import annotations

import re
import shlex
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from martensite.app.messages import BadMessageError, Request, require_entry
from martensite.base import units
from martensite.base.errors import MartensiteError, ParameterError
from martensite.design.sweep.api import SweepExecution
from martensite.design.sweep.axes import parse_axis
from martensite.design.sweep.backends.processes import count_cores
from martensite.design.sweep.job import SweepRequest, build_plan
from martensite.design.sweep.plan import CHUNK, SweepPlan
from martensite.design.sweep.sampling.samples import AbstractDesign, parse_sampling
from martensite.design.sweep.subject import build_course
from martensite.scenario.scenario import Scenario
from martensite.scenario.targets import list_targets
from martensite.search.free_numbers import FreeNumber
from martensite.simulate.measures.base import parse_measure
from martensite.simulate.variants import LANES

T = TypeVar("T")
MOST_RUNS = 1_000_000
MOST_WORDS = 64
LONGEST_ENTRY = 400
CHUNK_TIME = 0.4
"""Target time of a chunk [s]."""
MOST_CHUNKS = 500
_PLAIN = re.compile(r"^[\w./:=,-]+$")
_QUOTABLE = re.compile(r"^[\w .,:;=+/()%^*·µΩ°±²³-]*$")


def read_wanted(request: Request) -> SweepRequest:
    """Return the request in the form of the library."""
    step = str(require_entry(request, "step", str, "")).strip()
    return SweepRequest(
        over=read_texts(request, "over"),
        sample=_read_sample(require_entry(request, "sample", str, "grid")),
        measures=read_texts(request, "measures"),
        seed=require_entry(request, "seed", int, 0),
        step=parse_step(step),
        runtime=require_entry(request, "runtime", str, "") or None,
    )


def read_workers(request: Request) -> SweepExecution:
    """Return the number of processes, 0 for automatic."""
    workers = require_entry(request, "workers", int, 0)
    if not 0 <= workers <= 256:
        raise ParameterError(f"Processes must be between 0 and 256, but are {workers}.")
    return SweepExecution(workers=workers)


def parse_step(words: str) -> float | None:
    """Return a longest step [s]; None for automatic."""
    if not words:
        return None
    quantity = units.parse_quantity(words, "s")
    if not quantity > 0.0:
        raise ParameterError(f"A step must be above 0, but is {words}.")
    return quantity


def require_size(plan: SweepPlan) -> SweepPlan:
    """Return the plan."""
    if plan.size > MOST_RUNS:
        raise ParameterError(
            f"This sweep has {plan.size:,} runs; the page starts at most {MOST_RUNS:,}. Use "
            "`martensite sweep` for more."
        )
    return plan


def read_texts(request: Request, name: str, default: Any = ...) -> tuple[str, ...]:
    """Return a list of texts of a message."""
    given = require_entry(request, name, list, default)
    fits = (isinstance(one, str) and len(one) <= LONGEST_ENTRY for one in given)
    if len(given) > MOST_WORDS or not all(fits):
        raise BadMessageError(
            f"`{name}` must be a list of at most {MOST_WORDS} texts of at most {LONGEST_ENTRY} letters."
        )
    return tuple(given)


def _read_sample(words: str) -> str:
    if len(words) > LONGEST_ENTRY or not words.isascii():
        raise BadMessageError(f"`{words[:40]}` is no sample; write for example `sobol:1024`.")
    return words


class FieldFaults(dict[str, str]):
    """Error sentences by field of the form."""

    def attempt(self, field: str, action: Callable[[], T]) -> T | None:
        """Return the result of an action; on an error return None, and record the sentence for the field."""
        try:
            return action()
        except MartensiteError as error:
            self.setdefault(field, str(error))
            return None


def check_request(scenario: Scenario, request: Request) -> tuple[SweepPlan | None, FieldFaults]:
    """Return the plan of a request, or its errors by field of the form.

    Fields are `over.0`, `over.1` …, `sample`, `seed`, `measures.0` …, `step`, `runtime`, `workers`, and `` (the whole).
    """
    field_faults = FieldFaults()
    field_faults.attempt("step", lambda: parse_step(str(require_entry(request, "step", str, "")).strip()))
    field_faults.attempt("workers", lambda: read_workers(request))
    wanted = field_faults.attempt("", lambda: read_wanted({**request, "step": ""}))
    if wanted is None:
        return None, field_faults
    field_faults.attempt("runtime", lambda: build_course(scenario, None, wanted.runtime))
    _check_measures(scenario, wanted, field_faults)
    chosen = field_faults.attempt(
        "seed" if wanted.seed < 0 else "sample", lambda: parse_sampling(wanted.sample, wanted.seed)
    )
    _check_axes(scenario, wanted, chosen, field_faults)
    if field_faults:
        return None, field_faults
    step = parse_step(str(request.get("step") or "").strip())
    plan = field_faults.attempt("", lambda: build_plan(scenario, replace(wanted, step=step)))
    if plan is not None:
        field_faults.attempt("sample", lambda: require_size(plan))
    if plan is not None and not field_faults:
        field_faults.attempt("", lambda: plan.make_lost_piece(range(1)))
    return (None if field_faults else plan), field_faults


def _check_measures(scenario: Scenario, request: SweepRequest, field_faults: FieldFaults) -> None:
    for k, words in enumerate(request.measures):
        field_faults.attempt(f"measures.{k}", lambda words=words: parse_measure(words).unit_in(scenario.whole))


def _check_axes(
    scenario: Scenario, request: SweepRequest, chosen: AbstractDesign | None, field_faults: FieldFaults
) -> None:
    """Check syntax and bounds of each axis, and its levels in a grid."""
    targets = list_targets(scenario)
    for k, words in enumerate(request.over):
        one = field_faults.attempt(f"over.{k}", lambda words=words: parse_axis(words, targets))
        if one is not None:
            field_faults.attempt(f"over.{k}", lambda one=one: _check_axis(scenario, one, chosen))


def _check_axis(scenario: Scenario, one: FreeNumber, chosen: AbstractDesign | None) -> None:
    course = build_course(scenario)
    SweepPlan(course, (one,), parse_sampling("monte-carlo:1"), {"stroke": parse_measure("stroke")})
    if chosen is not None and chosen.registered_name == "grid":
        one.levels()


@dataclass(frozen=True)
class TimedBlock:
    """A block of runs with its duration."""

    runs: int
    lanes: int
    seconds: float

    def total(self, size: int, workers: int) -> float:
        """Return the duration of `size` runs on `workers` processes [s]."""
        return -(-size // self.lanes) * self.seconds / max(workers or count_cores(), 1)


def time_block(plan: SweepPlan) -> TimedBlock:
    """Return the timed second run of one block of a plan; the first compiles."""
    lanes = LANES.get(plan.course.runtime, CHUNK)
    rows = range(min(lanes, plan.size))
    plan.compute(rows if plan.course.runtime != "floats" else range(1))
    begin = time.perf_counter()
    plan.compute(rows)
    return TimedBlock(len(rows), lanes, time.perf_counter() - begin)


def choose_chunk(plan: SweepPlan) -> int:
    """Return the runs in a chunk: whole blocks of about `CHUNK_TIME`, in at most `MOST_CHUNKS` chunks."""
    one = time_block(plan)
    blocks = max(int(CHUNK_TIME / max(one.seconds, 1e-6)), 1)
    usual = min(blocks * one.lanes, CHUNK)
    least = -(-plan.size // MOST_CHUNKS)
    return max(usual, -(-least // one.lanes) * one.lanes)


def quote_words(words: str) -> str:
    """Return words for a shell, in double quotes, which all shells know, where that is safe."""
    if _PLAIN.match(words):
        return words
    return f'"{words}"' if _QUOTABLE.match(words) else shlex.quote(words)


def write_command(name: str, request: SweepRequest, workers: int = 0, step: str = "") -> str:
    """Return the command `martensite sweep …` for a scenario in `name`.toml."""
    pieces = ["martensite sweep", quote_words(f"{name}.toml")]
    pieces += [f"--over {quote_words(words)}" for words in request.over]
    if request.sample != "grid":
        pieces.append(f"--sample {quote_words(request.sample)}")
    pieces += [f"--output {quote_words(words)}" for words in request.measures]
    options = {
        "seed": request.seed or None,
        "step": quote_words(step) if step else None,
        "runtime": request.runtime,
        "workers": workers or None,
        "chunk-size": request.chunk if request.chunk != CHUNK else None,
    }
    pieces += [f"--{option} {value}" for option, value in options.items() if value is not None]
    return " ".join(pieces)
