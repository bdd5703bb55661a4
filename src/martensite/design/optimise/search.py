"""The search for the best design: a sample of the box, then descents from its best points.

A Sobol sample of the box is judged in one batch. From its best points, which must lie apart, and
from the design of the scenario it is descended (`martensite.search.box_search`).

Where a wire does not transform at all, derivatives are 0: no descent leaves such a place, but
a sample that reaches beyond it does. As long as no point of it keeps all constraints, more of the
box is sampled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from martensite.base.errors import SolveError
from martensite.design.optimise.evaluate import DesignEvaluator, Numbers
from martensite.search.box_search import FAILED_GOAL, BoxPoint, BoxSearch, JudgedPoints, Tell
from martensite.search.starts import choose_apart, start_sobol


@dataclass(frozen=True)
class DesignSearch:
    """How designs are searched."""

    sample: int = 64
    """Points of the sample, a power of 2."""
    more: int = 3
    """How often the sample is doubled while none of its points keeps all constraints."""
    descents: int = 3
    """Points from which it is descended, beside the design of the scenario."""
    iterations: int = 50
    """Of each descent, and half of the runs with derivatives that it may make."""
    clouds: int = 2
    """How often the neighbourhood of the best end is tried."""
    seed: int = 0


def start_search(designs: DesignEvaluator, search: DesignSearch, watch: Tell | None = None) -> BoxSearch:
    """A search of designs that has judged nothing yet."""
    return BoxSearch(designs, iterations=search.iterations, clouds=search.clouds, seed=search.seed, watch=watch)


def search_designs(
    designs: DesignEvaluator, begin: Numbers, search: DesignSearch, watch: Tell | None = None
) -> BoxSearch:
    """Search the box from a sample of it and from one design.

    Raises:
        SolveError: no run of the sample can be made.
    """
    hunt = start_search(designs, search, watch)
    starts = _choose_starts(_sample_box(hunt, designs, begin, search), search.descents)
    for k, start in enumerate(starts):
        hunt.tell(f"descent {k + 1} of {len(starts)}", 0.1 + 0.6 * k / len(starts))
        hunt.descend(start.z)
    hunt.tell("looking around", 0.7)
    hunt.look_around()
    return hunt


def _sample_box(hunt: BoxSearch, designs: DesignEvaluator, begin: Numbers, search: DesignSearch) -> list[BoxPoint]:
    """The sample, until one of its points keeps all constraints; the scenario first."""
    sobol = start_sobol(hunt.size, search.seed)
    hunt.tell("sampling", 0.0)
    first = np.concatenate([begin[None], sobol.random(search.sample)])
    values = designs.values(first)
    designs.set_size(values)
    points = hunt.note_points(first, designs.judge_values(values))
    for k in range(search.more):
        if any(point.kept for point in points):
            break
        hunt.tell("sampling more", 0.03 * (k + 1))
        points += hunt.judge(sobol.random(len(points) - 1))
    if all(point.goal >= FAILED_GOAL for point in points):
        raise SolveError(
            f"None of {len(points)} designs in the box can be run and judged; narrow the "
            "bounds, or try the scenario by itself."
        )
    return points


def _choose_starts(points: Sequence[BoxPoint], count: int) -> list[BoxPoint]:
    """The best points that lie apart, after the design of the scenario."""
    judged = JudgedPoints(np.array([p.goal for p in points]), -np.array([[p.violation] for p in points]))
    places = np.stack([point.z for point in points])
    chosen = [points[k] for k in choose_apart(places, judged.order(), count)]
    own = points[0]
    return chosen if any(one is own for one in chosen) else [*chosen, own]
