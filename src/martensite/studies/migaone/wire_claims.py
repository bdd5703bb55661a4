"""Claims on the wire itself: the geometry of Table 1, and the resistance behind Table 2.

Table 1 prints a diameter of 0.038 mm where the text has 0.015 inch, 0.381 mm. Surface and
volume were computed from the misprint: they are too small by 10 and by 100.
"""

from __future__ import annotations

import math

from martensite.studies.base import Claim
from martensite.studies.migaone import bench
from martensite.studies.migaone.printed import PAPER, Printed

TABLE_1 = f"{PAPER}, Table 1"
TABLE_2 = f"{PAPER}, Table 2 and section 4.1"


def claims(printed: Printed) -> list[Claim]:
    """Geometry first, then resistance."""
    return [*_geometry(printed), *_resistance(printed)]


def printed_length(printed: Printed) -> float:
    """Length of wire that gives the printed surface with the printed diameter [m]."""
    return printed.surface / (math.pi * printed.diameter)


def series_resistance(voltage: float, printed: Printed) -> float:
    """What must stand in series with the quoted resistance for the powers of Table 2 [ohm]."""
    power = voltage**2 / bench.equivalent_resistance(voltage, printed)
    return voltage / math.sqrt(power / printed.resistance) - printed.resistance


def _geometry(printed: Printed) -> list[Claim]:
    length, wrong, right = printed_length(printed), printed.diameter, printed.diameter_in_text
    surface, volume = math.pi * right * length, 0.25 * math.pi * right**2 * length
    return [
        Claim.checked(
            "geometry-diameter", "the wire is 0.038 mm thick", TABLE_1,
            1e3 * wrong, 1e3 * right, "mm", 0.0005,
            "section 4.1 of the same paper quotes the maker: 0.015 inch",
        ),
        Claim.calibrated(
            "geometry-length", "length of the wire, which is not printed", TABLE_1,
            None, length, "m", "chosen to give the printed surface with the printed diameter",
        ),
        Claim.checked(
            "geometry-volume-misprint", "volume follows from the diameter of 0.038 mm", TABLE_1,
            printed.volume, 0.25 * math.pi * wrong**2 * length, "m^3", 0.005e-10,
            "surface and volume agree on one length if both were computed from 0.038 mm",
        ),
        Claim.checked(
            "geometry-surface", "surface of the wire", TABLE_1,
            printed.surface, surface, "m^2", 0.005e-5,
            f"a wire of 0.381 mm has {surface / printed.surface:.1f} times the printed surface",
        ),
        Claim.checked(
            "geometry-volume", "volume of the wire", TABLE_1,
            printed.volume, volume, "m^3", 0.005e-10,
            f"a wire of 0.381 mm has {volume / printed.volume:.0f} times the printed volume",
        ),
    ]  # fmt: skip


def _resistance(printed: Printed) -> list[Claim]:
    first, last = printed.steps[0].voltage, printed.steps[-1].voltage
    missing = series_resistance(first, printed)
    return [
        *(
            Claim.checked(
                f"resistance-{volt:.1f}V", f"a step of {volt:.1f} V heats 2.7 ohm", TABLE_2,
                printed.resistance, bench.equivalent_resistance(volt, printed), "ohm", 0.3,
                "V²/[h S (T_ss - T_a)] with the right surface; the rest of the voltage drops "
                "elsewhere, in the amplifier or leads, of which nothing is said",
            )
            for volt in (first, last)
        ),
        Claim.calibrated(
            "resistance-series", "resistance in series with the wire, which is not printed",
            TABLE_2, None, series_resistance(last, printed), "ohm",
            f"chosen to heat 2.7 ohm at {last:.1f} V with the power behind Table 2; at "
            f"{first:.1f} V it would have to be {missing:.2f} ohm",
        ),
    ]  # fmt: skip
