"""Claims on the platform and its springs at rest: geometry, stroke, reach, mass, vibration."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

from martensite.mechanisms.shared.platform_inertia import thin_plate
from martensite.mechanisms.shared.platform_kinematics import corners, platform_lengths, slopes
from martensite.mechanisms.shared.platform_workspace import Workspace, reachable_angles
from martensite.runtimes import floats
from martensite.studies.base import Claim
from martensite.studies.platform import bench
from martensite.studies.platform.printed import PAPER, Printed

GEOMETRY = f"{PAPER}, section 3.1 and Table 1"
DYNAMICS = f"{PAPER}, section 3.2, equations (3) and (4)"
RESULTS = f"{PAPER}, section 4"
SHORTEST, LONGEST = 0.030, 0.090
"""Lengths of springs between which the reach is asked for [m]: assumed."""

DENSITY = 6450.0
"""Of nickel-titanium [kg/m³]."""


def claims(printed: Printed) -> list[Claim]:
    """Geometry first, then the stroke of one spring, the reach, and vibration."""
    return [*_geometry(printed), *_stroke(printed), *_reach(printed), *_plate(printed)]


def lengths_at(printed: Printed, degrees: float) -> Sequence[float]:
    """Lengths [m] of the springs at a rotation about X."""
    return platform_lengths(bench.platform(printed).plates(), math.radians(degrees), 0.0)


@cache
def end_of_one_spring(printed: Printed) -> tuple[float, float]:
    """Contraction [m] and angle [°] of one hot spring against two cold ones."""
    result = bench.heated(bench.AS_PRINTED, printed, printed.high, 12.0)
    turned = result["alpha"][-1]
    return bench.platform(printed).contraction(floats, [turned, 0.0])[0], math.degrees(turned)


@cache
def workspace(printed: Printed) -> Workspace:
    """Postures with springs of 30 to 90 mm."""
    plates = bench.platform(printed).plates()
    return reachable_angles(plates, SHORTEST, LONGEST)


def natural_frequency(printed: Printed) -> float:
    """Of small vibrations about any axis, all springs cold [Hz]."""
    plates, spring = bench.platform(printed).plates(), bench.spring(bench.AS_PRINTED, printed)
    rate = 1.0 / spring.spring(floats, spring.initial_fractions(), 298.15, 1.0).compliance
    _, levers, _ = slopes(floats, plates, 0.0, 0.0)
    inertia = thin_plate(plates, printed.plate_mass).inertia
    return math.sqrt(rate * sum(lever**2 for lever in levers) / inertia) / (2.0 * math.pi)


def _geometry(printed: Printed) -> list[Claim]:
    (x, y), (_, near), _ = corners(printed.side)
    rows = {degrees: lengths_at(printed, degrees) for degrees in (printed.angle, printed.target)}
    return [
        Claim.checked(
            "centroid", "distance of the centroid from a side", GEOMETRY,
            1e3 * printed.centroid, -1e3 * near, "mm", 0.05, "s/(2 √3)",
        ),
        Claim.checked(
            "lever", "the same number is the lever r \"from vertex to centroid\"", DYNAMICS,
            1e3 * printed.centroid, 1e3 * math.hypot(x, y), "mm", 0.05,
            "that is s/√3: the hot spring acts at 57.7 mm, the two cold ones at 28.9 mm",
        ),
        *(
            Claim.reported(
                f"length-{degrees:.0f}-{name}", f"{name} spring at {degrees:.0f}° about X",
                GEOMETRY, 1e3 * length, "mm",
                "equation (2) gives a vector without the distance of the plates; this is the "
                "length of the whole one",
            )
            for degrees, found in rows.items()
            for name, length in zip(("hot", "cold"), found, strict=False)
        ),
    ]  # fmt: skip


def _stroke(printed: Printed) -> list[Claim]:
    contraction, angle = end_of_one_spring(printed)
    spring = bench.spring(bench.AS_PRINTED, printed)
    hot, cold = (g / (8.0 * spring.index() ** 3 * printed.turns) * printed.diameter
                 for g in (printed.G_A, printed.G_M))  # fmt: skip
    wide = (spring.mean_diameter() / printed.coil_diameter) ** 3
    mass = spring.with_values({"density": DENSITY}).mass()
    return [
        Claim.checked(
            "contraction", "complete contraction of a spring", RESULTS,
            1e3 * printed.contraction, 1e3 * contraction, "mm", 1.0,
            "fully hot against two cold springs; nothing is fitted: springs free of force as "
            "assembled at 60 mm, and hot when closed at 15 mm",
        ),
        Claim.reported(
            "full-angle", "rotation about X with one spring fully hot", RESULTS, angle, "deg",
            "the paper asks for 30°",
        ),
        Claim.checked(
            "spring-mass", "mass of a spring", f"{PAPER}, Table 1",
            1e3 * printed.spring_mass, 1e3 * mass, "g", 0.1,
            f"20 turns of 0.75 mm wire at {DENSITY:g} kg/m³",
        ),
        Claim.reported(
            "rate-cold", "rate of a cold spring, 6 mm over all", f"{PAPER}, Table 1", cold, "N/m",
            f"hot: {hot:.1f} N/m; were 6 mm the mean diameter, {wide * cold:.1f} and "
            f"{wide * hot:.1f} N/m",
        ),
    ]  # fmt: skip


def _reach(printed: Printed) -> list[Claim]:
    found = workspace(printed)
    plates = found.legs.plates
    x, y = (math.radians(printed.angle),) * 2
    straight = platform_lengths(plates, x, y)
    swapped = _swapped(plates.side, plates.height, x, y)
    most = max(abs(a - b) for a, b in zip(straight, swapped, strict=True))
    why = f"springs of {1e3 * SHORTEST:.0f} to {1e3 * LONGEST:.0f} mm: assumed"
    ends = [tuple(math.degrees(angle) for angle in ray[-1]) for ray in found.rays]
    return [
        *(
            Claim.reported(
                f"reach-{name}", f"{words} about {axis} alone", GEOMETRY, math.degrees(angle),
                "deg", why,
            )
            for axis, extent, kind in (
                ("X", found.alpha_extent, "alpha"), ("Y", found.beta_extent, "beta"),
            )
            for name, words, angle in (
                (f"{kind}-low", "smallest rotation", extent[0]),
                (f"{kind}-high", "largest rotation", extent[1]),
            )
        ),
        Claim.reported(
            "one-at-a-time", "direction between the rays of single springs", RESULTS,
            math.degrees(math.atan2(found.rays[1][1][1], found.rays[1][1][0])), "deg",
            "one hot spring at a time, as in the paper, reaches three curves only, ending at "
            + ", ".join(f"({a:.1f}°, {b:.1f}°)" for a, b in ends)
            + "; rotations about Y alone need two",
        ),
        Claim.reported(
            "rotation-order", "largest change of a length if the order of rotations is swapped",
            f"{PAPER}, equation (1)", 1e3 * most, "mm",
            f"at {printed.angle:.0f}° about both axes; the order printed is kept",
        ),
    ]  # fmt: skip


def _swapped(side: float, height: float, alpha: float, beta: float) -> list[float]:
    """Lengths [m] with R_X(α) R_Y(β) in place of R_Y(β) R_X(α), joint in the plate."""
    found: list[float] = []
    for x, y in corners(side):
        over, down = math.cos(beta) * x, -math.sin(beta) * x
        along = math.cos(alpha) * y - math.sin(alpha) * down
        drop = math.sin(alpha) * y + math.cos(alpha) * down
        found.append(math.sqrt((over - x) ** 2 + (along - y) ** 2 + (drop - height) ** 2))
    return found


def _plate(printed: Printed) -> list[Claim]:
    frequency = natural_frequency(printed)
    inertia = thin_plate(bench.platform(printed).plates(), printed.plate_mass).inertia
    area = printed.side * (0.5 * math.sqrt(3.0) * printed.side) ** 3 / 12.0
    return [
        Claim.reported(
            "inertia", "moment of inertia of the plate about an axis in it", DYNAMICS,
            inertia, "kg*m^2",
            f"M s²/24; equation (4) gives {area:.2g} m⁴, the second moment of the triangle's "
            "area about a side",
        ),
        Claim.reported(
            "natural-frequency", "natural frequency of the plate on three cold springs", DYNAMICS,
            frequency, "Hz",
            f"one period is {1e3 / frequency:.0f} ms where the responses take seconds: inertia "
            "is not what overshoots",
        ),
    ]  # fmt: skip
