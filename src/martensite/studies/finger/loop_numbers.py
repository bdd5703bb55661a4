"""Numbers of the calibration loop: 0.015 Hz at r = 1.5 mm is not quasi-stationary."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from martensite.studies.finger import bench
from martensite.studies.tables import Printed

SLOW, SLOWEST = 0.1, 0.03
"""Frequencies of slower loops, relative to the paper."""
OTHER_ARM = 16e-3
CLOSE = 1.1
"""Largest width ratio of a quasi-stationary loop."""
LATENT = (8e3, 0.0)
"""Other latent heats than in Table 1 [J/kg]."""


def compute_loop(printed: Printed) -> dict[str, Any]:
    """Return widths, temperature lag, and widths with other latent heats."""
    here = bench.build_finger().value_of("mechanism.arm")
    return {
        "widths": (widths := [_list_widths(printed, arm) for arm in (here, OTHER_ARM)]),
        "near": SimpleNamespace(**widths[0]),
        "far": SimpleNamespace(**widths[1]),
        "calm_frequency": calm_frequency(printed),
        "calm_percent": 100.0 * (CLOSE - 1.0),
        "proportional": temperature_lag(printed, None),
        "other_lag": temperature_lag(printed, OTHER_ARM),
        "other_arm": 1e3 * OTHER_ARM,
        **{f"latent_{heat / 1e3:.0f}kJ": latent_width(heat, printed) for heat in LATENT},
    }


def _list_widths(printed: Printed, arm: float) -> dict[str, float]:
    full, slow, static = loop_widths(printed, arm)
    ratio = full / static
    return {"arm": 1e3 * arm, "full": full, "slow": slow, "static": static, "ratio": ratio}


def loop_widths(printed: Printed, arm: float | None) -> tuple[float, float, float]:
    """Return the widths of the loop as in the paper, ten times slower, and without stored heat [W]."""
    return (
        bench.loop_width(bench.run_loop(printed.frequency, arm, printed)),
        bench.loop_width(bench.run_loop(SLOW * printed.frequency, arm, printed)),
        bench.loop_width(bench.run_loop(printed.frequency, arm, printed, bench.STATIC)),
    )


def calm_frequency(printed: Printed) -> float:
    """Return the largest tried frequency of a quasi-stationary loop [Hz]; 0 without one."""
    static = bench.loop_width(bench.run_loop(printed.frequency, None, printed, bench.STATIC))
    tried = (share * printed.frequency for share in (1.0, SLOW, SLOWEST))
    return next((f for f in tried if bench.loop_width(bench.run_loop(f, None, printed)) <= CLOSE * static), 0.0)


def latent_width(latent: float, printed: Printed) -> float:
    """Return the width of the loop [W] with a latent heat [J/kg]."""
    run = bench.run_loop(printed.frequency, None, printed, (("latent_heat", latent),))
    return bench.loop_width(run)


def temperature_lag(printed: Printed, arm: float | None) -> float:
    """Return the largest deviation of the temperature from T_E + P/(α S) [K]."""
    run = bench.run_loop(printed.frequency, arm, printed)
    per_kelvin = bench.surface_conductance(printed)
    rows = zip(run["temperature"], run["power"], strict=True)
    return max(abs(T - printed.ambient - P / per_kelvin) for T, P in rows)
