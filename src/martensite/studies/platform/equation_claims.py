"""Claims on the equations of the spring as printed: what they give where the answer is known."""

from __future__ import annotations

import math

from martensite.studies.base import Claim
from martensite.studies.platform import bench
from martensite.studies.platform.printed import PAPER, Printed

KINETICS = f"{PAPER}, equation (8)"
TABLE_1 = f"{PAPER}, Table 1"


def claims(printed: Printed) -> list[Claim]:
    """Kinetics, then resistance."""
    why = "the bracket of (8) encloses the last term too; (1 - ξ_A)/2 cos[…] + (1 + ξ_A)/2 is right"
    spring = bench.spring(bench.AS_PRINTED, printed)
    shape = spring.section() / spring.wire_length()
    return [
        Claim.checked(
            "eq8-finish", "martensite fraction at M_f on cooling from austenite", KINETICS,
            1.0, equation_8(printed, printed.M_f), "1", 0.01, why,
        ),
        Claim.checked(
            "eq8-start", "martensite fraction at M_s on cooling from austenite", KINETICS,
            0.0, equation_8(printed, printed.M_s), "1", 0.01, why,
        ),
        Claim.reported(
            "resistivity-hot", "resistivity of austenite behind the printed resistance", TABLE_1,
            printed.R_A * shape, "ohm*m",
            f"cold: {1e6 * printed.R_M * shape:.3f} µΩ m; the text after equation (6) swaps the "
            "two phases, the table does not",
        ),
    ]  # fmt: skip


def equation_8(printed: Printed, temperature: float, fraction: float = 0.0) -> float:
    """ξ as printed at a temperature [°C] without stress, from an earlier fraction ξ_A."""
    cosine = math.cos(math.pi * (temperature - printed.M_f) / (printed.M_s - printed.M_f))
    return 0.5 * (1.0 - fraction) * (cosine + 0.5 * (1.0 + fraction))
