"""Numbers of the wire: the geometry of Table 1, and the resistance implied by Table 2.

Table 1 prints a diameter of 0.038 mm, but the text 0.015 inch, 0.381 mm. Surface and volume follow from the misprint:
they are too small by 10 and by 100.
"""

from __future__ import annotations

import math
from typing import Any

from martensite.studies.migaone import bench
from martensite.studies.tables import Printed


def compute_wire(printed: Printed) -> dict[str, Any]:
    """Return geometry, then resistance."""
    length, wrong, right = printed_length(printed), printed.diameter, printed.diameter_in_text
    surface, volume = math.pi * right * length, 0.25 * math.pi * right**2 * length
    first, last = printed.steps[0].voltage, printed.steps[-1].voltage
    return {
        "length": length,
        "geometry_volume_misprint": 0.25 * math.pi * wrong**2 * length,
        "geometry_surface": surface,
        "surface_ratio": surface / printed.surface,
        "geometry_volume": volume,
        "volume_ratio": volume / printed.volume,
        "first": first,
        "last": last,
        "resistance_first": bench.equivalent_resistance(first, printed),
        "resistance_last": bench.equivalent_resistance(last, printed),
        "resistance_series": series_resistance(last, printed),
        "series_first": series_resistance(first, printed),
    }


def printed_length(printed: Printed) -> float:
    """Return the length that gives the printed surface with the printed diameter [m]."""
    return printed.surface / (math.pi * printed.diameter)


def series_resistance(voltage: float, printed: Printed) -> float:
    """Return the series resistance that, with the quoted resistance, gives the powers of Table 2 [ohm]."""
    power = voltage**2 / bench.equivalent_resistance(voltage, printed)
    return voltage / math.sqrt(power / printed.resistance) - printed.resistance
