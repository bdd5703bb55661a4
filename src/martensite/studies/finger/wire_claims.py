"""Claims on the wire alone: its heat balance, its thresholds, and what Table 1 implies."""

from __future__ import annotations

from martensite.laws.base import Fractions
from martensite.simulate.point import Leg, PointResult, material_point
from martensite.studies.base import Claim
from martensite.studies.finger import bench
from martensite.studies.finger.printed import PAPER, Printed
from martensite.studies.readings import passing, runtime

HEAT = f"{PAPER}, equation (5) and Table 1"
KINETICS = f"{PAPER}, section 3 and Table 1"
RATE = 1e-3
"""Strain rate of the plateaus [1/s]."""
TWINNED = Fractions(1.0, 0.0)
"""Martensite of both variants alike."""
PLASTIC = 1040.0
"""Density of a printed phalanx, ABS [kg/m³]; not in the paper."""
HOT = (340.0, 355.0, 370.0)
"""Temperatures of the plateaus [K]."""
LOADS = (50e6, 150e6)
"""Stresses of the isobaric cycles [Pa]."""
ALL_STRETCH = 0.05


def claims(printed: Printed) -> list[Claim]:
    """Heat first, then the law, then the mounting."""
    return [
        *_heat(printed), *_plateaus(), *_cold(printed), *_isobaric(), *_mounting(printed),
        *_weight(printed),
    ]  # fmt: skip


def threshold(printed: Printed) -> float:
    """Power at which an unstressed wire begins to contract [W]."""
    system = bench.finger()
    slope = system.value_of("dsigma_dT")
    low = system.value_of("T_L") - system.value_of("sigma_L") / slope
    austenite = low + system.value_of("Delta_sigma") / slope
    return bench.surface_conductance(printed) * (austenite - printed.ambient)


def free_width(printed: Printed) -> float:
    """Width in power of a loop without any rates [W]."""
    system = bench.finger()
    across = system.value_of("Delta_sigma") / system.value_of("dsigma_dT")
    return bench.surface_conductance(printed) * across


def _heat(printed: Printed) -> list[Claim]:
    wire = bench.wire()
    per_kelvin = bench.surface_conductance(printed)
    constant = wire.heat_capacity_total() / per_kelvin
    found = [
        Claim.reported(
            f"steady-{watts:.1f}W", f"steady temperature at {watts:.1f} W in the 440 mm",
            HEAT, bench.steady(watts, printed), "K",
            f"T_E + P/(α S) is {printed.ambient + watts / per_kelvin:.1f} K; read as the power of "
            f"each half it would be {printed.ambient + 2.0 * watts / per_kelvin:.1f} K, beyond "
            "what such a wire stands, and both powers would then reach the full stroke at once",
        )
        for watts in printed.powers
    ]  # fmt: skip
    return [
        *found,
        Claim.reported(
            "time-constant", "time constant without transformation", HEAT, constant, "s",
            "ρ c d/(4 α), with a density of 6500 kg/m³, which the paper does not print",
        ),
        Claim.reported(
            "start-power", "power at which an unstressed wire begins to contract", HEAT,
            threshold(printed), "W",
            f"and {per_kelvin * 1e6 / bench.finger().value_of('dsigma_dT') * 1e3:.1f} mW more "
            "for every MPa: between the 1.4 W and nothing there is little room",
        ),
        Claim.reported(
            "free-width", "width of a loop without rates, in power", HEAT, free_width(printed),
            "W", "α S Δσ/(dσ/dT)",
        ),
    ]  # fmt: skip


def _law_number(name: str) -> float:
    return bench.finger().value_of(name)


def threshold_stress(temperature: float) -> float:
    """σ_A at a temperature [Pa]."""
    above = temperature - _law_number("T_L")
    return _law_number("sigma_L") + _law_number("dsigma_dT") * above


def loaded(temperature: float) -> PointResult:
    """To 5 % of strain and back, from austenite."""
    seconds = ALL_STRETCH / RATE
    legs = [Leg(strain=ALL_STRETCH, duration=seconds), Leg(strain=0.0, duration=seconds)]
    return material_point(
        bench.wire().law, legs, start=(0.0, temperature), steps=500,
        tolerance=1e-3, runtime=runtime(),
    )  # fmt: skip


def plateaus(path: PointResult, strain: float = 0.02) -> tuple[float, float]:
    """Stress at a strain on the way up and on the way down [Pa]."""
    half = path.ends[1]
    up = passing(path.stress[: half + 1], path.strain[: half + 1], strain)
    down = passing(path.stress[half:][::-1], path.strain[half:][::-1], strain)
    return up, down


def _plateaus() -> list[Claim]:
    found: list[Claim] = []
    for T in HOT:
        nominal = threshold_stress(T)
        up, down = (s / 1e6 for s in plateaus(loaded(T)))
        low = (nominal - _law_number("Delta_sigma")) / 1e6
        found.append(
            Claim.reported(
                f"plateau-{T:.0f}K",
                f"upper plateau at {T:.0f} K, 0.1 % per second",
                KINETICS,
                up,
                "MPa",
                f"the printed threshold is {nominal / 1e6:.0f} MPa; layers jump early by thermal "
                f"activation. Lower plateau {down:.1f} MPa, its threshold {low:.0f} MPa. Layer "
                "volume and time are not printed; they move both by 0.2 MPa per decade",
            )
        )
    return found


def stretched_cold(temperature: float) -> PointResult:
    """Twinned martensite to 5 % of strain, then unloaded."""
    seconds = ALL_STRETCH / RATE
    legs = [Leg(strain=ALL_STRETCH, duration=seconds), Leg(stress=0.0, duration=10.0)]
    return material_point(
        bench.wire().law, legs, start=(0.0, temperature), fractions=TWINNED, steps=500,
        tolerance=1e-3, runtime=runtime(),
    )  # fmt: skip


def _cold(printed: Printed) -> list[Claim]:
    path, half = stretched_cold(printed.ambient), 501
    plateau = passing(path.stress[:half], path.strain[:half], 0.02) / 1e6
    printed_threshold = threshold_stress(printed.ambient) / 1e6
    return [
        Claim.checked(
            "residual-strain", f"strain that stays after stretching at {printed.ambient:.0f} K",
            KINETICS, 100.0 * printed.eps_T, 100.0 * path.strain[-1], "%", 0.02,
            f"equation (4) at rest; the twins turn at {plateau:.1f} MPa, just below Δσ. Needs a "
            f"threshold limited at zero: by equation (6) it would be {printed_threshold:.0f} MPa",
        )
    ]  # fmt: skip


def _isobaric() -> list[Claim]:
    slope = _law_number("dsigma_dT")
    law, low = bench.wire().law, _law_number("T_L") - _law_number("sigma_L") / slope
    found: list[Claim] = []
    for stress in LOADS:
        legs = [Leg(temperature=400.0, duration=100.0), Leg(temperature=300.0, duration=100.0)]
        path = material_point(
            law, legs, start=(stress, 300.0), fractions=Fractions(1.0, 1.0), steps=1000,
            tolerance=1e-3, runtime=runtime(),
        )  # fmt: skip
        half = path.ends[1]
        level = 0.5 * (max(path.strain) + min(path.strain))
        hot = passing(path.temperature[: half + 1], [-x for x in path.strain[: half + 1]], -level)
        cold = passing(path.temperature[half:], path.strain[half:], level)
        nominal = low + (stress + _law_number("Delta_sigma")) / slope
        found.append(
            Claim.reported(
                f"heating-{stress / 1e6:.0f}MPa",
                f"temperature of half the contraction under {stress / 1e6:.0f} MPa, 1 K/s",
                KINETICS, hot, "K",
                f"the threshold is {nominal:.2f} K; on cooling {cold:.2f} K, its threshold "
                f"{low + stress / slope:.2f} K",
            )
        )  # fmt: skip
    return found


def _mounting(printed: Printed) -> list[Claim]:
    return [
        Claim.reported(
            "no-reference-strain", "stress at rest by equations (8) to (12) as printed",
            f"{PAPER}, equations (8) to (12)", -printed.E_M * printed.eps_T / 1e6, "MPa",
            "with σ = 0 at a strain of zero and the wire in martensite: the strain must count from "
            "a reference ε_T + σ₀/E_M, since the wire is mounted hot; nor may the wire push",
        )
    ]  # fmt: skip


def weight_stress(printed: Printed) -> float:
    """Stress at which the wire holds the second phalanx level, at the smallest r [Pa]."""
    length, side, gravity = printed.phalanx, printed.side, 9.80665
    torque = PLASTIC * length * side * side * gravity * 0.5 * length
    return torque / (2.0 * bench.wire().section() * min(printed.offsets))


def _weight(printed: Printed) -> list[Claim]:
    return [
        Claim.reported(
            "weight", f"stress that holds the phalanx up, r = {1e3 * min(printed.offsets):.1f} mm",
            f"{PAPER}, section 2.1", weight_stress(printed) / 1e6, "MPa",
            "solid ABS of 1040 kg/m³ (assumed), level; more than σ_M at either power, so the joint "
            "must turn in a horizontal plane, of which nothing is said",
        )
    ]  # fmt: skip
