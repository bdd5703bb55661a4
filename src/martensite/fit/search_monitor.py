"""Progress of a search, its saved state, and its resumption.

The state is a small JSON file with a key of the problem, the best parameters, and the finished starts. A search of
another problem does not change it.
"""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.errors import DataError
from martensite.base.files import write_file
from martensite.base.object_text import encode
from martensite.fit.evaluation import Evaluation
from martensite.fit.problem import Problem

TOGETHER = 32
"""Number of points between records of the best point."""
EVERY = 2.0
"""Time between writes of the state [s]."""


@dataclass(frozen=True)
class SearchNote:
    """Report after every evaluation."""

    stage: str
    cost: float
    """Best cost."""
    values: tuple[float, ...]
    """Best point, from 0 to 1."""
    simulations: int
    share: float
    """Estimated fraction of the search that is done, from 0 to 1."""


Tell = Callable[[SearchNote], None]


@dataclass
class SearchMonitor:
    """Evaluator of a problem that counts runs and stores the best point."""

    problem: Problem
    tell: Tell | None = None
    path: Path | None = None
    """File of the saved state, if any."""
    stage: str = ""
    share: float = 0.0
    simulations: int = 0
    """Runs of single experiments, one for each variant."""
    jacobians: int = 0
    """Runs of single experiments with derivatives."""
    best: tuple[float, ...] | None = None
    cost: float = math.inf
    history: list[tuple[int, float]] = field(default_factory=list[tuple[int, float]])
    done: list[str] = field(default_factory=list[str])
    """Stages that are finished, of this search and the one it resumes."""
    _save_time: float = 0.0

    def evaluate(self, u: Sequence[float], *, slopes: bool = False) -> Evaluation | None:
        """Evaluate the problem as `Problem.evaluate` does, and record the point."""
        evaluation = self.problem.evaluate(u, slopes=slopes)
        count = len(self.problem.experiments)
        if slopes:
            self.jacobians += count
        else:
            self.simulations += count
        self._record_point(u, math.inf if evaluation is None else evaluation.cost)
        return evaluation

    def costs(self, points: Any) -> Any:
        """Evaluate costs as `Problem.costs` does, and record the best point."""
        answers = list[Any]()
        for some in np.split(points, range(TOGETHER, len(points), TOGETHER)):
            costs = self.problem.costs(some)
            self.simulations += len(some) * len(self.problem.experiments)
            least = int(costs.argmin())
            self._record_point(some[least], float(costs[least]))
            answers.append(costs)
        return np.concatenate(answers)

    def _record_point(self, u: Sequence[float], cost: float) -> None:
        if cost < self.cost:
            self.best, self.cost = tuple(map(float, u)), cost
            self.history.append((self.simulations + self.jacobians, cost))
            if time.monotonic() - self._save_time > EVERY:
                self.save()
        if self.tell is not None:
            point = self.best or tuple(map(float, u))
            self.tell(SearchNote(self.stage, self.cost, point, self.simulations, self.share))

    def finish_stage(self, stage: str) -> None:
        """Note that a stage need not be repeated."""
        self.done.append(stage)
        self.save()

    def save(self) -> None:
        """Write the state, if there is a file."""
        if self.path is None or self.best is None:
            return
        self._save_time = time.monotonic()
        document = {"problem": identify_problem(self.problem), "values": self.best, "done": self.done}
        write_file(self.path, json.dumps(document))

    def resume(self) -> None:
        """Resume an earlier search of the same problem, if there is one.

        Raises:
            DataError: the file is not the state of this problem.
        """
        if self.path is None or not self.path.exists():
            return
        try:
            document = json.loads(self.path.read_text(encoding="utf-8"))
            same = document["problem"] == identify_problem(self.problem)
            values, done = tuple(map(float, document["values"])), list(map(str, document["done"]))
        except (OSError, ValueError, KeyError, TypeError):
            raise DataError(f"`{self.path}` does not hold the state of a search.") from None
        if not same:
            raise DataError(
                f"`{self.path}` holds the state of another problem: other records, scenario or "
                "free parameters; name another file, or remove this one."
            )
        self.done = done
        self.evaluate(values)


def identify_problem(problem: Problem) -> str:
    """Return a short text that differs between problems."""
    parts: list[Any] = [repr(problem.free), sorted(problem.noise.items()), problem.step]
    for one in problem.experiments:
        parts += [one.name, encode(one.system), sorted(one.columns.items()), one.held_out_intervals, one.step]
        parts += [sorted((name, column.tolist()) for name, column in one.record.columns.items())]
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:24]
