"""Numbers of the wire alone: its heat balance, its thresholds, and implications of Table 1."""

from __future__ import annotations

from typing import Any

from martensite.physics.laws.base import Fractions
from martensite.simulate.point import PathLeg, PointResult, material_point
from martensite.studies.finger import bench
from martensite.studies.readings import choose_runtime, passing_time
from martensite.studies.tables import Printed

RATE = 1e-3
"""Strain rate of the plateaus [1/s]."""
TWINNED = Fractions(1.0, 0.0)
"""Martensite with equal variants."""
PLASTIC = 1040.0
"""Density of a printed phalanx, ABS [kg/m³]; not in the paper."""
HOT = (340.0, 355.0, 370.0)
"""Temperatures of the plateaus [K]."""
LOADS = (50e6, 150e6)
"""Stresses of the isobaric cycles [Pa]."""
ALL_STRETCH = 0.05
MEAN_KELVIN = 325.0
"""Temperature for the comparison of latent heat and slope [K]."""


def compute_wire(printed: Printed) -> dict[str, Any]:
    """Return heat, then law, then mounting."""
    per_kelvin = bench.surface_conductance(printed)
    path, half = stretched_cold(printed.ambient), 501
    rest = bench.run_bending(printed.powers[0], min(printed.offsets), printed)
    return {
        "steady": [
            {
                "watts": watts,
                "kelvin": bench.steady_temperature(watts, printed),
                "by_hand": printed.ambient + watts / per_kelvin,
                "per_half": printed.ambient + 2.0 * watts / per_kelvin,
            }
            for watts in printed.powers
        ],
        "time_constant": bench.get_wire().heat_capacity_total() / per_kelvin,
        "start_power": threshold_power(printed),
        "per_stress": per_kelvin * 1e6 / bench.build_finger().value_of("dsigma_dT") * 1e3,
        "free_width": free_width(printed),
        "plateaus": [_list_plateau(kelvin) for kelvin in HOT],
        "residual_strain": path.strain[-1],
        "cold_plateau": passing_time(path.stress[:half], path.strain[:half], 0.02) / 1e6,
        "cold_threshold": threshold_stress(printed.ambient) / 1e6,
        "cold_limit": max(0.0, threshold_stress(printed.ambient)) / 1e6,
        "isobars": [_list_isobar(stress) for stress in LOADS],
        "no_reference_strain": -printed.E_M * printed.eps_T / 1e6,
        "rest_stress": bench.column_at(rest, "stress", 0.0) / 1e6,
        "consistent_heat": MEAN_KELVIN * printed.eps_T * _law_number("dsigma_dT") / bench.get_wire().density,
        "mean_kelvin": MEAN_KELVIN,
        "least_r": 1e3 * min(printed.offsets),
        "weight": weight_stress(printed) / 1e6,
    }


def threshold_power(printed: Printed) -> float:
    """Return the power at which an unstressed wire begins to contract [W]."""
    system = bench.build_finger()
    slope = system.value_of("dsigma_dT")
    low = system.value_of("T_L") - system.value_of("sigma_L") / slope
    austenite = low + system.value_of("Delta_sigma") / slope
    return bench.surface_conductance(printed) * (austenite - printed.ambient)


def free_width(printed: Printed) -> float:
    """Return the width in power of a rate-independent loop [W]."""
    system = bench.build_finger()
    across = system.value_of("Delta_sigma") / system.value_of("dsigma_dT")
    return bench.surface_conductance(printed) * across


def _law_number(name: str) -> float:
    return bench.build_finger().value_of(name)


def threshold_stress(temperature: float) -> float:
    """Return σ_A at a temperature [Pa]."""
    above = temperature - _law_number("T_L")
    return _law_number("sigma_L") + _law_number("dsigma_dT") * above


def load_wire(temperature: float) -> PointResult:
    """Return a path to 5 % strain and back, from austenite."""
    seconds = ALL_STRETCH / RATE
    legs = [PathLeg(strain=ALL_STRETCH, duration=seconds), PathLeg(strain=0.0, duration=seconds)]
    return material_point(
        bench.get_wire().law, legs, start=(0.0, temperature), steps=500, tolerance=1e-3, runtime=choose_runtime()
    )


def plateau_stresses(path: PointResult, strain: float = 0.02) -> tuple[float, float]:
    """Return the stress at a strain on loading and on unloading [Pa]."""
    half = path.ends[1]
    up = passing_time(path.stress[: half + 1], path.strain[: half + 1], strain)
    down = passing_time(path.stress[half:][::-1], path.strain[half:][::-1], strain)
    return up, down


def _list_plateau(kelvin: float) -> dict[str, float]:
    nominal = threshold_stress(kelvin)
    upper, lower = (stress / 1e6 for stress in plateau_stresses(load_wire(kelvin)))
    low = (nominal - _law_number("Delta_sigma")) / 1e6
    return {"kelvin": kelvin, "upper": upper, "lower": lower, "nominal": nominal / 1e6, "nominal_low": low}


def stretched_cold(temperature: float) -> PointResult:
    """Return a path of twinned martensite to 5 % strain, then unloaded."""
    seconds = ALL_STRETCH / RATE
    legs = [PathLeg(strain=ALL_STRETCH, duration=seconds), PathLeg(stress=0.0, duration=10.0)]
    return material_point(
        bench.get_wire().law,
        legs,
        start=(0.0, temperature),
        fractions=TWINNED,
        steps=500,
        tolerance=1e-3,
        runtime=choose_runtime(),
    )


def _list_isobar(stress: float) -> dict[str, float]:
    """Return the temperatures of half the contraction under a stress [Pa], and their thresholds [K]."""
    slope = _law_number("dsigma_dT")
    low = _law_number("T_L") - _law_number("sigma_L") / slope
    legs = [PathLeg(temperature=400.0, duration=100.0), PathLeg(temperature=300.0, duration=100.0)]
    path = material_point(
        bench.get_wire().law,
        legs,
        start=(stress, 300.0),
        fractions=Fractions(1.0, 1.0),
        steps=1000,
        tolerance=1e-3,
        runtime=choose_runtime(),
    )
    half, level = path.ends[1], 0.5 * (max(path.strain) + min(path.strain))
    shortening = [-strain for strain in path.strain[: half + 1]]
    return {
        "load": stress / 1e6,
        "hot": passing_time(path.temperature[: half + 1], shortening, -level),
        "cold": passing_time(path.temperature[half:], path.strain[half:], level),
        "hot_threshold": low + (stress + _law_number("Delta_sigma")) / slope,
        "cold_threshold": low + stress / slope,
    }


def weight_stress(printed: Printed) -> float:
    """Return the stress at which the wire holds the second phalanx level, at the smallest r [Pa]."""
    length, side, gravity = printed.phalanx, printed.side, 9.80665
    torque = PLASTIC * length * side * side * gravity * 0.5 * length
    return torque / (2.0 * bench.get_wire().section() * min(printed.offsets))
