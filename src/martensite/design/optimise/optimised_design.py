"""Optimised design with its active constraints.

At an optimum the slope of the goal is balanced by the slopes of the active constraints and bounds,

    ∇f = Σ_i λ_i ∇g_i + Σ_k μ_k n_k,      λ_i, μ_k >= 0,

with the slacks g_i and the inward normals n_k of bounds. The Lagrange multipliers are the non-negative least-squares
solution; the residue measures the distance from a stationary point. A multiplier is the gain per relaxation of a limit.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.formats import write_difference
from martensite.design.optimise.evaluate import DesignEvaluator, RunCounts
from martensite.design.optimise.question import DesignQuestion
from martensite.design.optimise.search import DesignScan
from martensite.search.box_search import SearchMark
from martensite.search.free_numbers import BOX_TEMPERATURE
from martensite.simulate.waveform_levels import WaveformLevels

ACTIVE = 2e-3
"""Largest slack of an active constraint, as a fraction of its limit."""
PER_CENT = 0.01


@dataclass(frozen=True)
class ActiveConstraint:
    """Active constraint or bound of a design."""

    name: str
    """Constraint or free parameter."""
    kind: str
    """constraint, lower bound or upper bound"""
    limit: float
    """[SI]"""
    unit: str
    multiplier: float
    """Gain of the goal [SI] per SI unit of relaxation."""
    step: float
    """Small relaxation [SI]: 1 % of the limit, or of a range of a temperature."""
    goal: float
    """Size of the goal [SI]."""
    more: bool = True
    """True if a relaxation raises the limit."""
    cases: tuple[int, ...] = ()
    """Cases in which the constraint is active."""

    @property
    def gain(self) -> float:
        """Return the gain of the small relaxation [SI]."""
        return self.multiplier * self.step

    @property
    def share(self) -> float:
        """Return the gain as a fraction of the goal."""
        return self.gain / self.goal

    def to_dict(self) -> dict[str, Any]:
        """Return all fields and the gain by name, in plain values."""
        return asdict(self) | {"gain": self.gain, "share": self.share}

    def words(self, goal_unit: str) -> str:
        """Return a sentence on the gain of a relaxation."""
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
    """Active constraints of a design and the residue of their balance."""

    pressing: tuple[ActiveConstraint, ...]
    residue: float
    """Unbalanced part of the derivative of the goal, as a fraction of it."""


def find_multipliers(designs: DesignEvaluator, z: NDArray[np.float64]) -> OptimalityBalance | None:
    """Return the active constraints of a design with their multipliers; None without derivatives.

    Whole numbers are excluded.
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
    """Return non-negative weights of rows with the sum `slope`, and the missing fraction."""
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
    """Return the active constraints, with all cases of a constraint together."""
    subject = designs.question.subject
    active: list[ActiveConstraint] = []
    for i, one in enumerate(subject):
        rows = [k for k, row in enumerate(slack) if row % len(subject) == i]
        if not rows:
            continue
        rate = float(sum(rates[k] for k in rows)) / one.scale
        step, unit = PER_CENT * one.scale, one.aim.unit
        cases = tuple(int(slack[k]) // len(subject) for k in rows)
        active.append(
            ActiveConstraint(one.words, "constraint", one.limit, unit, rate, step, goal, one.is_upper_limit, cases)
        )
    return active


@dataclass(frozen=True)
class ReportedMeasure:
    """Measure of the scenario and of the final design."""

    words: str
    unit: str
    """SI"""
    before: tuple[float, ...]
    """Value in every case; NaN for a failed run."""
    after: tuple[float, ...]


@dataclass(frozen=True)
class RoundedDesign:
    """Best design with some whole numbers."""

    whole: tuple[int, ...]
    numbers: tuple[float, ...]
    """Free parameters [SI]."""
    goal: float
    """[SI]"""
    feasible: bool
    violation: float
    """Violation of the constraints, as fractions of their limits."""


@dataclass(frozen=True, eq=False)
class OptimisedDesign:
    """Best design and its active constraints."""

    designs: DesignEvaluator
    """Evaluator of the designs, with the final step."""
    steering: WaveformLevels
    """System and waveforms with the optimal values."""
    z: tuple[float, ...]
    """Positions between the bounds, from 0 to 1."""
    numbers: tuple[float, ...]
    """Optimal values [SI], one per free parameter."""
    feasible: bool
    """True if the rounded design keeps all constraints."""
    violated_constraints: tuple[str, ...]
    """Violated constraints."""
    measures: tuple[ReportedMeasure, ...]
    """Goal, then constrained and other measures."""
    balance: OptimalityBalance | None
    """Active constraints with multipliers; None without derivatives."""
    accuracy: float
    """Largest change of goal and slacks on halving the step, as a fraction of goal and limits."""
    rounded_designs: tuple[RoundedDesign, ...] = ()
    """Best designs by whole numbers."""
    relaxed_numbers: tuple[float, ...] | None = None
    """Optimal values with continuous instead of whole numbers [SI]; None without whole numbers."""
    relaxed_goal: float | None = None
    """[SI]"""
    history: tuple[SearchMark, ...] = ()
    """History of the best design; goals in SI."""
    life: str = ""
    """Statement on the life of the design."""
    scan: DesignScan | None = None
    """Grid for comparison."""
    exceeded_limits: tuple[str, ...] = ()
    """Limits that the runs exceed as `run` and `check` find them, in words."""
    notes: list[str] = field(default_factory=list[str])

    @property
    def question(self) -> DesignQuestion:
        """Return the question of the design."""
        return self.designs.question

    @property
    def counts(self) -> RunCounts:
        """Return the numbers of simulations."""
        return self.designs.counts

    @property
    def step(self) -> float:
        """Return the longest step of the runs [s]."""
        return self.designs.grid.longest

    @property
    def start(self) -> tuple[float, ...]:
        """Return the free parameters of the scenario [SI]."""
        return tuple(one.start for one in self.question.free)

    @property
    def goal(self) -> float:
        """Return the mean over the cases [SI]."""
        return _compute_mean(self.measures[0].after)

    @property
    def goal_before(self) -> float:
        """Return the goal of the scenario [SI]."""
        return _compute_mean(self.measures[0].before)

    def values_by_name(self) -> dict[str, float]:
        """Return the optimal values by name [SI]."""
        names = (one.name for one in self.question.free)
        return dict(zip(names, self.numbers, strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Return all results as plain values, in SI."""
        question, balance = self.question, self.balance
        free = zip(question.free, self.numbers, self.z, strict=True)
        return {
            "goal": {
                "measure": question.goal.words,
                "unit": question.goal.unit,
                "sense": "max" if question.is_maximised else "min",
                "before": self.goal_before,
                "after": self.goal,
            },
            "feasible": self.feasible,
            "missed": list(self.violated_constraints),
            "exceeded": list(self.exceeded_limits),
            "free": {
                one.name: {
                    "before": one.start,
                    "after": number,
                    "low": one.low,
                    "high": one.high,
                    "unit": one.unit,
                    "whole": one.whole,
                    "at_bound": one.bound(z),
                }
                for one, number, z in free
            },
            "subject": [one.words for one in question.subject],
            "cases": [dict(case) for case in question.cases],
            "measures": {
                one.words: {"unit": one.unit, "before": list(one.before), "after": list(one.after)}
                for one in self.measures
            },
            "pressing": [] if balance is None else [one.to_dict() for one in balance.pressing],
            "imbalance": None if balance is None else balance.residue,
            "whole_numbers": [vars(one) for one in self.rounded_designs],
            "relaxed": None
            if self.relaxed_numbers is None
            else {"numbers": list(self.relaxed_numbers), "goal": self.relaxed_goal},
            "runs": self.counts.to_dict(),
            "step": self.step,
            "accuracy": self.accuracy,
            "life": self.life or None,
            "grid": None if self.scan is None else self.scan.to_dict(),
            "history": [mark._asdict() for mark in self.history],
            "notes": self.notes,
        }


def _compute_mean(values: tuple[float, ...]) -> float:
    return math.fsum(values) / len(values)
