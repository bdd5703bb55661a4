"""What holds a design where it is: active constraints and bounds, with their Lagrange multipliers.

At a best design the slope of the goal is balanced by those of what it is pressed against,

    ∇f = Σ_i λ_i ∇g_i + Σ_k μ_k n_k,      λ_i, μ_k >= 0,

with the slacks g_i of active constraints and the inward normals n_k of bounds that are met. The
multipliers are the non-negative least-squares solution of this balance, and its residue says how
far from a stationary point the design is. A multiplier is what relaxing its limit a little gains.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.formats import write_difference
from martensite.design.optimise.evaluate import DesignEvaluator
from martensite.search.free_numbers import BOX_TEMPERATURE

ACTIVE = 2e-3
"""Slack up to which a constraint counts as active, as a share of its limit."""
PER_CENT = 0.01


@dataclass(frozen=True)
class ActiveConstraint:
    """A constraint or a bound that a design is pressed against."""

    name: str
    """The constraint, or the free number."""
    kind: str
    """constraint, lower bound or upper bound"""
    limit: float
    """[SI]"""
    unit: str
    multiplier: float
    """Gain of the goal [SI] per SI unit by which the limit is relaxed."""
    step: float
    """A small relaxation [SI]: 1 % of the limit, or of a range of a temperature."""
    goal: float
    """Size of the goal [SI]."""
    more: bool = True
    """Whether it is relaxed upwards."""
    cases: tuple[int, ...] = ()
    """In which cases a constraint is active."""

    @property
    def gain(self) -> float:
        """What the small relaxation gains [SI]."""
        return self.multiplier * self.step

    @property
    def share(self) -> float:
        """The same as a share of the goal."""
        return self.gain / self.goal

    def to_dict(self) -> dict[str, Any]:
        """All fields and what relaxing it gains by name, for JSON."""
        return asdict(self) | {"gain": self.gain, "share": self.share}

    def words(self, goal_unit: str) -> str:
        """What relaxing it would gain."""
        label = self.name if self.kind == "constraint" else f"{self.name}, {self.kind}"
        if self.gain == 0.0:
            return f"`{label}` is met, but relaxing it gains nothing."
        way = "more" if self.more else "less"
        return (
            f"`{label}` holds it: {write_difference(self.step, self.unit, 3)} {way} would gain "
            f"{write_difference(self.gain, goal_unit, 3)} ({100.0 * self.share:.3g} %)."
        )


@dataclass(frozen=True)
class OptimalityBalance:
    """All that a design is pressed against."""

    pressing: tuple[ActiveConstraint, ...]
    residue: float
    """What of the slope of the goal is not balanced, as a share of it."""


def find_multipliers(designs: DesignEvaluator, z: NDArray[np.float64]) -> OptimalityBalance | None:
    """What holds a design; None if it cannot be differentiated.

    Whole numbers are held by being whole and take no part.
    """
    one, free = designs.differentiate(z), designs.question.free
    if one is None:
        return None
    moving = np.array([not f.whole for f in free])
    slack = np.flatnonzero(np.abs(one.slack) <= ACTIVE)
    bounds = [(k, f.bound(float(z[k]))) for k, f in enumerate(free) if not f.whole]
    met = [(k, side) for k, side in bounds if side]
    normals = np.zeros((len(met), len(free)))
    for row, (k, side) in enumerate(met):
        normals[row, k] = 1.0 if side == "lower" else -1.0
    rows = np.concatenate([one.slack_slope[slack], normals])[:, moving]
    weights, residue = _solve_multipliers(rows, one.goal_slope[moving])
    rates, goal = weights * designs.goal_size, abs(designs.restore_goal(one.goal)) or 1.0
    pressing = _list_active(designs, slack, rates, goal)
    for (k, side), rate in zip(met, rates[len(slack) :], strict=True):
        limit = free[k].low if side == "lower" else free[k].high
        own = float(rate) / abs(free[k].slope(float(z[k])))
        step = PER_CENT * (BOX_TEMPERATURE if free[k].unit == "K" else abs(limit) or free[k].high)
        kind, more = f"{side} bound", side == "upper"
        pressing.append(ActiveConstraint(free[k].name, kind, limit, free[k].unit, own, step, goal, more))
    return OptimalityBalance(tuple(pressing), residue)


def _solve_multipliers(rows: NDArray[np.float64], slope: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Non-negative weights of rows whose sum is the slope, and the share that is missing."""
    size = float(np.linalg.norm(slope))
    if not size:
        return np.zeros(len(rows)), 0.0
    if not len(rows) or not rows.shape[1]:
        return np.zeros(len(rows)), 1.0
    weights, missing = import_module("scipy.optimize").nnls(rows.T, slope)
    return weights, float(missing) / size


def _list_active(
    designs: DesignEvaluator, slack: NDArray[np.intp], rates: NDArray[np.float64], goal: float
) -> list[ActiveConstraint]:
    """Active constraints, those of all cases together."""
    subject = designs.question.subject
    found: list[ActiveConstraint] = []
    for i, one in enumerate(subject):
        rows = [k for k, row in enumerate(slack) if row % len(subject) == i]
        if not rows:
            continue
        rate = float(sum(rates[k] for k in rows)) / one.scale
        step, unit = PER_CENT * one.scale, one.aim.unit
        cases = tuple(int(slack[k]) // len(subject) for k in rows)
        found.append(ActiveConstraint(one.words, "constraint", one.limit, unit, rate, step, goal, one.most, cases))
    return found
