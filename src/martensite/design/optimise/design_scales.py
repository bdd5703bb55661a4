"""Goal and slacks: what a search sees of a design, on scales of its own.

The goal is the mean over all cases, divided by its size at the beginning, and its negative where
it shall be as large as it can. A slack is how far a constraint is from its limit in one case, as a
share of the limit (of 50 K for a temperature): below 0 it is violated. What never happens, and
a run that fails, is far beyond every limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.design.optimise.evaluate import AimSlopes
from martensite.design.optimise.question import DesignQuestion

Numbers: TypeAlias = NDArray[np.float64]
LARGEST_SLACK = 10.0
"""Slack beyond which nothing more is counted."""
FAILED_GOAL = 1e6
"""Goal of a design whose run fails, or that never reaches it."""
FEASIBLE_VIOLATION = 1e-5
"""Violation, as a share of a limit, that counts as none."""


class JudgedDesigns(NamedTuple):
    """Many designs as a search sees them."""

    goal: Numbers
    """(designs,)"""
    slack: Numbers
    """(designs, cases * constraints)"""

    @property
    def violation(self) -> Numbers:
        """Sum of what constraints miss, (designs,)."""
        return np.maximum(-self.slack, 0.0).sum(axis=1)

    @property
    def kept(self) -> NDArray[np.bool_]:
        """Whether all constraints are kept, (designs,)."""
        return (self.slack >= -FEASIBLE_VIOLATION).all(axis=1) & (self.goal < FAILED_GOAL)

    def order(self) -> list[int]:
        """Designs from best to worst: those that keep all by goal, then others by violation."""
        lost = np.where(self.kept, 0.0, FEASIBLE_VIOLATION + self.violation)
        return [int(k) for k in np.lexsort((self.goal, lost))]


class DesignGradient(NamedTuple):
    """One design as a search sees it, with derivatives by the places of the free numbers."""

    goal: float
    slack: Numbers
    goal_slope: Numbers
    """(free,)"""
    slack_slope: Numbers
    """(cases * constraints, free)"""


@dataclass
class DesignScales:
    """How a question is turned into goal and slacks."""

    question: DesignQuestion
    goal: float = 1.0
    """Size of the goal."""

    @property
    def sign(self) -> float:
        """1 where the goal shall be small."""
        return -1.0 if self.question.most else 1.0

    def set_size(self, values: Numbers) -> None:
        """Take the size of the goal from that of some designs, (designs, cases, aims)."""
        goals = np.abs(values[:, :, 0].mean(axis=1))
        goals = goals[np.isfinite(goals) & (goals > 0.0)]
        self.goal = float(np.median(goals)) if len(goals) else 1.0

    def convergence_scales(self, values: Numbers) -> JudgedDesigns:
        """Of values of designs, (designs, cases, aims)."""
        goal = self.sign * values[:, :, 0].mean(axis=1) / self.goal
        slack = [
            c.sign * (values[:, :, k + 1] - c.limit) / c.scale
            for k, c in enumerate(self.question.subject)
        ]
        table = np.stack(slack, axis=2).reshape(len(values), -1) if slack else goal[:, None][:, :0]
        held = np.clip(
            np.nan_to_num(table, nan=-LARGEST_SLACK, posinf=LARGEST_SLACK, neginf=-LARGEST_SLACK),
            -LARGEST_SLACK,
            LARGEST_SLACK,
        )
        held[np.isnan(values).any(axis=(1, 2))] = -LARGEST_SLACK
        return JudgedDesigns(np.where(np.isfinite(goal), goal, FAILED_GOAL), held)

    def gradient(self, found: AimSlopes) -> DesignGradient:
        """Of one design."""
        one = self.convergence_scales(found.values[None])
        slope = self.sign * found.slopes[:, 0].mean(axis=0) / self.goal
        rows = [
            c.sign * found.slopes[:, k + 1] / c.scale for k, c in enumerate(self.question.subject)
        ]
        count = found.slopes.shape[2]
        table = np.stack(rows, axis=1).reshape(-1, count) if rows else np.zeros((0, count))
        table = np.where((np.abs(one.slack[0]) < LARGEST_SLACK)[:, None], table, 0.0)
        return DesignGradient(float(one.goal[0]), one.slack[0], slope, table)
