"""Numbers of the crystal: single crystal and polycrystal with spread barriers, at intermediate powers.

The paper blames its single crystal for model errors that it does not show.
"""

from __future__ import annotations

from typing import Any

from martensite.studies.finger import bench
from martensite.studies.tables import Printed

MIDDLE = (1.0, 1.2, 1.3, 1.4, 1.6, 1.8)
"""Powers of the comparison [W]."""
OUTER_ARM = 12e-3
"""Place of the spring at which intermediate powers lie between those of the paper [m]."""


def compute_crystal(printed: Printed) -> dict[str, Any]:
    """Return the angles of a polycrystal, then both crystals at intermediate powers."""
    return {
        "middle_r": 1e3 * printed.offsets[1],
        "polycrystal": [_list_polycrystal(watts, printed) for watts in printed.powers],
        "apart": [_list_difference(printed, "crystals", None), _list_difference(printed, "crystals-12mm", OUTER_ARM)],
    }


def _list_polycrystal(watts: float, printed: Printed) -> dict[str, Any]:
    angles = [
        bench.top_angle(bench.run_bending(watts, r, printed, None, bench.POLYCRYSTAL), printed) for r in printed.offsets
    ]
    listed = ", ".join(f"{angle:.1f}°" for angle in angles)
    return {"watts": watts, "angle": angles[1], "listed": listed}


def _list_difference(printed: Printed, name: str, arm: float | None) -> dict[str, Any]:
    differences = {watts: crystal_difference(watts, printed, arm) for watts in MIDDLE}
    worst = max(differences, key=lambda watts: abs(differences[watts]))
    return {
        "name": name,
        "watts": worst,
        "difference": differences[worst],
        "arm": 1e3 * (arm or bench.build_finger().value_of("mechanism.arm")),
        "listed": ", ".join(f"{d:+.1f}° at {watts:.1f} W" for watts, d in differences.items()),
    }


def crystal_difference(watts: float, printed: Printed, arm: float | None = None) -> float:
    """Return the angle of the single crystal less that of the polycrystal at r = 3.5 mm [°]."""
    single, many = (
        bench.top_angle(bench.run_bending(watts, printed.offsets[1], printed, arm, law), printed)
        for law in (bench.SINGLE, bench.POLYCRYSTAL)
    )
    return single - many
