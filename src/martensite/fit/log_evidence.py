"""Evidence for the parameters of a model of logs: dependence on assumptions, and temperatures at each load.

A parameter depends on an assumed value if a change of this value by a tenth, or by 10 K, moves it by more than half of
its 95 % interval. With residuals r and their Jacobian J the change is

    Δp = -J⁺ (r(changed) - r(assumed))

It is computed for the fraction `SMALL` of the change and scaled, so that it is linear.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from martensite.base.errors import MartensiteError
from martensite.characterise.loop_paths import trace_loop
from martensite.fit.drive_lag import find_drive
from martensite.fit.fit import Fit
from martensite.fit.problem import Problem

CHANGE, WARMER = 0.1, 10.0
"""Relative change of an assumed value, and change of an assumed temperature [K]."""
SMALL = 0.01
"""Computed fraction of these changes."""
STEP = 1e-6
"""Step of finite differences, as a fraction of a search range."""
CANCEL = 0.02
"""Relative sum of two opposite changes of a temperature that counts as zero."""
SHIFTED = {"A_s": "C_A", "A_f": "C_A", "M_s": "C_M", "M_f": "C_M"}
"""Transformation temperature -> the slope of its line."""
Rebuild = Callable[[str, str], Problem]
"""Path and changed value, as text -> the problem of the chosen model under that assumption."""


@dataclass(frozen=True)
class ShiftedTemperature:
    """A transformation temperature at one stress."""

    name: str
    stress: float
    """[Pa]"""
    value: float
    """[K]"""
    half_width: float
    """Half of its 95 % interval [K]; infinite if undetermined."""
    assumed: tuple[str, ...] = ()
    """Paths of assumed values on which it depends."""


@dataclass(frozen=True)
class AssumedMove:
    """Change of an assumed value, and the resulting change of the free parameters as fractions of their ranges."""

    path: str
    move: Any


def trace_assumptions(fit: Fit, assumed: Mapping[str, float], rebuild: Rebuild) -> list[AssumedMove]:
    """Return the change of the parameters of a fit with each assumed value."""
    moves: list[AssumedMove] = []
    for path, value in assumed.items():
        unit = "K" if path.endswith("temperature") else _find_unit(path, fit)
        try:
            moved = value + SMALL * WARMER if unit == "K" else (1.0 + SMALL * CHANGE) * value
            changed = rebuild(path, f"{moved} {unit}").evaluate(fit.values)
        except MartensiteError:
            continue
        before = fit.evaluation.residuals
        if changed is not None and len(changed.residuals) == len(before):
            step = np.linalg.lstsq(fit.evaluation.jacobian, changed.residuals - before, rcond=1e-10)[0]
            moves.append(AssumedMove(path, -step / SMALL))
    return moves


def count_jitter(fit: Fit, jitter: Mapping[str, float]) -> Fit:
    """Return a fit with intervals that include the smoothing error of loop drives.

    Each leg of a loop has a separate offset of known standard deviation.

    Args:
        fit: fit without this error.
        jitter: record -> standard deviation of the offset [SI].
    """
    problem, uncertainty = fit.problem, fit.uncertainty
    sizes = np.array([free.slope(u) for free, u in _pair_free(fit)])
    extra = np.zeros((len(sizes), len(sizes)))
    places = np.cumsum([0, *(int(used.sum()) for used in problem.training_rows)])
    for k, one in enumerate(problem.experiments):
        if error := jitter.get(one.record.name, 0.0):
            for change in _shift_legs(fit, k, error):
                whole = np.zeros(len(fit.evaluation.residuals))
                whole[places[k] : places[k + 1]] = change
                move = sizes * np.linalg.lstsq(fit.evaluation.jacobian, whole, rcond=1e-10)[0]
                extra += np.outer(move, move)
    if not extra.any() or not np.isfinite(uncertainty.errors).all():
        return fit
    whole = np.array(uncertainty.covariance) + extra / uncertainty.widening**2
    errors = np.sqrt(whole.diagonal())
    wider = replace(
        uncertainty, errors=tuple(map(float, errors)), correlation=tuple(map(tuple, whole / np.outer(errors, errors)))
    )
    wider_fit = replace(fit)
    wider_fit.__dict__["uncertainty"] = wider
    return wider_fit


def _shift_legs(fit: Fit, k: int, error: float) -> Iterator[Any]:
    """Yield the changes of the residuals of a record, (rows,), for an offset of each leg of its drive."""
    one = fit.problem.experiments[k]
    drive = find_drive(one)
    values = np.array(one.find_followed_waveform(drive).values)
    ratio = fit.problem.scale(one.outputs[0])
    alone = replace(fit.problem, experiments=(one,))
    before = alone.evaluate(fit.values)
    for first, last in trace_loop(values).legs:
        moved = values.copy()
        moved[first : last + 1] += error
        after = replace(alone, experiments=(one.with_inputs({drive: moved}),)).evaluate(fit.values)
        if before is not None and after is not None:
            yield (after.residuals - before.residuals) * alone.scale(one.outputs[0]) / ratio


def list_dependent(fit: Fit, moves: Sequence[AssumedMove]) -> dict[str, tuple[str, ...]]:
    """Return the free parameters that depend on assumed values, with the paths of these values."""
    dependences: dict[str, tuple[str, ...]] = {}
    for i, free in enumerate(fit.problem.free):
        low, high = fit.uncertainty.widen_interval(free.name)
        slope = abs(free.slope(fit.values[i]))
        paths = tuple(one.path for one in moves if abs(one.move[i]) * slope > 0.5 * (high - low))
        if paths:
            dependences[free.name] = paths
    return dependences


def list_temperatures(fit: Fit, moves: Sequence[AssumedMove]) -> list[ShiftedTemperature]:
    """Return the transformation temperatures at zero stress and at each load, for a law with straight lines."""
    values = _read_law(fit, fit.values)
    if not set(SHIFTED) | set(SHIFTED.values()) <= values.keys() or any(
        values.get(name) for name in ("curvature_f", "curvature_r", "widening_f", "widening_r")
    ):
        return []
    loads = {round(float(np.mean(one.record["stress"])), -4) for one in fit.problem.experiments if _is_isobaric(one)}
    slopes = _differentiate_law(fit)
    temperatures: list[ShiftedTemperature] = []
    for stress in (0.0, *sorted(loads)):
        for name, slope in SHIFTED.items():
            rate = values[slope]
            gradient = slopes[name] - stress / rate**2 * slopes[slope]
            half = fit.uncertainty.half_width(gradient / np.array([x.slope(u) for x, u in _pair_free(fit)]))
            changes = [(one.path, gradient @ one.move, _own(one, slope, stress, rate)) for one in moves]
            least = [max(half, CANCEL * abs(own)) for _, _, own in changes]
            paths = tuple(path for (path, by, own), x in zip(changes, least, strict=True) if abs(by + own) > x)
            temperatures.append(ShiftedTemperature(name, stress, values[name] + stress / rate, half, paths))
    return temperatures


def _own(one: AssumedMove, slope: str, stress: float, rate: float) -> float:
    """Return the direct change of a temperature with an assumed slope of its line [K]."""
    return -CHANGE * stress / rate if one.path.endswith(slope) else 0.0


def _is_isobaric(one: Any) -> bool:
    return "stress" in one.record.columns and "stress" not in one.outputs


def _pair_free(fit: Fit) -> list[tuple[Any, float]]:
    return list(zip(fit.problem.free, fit.values, strict=True))


def _read_law(fit: Fit, point: Sequence[float]) -> dict[str, float]:
    """Return the parameters of the law at a point, by their last names [SI]."""
    leaves = fit.problem.system(0, point).leaves()
    return {leaf.path.rpartition(".")[2]: float(leaf.value) for leaf in leaves if ".law." in f".{leaf.path}"}


def _differentiate_law(fit: Fit) -> dict[str, Any]:
    """Return the derivatives of the law parameters with respect to the places of the free parameters."""
    base = _read_law(fit, fit.values)
    rows = [_move_law(fit, i, base) for i in range(len(fit.values))]
    return {name: np.array([row[name] for row in rows]) for name in base}


def _move_law(fit: Fit, i: int, base: Mapping[str, float]) -> dict[str, float]:
    """Return the derivatives by one place, on the side that keeps the order of the law; otherwise 0."""
    for step in (STEP, -STEP):
        try:
            moved = _read_law(fit, [u + step * (k == i) for k, u in enumerate(fit.values)])
        except MartensiteError:
            continue
        return {name: (moved[name] - base[name]) / step for name in base}
    return dict.fromkeys(base, 0.0)


def _find_unit(path: str, fit: Fit) -> str:
    """Return the SI unit of a path of the scenario."""
    last = path.rpartition(".")[2]
    return next((x.declared.unit for x in fit.system().leaves() if x.path.rpartition(".")[2] == last), "1")
