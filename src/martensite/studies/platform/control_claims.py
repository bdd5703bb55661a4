"""Claims on ON/OFF control to 30°: limit cycle, and where an overshoot can come from.

The paper says that the actuation "was not smooth and had an overshoot with oscillations", for
which it shows a figure that is not in the text at hand.
"""

from __future__ import annotations

from martensite.studies.base import Claim
from martensite.studies.platform import loop
from martensite.studies.platform.bench import CASES
from martensite.studies.platform.loop import BAND, CYCLES, DELAY, LAGGING, QUICK
from martensite.studies.platform.printed import PAPER, Printed

FIGURE_7 = f"{PAPER}, section 4 and Figure 7"


def claims(printed: Printed) -> list[Claim]:
    """Limit cycle first, then overshoot."""
    return [*_cycle(printed), *_overshoot(printed)]


def cycle(printed: Printed) -> tuple[float, float, float]:
    """First switching off, period of the limit cycle and time on in it [s], of set A."""
    result = loop.controlled(CASES["A"], printed, CYCLES)
    first, _, second, on, third = loop.switchings(result)[:5]
    return first, third - second, third - on


def overshoots(printed: Printed) -> dict[str, float]:
    """Of several cases and delays [°]."""
    late = DELAY
    runs = {
        "printed": loop.controlled(CASES["as-printed"], printed, QUICK),
        "printed-late": loop.controlled(CASES["as-printed"], printed, QUICK, late),
        "printed-dynamic": loop.controlled(CASES["as-printed"], printed, QUICK, 0.0, "dynamic"),
        "A": loop.controlled(CASES["A"], printed, CYCLES),
        "A-late": loop.controlled(CASES["A"], printed, CYCLES, late),
        "C": loop.controlled(CASES["C"], printed, LAGGING),
    }
    return {key: loop.overshoot(result, printed) for key, result in runs.items()}


def _cycle(printed: Printed) -> list[Claim]:
    first, period, on = cycle(printed)
    why = f"band of {BAND:g}°, measured every {1e3 * CYCLES.period:.0f} ms: assumed"
    rows = [
        ("first-off", f"{printed.target:.0f}° reached", first),
        ("period", "period of the limit cycle", period),
        ("on", "time on in every period", on),
    ]
    return [
        Claim.reported(f"cycle-{key}", f"ON/OFF, set A: {words}", FIGURE_7, value, "s", why)
        for key, words, value in rows
    ]


def _overshoot(printed: Printed) -> list[Claim]:
    found = overshoots(printed)
    delay = f"with a measurement {DELAY:g} s old"
    rows = [
        ("printed", "as printed, without delay", "nothing is stored but heat: none to speak of"),
        ("printed-dynamic", "as printed, with inertia", "and with no damping at all"),
        ("printed-late", f"as printed, {delay}", "rate times delay, less what the path flattens"),
        ("A", "set A, without delay", "dead band only: it oscillates by the band"),
        ("A-late", f"set A, {delay}", "the same delay at a tenth of the rate"),
        ("C", "set C, without delay", "the joint lags behind a spring that is far too hot"),
    ]
    return [
        Claim.reported(
            f"overshoot-{key}", f"ON/OFF to {printed.target:.0f}°, overshoot: {words}", FIGURE_7,
            found[key], "deg", why,
        )
        for key, words, why in rows
    ]  # fmt: skip
