"""`size_wire`: every size and alloy of a catalogue put to the request, the best first.

For each the statics are closed, and one strand is simulated: the current that makes the stroke in
1 s (or half a period, if that is less; a coil takes up to a quarter of the period, or half its time constant), and the
cooling after it. If both together take longer
than a period, the current is raised until the pulse fits beside the cooling, as far as the supply
goes. What fails is said as a reason; nothing is left out in silence.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from martensite.actuators.assembly import System
from martensite.control.faults.plant import Multiplied
from martensite.design.sizing import remarks
from martensite.design.sizing.cycle import PulseCycle, find_current, find_reach_time, repeat_pulse, simulate_cycle
from martensite.design.sizing.request import ALLOYS, LIFE_STRESS, WireRequest, Wiring, choose_wiring
from martensite.design.sizing.statics import HEAVIER, CoilStrand, Statics, compute_statics, list_alloy_numbers
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
WARMER = 10.0
"""A warmer day [K], which a robust wire withstands."""
SHADED = 0.5
"""Share of the heat that a coil, whose turns warm one another, still loses when it is robust."""
MOST_TRIED, MOST_CHANGES, SHOWN_CHANGES, MOST_STRANDS = 12, 4, 3, 1000
"""Wires for which a request is changed, how often, how many changes are named, and strands that may be asked for."""
THICKER = (0.75e-3, 1.0e-3)
"""Wires of coils [m] beyond the table."""
USED_CELLS = ("diameter", "resistance")
"""Cells of the catalogue that the answer rests on."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Drive:
    """Output of the supply to all strands during a pulse."""

    current: float
    """[A]"""
    voltage: float
    """[V]"""
    power: float
    """[W]"""
    energy: float
    """Energy of one cycle [J]."""


@dataclass(frozen=True)
class Candidate:
    """One size and alloy put to a request; forces of all strands, currents as named."""

    size: WireSize
    alloy: str
    statics: Statics
    wiring: Wiring | None
    cycle: PulseCycle | None
    """Cycle of one strand; None if it was not simulated."""
    overheating_current: float
    """Current per strand that in the long run heats it to the temperature limit [A]."""
    temperature_limit: float
    """Temperature limit of the material [K]."""
    reasons: tuple[str, ...] = ()
    """Why the request is not met; empty if it is."""
    warnings: tuple[str, ...] = ()
    life: str = ""
    frail: tuple[str, ...] = ()
    """Failures on a warmer day or with more load; empty if the candidate withstands both."""
    recalled: tuple[str, ...] = ()
    """Cells the answer rests on that are recalled, or interpolated, not read in a source."""

    @property
    def feasible(self) -> bool:
        """True if the request is met."""
        return not self.reasons

    @property
    def drive(self) -> Drive | None:
        """Return the output of the supply; None if the candidate was not simulated."""
        if self.wiring is None or self.cycle is None:
            return None
        strand, wiring, heating = self.cycle.current, self.wiring, self.cycle.heating
        current, voltage = wiring.total_current(strand), wiring.voltage(strand)
        return Drive(current, voltage, current * voltage, current * voltage * heating)

    def to_dict(self) -> dict[str, Any]:
        """Return everything, ready for JSON; numbers in SI."""
        mine = self.statics
        own = {name: getattr(mine, name) for name in mine.__dataclass_fields__ if name != "strand"}
        return {
            "size": self.size.name,
            "alloy": self.alloy,
            "feasible": self.feasible,
            "reasons": list(self.reasons),
            **own,
            "length": mine.strand.length,
            "coil": mine.strand.describe_shape(mine.cold_stress, mine.hot_stress),
            "strand_resistance": mine.strand.resistance,
            "wiring": self.wiring.kind if self.wiring else None,
            "drive": asdict(self.drive) if self.drive else None,
            "strand": asdict(self.cycle) | {"fastest": self.cycle.fastest} if self.cycle else None,
            "overheating_current": self.overheating_current,
            "temperature_limit": self.temperature_limit,
            "life": self.life,
            "warnings": list(self.warnings),
            "frail": list(self.frail),
            "recalled": list(self.recalled),
        }


@dataclass(frozen=True)
class Sizing:
    """The answer to a request."""

    request: WireRequest
    candidates: list[Candidate] = field(default_factory=list[Candidate])
    """The best first: those that meet the request, the robust before others and by energy per cycle and length; then
    those that do not."""
    changes: tuple[str, ...] = ()
    """Changes of the request that make a candidate fit, the nearest first; empty if one fits already."""

    @property
    def best(self) -> Candidate | None:
        """Return the first candidate that meets the request, if any does."""
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
    if math.isfinite(request.life):
        request = request.with_values({"stress": min(request.stress, LIFE_STRESS)})
    sizes = list_sizes(request, catalogue or load_wires())
    pairs = [(size, alloy) for alloy in request.alloys() for size in sizes]
    found: list[Candidate] = []
    for size, alloy in pairs:
        if stop is not None and stop():
            break
        found.append(judge_candidate(request, size, alloy))
        if progress is not None:
            progress(len(found), len(pairs))
    ranked = sorted(found, key=rank_candidates)
    fits = any(one.feasible for one in ranked) or len(found) < len(pairs)
    return Sizing(request, ranked, () if fits else find_changes(request, ranked))


def list_sizes(request: WireRequest, catalogue: WireCatalogue) -> list[WireSize]:
    """Sizes that are put to a request: those of a catalogue, and for coils thicker ones, too."""
    sizes = list(catalogue.sizes.values())
    thicker = THICKER if request.element == "coil" and len(sizes) > 1 else ()
    return sizes + [catalogue.interpolate(diameter) for diameter in thicker]


def rank_candidates(candidate: Candidate) -> tuple[float, ...]:
    """Feasible ones by robustness, energy and length, then simulated ones by cooling time, then the rest."""
    drive, length = candidate.drive, candidate.statics.strand.length
    if drive is None or candidate.cycle is None:
        return 2.0, 0.0, float(candidate.statics.count), length
    if candidate.feasible:
        return 0.0, float(len(candidate.frail)), drive.energy, length
    cooling = candidate.cycle.cooling
    return 1.0, 0.0, math.inf if cooling is None else cooling, length


def judge_candidate(request: WireRequest, size: WireSize, alloy: str) -> Candidate:
    """Return one size and alloy put to a request."""
    static = compute_statics(request, size, alloy)
    hopeless = [*remarks.list_static_reasons(request, static)]
    wiring, driven = (None, None) if hopeless else _find_drive(request, static)
    limits = list_alloy_numbers(alloy)
    hot = static.strand.steady_current(limits["temperature_limit"])
    reasons = tuple(hopeless or remarks.list_reasons(request, static, wiring, driven, limits))
    return Candidate(
        size,
        alloy,
        static,
        wiring,
        driven,
        hot,
        limits["temperature_limit"],
        reasons,
        tuple(remarks.list_warnings(request, static, driven, hot, limits)),
        remarks.describe_life(static.hot_stress, request.element, request.life),
        () if reasons or driven is None else tuple(_list_frailties(request, static, driven, limits)),
        tuple(name for name in USED_CELLS if size.cells()[name].kind in DOUBTFUL),
    )


def _find_drive(request: WireRequest, static: Statics) -> tuple[Wiring, PulseCycle | None]:
    """Return the wiring and the cycle of one strand; no cycle if the supply cannot make the stroke."""
    system = static.strand.system(static.mechanism(request.stroke, static.count))
    slowness = static.strand.time_constant()
    longest = max(PULSE, min(0.25 * request.period, 0.5 * slowness)) if request.element == "coil" else PULSE
    first = min(longest, max(0.5 * request.period, HASTE * slowness))
    wiring, found = _find_pulse(request, static, system, first)
    if found is not None and found.cooling is not None:
        left = request.period - SPARE * found.cooling
        if found.heating > left >= SHORTEST * request.period:
            again = _find_pulse(request, static, system, left)
            wiring, found = again if again[1] is not None else (wiring, found)
    if found is None or not found.keeps(request.period):
        return wiring, found
    return wiring, repeat_pulse(system, found, request.rate)


def _find_pulse(
    request: WireRequest, static: Statics, system: System, heating: float
) -> tuple[Wiring, PulseCycle | None]:
    """Return the wiring and cycle for a heating time [s], or for as short a one as the supply allows."""
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


# ---------------------------------------------------------------- what a candidate withstands, and what would fit


def _list_frailties(
    request: WireRequest, static: Statics, cycle: PulseCycle, limits: Mapping[str, float]
) -> Iterator[str]:
    """Yield the failures of a candidate on a 10 K warmer day, with 20 % more load, and with mutually heated turns."""
    strand = static.strand
    trials = {f"on a day {WARMER:g} K warmer": replace(strand, ambient=request.ambient + WARMER)}
    if isinstance(strand, CoilStrand):
        shaded = replace(strand, cooling=Multiplied(cooling=strand.cooling, factor=SHADED))
        trials["if its turns warm one another, so that half of the heat is lost,"] = shaded
    for when, other in trials.items():
        system = other.system(replace(static, strand=other).mechanism(request.stroke, static.count))
        again = simulate_cycle(system, request.stroke, cycle.current, cycle.heating, other.time_constant())
        if not again.keeps(request.period):
            late = "never" if again.cooling is None else f"in {again.cooling:.3g} s, too late,"
            yield f"{when} it returns {late} under the same pulse"
    more = static.hot_stress * (1.0 + (HEAVIER - 1.0) * request.force / static.work_force)
    if more > limits["stress_limit"] * (1.0 + 1e-9):
        most = limits["stress_limit"] / 1e6
        yield f"under {HEAVIER - 1.0:.0%} more load it has {more / 1e6:.4g} MPa, above the maker's {most:.4g} MPa"
    if static.strand.reachable_strain(static.cold_stress, more) < static.strain:
        yield f"under {HEAVIER - 1.0:.0%} more load it does not give the stroke any more"


def find_changes(request: WireRequest, candidates: Sequence[Candidate]) -> tuple[str, ...]:
    """Changes of a request that nothing meets under which a candidate would do, the nearest first.

    Strands, rate and supply of a candidate are changed one after another, each as far as it needs; where one alloy was
    asked for, the other is tried, too.
    """
    found: list[tuple[float, str]] = []
    others = [] if request.alloy == "any" else [name for name in ALLOYS if name != request.alloy]
    tried = list(candidates[:MOST_TRIED])
    tried += [judge_candidate(request, one.size, name) for name in others for one in candidates[:MOST_TRIED]]
    for one in tried:
        asked, now = request, one
        for _ in range(MOST_CHANGES):
            values = _relax_request(asked, now)
            if now.feasible or values is None:
                break
            asked = asked.with_values(values)
            now = judge_candidate(asked, one.size, one.alloy)
        if now.feasible:
            found.append(_describe_change(request, asked, one))
    words = [said for _, said in sorted(found)]
    return tuple(dict.fromkeys(words))[:SHOWN_CHANGES]


def _relax_request(request: WireRequest, candidate: Candidate) -> dict[str, float] | None:
    """Return the parameter of the request that excludes a candidate, at a sufficient value; None without one."""
    cycle, static = candidate.cycle, candidate.statics
    if static.count > request.strands:
        return {"strands": float(static.count)} if static.count <= MOST_STRANDS else None
    if candidate.wiring is not None and cycle is None:
        return {"supply": 1.5 * request.supply} if math.isinf(request.current_limit) else None
    if cycle is None or cycle.fastest is None or cycle.keeps(request.period):
        return None
    digits = 1 - math.floor(math.log10(0.95 * cycle.fastest))
    return {"rate": math.floor(0.95 * cycle.fastest * 10.0**digits) / 10.0**digits}


def _describe_change(request: WireRequest, asked: WireRequest, one: Candidate) -> tuple[float, str]:
    """Return the distance of a request from another [factors of e], and the options that change it."""
    forms = {"strands": "--strands {:.0f}", "rate": '--rate "{:.4g} Hz"', "supply": '--supply "{:.4g} V"'}
    apart = {name: getattr(asked, name) / getattr(request, name) for name in forms}
    changed = {name: factor for name, factor in apart.items() if factor != 1.0}
    options = [forms[name].format(getattr(asked, name)) for name in changed]
    options += [f"--alloy {one.alloy}"] * (one.alloy not in request.alloys())
    return sum(abs(math.log(x)) for x in changed.values()), f"{' '.join(options)}: {one.size.name}, {one.alloy} °C"
