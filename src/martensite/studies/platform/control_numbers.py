"""Numbers of ON/OFF control to 30°: limit cycle, and causes of an overshoot.

The paper reports that the actuation "was not smooth and had an overshoot with oscillations", in an unavailable figure.
"""

from __future__ import annotations

from martensite.studies.platform import loop
from martensite.studies.platform.bench import CASES
from martensite.studies.platform.loop import BAND, CYCLES, DELAY, LAGGING, QUICK
from martensite.studies.tables import Printed


def compute_control(printed: Printed) -> dict[str, float]:
    """Return limit cycle, then overshoots."""
    first, period, on = limit_cycle(printed)
    overshoots = {f"overshoot_{key}": value for key, value in list_overshoots(printed).items()}
    return {name.replace("-", "_"): value for name, value in overshoots.items()} | {
        "band": BAND,
        "sampling": 1e3 * CYCLES.period,
        "cycle_first_off": first,
        "cycle_period": period,
        "cycle_on": on,
        "delay": DELAY,
    }


def limit_cycle(printed: Printed) -> tuple[float, float, float]:
    """Return first switch-off, period of the limit cycle and its on-time [s], of set A."""
    result = loop.run_controlled(CASES["A"], printed, CYCLES)
    first, _, second, on, third = loop.switching_times(result)[:5]
    return first, third - second, third - on


def list_overshoots(printed: Printed) -> dict[str, float]:
    """Return the overshoots of several cases and delays [°]."""
    late = DELAY
    runs = {
        "printed": loop.run_controlled(CASES["as-printed"], printed, QUICK),
        "printed-late": loop.run_controlled(CASES["as-printed"], printed, QUICK, late),
        "printed-dynamic": loop.run_controlled(CASES["as-printed"], printed, QUICK, 0.0, "dynamic"),
        "A": loop.run_controlled(CASES["A"], printed, CYCLES),
        "A-late": loop.run_controlled(CASES["A"], printed, CYCLES, late),
        "C": loop.run_controlled(CASES["C"], printed, LAGGING),
    }
    return {key: loop.angle_overshoot(result, printed) for key, result in runs.items()}
