"""`fit tangents`: reading isobaric logs, and what is printed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from martensite.base.errors import InputError
from martensite.cli.options import quantity

if TYPE_CHECKING:
    from martensite.base.confidence import Interval
    from martensite.characterise.estimate import MeasuredValue
    from martensite.characterise.tangent_fit import TangentFit
    from martensite.characterise.tangent_points import TangentPoints

ZERO = 273.15
"""0 °C [K]."""


def read_cycles(
    logs: Sequence[str], stresses: Sequence[str] | None, cycle: int | None
) -> list[TangentPoints]:
    """The tangents of each log, in the order given.

    Raises:
        InputError: stresses and logs are not equally many, or the cycle is counted from below 1.
        DataError: a log is missing, malformed, or holds no isobaric cycle.
        UnitError: a stress is none.
    """
    from martensite.characterise.tangent_points import find_tangent_points
    from martensite.scenario.tables import read_table

    if cycle is not None and cycle < 1:
        raise InputError(f"Option `--cycle` counts from 1 on, but is {cycle}.")
    if stresses and len(stresses) != len(logs):
        raise InputError(
            "Give --stress once for every LOG, in their order; "
            f"stresses: {len(stresses)}, logs: {len(logs)}."
        )
    given = (
        [quantity("stress", text, "Pa") for text in stresses] if stresses else [None] * len(logs)
    )
    which = -1 if cycle is None else cycle - 1
    return [
        find_tangent_points(read_table(log), stress=stress, cycle=which)
        for log, stress in zip(logs, given, strict=True)
    ]


def fitted(levels: Sequence[TangentPoints]) -> TangentFit | None:
    """What the logs say together; None for a single one."""
    from martensite.characterise.tangent_fit import fit_tangents

    return fit_tangents(levels) if len(levels) > 1 else None


def draw(levels: Sequence[TangentPoints], fit: TangentFit | None, path: Path) -> None:
    """Write the figure."""
    from martensite.show.figures.files import write_figure
    from martensite.show.figures.tangents import plot_tangents

    title = f"Tangents of {levels[0].name}" if fit is None else f"Tangents of {len(levels)} cycles"
    write_figure(plot_tangents(levels[0] if fit is None else fit, title), path)


def as_dict(levels: Sequence[TangentPoints], fit: TangentFit | None) -> dict[str, Any]:
    """All numbers by name in SI, for JSON."""
    return {"levels": [levels[0].to_dict()]} if fit is None else fit.to_dict()


# ---------------------------------------------------------------- printing


def print_tangents(
    levels: Sequence[TangentPoints], fit: TangentFit | None, written: Sequence[Path]
) -> None:
    """Print the points of every log, what they say together, and what is to be known of them."""
    from martensite.cli import show

    ordered = levels if fit is None else fit.levels
    show.text(f"Tangents of {len(levels)} isobaric cycle{'s' * (len(levels) > 1)}", "bold")
    columns = (
        "stress [MPa]", "A_s [degC]", "A_f", "half", "M_s [degC]", "M_f", "half", "H [%]",
        "residual [%]", "stroke [%]", "log",
    )  # fmt: skip
    show.table(columns, [_row(points) for points in ordered], right=",".join(columns[:-1]))
    if fit is None:
        show.text("C_A, C_M and temperatures at zero stress need cycles at two or more stresses.")
        remarks = levels[0].remarks
    else:
        show.table(("quantity", "value", "95 % interval", "unit", "meaning"), summary(fit))
        remarks = fit.remarks
    for remark in remarks:
        show.text(remark, "yellow")
    for path in written:
        show.text(f"wrote {path}")


def _row(points: TangentPoints) -> tuple[str, ...]:
    temperatures = (
        f"{getattr(points, name) - ZERO:.2f}"
        for name in ("A_s", "A_f", "A_half", "M_s", "M_f", "M_half")
    )
    strains = (f"{100.0 * e:.3f}" for e in (points.H, points.residual_strain, points.stroke))
    return (f"{points.stress / 1e6:.4g}", *temperatures, *strains, points.name)


def summary(fit: TangentFit) -> list[tuple[str, ...]]:
    """Rows of a table: what was found over all stresses, with 95 % intervals."""
    rows = [
        _estimate(name, getattr(fit, name), "degC", 1.0, ZERO, meaning, ".2f")
        for name, meaning in (
            ("A_s", "austenite start at zero stress"), ("A_f", "austenite finish"),
            ("M_s", "martensite start"), ("M_f", "martensite finish"),
        )
    ]  # fmt: skip
    for name, one in (("C_A", fit.reverse), ("C_M", fit.forward)):
        meaning = f"common slope of {one.names[0]} and {one.names[1]}"
        rows.append(_numbers(name, one.slope, one.slope_interval(), "MPa/K", 1e6, 0.0, meaning))
    rows.append(_estimate("eps_L", fit.eps_L, "%", 0.01, 0.0, "mean transformation strain"))
    form = fit.strain
    if form.H_k is not None:
        rows += [
            _estimate("H_min", form.H_min, "%", 0.01, 0.0, "H at no stress"),
            _estimate("H_sat", form.H_sat, "%", 0.01, 0.0, "H at high stress"),
            _estimate("H_k", form.H_k, "1/MPa", 1e-6, 0.0, "rate of saturation"),
        ]
    if form.sigma_crit is not None:
        meaning = "stress at which H begins to grow"
        rows.append(_estimate("sigma_crit", form.sigma_crit, "MPa", 1e6, 0.0, meaning))
    return rows


def _estimate(
    name: str, found: MeasuredValue, unit: str, factor: float, zero: float, meaning: str,
    digits: str = ".4g",
) -> tuple[str, ...]:  # fmt: skip
    interval = found.interval()
    return _numbers(name, found.value, interval, unit, factor, zero, meaning, digits)


def _numbers(
    name: str, value: float, interval: Interval, unit: str, factor: float, zero: float,
    meaning: str, digits: str = ".4g",
) -> tuple[str, ...]:  # fmt: skip
    """A value and its interval in a unit; `unknown` for an interval without bounds."""
    low, high = ((end - zero) / factor for end in interval)
    bounds = f"{low:{digits}} to {high:{digits}}" if math.isfinite(high - low) else "unknown"
    return name, f"{(value - zero) / factor:{digits}}", bounds, unit, meaning
