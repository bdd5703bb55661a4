"""`size_wire`: every size and alloy of a catalogue put to the request, the best first.

For each the statics are closed, and one strand is simulated: the current that makes the stroke in
1 s (or half a period, if that is less), and the cooling after it. If both together take longer
than a period, the current is raised until the pulse fits beside the cooling, as far as the supply
goes. What fails is said as a reason; nothing is left out in silence.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from martensite.actuators.assembly import System
from martensite.design.sizing import remarks
from martensite.design.sizing.cycle import PulseCycle, find_current, find_hottest, find_reach_time, simulate_cycle
from martensite.design.sizing.request import WireRequest, Wiring, choose_wiring
from martensite.design.sizing.statics import Statics, compute_statics, list_alloy_numbers
from martensite.physics.materials.base import DOUBTFUL
from martensite.physics.materials.wires import WireCatalogue, WireSize, load_wires

PULSE = 1.0
"""Heating time that is tried first [s]: the one for which the maker gives currents."""
HASTE = 0.05
"""Shortest pulse that is tried first, as a share of the thermal time constant: a wire that must
heat so fast is far too slow in cooling."""
SPARE = 1.02
"""Margin on the cooling time when the pulse is shortened to fit beside it."""
SHORTEST = 0.02
"""Shortest pulse, as a share of the period."""
USED_CELLS = ("diameter", "resistance")
"""Cells of the catalogue that the answer rests on."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Drive:
    """What the supply gives to all strands during a pulse."""

    current: float
    """[A]"""
    voltage: float
    """[V]"""
    power: float
    """[W]"""
    energy: float
    """Of one cycle [J]."""


@dataclass(frozen=True)
class Candidate:
    """One size and alloy put to a request; forces of all strands, currents as named."""

    size: WireSize
    alloy: str
    statics: Statics
    wiring: Wiring | None
    cycle: PulseCycle | None
    """Of one strand; None if it was not worth simulating."""
    overheating_current: float
    """Current per strand that in the long run heats it to the temperature limit [A]."""
    temperature_limit: float
    """That of the material [K]."""
    reasons: tuple[str, ...] = ()
    """Why the request is not met; empty if it is."""
    warnings: tuple[str, ...] = ()
    life: str = ""
    recalled: tuple[str, ...] = ()
    """Cells the answer rests on that are recalled, not read in a source."""

    @property
    def feasible(self) -> bool:
        """True if the request is met."""
        return not self.reasons

    @property
    def drive(self) -> Drive | None:
        """What the supply gives; None if the candidate was not simulated."""
        if self.wiring is None or self.cycle is None:
            return None
        strand, wiring, heating = self.cycle.current, self.wiring, self.cycle.heating
        current, voltage = wiring.total_current(strand), wiring.voltage(strand)
        return Drive(current, voltage, current * voltage, current * voltage * heating)

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; numbers in SI."""
        mine = self.statics
        own = {name: getattr(mine, name) for name in mine.__dataclass_fields__ if name != "strand"}
        return {
            "size": self.size.name,
            "alloy": self.alloy,
            "feasible": self.feasible,
            "reasons": list(self.reasons),
            **own,
            "length": mine.strand.length,
            "strand_resistance": mine.strand.resistance,
            "wiring": self.wiring.kind if self.wiring else None,
            "drive": asdict(self.drive) if self.drive else None,
            "strand": asdict(self.cycle) | {"fastest": self.cycle.fastest} if self.cycle else None,
            "overheating_current": self.overheating_current,
            "temperature_limit": self.temperature_limit,
            "life": self.life,
            "warnings": list(self.warnings),
            "recalled": list(self.recalled),
        }


@dataclass(frozen=True)
class Sizing:
    """The answer to a request."""

    request: WireRequest
    candidates: list[Candidate] = field(default_factory=list[Candidate])
    """The best first: those that meet the request by energy per cycle and length, then others."""

    @property
    def best(self) -> Candidate | None:
        """The first candidate that meets the request, if any does."""
        return next((found for found in self.candidates if found.feasible), None)


def size_wire(
    request: WireRequest,
    catalogue: WireCatalogue | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
) -> Sizing:
    """Put every size and alloy of a catalogue to a request.

    Args:
        request: force, stroke, rate and supply, with options.
        catalogue: wires to choose from; the maker's table of Flexinol if not given.
        progress: called with the number of candidates done and their total.
        stop: asked before each candidate; once it says so, those judged so far are the answer.

    Raises:
        InputError: the request contradicts itself.
        SolveError: a simulation failed.
    """
    sizes = (catalogue or load_wires()).sizes.values()
    pairs = [(size, alloy) for alloy in request.alloys() for size in sizes]
    found: list[Candidate] = []
    for size, alloy in pairs:
        if stop is not None and stop():
            break
        found.append(judge_candidate(request, size, alloy))
        if progress is not None:
            progress(len(found), len(pairs))
    return Sizing(request, sorted(found, key=_rank_candidates))


def _rank_candidates(candidate: Candidate) -> tuple[float, ...]:
    """Feasible ones by energy and length, then simulated ones by cooling time, then the rest."""
    drive, length = candidate.drive, candidate.statics.strand.length
    if drive is None or candidate.cycle is None:
        return 2.0, float(candidate.statics.count), length
    if candidate.feasible:
        return 0.0, drive.energy, length
    cooling = candidate.cycle.cooling
    return 1.0, math.inf if cooling is None else cooling, length


def judge_candidate(request: WireRequest, size: WireSize, alloy: str) -> Candidate:
    """One size and alloy put to a request."""
    static = compute_statics(request, size, alloy)
    hopeless = [*remarks.list_static_reasons(request, static)]
    wiring, driven = (None, None) if hopeless else _find_drive(request, static)
    limits = list_alloy_numbers(alloy)
    hot = static.strand.steady_current(limits["temperature_limit"])
    reasons = hopeless or remarks.list_reasons(request, static, wiring, driven, limits)
    return Candidate(
        size,
        alloy,
        static,
        wiring,
        driven,
        hot,
        limits["temperature_limit"],
        tuple(reasons),
        tuple(remarks.list_warnings(request, static, driven, hot, limits)),
        remarks.describe_life(static.hot_stress),
        tuple(name for name in USED_CELLS if size.cells()[name].kind in DOUBTFUL),
    )


def _find_drive(request: WireRequest, static: Statics) -> tuple[Wiring, PulseCycle | None]:
    """The wiring and the cycle of one strand; no cycle if the supply cannot make the stroke."""
    system = static.strand.system(static.mechanism(request.stroke, static.count))
    quick = HASTE * static.strand.time_constant()
    first = min(PULSE, max(0.5 * request.period, quick))
    wiring, found = _find_pulse(request, static, system, first)
    if found is not None and found.cooling is not None:
        left = request.period - SPARE * found.cooling
        if found.heating > left >= SHORTEST * request.period:
            again = _find_pulse(request, static, system, left)
            wiring, found = again if again[1] is not None else (wiring, found)
    if found is None or not found.keeps(request.period):
        return wiring, found
    return wiring, replace(found, running=find_hottest(system, found, request.rate))


def _find_pulse(
    request: WireRequest, static: Statics, system: System, heating: float
) -> tuple[Wiring, PulseCycle | None]:
    """The wiring and cycle for a heating time [s], or for as short a one as the supply allows."""
    strand, count = static.strand, static.count
    needed = find_current(system, request.stroke, heating, strand.size.current.value)
    wiring = choose_wiring(request, count, strand.resistance, needed or math.inf)
    current = min(needed or math.inf, wiring.most(request))
    if current != needed:
        longest = max(request.period, 3.0 * strand.time_constant())
        slower = find_reach_time(system, request.stroke, current, longest)
        if slower is None:
            return wiring, None
        heating = slower
    return wiring, simulate_cycle(system, request.stroke, current, heating, strand.time_constant())
