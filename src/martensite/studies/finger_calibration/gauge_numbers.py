"""Numbers of gauges: joint changes of parameters that the test cannot detect.

force      k_s, dσ/dT, Δσ, σ_L, E_A, E_M and 1/V times q: the same angles, exactly
thermal    α, c and dσ/dT times q, T_L - T_E divided by it: nearly the same
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from martensite.fit.problem import Problem, build_problem
from martensite.fit.solve import solve_problem
from martensite.search.free_numbers import SearchRange
from martensite.search.identifiability import Identifiability, assess_identifiability
from martensite.studies.finger_calibration import bench
from martensite.studies.finger_calibration.bench import NEAR
from martensite.studies.finger_calibration.record_numbers import (
    SURE,
    parameter_errors,
    table_numbers,
    temperature_width,
)
from martensite.studies.finger_calibration.searches import STARTS, CalibrationSearch, angle_rms
from martensite.studies.tables import Printed

FORCE = ("stiffness", "dsigma_dT", "Delta_sigma", "sigma_L", "E_A", "E_M", "layer_volume")
THERMAL = ("T_L", "dsigma_dT", "cooling.h", "heat_capacity")
BEYOND = ("stiffness", "layer_volume")
"""Free parameters of the gauges that are known in the paper."""
AROUND = 2.0
"""Range factor of parameters without a range in the paper."""
FORCED, WARMED = 1.3, 1.2
"""Factors of the gauges."""
WRONG_ARMS = 9e-3, 7e-3
"""Wrong places of the spring in a fit; the true one is 8 mm [m]."""
TENTH = 0.1


def compute_gauge(printed: Printed) -> dict[str, Any]:
    """Return the two gauges, their consequences for the table, and the effects of parameters."""
    without = [name for name in FORCE if name not in ("E_A", "E_M", "layer_volume")]
    exact = [one for one in assess_test(FORCE, printed).weak if one.exact]
    return {
        "forced": FORCED,
        "force_gauge": largest_change(scale_gauge(FORCE, FORCED, printed), printed),
        "force_lost": " ".join(one.sentence for one in exact),
        "force_without": largest_change(scale_gauge(without, FORCED, printed), printed),
        "warmed": WARMED,
        "thermal_gauge": largest_change(scale_thermal_gauge(WARMED, printed), printed),
        "thermal_lost": " ".join(one.sentence for one in assess_test(THERMAL, printed).weak),
        **compute_wrong(printed),
        **compute_effects(printed),
    }


@cache
def free_problem(printed: Printed) -> Problem:
    """Return the calibration test with all unknown and gauge parameters free."""
    system = bench.build_finger(NEAR.arm, printed.offsets[0])
    rest = [*((one.name, one.value) for one in printed.fixed), *((name, system.value_of(name)) for name in BEYOND)]
    wishes = [SearchRange(one.name, one.low, one.high, one.value) for one in printed.searched]
    wishes += [SearchRange(name, value / AROUND, value * AROUND, value) for name, value in rest]
    return build_problem(bench.build_experiments(NEAR, printed), wishes, noise={"angle": bench.NOISE})


@cache
def angle_slopes(printed: Printed) -> Any:
    """Return the derivatives with Table 1 (samples, parameters), per search range."""
    evaluation = free_problem(printed).evaluate(free_problem(printed).start, slopes=True)
    return np.zeros((0, 0)) if evaluation is None else evaluation.jacobian


def assess_test(names: Sequence[str], printed: Printed) -> Identifiability:
    """Return the information of the calibration test on some parameters, the others fixed."""
    free = free_problem(printed).free
    places = [free_problem(printed).names.index(name) for name in names]
    return assess_identifiability(
        angle_slopes(printed)[:, places],
        names,
        values=[free[i].start for i in places],
        scales=[free[i].slope(free[i].share(free[i].start)) for i in places],
        units=[free[i].unit for i in places],
    )


def largest_change(values: dict[str, float], printed: Printed) -> float:
    """Return the largest change of the angle over the test with changed parameters [°]."""
    offset = printed.offsets[0]
    moved = bench.clean_angle(NEAR.arm, offset, printed, tuple(values.items()))
    return float(np.degrees(np.abs(moved - bench.clean_angle(NEAR.arm, offset, printed)).max()))


def scale_gauge(names: Sequence[str], factor: float, printed: Printed) -> dict[str, float]:
    """Return the values of a gauge times a factor; the layer volume is divided by it."""
    start = {free.name: free.start for free in free_problem(printed).free}
    power = {"layer_volume": -1.0}
    return {name: start[name] * factor ** power.get(name, 1.0) for name in names}


def scale_thermal_gauge(factor: float, printed: Printed) -> dict[str, float]:
    """Return the values of the thermal gauge for a factor."""
    ambient = bench.build_finger(NEAR.arm, printed.offsets[0]).value_of("environment.temperature")
    hot = table_numbers(printed)["T_L"]
    others = scale_gauge([name for name in THERMAL if name != "T_L"], factor, printed)
    return {**others, "T_L": ambient + (hot - ambient) / factor}


@cache
def refit_finger(printed: Printed, arm: float, values: tuple[tuple[str, float], ...] = ()) -> CalibrationSearch:
    """Return a least-squares fit of the noise-free record by a different finger."""
    records = bench.build_experiments(NEAR, printed, noisy=False, arm=arm, values=values)
    return CalibrationSearch(solve_problem(bench.build_calibration(records, printed, STARTS[1])), ())


def compute_wrong(printed: Printed) -> dict[str, Any]:
    """Return fits with a misplaced spring, and without latent heat."""
    far, close = (refit_finger(printed, arm) for arm in WRONG_ARMS)
    dry = refit_finger(printed, NEAR.arm, (("latent_heat", 0.0),))
    return {
        "places": [f"{1e3 * arm:.0f} mm" for arm in (NEAR.arm, *WRONG_ARMS)],
        "wrong_arm": far.fit["dsigma_dT"] / 1e6,
        "far": far,
        "far_hysteresis": far.fit["Delta_sigma"] / 1e6,
        "far_ratio": temperature_width(far.fit.numbers),
        "close": close,
        "close_slope": close.fit["dsigma_dT"] / 1e6,
        "dry": dry,
        "hysteresis": [
            {
                "printed_hysteresis": table_numbers(printed)["Delta_sigma"],
                "dry_hysteresis": dry.fit["Delta_sigma"],
                "dry_rms": dry.rms,
            }
        ],
        "no_latent_heat": dry.fit["Delta_sigma"] / 1e6,
        "sure_hysteresis": SURE * parameter_errors(NEAR, printed).numbers["Delta_sigma"] / 1e6,
    }


def single_effects(printed: Printed) -> dict[str, float]:
    """Return the RMS change of the angle for a change of each parameter by a tenth, to first order [°]."""
    table = angle_slopes(printed)
    effects = {
        free.name: angle_rms(float(np.mean(table[:, i] ** 2))) * TENTH * free.start / free.slope(free.share(free.start))
        for i, free in enumerate(free_problem(printed).free)
        if free.name not in BEYOND
    }
    return dict(sorted(effects.items(), key=lambda pair: -pair[1]))


def compute_effects(printed: Printed) -> dict[str, Any]:
    """Return how many of the most influential parameters the paper searched for."""
    effects, names = single_effects(printed), printed.searched.column("name")
    first = list(effects)[: len(names)]
    return {
        "chosen": float(len(set(first) & set(names))),
        "effects": ", ".join(f"{name} {size:.2g}°" for name, size in effects.items()),
    }
