"""Claims on the calibration loop: 0.015 Hz at r = 1.5 mm is not quasi-stationary."""

from __future__ import annotations

from martensite.studies.base import Claim
from martensite.studies.finger import bench
from martensite.studies.finger.printed import PAPER, Printed

SECTION = f"{PAPER}, section 5.1 and Figure 5"
SLOW = 0.1
"""Frequency of a slower loop, as a share of that of the paper."""
NEAR = 0.1
"""Ratio of widths by which a loop may differ and still count as quasi-stationary."""
OTHER_ARM = 16e-3
LATENT = (8e3, 0.0)
"""Latent heats tried beside that of Table 1 [J/kg]."""


def claims(printed: Printed) -> list[Claim]:
    """Width against a slow loop, temperature against power, latent heat."""
    return [*_widths(printed), *_temperature(printed), *_latent(printed)]


def widths(printed: Printed, arm: float | None) -> tuple[float, float, float]:
    """Widths of the loop as in the paper, ten times slower, and without stored heat [W]."""
    return (
        bench.width(bench.loop(printed.frequency, arm, printed)),
        bench.width(bench.loop(SLOW * printed.frequency, arm, printed)),
        bench.width(bench.loop(printed.frequency, arm, printed, bench.STATIC)),
    )


def _widths(printed: Printed) -> list[Claim]:
    here = bench.finger().value_of("mechanism.arm")
    found: list[Claim] = []
    for arm in (here, OTHER_ARM):
        full, slow, static = widths(printed, arm)
        found.append(
            Claim.checked(
                f"quasi-stationary-{1e3 * arm:.0f}mm",
                "width of the loop over that of one without stored heat, spring at "
                f"{1e3 * arm:.0f} mm", SECTION, 1.0, full / static, "1", NEAR,
                f"the paper takes all derivatives for zero; the loop is {full:.3f} W wide, ten "
                f"times slower it is {slow:.3f} W, without stored and latent heat {static:.3f} W. "
                "The amplitude, 0 to 2 W, is assumed",
            )
        )  # fmt: skip
    return found


def lag(printed: Printed, arm: float | None) -> float:
    """Largest distance of the temperature from T_E + P/(α S) [K]."""
    run = bench.loop(printed.frequency, arm, printed)
    per_kelvin = bench.surface_conductance(printed)
    rows = zip(run["temperature"], run["power"], strict=True)
    return max(abs(T - printed.ambient - P / per_kelvin) for T, P in rows)


def _temperature(printed: Printed) -> list[Claim]:
    return [
        Claim.checked(
            "proportional", "largest distance of T from T_E + P/(α S)", SECTION, 0.0,
            lag(printed, None), "K", 1.0,
            f"{lag(printed, OTHER_ARM):.1f} K with the spring at {1e3 * OTHER_ARM:.0f} mm; by "
            "Table 1 that is up to 37 MPa of threshold, beside a Δσ of 52 MPa to be found",
        )
    ]  # fmt: skip


def _latent(printed: Printed) -> list[Claim]:
    found: list[Claim] = []
    for latent in LATENT:
        run = bench.loop(printed.frequency, None, printed, (("latent_heat", latent),))
        found.append(
            Claim.reported(
                f"latent-{latent / 1e3:.0f}kJ",
                f"width of the loop with a latent heat of {latent / 1e3:.0f} kJ/kg", SECTION,
                bench.width(run), "W",
                "8 kJ/kg is T ε_T (dσ/dT)/ρ, what Table 1 asks of a consistent law; it prints 25"
                if latent else
                "fitted without latent heat, such a record would give too large a Δσ",
            )
        )  # fmt: skip
    return found
