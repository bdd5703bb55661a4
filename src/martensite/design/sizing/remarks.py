"""Remarks on a candidate: reasons for rejection, warnings, life, and margins.

    stress, strain     relative to the request; strain also relative to the capability of the wire
    temperature        (T - T_a)/(T_limit - T_a), at the hottest
    cycle              heating and cooling of a period
    voltage, current   of the supply
    strands            of the largest number

A fraction above 1 exceeds its limit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from martensite.design.sizing.cycle import RETURNED, PulseCycle
from martensite.design.sizing.request import LIFE_STRESS, WireRequest, Wiring
from martensite.design.sizing.statics import Statics, list_alloy_numbers
from martensite.simulate.judgement import describe_excess

if TYPE_CHECKING:
    from martensite.design.sizing.candidates import Candidate

COLD_MARGIN = 10.0
"""Margin of M_f above the ambient [K] below which the return is slow and uncertain."""
UNKNOWN_LIFE = "no value in the available datasheets"
KNOWN_LIFE = (
    "within 25 ksi (172 MPa), the design limit for a million cycles on nitinolactuators.com (a secondary source, not "
    "the maker's datasheet)"
)
UNTOLD_LIFE = (
    "No source gives a number of cycles for a strain, so the maker's maximum strain applies. This is no prediction: "
    "no data are available beyond a million cycles"
)
COIL_DOUBT = (
    "The values hold for straight trained wire. A coil that was wound and annealed has other transformation "
    "temperatures, and its stress is averaged over the cross-section."
)


def describe_life(stress: float, element: str = "wire", requested_cycles: float = math.inf) -> str:
    """Return the published statement on the life at a stress [Pa] and the requested cycles."""
    if math.isfinite(requested_cycles):
        return f"{requested_cycles:,.0f} cycles requested; the stress is {KNOWN_LIFE}. {UNTOLD_LIFE}"
    if element == "coil":
        return f"{UNKNOWN_LIFE} for coils"
    return KNOWN_LIFE if stress <= LIFE_STRESS else UNKNOWN_LIFE


def list_static_reasons(request: WireRequest, static: Statics) -> Iterator[str]:
    """Yield the reasons for a rejection without a simulation."""
    strand, cold = static.strand, static.cold_stress
    if request.limits == "keep":
        yield from _list_exceeded(static)
    if static.count > request.strands:
        yield f"needs {static.count} strands, at most {request.strands:.0f} are allowed"
    start = strand.shift_temperature("M_s", cold)
    if request.ambient >= start:
        yield (
            f"does not return: the ambient of {_format_celsius(request.ambient)} is above M_s = "
            f"{_format_celsius(start)} at {_format_megapascal(cold)}"
        )


def list_reasons(
    request: WireRequest, static: Statics, wiring: Wiring | None, cycle: PulseCycle | None, limits: Mapping[str, float]
) -> Iterator[str]:
    """Yield the reasons for the rejection of a simulated candidate."""
    if wiring is not None and cycle is None:
        yield _describe_supply(request, static, wiring)
    if wiring is None or cycle is None:
        return
    if cycle.cooling is None:
        yield (
            f"does not return: more than {100.0 * RETURNED:.0f} % of the stroke is left after 16 thermal time constants"
        )
    elif not cycle.keeps(request.period):
        spent = cycle.current > 0.999 * wiring.most(request)
        excuse = ", at the largest current of the supply" if spent else ""
        yield (
            f"too slow: {cycle.heating:.2g} s of heating and {cycle.cooling:.3g} s of cooling in a "
            f"period of {request.period:.3g} s{excuse}"
        )
    if request.limits == "keep":
        yield from map(describe_excess, cycle.exceeded)


def _list_exceeded(static: Statics) -> Iterator[str]:
    """Yield the exceeded limits of the material."""
    limits = list_alloy_numbers(static.strand.alloy)
    if static.hot_stress > limits["stress_limit"] * (1.0 + 1e-9):
        yield (
            f"{_format_megapascal(static.hot_stress)} is above the maker's "
            f"{_format_megapascal(limits['stress_limit'])} for repeated use"
        )
    if static.strain > limits["strain_limit"]:
        yield f"{100.0 * static.strain:.2f} % strain is above the maker's {100.0 * limits['strain_limit']:.0f} %"


def _describe_supply(request: WireRequest, static: Statics, wiring: Wiring) -> str:
    most = wiring.most(request)
    limit = f"{request.supply:.4g} V"
    if math.isfinite(request.current_limit):
        limit += f" and {request.current_limit:.4g} A"
    return (
        f"the supply of {limit} drives at most {most:.3g} A through a strand of "
        f"{static.strand.resistance:.3g} Ω ({wiring.kind}), which is not enough for the stroke"
    )


def list_warnings(
    request: WireRequest, static: Statics, cycle: PulseCycle | None, overheating: float, limits: Mapping[str, float]
) -> Iterator[str]:
    """Yield the warnings about a candidate."""
    yield from _warn_of_cold(request, static)
    if request.limits == "ignore":
        yield from _list_exceeded(static)
    if static.strain < request.strain and request.element == "wire":
        yield (
            f"strain is {100.0 * static.strain:.2f} % instead of {100.0 * request.strain:.2f} %: "
            "the wire recovers no more under this load"
        )
    limit = limits["temperature_limit"]
    if request.limits == "ignore" and cycle is not None:
        yield from (describe_excess(alarm) for alarm in cycle.exceeded if alarm.kind == "temperature")
    if cycle is not None and cycle.current > overheating:
        yield (
            f"the pulse current is above the continuous rating of {overheating:.3g} A per strand: end every pulse in "
            f"time, or the wire exceeds {_format_celsius(limit)}"
        )


def _warn_of_cold(request: WireRequest, static: Statics) -> Iterator[str]:
    """Yield the warnings about an ambient temperature with too little martensite."""
    finish = static.strand.shift_temperature("M_f", static.cold_stress)
    under = f"M_f = {_format_celsius(finish)} under {_format_megapascal(static.cold_stress)}"
    if request.ambient >= finish:
        yield (
            f"the ambient of {_format_celsius(request.ambient)} is above {under}: the wire does not return completely"
        )
    elif request.ambient > finish - COLD_MARGIN:
        yield (
            f"the ambient of {_format_celsius(request.ambient)} is only "
            f"{finish - request.ambient:.1f} K below {under}: the return is slow and stops on a "
            "warmer day"
        )


def _format_celsius(kelvin: float) -> str:
    return f"{kelvin - 273.15:.4g} °C"


def _format_megapascal(pascal: float) -> str:
    return f"{pascal / 1e6:.4g} MPa"


# ---------------------------------------------------------------- margins


@dataclass(frozen=True)
class Margin:
    """Limit and its used part, in `unit`; `display_unit` is a readable unit."""

    name: str
    used: float
    limit: float
    unit: str
    display_unit: str
    chosen: bool = False
    """True for the strain, which the sizing itself sets to its limit."""

    @property
    def share(self) -> float:
        """Return the used fraction of the limit."""
        return self.used / self.limit


def list_margins(request: WireRequest, candidate: Candidate) -> list[Margin]:
    """Return the limits of a candidate: of its statics, and of its cycle after a simulation."""
    static = candidate.statics
    return [
        Margin("stress", static.hot_stress, request.stress, "Pa", "MPa"),
        Margin("strain", static.strain, request.strain, "1", "%", chosen=True),
        Margin("strain of the recoverable strain", static.strain, static.reachable, "1", "%", chosen=True),
        *_list_cycle_margins(request, candidate),
        Margin("strands", float(static.count), request.strands, "1", "1"),
    ]


def _list_cycle_margins(request: WireRequest, candidate: Candidate) -> Iterator[Margin]:
    cycle, drive = candidate.cycle, candidate.drive
    if cycle is None or drive is None:
        return
    hottest = max(cycle.hottest, cycle.running or 0.0)
    limit = candidate.temperature_limit
    yield Margin("temperature above the ambient", hottest - request.ambient, limit - request.ambient, "K", "K")
    if cycle.fastest is not None:
        yield Margin("time of a cycle", 1.0 / cycle.fastest, request.period, "s", "s")
    yield Margin("voltage", drive.voltage, request.supply, "V", "V")
    if math.isfinite(request.current_limit):
        yield Margin("current", drive.current, request.current_limit, "A", "A")


def find_tightest(margins: list[Margin]) -> Margin:
    """Return the limit with the largest used fraction, without chosen ones."""
    return max((margin for margin in margins if not margin.chosen), key=lambda margin: margin.share)
