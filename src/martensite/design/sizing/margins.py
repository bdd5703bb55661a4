"""How much of each limit a candidate uses.

    stress, strain     of what the request allows; strain of what the wire can give, too
    temperature        (T - T_a)/(T_limit - T_a), at the hottest
    cycle              heating and cooling of a period
    voltage, current   of the supply
    strands            of the most that are allowed

A share above 1 is a limit that is not kept.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from martensite.design.sizing.candidates import Candidate
from martensite.design.sizing.request import WireRequest


@dataclass(frozen=True)
class Margin:
    """One limit and what is used of it; both in `unit`, and best read in `shown`."""

    name: str
    used: float
    limit: float
    unit: str
    shown: str
    chosen: bool = False
    """True for what the sizing itself puts to its limit: the strain."""

    @property
    def share(self) -> float:
        """Used over limit."""
        return self.used / self.limit


def list_margins(request: WireRequest, found: Candidate) -> list[Margin]:
    """The limits of a candidate: those of its statics, and of its cycle if it was simulated."""
    static = found.statics
    return [
        Margin("stress", static.hot_stress, request.stress, "Pa", "MPa"),
        Margin("strain", static.strain, request.strain, "1", "%", chosen=True),
        Margin("strain of what the wire gives", static.strain, static.reachable, "1", "%", chosen=True),
        *_list_cycle_margins(request, found),
        Margin("strands", float(static.count), request.strands, "1", "1"),
    ]


def _list_cycle_margins(request: WireRequest, found: Candidate) -> Iterator[Margin]:
    cycle, drive = found.cycle, found.drive
    if cycle is None or drive is None:
        return
    hottest = max(cycle.hottest, cycle.running or 0.0)
    limit = found.temperature_limit
    yield Margin("temperature above the ambient", hottest - request.ambient, limit - request.ambient, "K", "K")
    if cycle.fastest is not None:
        yield Margin("time of a cycle", 1.0 / cycle.fastest, request.period, "s", "s")
    yield Margin("voltage", drive.voltage, request.supply, "V", "V")
    if math.isfinite(request.current_limit):
        yield Margin("current", drive.current, request.current_limit, "A", "A")


def find_tightest(found: list[Margin]) -> Margin:
    """The limit of which most is used, apart from what is put to its limit by choice."""
    return max((margin for margin in found if not margin.chosen), key=lambda margin: margin.share)
