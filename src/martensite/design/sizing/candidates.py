"""Sizing of wires: every size and alloy of a catalogue is judged for a request.

The statics of each candidate follow in closed form, and one strand is simulated. The current makes the stroke in 1 s,
or in half a period if that is shorter; a coil takes up to a quarter of the period, or half its time constant. If pulse
and cooling do not fit into a period, the current is raised until the pulse fits or the supply is at its limit. Every
failure has a reason.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from martensite.actuators.assembly import System
from martensite.control.faults.plant import ScaledCooling
from martensite.design.sizing import remarks
from martensite.design.sizing.cycle import (
    FIRST_FACTOR,
    PulseCycle,
    find_current,
    find_reach_time,
    repeat_pulse,
    simulate_cycle,
)
from martensite.design.sizing.request import ALLOYS, LIFE_STRESS, WireRequest, Wiring, choose_wiring
from martensite.design.sizing.statics import HEAVIER, CoilStrand, Statics, compute_statics, list_alloy_numbers
from martensite.physics.materials.base import DOUBTFUL
from martensite.physics.materials.wires import WireCatalogue, WireSize, load_wires

PULSE = 1.0
"""First heating time [s], for which the maker gives currents."""
HASTE = 0.05
"""Shortest first pulse, as a fraction of the thermal time constant."""
SPARE = 1.02
"""Margin on the cooling time for a shortened pulse."""
CLOSE = 1.015
"""Factor between a good guess of a current and its bounds."""
SHORTEST = 0.02
"""Shortest pulse, as a fraction of the period."""
WARMER = 10.0
"""Temperature rise of a day [K] that a robust wire withstands."""
SHADED = 0.5
"""Fraction of the heat loss of a robust coil with mutually heated turns."""
MOST_TRIED, MOST_CHANGES, SHOWN_CHANGES, MOST_STRANDS = 12, 4, 3, 1000
"""Limits: wires with a changed request, changes of each, reported changes, and strands."""
THICKER = (0.75e-3, 1.0e-3)
"""Additional wires of coils [m]."""
USED_CELLS = ("diameter", "resistance")
"""Cells of the catalogue behind the answer."""

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
    """Size and alloy judged for a request; forces of all strands."""

    size: WireSize
    alloy: str
    statics: Statics
    wiring: Wiring | None
    cycle: PulseCycle | None
    """Cycle of one strand; None without a simulation."""
    overheating_current: float
    """Continuous current per strand at the temperature limit [A]."""
    temperature_limit: float
    """Temperature limit of the material [K]."""
    reasons: tuple[str, ...] = ()
    """Reasons for rejection; empty if the request is met."""
    warnings: tuple[str, ...] = ()
    life: str = ""
    frail: tuple[str, ...] = ()
    """Failures on a warmer day or with more load."""
    recalled: tuple[str, ...] = ()
    """Cells behind the answer that are recalled or interpolated."""

    @property
    def feasible(self) -> bool:
        """Return true if the request is met."""
        return not self.reasons

    @property
    def drive(self) -> Drive | None:
        """Return the output of the supply; None without a simulation."""
        if self.wiring is None or self.cycle is None:
            return None
        strand, wiring, heating = self.cycle.current, self.wiring, self.cycle.heating
        current, voltage = wiring.total_current(strand), wiring.voltage(strand)
        return Drive(current, voltage, current * voltage, current * voltage * heating)

    def to_dict(self) -> dict[str, Any]:
        """Return all results as plain values, in SI."""
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
    """Judged candidates of a request."""

    request: WireRequest
    candidates: list[Candidate] = field(default_factory=list[Candidate])
    """Feasible candidates by robustness, energy per cycle and length, then the others."""
    changes: tuple[str, ...] = ()
    """Changes of the request that make a candidate feasible, the nearest first."""

    @property
    def best(self) -> Candidate | None:
        """Return the first feasible candidate, or None."""
        return next((one for one in self.candidates if one.feasible), None)


def size_wire(
    request: WireRequest,
    catalogue: WireCatalogue | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
) -> Sizing:
    """Judge every size and alloy of a catalogue for a request.

    Args:
        request: force, stroke, rate and supply, with options.
        catalogue: available wires, by default the maker's table of Flexinol.
        progress: called with the number of finished candidates and their total.
        stop: called before each candidate; True ends the search with the candidates so far.

    Raises:
        InputError: the request contradicts itself.
        SolveError: a simulation failed.
    """
    if math.isfinite(request.life):
        request = request.with_values({"stress": min(request.stress, LIFE_STRESS)})
    sizes = list_sizes(request, catalogue or load_wires())
    pairs = [(size, alloy) for alloy in request.alloys() for size in sizes]
    judged: list[Candidate] = []
    for size, alloy in pairs:
        if stop is not None and stop():
            break
        judged.append(judge_candidate(request, size, alloy))
        if progress is not None:
            progress(len(judged), len(pairs))
    ranked = sorted(judged, key=rank_candidates)
    fits = any(one.feasible for one in ranked) or len(judged) < len(pairs)
    return Sizing(request, ranked, () if fits else find_changes(request, ranked))


def list_sizes(request: WireRequest, catalogue: WireCatalogue) -> list[WireSize]:
    """Return the sizes of a catalogue, with thicker ones for coils."""
    sizes = list(catalogue.sizes.values())
    thicker = THICKER if request.element == "coil" and len(sizes) > 1 else ()
    return sizes + [catalogue.interpolate(diameter) for diameter in thicker]


def rank_candidates(candidate: Candidate) -> tuple[float, ...]:
    """Return the sort key: feasible ones by robustness, energy and length, then the others by cooling time."""
    drive, length = candidate.drive, candidate.statics.strand.length
    if drive is None or candidate.cycle is None:
        return 2.0, 0.0, float(candidate.statics.count), length
    if candidate.feasible:
        return 0.0, float(len(candidate.frail)), drive.energy, length
    cooling = candidate.cycle.cooling
    return 1.0, 0.0, math.inf if cooling is None else cooling, length


def judge_candidate(request: WireRequest, size: WireSize, alloy: str, guess: float | None = None) -> Candidate:
    """Return a size and alloy judged for a request; `guess` is the approximate current of a strand [A], if known."""
    static = compute_statics(request, size, alloy)
    hopeless = [*remarks.list_static_reasons(request, static)]
    wiring, driven = (None, None) if hopeless else _find_drive(request, static, guess)
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


def _find_drive(request: WireRequest, static: Statics, guess: float | None) -> tuple[Wiring, PulseCycle | None]:
    """Return the wiring and the cycle of one strand; no cycle if the supply is too weak."""
    system = static.strand.system(static.mechanism(request.stroke, static.count))
    slowness = static.strand.time_constant()
    longest = max(PULSE, min(0.25 * request.period, 0.5 * slowness)) if request.element == "coil" else PULSE
    first = min(longest, max(0.5 * request.period, HASTE * slowness))
    wiring, cycle = _find_pulse(request, static, system, first, guess)
    if cycle is not None and cycle.cooling is not None:
        left = request.period - SPARE * cycle.cooling
        if cycle.heating > left >= SHORTEST * request.period:
            again = _find_pulse(request, static, system, left)
            wiring, cycle = again if again[1] is not None else (wiring, cycle)
    if cycle is None or not cycle.keeps(request.period):
        return wiring, cycle
    return wiring, repeat_pulse(system, cycle, request.rate)


def _find_pulse(
    request: WireRequest, static: Statics, system: System, heating: float, guess: float | None = None
) -> tuple[Wiring, PulseCycle | None]:
    """Return wiring and cycle for a heating time [s], or for the shortest time that the supply allows."""
    strand, count = static.strand, static.count
    near = (strand.size.current.value, FIRST_FACTOR) if guess is None else (CLOSE * guess, CLOSE**2)
    needed = find_current(system, request.stroke, heating, *near)
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
    """Yield the failures on a warmer day, with more load, and with mutually heated turns."""
    strand = static.strand
    trials = {f"on a day {WARMER:g} K warmer": replace(strand, ambient=request.ambient + WARMER)}
    if isinstance(strand, CoilStrand):
        shaded = replace(strand, cooling=ScaledCooling(cooling=strand.cooling, factor=SHADED))
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
    """Return the changes of a request that make a candidate feasible, the nearest first.

    Strands, rate and supply are changed in turn, each as far as necessary. The other alloy is tried too.
    """
    changes: list[tuple[float, str]] = []
    others = [] if request.alloy == "any" else [name for name in ALLOYS if name != request.alloy]
    tried = list(candidates[:MOST_TRIED])
    tried += [judge_candidate(request, one.size, name) for name in others for one in candidates[:MOST_TRIED]]
    for one in tried:
        easier_request, now = request, one
        for _ in range(MOST_CHANGES):
            values = _relax_request(easier_request, now)
            if now.feasible or values is None:
                break
            easier_request = easier_request.with_values(values)
            now = judge_candidate(easier_request, one.size, one.alloy)
        if now.feasible:
            changes.append(_describe_change(request, easier_request, one))
    return tuple(dict.fromkeys(options for _, options in sorted(changes)))[:SHOWN_CHANGES]


def _relax_request(request: WireRequest, candidate: Candidate) -> dict[str, float] | None:
    """Return the parameter of the request that excludes a candidate, at a sufficient value, or None."""
    cycle, static = candidate.cycle, candidate.statics
    if static.count > request.strands:
        return {"strands": float(static.count)} if static.count <= MOST_STRANDS else None
    if candidate.wiring is not None and cycle is None:
        return {"supply": 1.5 * request.supply} if math.isinf(request.current_limit) else None
    if cycle is None or cycle.fastest is None or cycle.keeps(request.period):
        return None
    digits = 1 - math.floor(math.log10(0.95 * cycle.fastest))
    return {"rate": math.floor(0.95 * cycle.fastest * 10.0**digits) / 10.0**digits}


def _describe_change(request: WireRequest, easier_request: WireRequest, one: Candidate) -> tuple[float, str]:
    """Return the distance between two requests [factors of e], and the options that change them."""
    forms = {"strands": "--strands {:.0f}", "rate": '--rate "{:.4g} Hz"', "supply": '--supply "{:.4g} V"'}
    apart = {name: getattr(easier_request, name) / getattr(request, name) for name in forms}
    changed = {name: factor for name, factor in apart.items() if factor != 1.0}
    options = [forms[name].format(getattr(easier_request, name)) for name in changed]
    options += [f"--alloy {one.alloy}"] * (one.alloy not in request.alloys())
    return sum(abs(math.log(x)) for x in changed.values()), f"{' '.join(options)}: {one.size.name}, {one.alloy} °C"
