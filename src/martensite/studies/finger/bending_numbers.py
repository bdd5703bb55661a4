"""Numbers of the bending: angles at two powers and three distances, times, and geometry.

The measured angles are in an unavailable figure. The text allows qualitative checks: the trend in r, the return, the
power dependence of the time constants.
"""

from __future__ import annotations

import math
from typing import Any

from martensite.studies.finger import bench, wire_numbers
from martensite.studies.tables import Printed

ARMS = tuple(1e-3 * i for i in range(6, 20))
"""Tried places of the spring [m]."""
OTHER_FILM = 220.0


def compute_bending(printed: Printed) -> dict[str, Any]:
    """Return trend and angles, then thresholds, times, energy and sensitivities."""
    arm = bench.build_finger().value_of("mechanism.arm")
    low, high = printed.powers
    run, wire = (bench.run_bending(max(printed.powers), printed.offsets[0], printed), bench.get_wire())
    heats = {name: getattr(wire, name) for name in ("heat_capacity", "latent_heat")}
    return {
        "count": float(len(printed.powers)),
        "arm": 1e3 * arm,
        "safe_arm": 1e3 * bench.SAFE_ARM,
        "far_arm": 1e3 * bench.FAR_ARM,
        "trend": count_falls(printed),
        "trend_safe": count_falls(printed, bench.SAFE_ARM),
        "trend_far": count_falls(printed, bench.FAR_ARM),
        "ends": [{"watts": w, "end": 1e3 * last_arm(w, printed)} for w in printed.powers],
        "angles": [_list_angle(watts, r, arm, printed) for r in printed.offsets for watts in printed.powers],
        "limited": [_list_limit(watts, printed) for watts in printed.powers],
        "low": low,
        "high": high,
        "rises": [_list_rise(r, printed) for r in printed.offsets],
        "return": math.degrees(run["angle"][-1]),
        "energy": bench.energy_imbalance(run, {"mass": wire.mass(), **heats}),
        **compute_sensitivity(printed),
        "redundant": gauge_change(printed),
    }


def top_angles(watts: float, printed: Printed, arm: float | None = None) -> list[float]:
    """Return the angles at the end of the full power by r [°]."""
    return [bench.top_angle(bench.run_bending(watts, r, printed, arm), printed) for r in printed.offsets]


def angles_fall(watts: float, printed: Printed, arm: float | None = None) -> bool:
    """Return whether a larger r bends less."""
    first, second, third = top_angles(watts, printed, arm)
    return first > second > third


def count_falls(printed: Printed, arm: float | None = None) -> float:
    """Return the number of powers at which a larger r bends less."""
    return float(sum(angles_fall(watts, printed, arm) for watts in printed.powers))


def last_arm(watts: float, printed: Printed) -> float:
    """Return the largest tried place of the spring up to which a larger r bends less [m]."""
    last = 0.0
    for arm in ARMS:
        if not angles_fall(watts, printed, arm):
            break
        last = arm
    return last


def _list_angle(watts: float, r: float, arm: float, printed: Printed) -> dict[str, float]:
    run = bench.run_bending(watts, r, printed)
    return {
        "r": 1e3 * r,
        "watts": watts,
        "angle": bench.top_angle(run, printed),
        "full": bench.full_stroke(r, arm, printed),
        "stress": bench.column_at(run, "stress", printed.fall) / 1e6,
    }


def _list_limit(watts: float, printed: Printed) -> dict[str, float]:
    """Return threshold and stress of a wire with the spring far out, which stops at its threshold."""
    r = printed.offsets[-1]
    run = bench.run_bending(watts, r, printed, bench.FAR_ARM)
    stress, kelvin = (bench.column_at(run, name, printed.fall) for name in ("stress", "temperature"))
    threshold = wire_numbers.threshold_stress(kelvin) - bench.build_finger().value_of("Delta_sigma")
    return {"watts": watts, "r": 1e3 * r, "threshold": threshold / 1e6, "stress": stress / 1e6, "kelvin": kelvin}


def _list_rise(r: float, printed: Printed) -> dict[str, float]:
    slow, quick = (bench.run_bending(watts, r, printed) for watts in printed.powers)
    spans = [bench.rise_time(run, 0.9, printed) - bench.rise_time(run, 0.1, printed) for run in (slow, quick)]
    return {
        "r": 1e3 * r,
        "ratio": spans[0] / spans[1],
        "slow_end": bench.rise_time(slow, 0.63, printed),
        "quick_end": bench.rise_time(quick, 0.63, printed),
    }


def compute_sensitivity(printed: Printed) -> dict[str, float]:
    """Return the angles with another film coefficient and with twice the power."""
    low, r = min(printed.powers), printed.offsets[0]
    changed = (("mechanism.offset", r), ("environment.cooling.h", OTHER_FILM))
    run = bench.run_trapezoid(bench.build_finger(bench.SINGLE, changed), low, printed)
    doubled = [bench.run_bending(2.0 * watts, r, printed) for watts in printed.powers]
    angles = [bench.top_angle(one, printed) for one in doubled]
    return {
        "first_r": 1e3 * r,
        "other_film": OTHER_FILM,
        "film_220": bench.top_angle(run, printed),
        "usual": bench.top_angle(bench.run_bending(low, r, printed), printed),
        "power_per_half": angles[1] - angles[0],
        "hottest": max(max(one["temperature"]) for one in doubled),
    }


def gauge_change(printed: Printed) -> float:
    """Return the largest change of the angle with T_L 10 K higher and the matching σ_L [°]."""
    low, r = min(printed.powers), printed.offsets[0]
    usual, slope = bench.build_finger(), bench.build_finger().value_of("dsigma_dT")
    moved = bench.build_finger(
        bench.SINGLE,
        (
            ("mechanism.offset", r),
            ("T_L", usual.value_of("T_L") + 10.0),
            ("sigma_L", usual.value_of("sigma_L") + 10.0 * slope),
        ),
    )
    pair = bench.run_bending(low, r, printed), bench.run_trapezoid(moved, low, printed)
    angles = zip(*(run["angle"] for run in pair), strict=True)
    return math.degrees(max(abs(a - b) for a, b in angles))
