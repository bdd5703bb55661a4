"""Claims on the response times: what the printed equations give, and what they cannot.

Heated by V²/R with any fixed resistances, any heat capacity, latent heat and heat loss, the time
to an angle is T(V) = ∫ C dx/[V² p(x) - q(x)] with the same C > 0, p > 0 and q ≥ 0 at both
voltages, because the path x from cold to hot does not depend on power. The integrand at 3 V is at
least 25/9 of that at 5 V, hence T(3 V)/T(5 V) ≥ 25/9, with equality without heat loss. The paper
has 30/18 = 5/3. A current limit alone that both voltages reach gives 1: something between the two
must be present, or a lag that does not depend on the voltage.
"""

from __future__ import annotations

import math
from dataclasses import replace

from martensite.studies.base import Claim
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
from martensite.studies.platform.printed import PAPER, Printed
from martensite.studies.readings import passing

TIMES = f"{PAPER}, section 4"
TABLE_1 = f"{PAPER}, Table 1"
FREE, SLOWED = 12.0, 80.0
"""Durations of runs without a current limit, with nothing and something in series [s]."""
LONG = 400.0
"""Duration after which a platform that has not arrived has stalled [s]."""
NO_STRESS = "C of 1 GPa/K"
"""Name of the reading in which stress hardly matters."""
AROUND = 2.0
"""What "around 30 s" may differ by [s]."""


def claims(printed: Printed) -> list[Claim]:
    """As printed; the ratio; the limit; the calibrated sets; cooling."""
    return [
        *_printed(printed), *_ratio(printed), *_limit(printed), *_stress_factor(printed),
        *_calibrated(printed), *_damped(printed), *_cooling(printed),
    ]  # fmt: skip


def free_times(case: Case, printed: Printed) -> tuple[float, float]:
    """Times [s] to the angle at the high and at the low voltage, without a current limit."""
    duration = FREE if case.series == 0.0 else SLOWED
    fast, slow = (
        bench.arrival(case, printed, volts, printed.angle, duration)
        for volts in (printed.high, printed.low)
    )
    return fast, slow


def times(key: str, printed: Printed, angle: float) -> tuple[float, float]:
    """Times [s] of a calibrated set to an angle [°] at the high and at the low voltage."""
    fast, slow = (
        bench.arrival(CASES[key], printed, volts, angle, duration, bench.step_of(CASES[key]))
        for volts, duration in ((printed.high, RISE), (printed.low, LATE))
    )
    return fast, slow


def needed_current(printed: Printed) -> float:
    """Current that holds the angle of the response times with everything as printed [A].

    Temperature and resistance there are those of the path, which does not depend on power.
    """
    result = bench.heated(AS_PRINTED, printed, printed.high, FREE)
    warm = bench.at_angle(result, printed.angle, "temperature") - bench.ZERO - printed.ambient
    ohms = bench.at_angle(result, printed.angle, "resistance")
    surface = bench.spring(AS_PRINTED, printed).surface()
    return math.sqrt(printed.film * surface * warm / ohms)


def _printed(printed: Printed) -> list[Claim]:
    fast, slow = free_times(AS_PRINTED, printed)
    found = {name: free_times(case, printed) for name, case in VARIANTS.items()}
    slowest = [max(found, key=lambda name, k=k: found[name][k]) for k in (0, 1)]
    rows = (
        (printed.high, printed.fast, fast, slowest[0], 0),
        (printed.low, printed.slow, slow, slowest[1], 1),
    )
    return [
        *(
            Claim.checked(
                f"printed-{volts:.0f}V", f"{printed.angle:.0f}° at {volts:.0f} V, as printed",
                TIMES, published, computed, "s", 1.0 if k == 0 else AROUND,
                "V²/R of the printed resistances, 150 W/(m² K), 1 g; heat capacity and latent "
                "heat are not printed: 837 J/(kg K), 24.2 kJ/kg",
            )
            for volts, published, computed, _, k in rows
        ),
        *(
            Claim.checked(
                f"slowest-{volts:.0f}V",
                f"{printed.angle:.0f}° at {volts:.0f} V, slowest of {len(found)} readings", TIMES,
                published, found[name][k], "s", 1.0 if k == 0 else AROUND,
                f"{name}; the fastest takes {min(pair[k] for pair in found.values()):.2f} s",
            )
            for volts, published, _, name, k in rows
        ),
        Claim.checked(
            "current", f"largest current of a spring at {printed.high:.0f} V", TIMES,
            printed.current, printed.high / printed.R_A, "A", 0.1,
            "the printed resistances draw 6.1 to 6.9 A at 5 V and 3.7 to 4.1 A at 3 V: the supply "
            "was limited, or more than an ohm stood in series",
        ),
    ]  # fmt: skip


def ratios(printed: Printed) -> dict[str, float]:
    """Time at the low voltage over that at the high one, of every reading."""
    found = {name: free_times(case, printed) for name, case in (VARIANTS | IN_SERIES).items()}
    return {name: slow / fast for name, (fast, slow) in found.items()}


def _ratio(printed: Printed) -> list[Claim]:
    found, bound = ratios(printed), (printed.high / printed.low) ** 2
    least = min(found, key=found.__getitem__)
    both = [
        bench.arrival(replace(LIMITED, slope=STEEP), printed, volts, printed.angle, RISE)
        for volts in (printed.high, printed.low)
    ]
    return [
        Claim.checked(
            "ratio", "ratio of the two response times", TIMES, printed.slow / printed.fast,
            found[least], "1", 0.2,
            f"smallest of {len(found)} readings ({least}); no heating with V² can be below "
            f"(5/3)² = {bound:.4f}, so the two times do not follow from equations (5) to (12)",
        ),
        Claim.reported(
            "ratio-largest", "the same, largest of the readings", TIMES, max(found.values()), "1",
            f"{max(found, key=found.__getitem__)}: heat loss only makes it larger",
        ),
        Claim.reported(
            "ratio-limited", "the same, if both voltages reach a limit of 2.5 A", TIMES,
            both[1] / both[0], "1",
            f"{both[0]:.2f} s at both, with C of 1 GPa/K, since as corrected there is no arrival; "
            "the paper's ratio lies between",
        ),
    ]  # fmt: skip


def _limit(printed: Printed) -> list[Claim]:
    stalled = bench.heated(LIMITED, printed, printed.high, LONG, 0.05)
    return [
        Claim.checked(
            "limited-angle", f"rotation at {printed.current:g} A, everything else as printed",
            TIMES, printed.angle, bench.degrees(stalled)[-1], "deg", 0.5,
            f"after {LONG:.0f} s; the heat loss with 150 W/(m² K) then equals the power",
        ),
        Claim.checked(
            "needed-current", f"current that reaches {printed.angle:.0f}°", TIMES,
            printed.current, needed_current(printed), "A", 0.05,
            "from heat loss and resistance at that angle: 2.5 A and 150 W/(m² K) exclude each "
            "other",
        ),
    ]  # fmt: skip


def _stress_factor(printed: Printed) -> list[Claim]:
    shift = 200.0 / printed.C_A
    cases = {"MPa": ("C_A = 6 MPa/°C", AS_PRINTED), "GPa": ("C_A = 1 GPa/°C", VARIANTS[NO_STRESS])}
    claims: list[Claim] = []
    for key, (words, case) in cases.items():
        result = bench.heated(case, printed, printed.high, FREE)
        for angle in (printed.angle, printed.target):
            fraction = bench.at_angle(result, angle, "martensite_fraction")
            claims.append(Claim.reported(
                f"path-{key}-{angle:.0f}", f"temperature of the spring at {angle:.0f}°, {words}",
                TABLE_1, bench.at_angle(result, angle, "temperature") - bench.ZERO, "degC",
                f"ξ = {fraction:.3f}; with the printed 6 GPa/°C, 200 MPa would move A_f by "
                f"{1e-3 * shift:.2f} °C instead of {shift:.0f} °C",
            ))  # fmt: skip
    return claims


def _calibrated(printed: Printed) -> list[Claim]:
    claims: list[Claim] = []
    words = {
        "A": ("h and series resistance chosen for these two times", "A"),
        "A'": ("h of free convection, one current per voltage chosen for each time", "A2"),
    }
    for key, (why, short) in words.items():
        case = CASES[key]
        first, second = times(key, printed, printed.angle)
        later = times(key, printed, printed.target)
        for volts, published, computed in (
            (printed.high, printed.fast, first), (printed.low, printed.slow, second),
        ):  # fmt: skip
            claims.append(Claim.calibrated(
                f"set-{short}-{volts:.0f}V", f"set {key}: {printed.angle:.0f}° at {volts:.0f} V",
                TIMES, published, computed, "s", f"{why}; {_currents(case, volts, printed)}",
            ))  # fmt: skip
        claims += [
            Claim.reported(
                f"set-{short}-{volts:.0f}V-later",
                f"set {key}: {printed.target:.0f}° at {volts:.0f} V", TIMES, computed, "s",
                "not calibrated: this time, and the current, would tell the sets apart",
            )
            for volts, computed in zip((printed.high, printed.low), later, strict=True)
        ]  # fmt: skip
    return claims


def _currents(case: Case, volts: float, printed: Printed) -> str:
    """The currents of a case at a voltage, in words."""
    limit = case.limits[0 if volts >= printed.high else 1]
    low, high = (min(volts / (ohms + case.series), limit) for ohms in (printed.R_M, printed.R_A))
    return f"{low:.2f} A" if high - low < 0.005 else f"{low:.2f} to {high:.2f} A"


def _damped(printed: Printed) -> list[Claim]:
    fast, slow = times("C", printed, printed.angle)
    result = bench.heated(CASES["C"], printed, printed.high, RISE, FINE)
    hottest = max(result["first.temperature"])
    why = (
        "damping of the joint chosen for this time: 16.48 N m s/rad, of a universal joint; the "
        f"spring is then at {hottest - bench.ZERO:.0f} °C after {RISE:.0f} s"
    )
    return [
        Claim.calibrated(
            "set-C-5V", f"set C: {printed.angle:.0f}° at {printed.high:.0f} V", TIMES,
            printed.fast, fast, "s", why,
        ),
        Claim.checked(
            "set-C-3V", f"set C: {printed.angle:.0f}° at {printed.low:.0f} V", TIMES,
            printed.slow, slow, "s", AROUND,
            "not used in the calibration: a lag that does not depend on the voltage brings the "
            "paper's ratio about as well, but not its current",
        ),
    ]  # fmt: skip


def _cooling(printed: Printed) -> list[Claim]:
    found = bench.cooled(printed, CASES["A"])
    result = bench.heated(CASES["A"], printed, printed.high, RISE, COARSE)
    turned = bench.degrees(result)
    rise = passing(result.times, turned, printed.angle) - passing(
        result.times, turned, printed.angle - 20.0
    )
    rows = (
        ("hold", "time until the plate moves back",
         "the spring must first cool to the start of the forward transformation at its stress"),
        ("10", "time to come 10° back", "from switching off"),
        ("20", "time to come 20° back", f"the same way up takes {rise:.1f} s at 5 V: \"the cooling "
         "time was more\""),
    )  # fmt: skip
    return [
        Claim.reported(
            f"cooling-{name}", f"set A from {printed.angle:.0f}°: {statement}", TIMES,
            found[name], "s", why,
        )
        for name, statement, why in rows
    ]  # fmt: skip
