"""Entries of the benchmark: a controller of the package each, with numbers that were found on the nominal wire alone.

An entry stands in `entries/NAME.toml`: its `controller` as in a scenario, `plants` that it is for (all by default), and
`free`, which of its numbers are searched, each with bounds and, where it is in signal per unit of what is followed or
in that unit, `per-span` or `span`: then the bounds are for a span of 1. Numbers `borrowed` are those of another entry.
On a plant whose two drives pull against each other the second drive has the same controller with the numbers `negative`
of opposite sign and those of `mirror` as given there, unless the first one `leads` it. A controller that learns a task
is told when it repeats, in the number `repeats`; a task that does not is one repetition. Numbers found are in
`gains.toml`, by entry and plant, with where they come from.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np

from benchmarks.control.tasks import ORDER, ZERO, BenchmarkTask, list_plant_drives, load_tasks, read_plant
from martensite.base.errors import UnknownNameError
from martensite.control.loop.bench import Bench
from martensite.scenario.scenario import read_scenario

FOLDER = Path(__file__).parent
GAINS = FOLDER / "gains.toml"
FOLLOWS = {"wire": ("position", "m"), "pair": ("angle", "rad"), "finger": ("angle", "rad")}
"""Output that is followed on a plant, and its unit."""
PER_SPAN, SPAN = "per-span", "span"
SCALE = "reference"
"""Prefix of numbers that turn the reference of a task into that of the controller: `reference.gain`, `.offset`."""


@dataclass(frozen=True)
class FreeGain:
    """A number that is searched."""

    name: str
    low: float
    high: float
    scale: str
    """`per-span`, `span`, or nothing."""

    @property
    def logarithmic(self) -> bool:
        """Whether it keeps a sign, and is searched on its logarithm."""
        return self.low > 0.0

    def convert(self, shares: Any, span: float) -> Any:
        """Numbers in SI from shares of the range, 0 to 1."""
        factor = scale_by(self.scale, span)
        if self.logarithmic:
            return factor * self.low * (self.high / self.low) ** shares
        return factor * (self.low + (self.high - self.low) * shares)


def scale_by(scale: str, span: float) -> float:
    """What a number of a scale is multiplied by."""
    return {PER_SPAN: 1.0 / span, SPAN: span}.get(scale, 1.0)


@dataclass(frozen=True, eq=False)
class BenchmarkEntry:
    """A controller that takes part."""

    name: str
    title: str
    controller: Mapping[str, Any]
    """As in a scenario."""
    free: tuple[FreeGain, ...] = ()
    fixed: Mapping[str, Any] | None = None
    """Numbers that follow from the span: a number and its scale, by name."""
    borrowed: Mapping[str, str] | None = None
    """Numbers that are those of another entry on the same plant, as `pid.Kp`, by name."""
    plants: tuple[str, ...] = ORDER
    why: str = ""
    """Why it has no entry on the other plants."""
    zero: Any = None
    """Nothing to follow, in the unit of its reference, where that is not what is followed."""
    negative: tuple[str, ...] = ()
    mirror: Mapping[str, Any] | None = None
    leads: bool = False
    """Whether the controller of the first drive has the second one as well."""
    repeats: str = ""
    """Name of the time after which a task repeats, of a controller that learns."""
    rounds: int | None = None
    """Of the search of its numbers, where it gets fewer than the others."""
    fault_wires: int | None = None
    """How many of the wires it runs with faults, where these are not all."""

    def build_bench(self, plant: str, numbers: Mapping[str, float] | None = None) -> Bench:
        """A plant under this controller, without a guard.

        Args:
            plant: name of the plant.
            numbers: of the controller, by path; by default those of `gains.toml`.
        """
        sections: dict[str, Any] = {}
        for k, drive in enumerate(list_plant_drives(plant)):
            sections[f"controllers.{drive}"] = self._list_sections(plant, k)
            zero = ZERO[plant] if self.zero is None else self.zero
            sections[f"references.{drive}"] = {"kind": "constant", "level": zero}
        bench = cast(Bench, read_scenario(read_plant(plant), None, sections).bench)
        return bench.with_values(self.place_numbers(plant, self.list_numbers(plant, numbers)))

    def list_numbers(self, plant: str, numbers: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Numbers on a plant, those that follow from its span or another entry too; by default of `gains.toml`."""
        span = find_span(plant)
        fixed = {name: value * scale_by(scale, span) for name, (value, scale) in (self.fixed or {}).items()}
        for name, where in (self.borrowed or {}).items():
            entry, _, path = where.partition(".")
            fixed[name] = load_gains(entry, plant)[path]
        return {**fixed, **(load_gains(self.name, plant) if numbers is None else numbers)}

    def _list_sections(self, plant: str, place: int) -> dict[str, Any]:
        """The section of the controller of a drive."""
        drives = list_plant_drives(plant)
        if place and self.leads:
            return {"kind": "follower", "high": 1.0}
        found = fill_words({**self.controller, **((self.mirror or {}) if place else {})}, plant)
        if self.leads and len(drives) > 1:
            found["leads"] = list(drives[1:])
        if "temperature" in found and len(drives) > 1:
            found["temperature"] = f"{drives[place]}_temperature"
        return found

    def place_numbers(self, plant: str, numbers: Mapping[str, Any]) -> dict[str, Any]:
        """Numbers by their paths in the bench, for all drives."""
        found: dict[str, Any] = {}
        for k, drive in enumerate(self._list_drives(plant)):
            sign = {name: -1.0 if k and name in self.negative else 1.0 for name in numbers}
            own = {name: value for name, value in numbers.items() if not name.startswith(f"{SCALE}.")}
            found |= {f"controllers.{drive}.{name}": sign[name] * value for name, value in own.items()}
        return found

    def list_repetitions(self, tasks: Sequence[BenchmarkTask], wires: int) -> dict[str, Any]:
        """When tasks repeat, by path in the bench, shape (tasks × wires,); nothing where nobody learns."""
        times = np.repeat([one.repetition for one in tasks], wires)
        drives = self._list_drives(tasks[0].plant) if self.repeats else ()
        return {f"controllers.{drive}.{self.repeats}": times for drive in drives}

    def _list_drives(self, plant: str) -> tuple[str, ...]:
        """Drives that have numbers of a controller."""
        return list_plant_drives(plant)[: 1 if self.leads else None]


def fill_words(given: Any, plant: str) -> Any:
    """A section with the unit and the name of what is followed on a plant in place of `[unit]` and `[output]`."""
    if isinstance(given, Mapping):
        return {key: fill_words(value, plant) for key, value in cast("Mapping[str, Any]", given).items()}
    if not isinstance(given, str):
        return given
    output, unit = FOLLOWS[plant]
    return given.replace("[unit]", unit).replace("[output]", output)


def find_scale(numbers: Mapping[str, Any]) -> tuple[Any, Any]:
    """Gain and offset of what a controller is given to follow, on what the task asks for."""
    return numbers.get(f"{SCALE}.gain", 1.0), numbers.get(f"{SCALE}.offset", 0.0)


def find_span(plant: str) -> float:
    """Largest span that a task asks for on a plant."""
    return max(one.span for one in load_tasks().values() if one.plant == plant)


@cache
def load_entries() -> dict[str, BenchmarkEntry]:
    """All entries of the package, by name."""
    return {path.stem: _read_entry(path) for path in sorted((FOLDER / "entries").glob("*.toml"))}


def find_entry(name: str) -> BenchmarkEntry:
    """An entry by name; `UnknownNameError` if there is none."""
    entries = load_entries()
    if name not in entries:
        raise UnknownNameError("entry", name, entries)
    return entries[name]


def read_entry(path: Path) -> BenchmarkEntry:
    """An entry of one's own, from a file; its controller stands there with all its numbers."""
    return _read_entry(path)


def _read_entry(path: Path) -> BenchmarkEntry:
    given = tomllib.loads(path.read_text(encoding="utf-8"))
    rows = [(name, *row, "") for name, row in given.get("free", {}).items()]
    given["free"] = tuple(FreeGain(name, float(low), float(high), scale) for name, low, high, scale, *_ in rows)
    for key in ("plants", "negative"):
        if key in given:
            given[key] = tuple(given[key])
    return BenchmarkEntry(name=path.stem, **given)


@cache
def _read_gains() -> dict[str, Any]:
    return tomllib.loads(GAINS.read_text(encoding="utf-8")) if GAINS.exists() else {}


def load_gains(entry: str, plant: str) -> dict[str, float]:
    """Numbers of an entry on a plant, by path in its controller; none where nothing was searched."""
    return dict(_read_gains().get(entry, {}).get(plant, {}).get("numbers", {}))


ABSENT = {"latched": "acts once, on one event, and follows no reference", "follower": "has the signals of its leader"}
"""Kinds of controllers without an entry, and why."""


def list_missing(entries: Mapping[str, BenchmarkEntry], kinds: Iterable[str]) -> list[tuple[str, str]]:
    """Kinds of controllers without an entry, and why."""
    there = {one.controller["kind"] for one in entries.values()}
    return [(name, ABSENT.get(name, "not yet tuned")) for name in kinds if name not in there]
