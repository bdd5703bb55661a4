"""One step of a MuJoCo model together with its elements: lines, balance, and the check."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from martensite.base.errors import SolveError
from martensite.export.balance import ForceBalance, LineStepEnd, Trial, compute_share, settle_lines
from martensite.export.mujoco_plant import TendonPlant
from martensite.export.strand import ForceWeights, TracedStrand

AIM = 1e-6
"""Error of a force, as a share of it, at which no new line is laid."""
AGREED = AIM
"""Error with which a step counts as solved."""
TURNS = 20
"""Lines that are laid in a step."""
HASTY = 3
"""Turns after which slopes only grow: at a kink that ends a to and fro."""
PROBE = 0.01
"""Difference of a force, as a share of it, by which slopes are measured."""


class PathEnds(NamedTuple):
    """Where the paths would end: l_i = ends_i - Σ_j slopes_ij (F_j - tensions_j)."""

    tensions: list[float]
    """[N]"""
    ends: list[float]
    """[m]"""
    slopes: list[list[float]]
    """[m/N]"""

    def at(self, tensions: Sequence[float]) -> list[float]:
        """Lengths [m] under tensions [N]."""
        changes = [a - b for a, b in zip(tensions, self.tensions, strict=True)]
        rows = zip(self.ends, self.slopes, strict=True)
        return [end - sum(s * d for s, d in zip(row, changes, strict=True)) for end, row in rows]


class Solved(NamedTuple):
    """A step that has been solved but not made."""

    answers: list[LineStepEnd]
    tensions: list[float]
    """In force during the step [N]."""
    error: float
    """Largest error of a force, as a share of it: of the lines, and of the balance."""
    turns: int
    """Lines that were laid."""
    asked: int
    """How often all elements were asked."""


def solve_step(
    plant: TendonPlant, strands: Sequence[TracedStrand], weights: ForceWeights, drives: Sequence[float]
) -> Solved:
    """Elements and machine at the end of a step.

    Raises:
        SolveError: no forces were found at which they agree, or an element failed.
    """
    plant.remember_state()
    rows = list(zip(strands, drives, strict=True))
    trials = [strand.trial(drive, plant.dt) for strand, drive in rows]
    known = [strand.held(weights) for strand in strands]
    forces = [strand.force for strand in strands]
    tensions = _find_tensions(known, weights, forces)
    ends, lines, asked = plant.after(tensions), None, 0
    for turn in range(TURNS):
        lines = _lay_lines(plant, strands, tensions, ends, lines if turn >= HASTY else None)
        found = _balance_trials(strands, trials, weights, lines, known, forces)
        for strand, answer in zip(strands, found.answers, strict=True):
            strand.require(answer, plant.time)
        forces = [answer.force for answer in found.answers]
        tensions, asked = _find_tensions(known, weights, forces), asked + found.asked
        ends = plant.after(tensions)
        errors = _compute_errors(strands, found.answers, weights, lines, ends, tensions)
        if max(errors) <= AIM:
            break
    worst = max(*errors, found.error)
    if not worst <= AGREED:
        name = strands[errors.index(max(errors))].name
        raise SolveError(
            f"Element and model did not agree on the tension of `{name}` in the step at t = {plant.time:.6g} s (to "
            f"{worst:.1e} of it). Try a smaller `timestep`, or softer contacts."
        )
    return Solved(found.answers, tensions, worst, turn + 1, asked)


def _find_tensions(known: Sequence[float], weights: ForceWeights, forces: Sequence[float]) -> list[float]:
    return [k + weights.end * f for k, f in zip(known, forces, strict=True)]


def _lay_lines(
    plant: TendonPlant,
    strands: Sequence[TracedStrand],
    tensions: list[float],
    ends: list[float],
    before: PathEnds | None,
) -> PathEnds:
    """New lines at the tensions, with slopes not below those before."""
    changes = [PROBE * (F + s.least) for F, s in zip(tensions, strands, strict=True)]
    slopes = plant.gives(tensions, ends, changes)
    if before is not None and _compute_trace(before.slopes) > _compute_trace(slopes):
        slopes = before.slopes
    return PathEnds(tensions, ends, slopes)


def _compute_trace(matrix: Sequence[Sequence[float]]) -> float:
    return sum(row[i] for i, row in enumerate(matrix))


def _balance_trials(
    strands: Sequence[TracedStrand],
    trials: Sequence[Trial],
    weights: ForceWeights,
    lines: PathEnds,
    known: Sequence[float],
    forces: Sequence[float],
) -> ForceBalance:
    """All elements on the lines, as functions of their forces at the end of the step."""
    paths = zip(lines.at(known), strands, strict=True)
    reach = [length - strand.reference for length, strand in paths]
    give = [[weights.end * slope for slope in row] for row in lines.slopes]
    return settle_lines(trials, reach, give, forces, [strand.least for strand in strands])


def _compute_errors(
    strands: Sequence[TracedStrand],
    answers: Sequence[LineStepEnd],
    weights: ForceWeights,
    lines: PathEnds,
    ends: Sequence[float],
    tensions: Sequence[float],
) -> list[float]:
    """What the lines were wrong by, as errors of the forces."""
    missed = [a - b for a, b in zip(ends, lines.at(tensions), strict=True)]
    return [
        compute_share(missed[i], answer, weights.end * lines.slopes[i][i], strands[i].least)
        for i, answer in enumerate(answers)
    ]
