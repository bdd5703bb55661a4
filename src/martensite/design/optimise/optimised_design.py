"""The answer to a question of design, and what holds it where it is.

At a best design the slope of the goal is balanced by those of what it is pressed against,

    ∇f = Σ_i λ_i ∇g_i + Σ_k μ_k n_k,      λ_i, μ_k >= 0,

with the slacks g_i of active constraints and the inward normals n_k of bounds that are met. The
Lagrange multipliers are the non-negative least-squares solution of this balance, and its residue says how
far from a stationary point the design is. A multiplier is what relaxing its limit a little gains.
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
    """True if a relaxation raises the limit."""
    cases: tuple[int, ...] = ()
    """In which cases a constraint is active."""

    @property
    def gain(self) -> float:
        """Return the gain of the small relaxation [SI]."""
        return self.multiplier * self.step

    @property
    def share(self) -> float:
        """Return the gain as a fraction of the goal."""
        return self.gain / self.goal

    def to_dict(self) -> dict[str, Any]:
        """Return all fields and what relaxing it gains by name, for JSON."""
        return asdict(self) | {"gain": self.gain, "share": self.share}

    def words(self, goal_unit: str) -> str:
        """Describe the gain of relaxing the constraint."""
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
    """Unbalanced part of the derivative of the goal, as a fraction of it."""


def find_multipliers(designs: DesignEvaluator, z: NDArray[np.float64]) -> OptimalityBalance | None:
    """Return the active constraints of a design with their multipliers; None if it cannot be differentiated.

    Whole numbers are left out.
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


@dataclass(frozen=True)
class ReportedMeasure:
    """A measure of the design of the scenario and of the one that was found."""

    words: str
    unit: str
    """SI"""
    before: tuple[float, ...]
    """In every case; NaN if the run fails."""
    after: tuple[float, ...]


@dataclass(frozen=True)
class RoundedDesign:
    """Find the best design if some parameters must be whole numbers."""

    whole: tuple[int, ...]
    numbers: tuple[float, ...]
    """All free numbers [SI]."""
    goal: float
    """[SI]"""
    kept: bool
    violation: float
    """Violation of the constraints, as fractions of their limits."""


@dataclass(frozen=True, eq=False)
class OptimisedDesign:
    """A design: the best that was found, and why it is where it is."""

    designs: DesignEvaluator
    """Evaluator of the designs, with the step of the answer."""
    steering: WaveformLevels
    """System and waveforms with the numbers that were found."""
    z: tuple[float, ...]
    """Positions between the bounds, from 0 to 1."""
    numbers: tuple[float, ...]
    """Optimal values [SI], one per free parameter."""
    kept: bool
    """True if the rounded design keeps all constraints."""
    missed: tuple[str, ...]
    """Constraints that it does not keep."""
    reported: tuple[ReportedMeasure, ...]
    """The goal first, then what is constrained, then other measures."""
    balance: OptimalityBalance | None
    """Active constraints with multipliers; None if the design cannot be differentiated."""
    accuracy: float
    """Largest change of what it is judged by on halving the step, as a share of limits and goal."""
    held: tuple[RoundedDesign, ...] = ()
    """The best designs with other whole numbers, that of the answer among them."""
    relaxed: tuple[float, ...] | None = None
    """Optimal values with continuous instead of whole numbers [SI]; None without whole numbers."""
    relaxed_goal: float | None = None
    """[SI]"""
    history: tuple[SearchMark, ...] = ()
    """History of the best design; goals in SI."""
    life: str = ""
    """Claim about the life of the design."""
    scan: DesignScan | None = None
    """The grid that it was compared with."""
    exceeded: tuple[str, ...] = ()
    """Limits that its runs exceed by the judgement of `run` and `check`, each in words."""
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
        """Longest step of its runs [s]."""
        return self.designs.grid.longest

    @property
    def start(self) -> tuple[float, ...]:
        """Return the free numbers of the scenario [SI]."""
        return tuple(one.start for one in self.question.free)

    @property
    def goal(self) -> float:
        """Return the mean over the cases [SI]."""
        return _compute_mean(self.reported[0].after)

    @property
    def goal_before(self) -> float:
        """Return the goal of the scenario [SI]."""
        return _compute_mean(self.reported[0].before)

    def named(self) -> dict[str, float]:
        """Return the optimal values by name [SI]."""
        names = (one.name for one in self.question.free)
        return dict(zip(names, self.numbers, strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Return everything, ready for JSON; numbers in SI."""
        question, balance = self.question, self.balance
        free = zip(question.free, self.numbers, self.z, strict=True)
        return {
            "goal": {
                "measure": question.goal.words,
                "unit": question.goal.unit,
                "sense": "max" if question.most else "min",
                "before": self.goal_before,
                "after": self.goal,
            },
            "kept": self.kept,
            "missed": list(self.missed),
            "exceeded": list(self.exceeded),
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
                for one in self.reported
            },
            "pressing": [] if balance is None else [one.to_dict() for one in balance.pressing],
            "imbalance": None if balance is None else balance.residue,
            "whole_numbers": [vars(one) for one in self.held],
            "relaxed": None if self.relaxed is None else {"numbers": list(self.relaxed), "goal": self.relaxed_goal},
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
