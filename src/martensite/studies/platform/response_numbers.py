"""Numbers of the response times, and a bound that the printed equations imply.

With V²/R heating and fixed resistances, the time to an angle is T(V) = ∫ C dx/[V² p(x) - q(x)] with the same C > 0,
p > 0 and q ≥ 0 at both voltages, because the path x does not depend on power. Hence T(3 V)/T(5 V) ≥ 25/9, with equality
without heat loss.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from martensite.studies.platform import bench
from martensite.studies.platform.bench import (
    AS_PRINTED,
    CASES,
    COARSE,
    FINE,
    IN_SERIES,
    LATE,
    LIMITED,
    RISE,
    STEEP,
    VARIANTS,
    Case,
)
from martensite.studies.readings import passing_time
from martensite.studies.tables import Printed

FREE, SLOWED = 12.0, 80.0
"""Durations of runs without a current limit, without and with a series resistance [s]."""
LONG = 400.0
"""Duration after which a platform has stalled [s]."""
NO_STRESS = "C of 1 GPa/K"
"""Variant with negligible effect of stress."""
ARRIVALS = (1.0, 2.0)
"""Tolerances of the two times [s]; the second is "around 30 s"."""

SETS = {
    "A": ("h and series resistance chosen for these two times", "A"),
    "A'": ("h of free convection, one current per voltage chosen for each time", "A2"),
}
"""Description of calibrated sets, and their name in claims."""


def compute_response(printed: Printed) -> dict[str, Any]:
    """Return the response as printed, the ratio, the limit, the calibrated sets, and cooling."""
    return {
        **compute_times(printed),
        **compute_ratios(printed),
        "long": LONG,
        "limited_angle": bench.angle_degrees(bench.run_heated(LIMITED, printed, printed.high, LONG, 0.05))[-1],
        "needed_current": needed_current(printed),
        "paths": _list_paths(printed),
        "sets": [row for key in SETS for row in _list_set(key, printed)],
        **compute_damped(printed),
        **compute_cooling(printed),
    }


def free_times(case: Case, printed: Printed) -> tuple[float, float]:
    """Return the times [s] to the angle at the high and at the low voltage, without a current limit."""
    duration = FREE if case.series == 0.0 else SLOWED
    fast, slow = (
        bench.arrival_time(case, printed, volts, printed.angle, duration) for volts in (printed.high, printed.low)
    )
    return fast, slow


def response_times(key: str, printed: Printed, angle: float) -> tuple[float, float]:
    """Return the times [s] of a calibrated set to an angle [°] at the high and at the low voltage."""
    fast, slow = (
        bench.arrival_time(CASES[key], printed, volts, angle, duration, bench.step_of(CASES[key]))
        for volts, duration in ((printed.high, RISE), (printed.low, LATE))
    )
    return fast, slow


def needed_current(printed: Printed) -> float:
    """Return the steady current at the angle of the response times, as printed [A].

    Temperature and resistance are those of the path, which does not depend on power.
    """
    result = bench.run_heated(AS_PRINTED, printed, printed.high, FREE)
    warm = bench.at_angle(result, printed.angle, "temperature") - bench.ZERO - printed.ambient
    ohms = bench.at_angle(result, printed.angle, "resistance")
    surface = bench.build_spring(AS_PRINTED, printed).surface()
    return math.sqrt(printed.film * surface * warm / ohms)


def compute_times(printed: Printed) -> dict[str, Any]:
    """Return the times as printed, and for all variants."""
    times = {name: free_times(case, printed) for name, case in VARIANTS.items()}
    rows = [
        {"volts": volts, "published": published, "around": around}
        for volts, published, around in zip(
            (printed.high, printed.low), (printed.fast, printed.slow), ARRIVALS, strict=True
        )
    ]
    slowest: list[dict[str, Any]] = []
    for k, row in enumerate(rows):
        name = max(times, key=lambda name, k=k: times[name][k])
        fastest = min(pair[k] for pair in times.values())
        slowest.append(row | {"name": name, "time": times[name][k], "fastest": fastest})
    as_printed = zip(rows, free_times(AS_PRINTED, printed), strict=True)
    return {
        "as_printed": [row | {"time": time} for row, time in as_printed],
        "readings": len(times),
        "slowest": slowest,
        "current_drawn": printed.high / printed.R_A,
    }


def time_ratios(printed: Printed) -> dict[str, float]:
    """Return the ratio of the times at low and high voltage, by variant."""
    times = {name: free_times(case, printed) for name, case in (VARIANTS | IN_SERIES).items()}
    return {name: slow / fast for name, (fast, slow) in times.items()}


def compute_ratios(printed: Printed) -> dict[str, Any]:
    """Return the smallest and the largest time ratio, and the ratio with a limited current."""
    ratios = time_ratios(printed)
    least, most = (choose(ratios, key=ratios.__getitem__) for choose in (min, max))
    fast, slow = (
        bench.arrival_time(replace(LIMITED, slope=STEEP), printed, volts, printed.angle, RISE)
        for volts in (printed.high, printed.low)
    )
    return {
        "ratio_printed": printed.slow / printed.fast,
        "ratio": ratios[least],
        "ratio_count": len(ratios),
        "least": least,
        "bound": (bound := (printed.high / printed.low) ** 2),
        "slow_at_least": bound * printed.fast,
        "ratio_largest": ratios[most],
        "most": most,
        "ratio_limited": slow / fast,
        "limited_time": fast,
    }


def _list_paths(printed: Printed) -> list[dict[str, Any]]:
    """Return the temperature and fraction at both angles, for both units of the stress factor."""
    shift = 200.0 / printed.C_A
    cases = {"MPa": ("C_A = 6 MPa/°C", AS_PRINTED), "GPa": ("C_A = 1 GPa/°C", VARIANTS[NO_STRESS])}
    rows: list[dict[str, Any]] = []
    for key, (words, case) in cases.items():
        result = bench.run_heated(case, printed, printed.high, FREE)
        rows += [
            {
                "key": key,
                "words": words,
                "turned": angle,
                "celsius": bench.at_angle(result, angle, "temperature") - bench.ZERO,
                "fraction": bench.at_angle(result, angle, "martensite_fraction"),
                "small_shift": 1e-3 * shift,
                "shift": shift,
            }
            for angle in (printed.angle, printed.target)
        ]
    return rows


def _list_set(key: str, printed: Printed) -> list[dict[str, Any]]:
    """Return the times of a calibrated set at both voltages, to both angles."""
    words, short = SETS[key]
    columns = (
        (printed.high, printed.low),
        (printed.fast, printed.slow),
        response_times(key, printed, printed.angle),
        response_times(key, printed, printed.target),
    )
    shared = {"key": key, "words": words, "short": short}
    return [
        shared
        | {"volts": volts, "published": published, "time": time, "later": later}
        | {"currents": _list_currents(CASES[key], volts, printed)}
        for volts, published, time, later in zip(*columns, strict=True)
    ]


def _list_currents(case: Case, volts: float, printed: Printed) -> str:
    limit = case.limits[0 if volts >= printed.high else 1]
    low, high = (min(volts / (ohms + case.series), limit) for ohms in (printed.R_M, printed.R_A))
    return f"{low:.2f} A" if high - low < 0.005 else f"{low:.2f} to {high:.2f} A"


def compute_damped(printed: Printed) -> dict[str, float]:
    """Return the times of set C, whose joint is damped."""
    fast, slow = response_times("C", printed, printed.angle)
    result = bench.run_heated(CASES["C"], printed, printed.high, RISE, FINE)
    hottest = result.measure("max(first.temperature)") - bench.ZERO
    return {"set_C_5V": fast, "set_C_3V": slow, "hottest": hottest, "rise": RISE}


def compute_cooling(printed: Printed) -> dict[str, float]:
    """Return the cooling times of set A, and the heating time of the same angle."""
    result = bench.run_heated(CASES["A"], printed, printed.high, RISE, COARSE)
    turned = bench.angle_degrees(result)
    begin, end = (passing_time(result.times, turned, angle) for angle in (printed.angle - 20.0, printed.angle))
    back = bench.run_cooling(printed, CASES["A"])
    return {f"cooling_{name}": time for name, time in back.items()} | {"way_up": end - begin}
