"""Numbers of the crystal: one against many with spread barriers, at intermediate powers.

The paper blames the errors of its model, which it does not show, on its single crystal. Without
the measured angles that can be compared with a polycrystal only.
"""

from __future__ import annotations

from typing import Any

from martensite.studies.finger import bench
from martensite.studies.tables import Printed

MIDDLE = (1.0, 1.2, 1.3, 1.4, 1.6, 1.8)
"""Powers at which both crystals are compared [W]."""
OUTER_ARM = 12e-3
"""A place of the spring at which intermediate powers lie between those of the paper [m]."""


def compute_crystal(printed: Printed) -> dict[str, Any]:
    """Return the angles of a polycrystal, then both crystals at intermediate powers."""
    return {
        "middle_r": 1e3 * printed.offsets[1],
        "polycrystal": [_list_polycrystal(watts, printed) for watts in printed.powers],
        "apart": [_list_difference(printed, "crystals", None), _list_difference(printed, "crystals-12mm", OUTER_ARM)],
    }


def _list_polycrystal(watts: float, printed: Printed) -> dict[str, Any]:
    """Return the angles of a polycrystal at all r."""
    angles = [
        bench.top_angle(bench.run_bending(watts, r, printed, None, bench.POLYCRYSTAL), printed) for r in printed.offsets
    ]
    listed = ", ".join(f"{angle:.1f}°" for angle in angles)
    return {"watts": watts, "angle": angles[1], "listed": listed}


def _list_difference(printed: Printed, name: str, arm: float | None) -> dict[str, Any]:
    """Return both crystals at intermediate powers."""
    apart = {watts: crystal_difference(watts, printed, arm) for watts in MIDDLE}
    worst = max(apart, key=lambda watts: abs(apart[watts]))
    return {
        "name": name,
        "watts": worst,
        "difference": apart[worst],
        "arm": 1e3 * (arm or bench.build_finger().value_of("mechanism.arm")),
        "listed": ", ".join(f"{d:+.1f}° at {watts:.1f} W" for watts, d in apart.items()),
    }


def crystal_difference(watts: float, printed: Printed, arm: float | None = None) -> float:
    """Return the angle of the single crystal less that of the polycrystal at r = 3.5 mm [°]."""
    single, many = (
        bench.top_angle(bench.run_bending(watts, printed.offsets[1], printed, arm, law), printed)
        for law in (bench.SINGLE, bench.POLYCRYSTAL)
    )
    return single - many
