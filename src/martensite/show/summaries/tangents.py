"""Isobaric cycles by tangents: the points of every cycle, and what they say together."""

from __future__ import annotations

import math

from martensite.base.confidence import Interval
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.characterise.estimate import MeasuredValue
from martensite.characterise.tangent_fit import TangentFit
from martensite.characterise.tangent_points import TangentPoints

ZERO = 273.15
"""0 °C [K]."""
POINTS = (
    "stress [MPa]",
    "A_s [degC]",
    "A_f",
    "half",
    "M_s [degC]",
    "M_f",
    "half",
    "H [%]",
    "residual [%]",
    "stroke [%]",
    "log",
)
FOUND = ("quantity", "value", "95 % interval", "unit", "meaning")


def summarise_tangents(found: TangentFit | TangentPoints) -> Summary:
    """Everything about one cycle, or about several together."""
    levels = found.levels if isinstance(found, TangentFit) else [found]
    title = f"Tangents of {len(levels)} isobaric cycle{'s' * (len(levels) > 1)}"
    blocks: list[Block] = [DataTable(POINTS, [_point_row(one) for one in levels], right=range(len(POINTS) - 1))]
    if isinstance(found, TangentFit):
        blocks.append(DataTable(FOUND, list(_estimate_rows(found)), right=(1, 2)))
        data = found.to_dict()
    else:
        told = "C_A, C_M and temperatures at zero stress need cycles at two or more stresses."
        blocks.append(Sentence(told))
        data = {"levels": [found.to_dict()]}
    blocks += [Sentence(remark, "caution") for remark in found.remarks]
    return Summary(title, blocks, data)


def _point_row(points: TangentPoints) -> tuple[str, ...]:
    temperatures = (f"{getattr(points, name) - ZERO:.2f}" for name in ("A_s", "A_f", "A_half", "M_s", "M_f", "M_half"))
    strains = (f"{100.0 * e:.3f}" for e in (points.H, points.residual_strain, points.stroke))
    return (f"{points.stress / 1e6:.4g}", *temperatures, *strains, points.name)


def _estimate_rows(fit: TangentFit) -> list[tuple[str, ...]]:
    """Rows of a table: what was found over all stresses, with 95 % intervals."""
    rows = [
        _write_estimate(name, getattr(fit, name), "degC", 1.0, ZERO, meaning, ".2f")
        for name, meaning in (
            ("A_s", "austenite start at zero stress"),
            ("A_f", "austenite finish"),
            ("M_s", "martensite start"),
            ("M_f", "martensite finish"),
        )
    ]
    for name, one in (("C_A", fit.reverse), ("C_M", fit.forward)):
        meaning = f"common slope of {one.names[0]} and {one.names[1]}"
        rows.append(_write_numbers(name, one.slope, one.slope_interval(), "MPa/K", 1e6, 0.0, meaning))
    rows.append(_write_estimate("eps_L", fit.eps_L, "%", 0.01, 0.0, "mean transformation strain"))
    form = fit.strain
    if form.H_k is not None:
        rows += [
            _write_estimate("H_min", form.H_min, "%", 0.01, 0.0, "H at no stress"),
            _write_estimate("H_sat", form.H_sat, "%", 0.01, 0.0, "H at high stress"),
            _write_estimate("H_k", form.H_k, "1/MPa", 1e-6, 0.0, "rate of saturation"),
        ]
    if form.sigma_crit is not None:
        meaning = "stress at which H begins to grow"
        rows.append(_write_estimate("sigma_crit", form.sigma_crit, "MPa", 1e6, 0.0, meaning))
    return rows


def _write_estimate(
    name: str, found: MeasuredValue, unit: str, factor: float, zero: float, meaning: str, digits: str = ".4g"
) -> tuple[str, ...]:
    interval = found.interval()
    return _write_numbers(name, found.value, interval, unit, factor, zero, meaning, digits)


def _write_numbers(
    name: str,
    value: float,
    interval: Interval,
    unit: str,
    factor: float,
    zero: float,
    meaning: str,
    digits: str = ".4g",
) -> tuple[str, ...]:
    """A value and its interval in a unit; `unknown` for an interval without bounds."""
    low, high = ((end - zero) / factor for end in interval)
    bounds = f"{low:{digits}} to {high:{digits}}" if math.isfinite(high - low) else "unknown"
    return name, f"{(value - zero) / factor:{digits}}", bounds, unit, meaning
