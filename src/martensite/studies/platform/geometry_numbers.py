"""Static numbers of the platform and its springs: geometry, stroke, reach, mass, vibration."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

from martensite.actuators.mechanics.platform_kinematics import compute_length_slopes, locate_corners, platform_lengths
from martensite.actuators.mechanisms.parallel_platform import thin_plate
from martensite.kernels import floats
from martensite.studies.platform import bench
from martensite.studies.platform.workspace import Workspace, reachable_angles
from martensite.studies.tables import Printed

SHORTEST, LONGEST = 0.030, 0.090
"""Assumed range of spring lengths for the reach [m]."""

DENSITY = 6450.0


def compute_geometry(printed: Printed) -> dict[str, Any]:
    """Return the geometry, then stroke, reach, and vibration."""
    (x, y), (_, near), _ = locate_corners(printed.side)
    frequency = natural_frequency(printed)
    return {
        "centroid": -near,
        "lever": math.hypot(x, y),
        "lengths": [
            {"degrees": degrees, "name": name, "length": 1e3 * length}
            for degrees in (printed.angle, printed.target)
            for name, length in zip(("hot", "cold"), lengths_at(printed, degrees), strict=False)
        ],
        **compute_stroke(printed),
        **compute_reach(printed),
        "inertia": thin_plate(bench.build_platform(printed).plates(), printed.plate_mass).inertia,
        "area": printed.side * (0.5 * math.sqrt(3.0) * printed.side) ** 3 / 12.0,
        "natural_frequency": frequency,
        "period": 1e3 / frequency,
    }


def lengths_at(printed: Printed, degrees: float) -> Sequence[float]:
    """Return the lengths [m] of the springs at a rotation about X."""
    return platform_lengths(bench.build_platform(printed).plates(), math.radians(degrees), 0.0)


@cache
def end_of_one_spring(printed: Printed) -> tuple[float, float]:
    """Return contraction [m] and angle [°] of one hot spring against two cold ones."""
    result = bench.run_heated(bench.AS_PRINTED, printed, printed.high, 12.0)
    turned = result["alpha"][-1]
    return bench.build_platform(printed).contraction(floats, [turned, 0.0])[0], math.degrees(turned)


@cache
def find_workspace(printed: Printed) -> Workspace:
    """Return the postures with springs of 30 to 90 mm."""
    plates = bench.build_platform(printed).plates()
    return reachable_angles(plates, SHORTEST, LONGEST)


def natural_frequency(printed: Printed) -> float:
    """Return the frequency of small vibrations about any axis with cold springs [Hz]."""
    plates, spring = (bench.build_platform(printed).plates(), bench.build_spring(bench.AS_PRINTED, printed))
    rate = 1.0 / spring.spring(floats, spring.initial_fractions(floats, 0.0), 298.15, 1.0).compliance
    _, levers, _ = compute_length_slopes(floats, plates, 0.0, 0.0)
    inertia = thin_plate(plates, printed.plate_mass).inertia
    return math.sqrt(rate * sum(lever**2 for lever in levers) / inertia) / (2.0 * math.pi)


def compute_stroke(printed: Printed) -> dict[str, float]:
    """Return stroke, mass and rates of one spring."""
    contraction, angle = end_of_one_spring(printed)
    spring = bench.build_spring(bench.AS_PRINTED, printed)
    hot, cold = (g / (8.0 * spring.index() ** 3 * printed.turns) * printed.diameter for g in (printed.G_A, printed.G_M))
    wide = (spring.mean_diameter() / printed.coil_diameter) ** 3
    return {
        "contraction": contraction,
        "full_angle": angle,
        "density": DENSITY,
        "spring_mass": spring.with_values({"density": DENSITY}).mass(),
        "rate_cold": cold,
        "rate_hot": hot,
        "wide_cold": wide * cold,
        "wide_hot": wide * hot,
    }


def compute_reach(printed: Printed) -> dict[str, Any]:
    """Return the reachable rotations, and the effect of the order of rotations."""
    workspace = find_workspace(printed)
    plates = workspace.legs.plates
    x, y = (math.radians(printed.angle),) * 2
    straight = platform_lengths(plates, x, y)
    swapped = _swap_rotations(plates.side, plates.height, x, y)
    ends = [tuple(math.degrees(angle) for angle in ray[-1]) for ray in workspace.rays]
    extents = {"alpha": workspace.alpha_extent, "beta": workspace.beta_extent}
    return {
        "shortest": 1e3 * SHORTEST,
        "longest": 1e3 * LONGEST,
        **{f"reach_{name}_low": math.degrees(extent[0]) for name, extent in extents.items()},
        **{f"reach_{name}_high": math.degrees(extent[1]) for name, extent in extents.items()},
        "one_at_a_time": math.degrees(math.atan2(workspace.rays[1][1][1], workspace.rays[1][1][0])),
        "ray_ends": ", ".join(f"({a:.1f}°, {b:.1f}°)" for a, b in ends),
        "rotation_order": 1e3 * max(abs(a - b) for a, b in zip(straight, swapped, strict=True)),
    }


def _swap_rotations(side: float, height: float, alpha: float, beta: float) -> list[float]:
    """Return the lengths [m] with R_X(α) R_Y(β) instead of R_Y(β) R_X(α), joint in the plate."""
    lengths: list[float] = []
    for x, y in locate_corners(side):
        over, down = math.cos(beta) * x, -math.sin(beta) * x
        along = math.cos(alpha) * y - math.sin(alpha) * down
        drop = math.sin(alpha) * y + math.cos(alpha) * down
        lengths.append(math.sqrt((over - x) ** 2 + (along - y) ** 2 + (drop - height) ** 2))
    return lengths
