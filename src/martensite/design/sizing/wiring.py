"""How strands are wired to the supply: which arrangement can drive the current they need."""

from __future__ import annotations

from dataclasses import dataclass

from martensite.design.sizing.request import WireRequest


@dataclass(frozen=True)
class Wiring:
    """Strands at the supply."""

    kind: str
    """single, series or parallel"""
    count: int
    resistance: float
    """Of one strand [ohm]."""

    def total_current(self, strand: float) -> float:
        """Current from the supply [A] for a current per strand [A]."""
        return strand * (self.count if self.kind == "parallel" else 1)

    def voltage(self, strand: float) -> float:
        """Voltage across the strands [V] for a current per strand [A]."""
        return strand * self.resistance * (self.count if self.kind == "series" else 1)

    def most(self, request: WireRequest) -> float:
        """Largest current per strand [A] that the supply drives."""
        return min(request.supply / self.voltage(1.0), request.current_limit / self.total_current(1.0))


def choose_wiring(request: WireRequest, count: int, resistance: float, needed: float) -> Wiring:
    """The arrangement for a current per strand [A].

    Series where the supply can drive it so, since that asks the least current of the driver;
    else parallel; if it can do neither, the one in which it drives more.
    """
    if count == 1:
        return Wiring("single", 1, resistance)
    series, parallel = (Wiring(kind, count, resistance) for kind in ("series", "parallel"))
    if series.most(request) >= needed:
        return series
    return max(parallel, series, key=lambda wiring: wiring.most(request))
