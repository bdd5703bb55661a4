"""Panels of the identified resistance: over apparent temperature, and over the offset.

The transformation drawn between A_s and A_f is one of many with the same error.
"""

from __future__ import annotations

from typing import Any

from martensite.show.figures.style import HEATING, INK, MEASURED, QUIET, SIMULATED
from martensite.studies.electrothermal import resistance_fit as fitting
from martensite.studies.figures import label_axes
from martensite.studies.readings import ZERO
from martensite.studies.tables import Printed

LOOKS = {
    "mixture": ("plain mixture", SIMULATED, "solid"),
    "austenite": ("$\\rho_A$ grows with $T$", MEASURED[1], (0, (5, 1.6))),
    "both": ("$\\rho_A$, $\\rho_M$ grow with $T$", MEASURED[3], (0, (1, 1.3))),
}
_SCALE = 1e8
_STEPS = 9
_OFFSETS = tuple(0.16 + 0.02 * k for k in range(11))


def over_temperature(axes: Any, stated: Printed) -> None:
    """Draw R over apparent temperature: measured, fitted, held out, and the band of offsets."""
    low, high = (fitting.fit_shape("mixture", offset) for offset in (fitting.UPPER, fitting.LOWER))
    warmth, below = fit_curve(low)
    axes.fill_between(
        warmth,
        below,
        fit_curve(high)[1],
        color=SIMULATED,
        alpha=0.14,
        linewidth=0.0,
        label=f"plain mixture, $V_0$ = {fitting.LOWER:g} to {fitting.UPPER:g} V",
    )
    for shape, (label, colour, dashes) in LOOKS.items():
        fit = fitting.fit_shape(shape, stated.offset)
        rms, held_out = fitting.residual_rms(fit), fitting.residual_rms(fit, "held-out")
        label += f", rms {rms:.3f} Ω, held out {held_out:.3f} Ω"
        axes.plot(*fit_curve(fit), color=colour, linestyle=dashes, label=label, linewidth=1.5)
    _draw_points(axes, stated)
    label_axes(
        axes,
        f"identified at the apparent temperature, $V_0$ = {stated.offset:.3f} V",
        "read by the infrared camera [°C]: not the temperature of the wire",
        "$R$ [Ω]",
    )
    axes.set_ylim(1.33, 1.72)
    axes.legend(loc="upper right", ncols=2)


def _draw_points(axes: Any, stated: Printed) -> None:
    """Draw the measured plateaus with the effect of the band of offsets."""
    at = [kelvin - ZERO for kelvin in fitting.compared_column("apparent_temperature")]
    ohms, least, most = (
        [fitting.load_staircase().resistances(offset)[i] for i in fitting.compared_places()]
        for offset in (stated.offset, fitting.UPPER, fitting.LOWER)
    )
    held_out = fitting.fit_shape("mixture", stated.offset).problem.experiments[0].held_out_rows
    axes.vlines(at, least, most, color=QUIET, linewidth=0.6, zorder=3)
    for flag, fill, label in ((False, INK, "run 5"), (True, "white", "run 5, held out")):
        rows = [k for k in range(len(at)) if bool(held_out[k]) is flag]
        axes.plot(
            [at[k] for k in rows],
            [ohms[k] for k in rows],
            "o",
            color=INK,
            markersize=4.2,
            markerfacecolor=fill,
            label=label,
            zorder=4,
        )


def fit_curve(fit: Any) -> tuple[list[float], list[float]]:
    """Return the temperatures [°C] and resistances [ohm] of a fit."""
    at = fitting.compared_column("apparent_temperature")
    first, last = fit["A_s"], fit["A_f"]
    strip = [first + (last - first) * k / _STEPS for k in range(_STEPS + 1)]
    warmth = sorted([at[0], *strip, at[-1]])
    return [kelvin - ZERO for kelvin in warmth], fitting.fitted_resistances(fit, warmth)


def over_offset(axes: Any, stated: Printed) -> None:
    """Draw ρ_M - ρ_A over the supply offset for each shape, with its best offset."""
    axes.axvspan(
        fitting.LOWER, fitting.UPPER, color=SIMULATED, alpha=0.14, linewidth=0.0, label="offsets of the record"
    )
    axes.axvline(stated.offset, color=QUIET, linewidth=0.8)
    for shape in LOOKS:
        _draw_difference(axes, shape)
    material = _SCALE * (stated.rho_M - stated.rho_A)
    axes.plot([stated.offset], [material], "s", color=HEATING, markersize=5.0, label="material `flexinol-90`", zorder=5)
    label_axes(
        axes,
        "how much more martensite resists, over the offset",
        "set-point less voltage, $V_0$ [V]; diamonds: best",
        "$\\rho_M - \\rho_A$ [µΩ cm]",
    )
    axes.set_ylim(0.0, 16.0)
    axes.set_xlim(_OFFSETS[0], _OFFSETS[-1])
    axes.legend(loc="upper right", ncols=2)


def _draw_difference(axes: Any, shape: str) -> None:
    """Draw the line of one shape, with its band except for `austenite`."""
    label, colour, dashes = LOOKS[shape]
    differences = [fitting.resistivity_difference(fitting.fit_shape(shape, offset)) for offset in _OFFSETS]
    middle = [_SCALE * value for value, _ in differences]
    axes.plot(_OFFSETS, middle, color=colour, linestyle=dashes, label=label, linewidth=1.5)
    if shape != "austenite":
        low, high = ([_SCALE * (v + sign * half) for v, half in differences] for sign in (-1.0, 1.0))
        axes.fill_between(_OFFSETS, low, high, color=colour, alpha=0.12, linewidth=0.0)
    best = fitting.offset_of(shape).value
    if best <= _OFFSETS[-1]:
        value, _ = fitting.resistivity_difference(fitting.fit_shape(shape, best))
        axes.plot([best], [_SCALE * value], "D", color=colour, markersize=5.0, zorder=4)
