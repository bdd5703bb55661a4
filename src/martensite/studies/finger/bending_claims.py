"""Claims on bending: angles at two powers and three distances, their times, and geometry.

The measured angles are in a figure that is not in the text at hand. What the text says can be
checked in kind: the trend in r, the return, the time constants that depend on the power.
"""

from __future__ import annotations

import math

from martensite.studies.base import Claim
from martensite.studies.finger import bench, wire_claims
from martensite.studies.finger.printed import PAPER, Printed

FIGURE_6 = f"{PAPER}, section 5 and Figure 6"
ARMS = tuple(1e-3 * i for i in range(6, 20))
"""Places of the spring that are tried [m]."""
OTHER_FILM = 220.0
"""[W/(m² K)]"""
ALLOWED = 0.1
"""Difference of angles that counts as none [°]."""
ACTIVATION = 3.0
"""Stress by which thermal activation may shift a threshold [MPa]."""


def claims(printed: Printed) -> list[Claim]:
    """Trend and angles first, then thresholds, times, energy and what the numbers hang on."""
    return [
        *_trend(printed), *_angles(printed), *_limited(printed), *_times(printed),
        *_return(printed), *_sensitive(printed), *_redundant(printed),
    ]  # fmt: skip


def tops(watts: float, printed: Printed, arm: float | None = None) -> list[float]:
    """Angles at the end of the full power, one for each r [°]."""
    return [bench.top(bench.bent(watts, r, printed, arm), printed) for r in printed.offsets]


def falls(watts: float, printed: Printed, arm: float | None = None) -> bool:
    """True if a larger r bends less."""
    first, second, third = tops(watts, printed, arm)
    return first > second > third


def last_arm(watts: float, printed: Printed) -> float:
    """Largest place of the spring tried up to which a larger r bends less [m]."""
    found = 0.0
    for arm in ARMS:
        if not falls(watts, printed, arm):
            break
        found = arm
    return found


def _trend(printed: Printed) -> list[Claim]:
    arm = bench.finger().value_of("mechanism.arm")
    here = sum(falls(watts, printed) for watts in printed.powers)
    safe = sum(falls(watts, printed, bench.SAFE_ARM) for watts in printed.powers)
    far = sum(falls(watts, printed, bench.FAR_ARM) for watts in printed.powers)
    count = float(len(printed.powers))
    words = "powers at which a larger r bends less"
    ends = [last_arm(watts, printed) for watts in printed.powers]
    return [
        Claim.checked(
            "trend", f"{words}, spring at {1e3 * arm:.0f} mm", FIGURE_6, count, float(here), "1",
            0.0, "follows only where the wire transforms to the end, since the brackets make its "
            "path bow; the place of the spring is not printed",
        ),
        Claim.checked(
            "trend-safe", f"{words}, spring at {1e3 * bench.SAFE_ARM:.0f} mm", FIGURE_6, count,
            float(safe), "1", 0.0, "a place that is not at the edge of this regime",
        ),
        Claim.checked(
            "trend-far", f"{words}, spring at {1e3 * bench.FAR_ARM:.0f} mm", FIGURE_6, count,
            float(far), "1", 0.0, "in the middle of the second phalanx the wire meets σ_M before "
            "it has transformed: there a longer lever bends more, so the spring cannot be there",
        ),
        *(
            Claim.reported(
                f"trend-end-{watts:.1f}W",
                f"largest distance of the spring at which {watts:.1f} W shows the trend", FIGURE_6,
                1e3 * end, "mm", "in steps of 1 mm, with brackets 10.6 mm from the hinge (assumed)",
            )
            for watts, end in zip(printed.powers, ends, strict=True)
        ),
    ]  # fmt: skip


def _angles(printed: Printed) -> list[Claim]:
    arm = bench.finger().value_of("mechanism.arm")
    found: list[Claim] = []
    for r in printed.offsets:
        full = bench.full_stroke(r, arm, printed)
        for watts in printed.powers:
            run = bench.bent(watts, r, printed)
            stress = bench.at(run, "stress", printed.fall) / 1e6
            found.append(
                Claim.reported(
                    f"angle-{1e3 * r:.1f}mm-{watts:.1f}W",
                    f"angle at {watts:.1f} W, r = {1e3 * r:.1f} mm", FIGURE_6,
                    bench.top(run, printed), "deg",
                    f"full stroke in closed form {full:.2f}°; stress {stress:.1f} MPa",
                )
            )  # fmt: skip
    unmeasured = Claim(
        "measured-error", "largest difference of computed and measured angles", FIGURE_6,
        printed.error, None, "deg", None, "not checkable",
        "the measured angles are not in the text at hand",
    )  # fmt: skip
    return [*found, unmeasured]


def _limited(printed: Printed) -> list[Claim]:
    """With the spring far out the wire stops at its threshold."""
    r, found = printed.offsets[-1], list[Claim]()
    for watts in printed.powers:
        run = bench.bent(watts, r, printed, bench.FAR_ARM)
        stress, T = (bench.at(run, name, printed.fall) for name in ("stress", "temperature"))
        threshold = wire_claims.threshold_stress(T) - bench.finger().value_of("Delta_sigma")
        found.append(
            Claim.checked(
                f"limited-{watts:.1f}W",
                f"stress where the wire stops short of its stroke, {watts:.1f} W, r = "
                f"{1e3 * r:.1f} mm, spring at {1e3 * bench.FAR_ARM:.0f} mm",
                f"{PAPER}, equations (6) and (7)", threshold / 1e6, stress / 1e6, "MPa",
                ACTIVATION, f"σ_M of the temperature held, {T:.1f} K; layers jump before their "
                "barrier is gone, so the wire goes on a little beyond",
            )
        )  # fmt: skip
    return found


def _times(printed: Printed) -> list[Claim]:
    low, high = printed.powers
    found: list[Claim] = []
    for r in printed.offsets:
        slow, quick = (bench.bent(watts, r, printed) for watts in (low, high))
        ends = [bench.rise(run, 0.63, printed) for run in (slow, quick)]
        spans = [
            bench.rise(run, 0.9, printed) - bench.rise(run, 0.1, printed) for run in (slow, quick)
        ]
        found.append(
            Claim.reported(
                f"rise-ratio-{1e3 * r:.1f}mm",
                f"10 to 90 % rise at {low:.1f} W over that at {high:.1f} W, r = {1e3 * r:.1f} mm",
                FIGURE_6, spans[0] / spans[1], "1",
                f"63 % after {ends[0]:.2f} s and {ends[1]:.2f} s: the time constant depends on the "
                f"power, and at {high:.1f} W the transient is sharp, as the paper says of both",
            )
        )  # fmt: skip
    return found


def _return(printed: Printed) -> list[Claim]:
    run = bench.bent(max(printed.powers), printed.offsets[0], printed)
    wire = bench.wire()
    values = {
        "mass": wire.mass(), "heat_capacity": wire.heat_capacity, "latent_heat": wire.latent_heat,
    }  # fmt: skip
    return [
        Claim.checked(
            "return", "angle 10 s after the power has gone", f"{PAPER}, section 5", 0.0,
            math.degrees(run["angle"][-1]), "deg", ALLOWED,
            "quasi-static; all martensite is oriented again",
        ),
        Claim.reported(
            "energy", "share of the energy put in that is not accounted for", f"{PAPER}, eq. (5)",
            bench.imbalance(run, values), "1", "work, loss, storage and latent heat of the run",
        ),
    ]  # fmt: skip


def _sensitive(printed: Printed) -> list[Claim]:
    low, r = min(printed.powers), printed.offsets[0]
    system = bench.finger(
        bench.SINGLE, (("mechanism.offset", r), ("environment.cooling.h", OTHER_FILM))
    )
    run = bench.simulated(system, low, printed)
    usual = bench.top(bench.bent(low, r, printed), printed)
    doubled = [bench.bent(2.0 * watts, r, printed) for watts in printed.powers]
    angles = [bench.top(one, printed) for one in doubled]
    hottest = max(max(one["temperature"]) for one in doubled)
    return [
        Claim.reported(
            "film-220", f"angle at {low:.1f} W, r = {1e3 * r:.1f} mm, with α = {OTHER_FILM:.0f}",
            f"{PAPER}, Table 1", bench.top(run, printed), "deg",
            f"with α = {printed.film:.0f} it is {usual:.1f}°: at the lower power the angle hangs "
            "on a film coefficient that was chosen",
        ),
        Claim.reported(
            "power-per-half", "difference of the angles at both powers, read per half wire",
            FIGURE_6, angles[1] - angles[0], "deg",
            f"both reach the full stroke, at up to {hottest:.0f} K; that the error grows between "
            "the two powers would then have no reason, so the power is read as that of the wire",
        ),
    ]  # fmt: skip


def redundancy(printed: Printed) -> float:
    """Largest change of the angle if T_L is 10 K and σ_L the matching stress higher [°]."""
    low, r = min(printed.powers), printed.offsets[0]
    usual, slope = bench.finger(), bench.finger().value_of("dsigma_dT")
    moved = bench.finger(
        bench.SINGLE,
        (
            ("mechanism.offset", r), ("T_L", usual.value_of("T_L") + 10.0),
            ("sigma_L", usual.value_of("sigma_L") + 10.0 * slope),
        ),
    )  # fmt: skip
    pair = bench.bent(low, r, printed), bench.simulated(moved, low, printed)
    angles = zip(*(run["angle"] for run in pair), strict=True)
    return math.degrees(max(abs(a - b) for a, b in angles))


def _redundant(printed: Printed) -> list[Claim]:
    return [
        Claim.reported(
            "redundant", "change of any angle if T_L is 10 K and σ_L 40 MPa higher",
            f"{PAPER}, section 5.2", redundancy(printed), "deg",
            "only T_L - σ_L/(dσ/dT) = 319.75 K enters: of the five numbers that are optimised two "
            "cannot be told apart",
        )
    ]  # fmt: skip
