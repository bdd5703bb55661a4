"""The answer to a question of design."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from martensite.design.optimise.active_constraints import OptimalityBalance
from martensite.design.optimise.evaluate import DesignEvaluator, RunCounts
from martensite.design.optimise.grid_scan import DesignScan
from martensite.design.optimise.question import DesignQuestion
from martensite.search.box_search import SearchMark
from martensite.simulate.waveform_levels import WaveformLevels


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
    """The best design with some whole numbers."""

    whole: tuple[int, ...]
    numbers: tuple[float, ...]
    """All free numbers [SI]."""
    goal: float
    """[SI]"""
    kept: bool
    violation: float
    """What its constraints miss, as shares of their limits."""


@dataclass(frozen=True, eq=False)
class OptimisedDesign:
    """A design: the best that was found, and why it is where it is."""

    designs: DesignEvaluator
    """What judged them, in the steps of the answer."""
    steering: WaveformLevels
    """System and waveforms with the numbers that were found."""
    z: tuple[float, ...]
    """Where they are between their bounds, from 0 to 1."""
    numbers: tuple[float, ...]
    """What was found [SI], one per free number."""
    kept: bool
    """Whether it keeps all constraints."""
    missed: tuple[str, ...]
    """Constraints that it does not keep."""
    reported: tuple[ReportedMeasure, ...]
    """The goal first, then what is constrained, then other measures."""
    balance: OptimalityBalance | None
    """What holds it; None if it cannot be differentiated."""
    accuracy: float
    """Largest change of what it is judged by on halving the step, as a share of limits and goal."""
    held: tuple[RoundedDesign, ...] = ()
    """The best designs with other whole numbers, that of the answer among them."""
    relaxed: tuple[float, ...] | None = None
    """What was found if whole numbers could be anything [SI]; None if there are none."""
    relaxed_goal: float | None = None
    """[SI]"""
    history: tuple[SearchMark, ...] = ()
    """How the best design became better; goals in SI."""
    life: str = ""
    """What is claimed of its life."""
    scan: DesignScan | None = None
    """The grid that it was compared with."""
    notes: list[str] = field(default_factory=list[str])

    @property
    def question(self) -> DesignQuestion:
        """What was asked."""
        return self.designs.question

    @property
    def counts(self) -> RunCounts:
        """What was computed."""
        return self.designs.counts

    @property
    def step(self) -> float:
        """Longest step of its runs [s]."""
        return self.designs.grid.longest

    @property
    def start(self) -> tuple[float, ...]:
        """The free numbers of the scenario [SI]."""
        return tuple(one.start for one in self.question.free)

    @property
    def goal(self) -> float:
        """Mean over the cases [SI]."""
        return _compute_mean(self.reported[0].after)

    @property
    def goal_before(self) -> float:
        """That of the scenario [SI]."""
        return _compute_mean(self.reported[0].before)

    def named(self) -> dict[str, float]:
        """What was found by name [SI]."""
        names = (one.name for one in self.question.free)
        return dict(zip(names, self.numbers, strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; numbers in SI."""
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
