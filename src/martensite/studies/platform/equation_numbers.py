"""Numbers of the printed equations of the spring, where the result is known."""

from __future__ import annotations

import math

from martensite.studies.platform import bench
from martensite.studies.tables import Printed


def compute_equation(printed: Printed) -> dict[str, float]:
    """Return kinetics, then resistance."""
    spring = bench.build_spring(bench.AS_PRINTED, printed)
    shape = spring.section() / spring.wire_length()
    return {
        "eq8_finish": equation_8(printed, printed.M_f),
        "eq8_start": equation_8(printed, printed.M_s),
        "martensite": correct_equation_8(printed, printed.M_f),
        "resistivity_hot": printed.R_A * shape,
        "resistivity_cold": 1e6 * printed.R_M * shape,
    }


def equation_8(printed: Printed, temperature: float, fraction: float = 0.0) -> float:
    """Return ξ as printed at a temperature [°C] without stress, from an earlier fraction ξ_A."""
    cosine = math.cos(math.pi * (temperature - printed.M_f) / (printed.M_s - printed.M_f))
    return 0.5 * (1.0 - fraction) * (cosine + 0.5 * (1.0 + fraction))


def correct_equation_8(printed: Printed, temperature: float, fraction: float = 0.0) -> float:
    """Return equation 8 with its bracket around the cosine alone."""
    cosine = math.cos(math.pi * (temperature - printed.M_f) / (printed.M_s - printed.M_f))
    return 0.5 * (1.0 - fraction) * cosine + 0.5 * (1.0 + fraction)
