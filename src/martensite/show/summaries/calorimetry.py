"""Summary of a calorimeter's ramps."""

from __future__ import annotations

import math
from collections.abc import Iterator

from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.characterise.calorimetry import Calorimetry
from martensite.characterise.estimate import MeasuredValue
from martensite.characterise.heat_peaks import RampPeaks

ZERO = 273.15
RAMPS = ("ramp", "peak [degC]", "onset [degC]", "endset [degC]", "area [J/g]", "record")
MEANINGS = {
    "A_s": "austenite start",
    "A_f": "austenite finish",
    "M_s": "martensite start",
    "M_f": "martensite finish",
    "R_s": "R-phase start on cooling",
    "R_f": "R-phase finish on cooling",
}


def summarise_calorimetry(calorimetry: Calorimetry) -> Summary:
    """Return the summary of DSC ramps: temperatures, latent heat, one row per peak, and remarks."""
    rows = [row for one in calorimetry.ramps for row in _list_rows(one)]
    blocks: list[Block] = [
        DataTable(("quantity", "value", "95 % interval", "meaning"), list(_list_values(calorimetry)), right=(1, 2)),
        DataTable(RAMPS, rows, right=range(1, 5)),
        Sentence(
            f"Baseline: {calorimetry.baseline} (`--baseline`). "
            "Tangents at the steepest rows of both flanks, ASTM F2004."
        ),
    ]
    if calorimetry.at_zero_rate:
        blocks.append(Sentence("Temperatures are extrapolated to rate 0 along a straight line."))
    if calorimetry.assumed_unit:
        blocks.append(
            Sentence(
                f"The file has no unit of the heat flow: {calorimetry.assumed_unit} is assumed, and areas follow from "
                "it. Give it by `--as COLUMN=heat_flow[W/g]`, or `[mW]` with `--mass`.",
                "caution",
            )
        )
    blocks += [Sentence(text, "caution") for text in calorimetry.remarks]
    return Summary(_write_title(calorimetry), blocks, calorimetry.to_dict())


def _write_title(calorimetry: Calorimetry) -> str:
    parts = [f"{name} {one.value - ZERO:.1f}" for name, one in calorimetry.values.items()]
    heat = "" if calorimetry.latent_heat is None else f", latent heat {1e-3 * calorimetry.latent_heat.value:.3g} J/g"
    return f"DSC: {', '.join(parts)} degC{heat}"


def _list_values(calorimetry: Calorimetry) -> Iterator[tuple[str, ...]]:
    for name, one in calorimetry.values.items():
        yield _write_row(name, one, 1.0, ZERO, "degC", MEANINGS[name], 1)
    if calorimetry.latent_heat is not None:
        per = f", per assumed {calorimetry.assumed_unit}" if calorimetry.assumed_unit else ""
        yield _write_row("latent heat", calorimetry.latent_heat, 1e3, 0.0, "J/g", f"mean area of all ramps{per}", 2)
    for name, one in calorimetry.heat_capacity.items():
        phase = {"A": "austenite", "M": "martensite"}[name]
        yield _write_row(f"c_{name}", one, 1.0, 0.0, "J/kg/K", f"heat capacity of {phase}", 0)


def _write_row(
    name: str, one: MeasuredValue, size: float, zero: float, unit: str, meaning: str, digits: int
) -> tuple[str, ...]:
    low, high = ((x - zero) / size for x in one.interval())
    is_finite = math.isfinite(low) and math.isfinite(high)
    interval = f"{low:.{digits}f} to {high:.{digits}f}" if is_finite else "not estimated"
    return name, f"{(one.value - zero) / size:.{digits}f} {unit}", interval, meaning


def _list_rows(one: RampPeaks) -> Iterator[tuple[str, ...]]:
    """Yield one row per peak; onset and endset in the direction of the ramp."""
    peaks = one.peaks if one.ramp.is_heating else one.peaks[::-1]
    for peak in peaks:
        ends = (peak.low, peak.high) if one.ramp.is_heating else (peak.high, peak.low)
        kelvin = (f"{x - ZERO:.1f}" for x in (peak.peak, *ends))
        yield one.ramp.label, *kelvin, f"{1e-3 * peak.enthalpy:.2f}", one.ramp.name
