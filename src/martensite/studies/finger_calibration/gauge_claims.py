"""Claims on what no such test can tell: gauges, by which several numbers change together.

Two of them:

    force      k_s, dσ/dT, Δσ, σ_L, E_A, E_M and 1/V times q: the same angles, exactly
    thermal    α, c and dσ/dT times q, T_L - T_E divided by it: nearly the same
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from martensite.identify.fitting.free import Wish
from martensite.identify.fitting.identifiability import Identifiability, identifiability
from martensite.identify.fitting.problem import Problem, problem
from martensite.identify.fitting.solve import solve
from martensite.studies.base import Claim
from martensite.studies.finger_calibration import bench
from martensite.studies.finger_calibration.bench import NEAR
from martensite.studies.finger_calibration.data_claims import SURE, errors, width
from martensite.studies.finger_calibration.printed import METHOD, PAPER, TABLE, Printed
from martensite.studies.finger_calibration.searches import STARTS, Search, rms

FORCE = ("stiffness", "dsigma_dT", "Delta_sigma", "sigma_L", "E_A", "E_M", "layer_volume")
THERMAL = ("T_L", "dsigma_dT", "cooling.h", "heat_capacity")
BEYOND = ("stiffness", "layer_volume")
"""What is free for the gauges besides the ten numbers that the paper calls unknown."""
AROUND = 2.0
"""Range of what has none in the paper: half to twice its value."""
FORCED, WARMED = 1.3, 1.2
"""Factors by which the gauges are tried."""
WRONG_ARMS = 9e-3, 7e-3
"""Places of the spring that a fit takes for granted where it is 8 mm [m]."""
TENTH = 0.1


def claims(printed: Printed) -> list[Claim]:
    """The two gauges, what follows for the table, and which numbers move the finger."""
    return [*_force(printed), *_thermal(printed), *_wrong(printed), *_effects(printed)]


@cache
def whole(printed: Printed) -> Problem:
    """The calibration test with all free that takes part in a gauge or is unknown to the paper."""
    system = bench.finger(NEAR.arm, printed.offsets[0])
    rest = [*printed.fixed, *((name, system.value_of(name)) for name in BEYOND)]
    wishes = [Wish(one.name, one.low, one.high, one.value) for one in printed.searched]
    wishes += [Wish(name, value / AROUND, value * AROUND, value) for name, value in rest]
    return problem(bench.experiments(NEAR, printed), wishes, noise={"angle": bench.NOISE})


@cache
def slopes(printed: Printed) -> Any:
    """(samples, parameters): derivatives with Table 1, per search range."""
    found = whole(printed).evaluate(whole(printed).start, slopes=True)
    return np.zeros((0, 0)) if found is None else found.jacobian


def held(names: Sequence[str], printed: Printed) -> Identifiability:
    """What the calibration test holds of some parameters, the others fixed."""
    free = whole(printed).free
    places = [whole(printed).names.index(name) for name in names]
    return identifiability(
        slopes(printed)[:, places], names, values=[free[i].start for i in places],
        scales=[free[i].slope(free[i].share(free[i].start)) for i in places],
        units=[free[i].unit for i in places],
    )  # fmt: skip


def apart(values: dict[str, float], printed: Printed) -> float:
    """Largest change of the angle over the test with numbers changed by name [°]."""
    offset = printed.offsets[0]
    moved = bench.clean(NEAR.arm, offset, printed, tuple(values.items()))
    return float(np.degrees(np.abs(moved - bench.clean(NEAR.arm, offset, printed)).max()))


def scaled(names: Sequence[str], factor: float, printed: Printed) -> dict[str, float]:
    """Numbers of a gauge times a factor; the layer volume divided by it."""
    start = {free.name: free.start for free in whole(printed).free}
    power = {"layer_volume": -1.0}
    return {name: start[name] * factor ** power.get(name, 1.0) for name in names}


def warmed(factor: float, printed: Printed) -> dict[str, float]:
    """The thermal gauge by a factor."""
    ambient = bench.finger(NEAR.arm, printed.offsets[0]).value_of("environment.temperature")
    hot = dict(zip(printed.names, printed.table, strict=True))["T_L"]
    others = scaled([name for name in THERMAL if name != "T_L"], factor, printed)
    return {**others, "T_L": ambient + (hot - ambient) / factor}


@cache
def refitted(printed: Printed, arm: float, values: tuple[tuple[str, float], ...] = ()) -> Search:
    """Least squares to the record without noise, by a finger that is another one."""
    records = bench.experiments(NEAR, printed, noisy=False, arm=arm, values=values)
    return Search(solve(bench.fitting(records, printed, STARTS[1])), ())


def _force(printed: Printed) -> list[Claim]:
    found = [one for one in held(FORCE, printed).weak if one.exact]
    without = [name for name in FORCE if name not in ("E_A", "E_M", "layer_volume")]
    return [
        Claim.reported(
            "force-gauge", f"largest change of the angle with seven numbers times {FORCED:g}",
            f"{PAPER}, section 2", apart(scaled(FORCE, FORCED, printed), printed), "deg",
            " ".join(one.sentence for one in found) + " "
            f"Without E_A, E_M and the layer volume the angle changes by "
            f"{apart(scaled(without, FORCED, printed), printed):.2f}° at most. Stresses rest on "
            "the spring and its place, which is not printed",
        ),
    ]  # fmt: skip


def _thermal(printed: Printed) -> list[Claim]:
    return [
        Claim.reported(
            "thermal-gauge",
            f"largest change of the angle with α, c and dσ/dT times {WARMED:g} and "
            "T_L - T_E divided by it", TABLE, apart(warmed(WARMED, printed), printed), "deg",
            " ".join(one.sentence for one in held(THERMAL, printed).weak) + " "
            "α is 200 W/(m² K) by convention, and dσ/dT goes with it",
        ),
    ]  # fmt: skip


def _wrong(printed: Printed) -> list[Claim]:
    far, close = (refitted(printed, arm) for arm in WRONG_ARMS)
    dry = refitted(printed, NEAR.arm, (("latent_heat", 0.0),))
    table = dict(zip(printed.names, printed.table, strict=True))
    places = [f"{1e3 * arm:.0f} mm" for arm in (NEAR.arm, *WRONG_ARMS)]
    return [
        Claim.reported(
            "wrong-arm", f"dσ/dT fitted with a spring at {places[0]} taken to be at {places[1]}",
            METHOD, far.fit["dsigma_dT"] / 1e6, "MPa/K",
            f"with Δσ = {far.fit['Delta_sigma'] / 1e6:.1f} MPa the record without noise is missed "
            f"by {far.rms:.3f}° only; the ratio of both is {width(far.fit.numbers):.2f} K. Taken "
            f"to be at {places[2]}, dσ/dT ends on its bound, {close.fit['dsigma_dT'] / 1e6:.2f} "
            f"MPa/K ({close.rms:.2f}°), as in Table 1",
        ),
        Claim.checked(
            "no-latent-heat", "Δσ fitted without latent heat", METHOD, table["Delta_sigma"] / 1e6,
            dry.fit["Delta_sigma"] / 1e6, "MPa",
            SURE * errors(NEAR, printed).numbers["Delta_sigma"] / 1e6,
            '"the effects of c and h can be neglected": without h the record is missed by '
            f"{dry.rms:.1f}°, and the width of its loop, which heat doubles, goes to Δσ",
        ),
    ]  # fmt: skip


def effects(printed: Printed) -> dict[str, float]:
    """Rms change of the angle if a number alone changes by a tenth, to first order [°]."""
    table = slopes(printed)
    found = {
        free.name: rms(float(np.mean(table[:, i] ** 2)))
        * TENTH * free.start / free.slope(free.share(free.start))
        for i, free in enumerate(whole(printed).free) if free.name not in BEYOND
    }  # fmt: skip
    return dict(sorted(found.items(), key=lambda pair: -pair[1]))


def _effects(printed: Printed) -> list[Claim]:
    found = effects(printed)
    first = list(found)[: len(printed.names)]
    shown = ", ".join(f"{name} {size:.2g}°" for name, size in found.items())
    return [
        Claim.checked(
            "chosen", "how many of the five numbers that move the finger most are those chosen",
            METHOD, float(len(printed.names)), float(len(set(first) & set(printed.names))), "1",
            0.0,
            f"rms change of the angle if each changes by a tenth: {shown}. A tenth of σ_L is only "
            "0.1 MPa; but E_M moves next to nothing even over its whole range",
        )
    ]  # fmt: skip
