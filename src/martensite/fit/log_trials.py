"""Trials of proposed models: fit to all records, test on held-out data, simplification.

The simplest law comes first. A law with more parameters replaces it only if its held-out error is clearly smaller.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol, TypeVar

import numpy as np

from martensite.base.errors import ParameterError, SolveError
from martensite.base.interrupts import accept_interrupt
from martensite.characterise.loop_paths import estimate_scatter, smooth_legs, trace_loop
from martensite.fit.api import build_task
from martensite.fit.cross_validation import HeldOutError, PooledError, cross_validate, pool_errors, with_start
from martensite.fit.descents import INTERRUPTED, OUT_OF_TIME
from martensite.fit.drive_lag import find_drive
from martensite.fit.experiment_kinds.base import AbstractExperimentKind, Proposal
from martensite.fit.experiment_kinds.driven import add_waist
from martensite.fit.fit import Fit
from martensite.fit.logs import AUTO
from martensite.fit.problem import Problem
from martensite.fit.proposal_changes import fix_parameter
from martensite.fit.search_monitor import SearchNote
from martensite.fit.solve import solve_problem
from martensite.scenario.exact_text import exact_text
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.search.quantity_text import list_names
from martensite.search.time_box import OutOfTimeError, TimeBox

CLEARLY = 0.85
"""Ratio of held-out errors below which a model with more parameters replaces a simpler one."""
FLOOR = 1.1
"""Held-out error over the scatter of the rows below which no richer law is tried."""
EXCELLENT = 99.0
"""Held-out fit [%] of loops from which no richer law is tried."""
CONFUSED = 0.995
"""Absolute correlation from which one of two parameters is fixed."""
EVALUATIONS = 60
"""Evaluations of one local search."""
GOOD = 93.0
"""Held-out fit [%] of a simple law above which rounder transformations are not tried."""
TRANSFORMED = 0.05
"""Least range of the martensite fraction that counts as a transformation."""
ENOUGH = 0.6
"""Used fraction of the time box from which no further proposal is tried."""
ALWAYS_FREE = ("A_s", "A_f", "M_s", "M_f", "eps_L", "H_min", "H_sat", "sigma_s", "sigma_f")
"""Parameters that no simplification fixes."""
INTERRUPTION, BOX = "interruption", "time box"
"""Reasons for an early end of the trials."""

Stage = Callable[[str], None]
Keep = Callable[[Problem, SearchNote], None]


class AbstractTried(Protocol):
    """Fit with a held-out error."""

    @property
    def fit(self) -> Fit:
        """Return the fit."""
        ...

    @property
    def error(self) -> float:
        """Return the held-out error."""
        ...


Tried = TypeVar("Tried", bound=AbstractTried)


@dataclass(frozen=True)
class TriedModel:
    """Proposal with its fit to all records and its predictions."""

    proposal: Proposal
    fit: Fit
    errors: tuple[HeldOutError, ...]

    @cached_property
    def pooled_errors(self) -> list[PooledError]:
        """Return the held-out errors by output, the main output first; empty if not tested."""
        return pool_errors(self.errors)

    @property
    def error(self) -> float:
        """Return the held-out error of the first output [SI]; infinite if not tested."""
        return self.pooled_errors[0].rms if self.pooled_errors else math.inf


@dataclass
class ModelTrials:
    """Trials of proposals within a time box."""

    kind: AbstractExperimentKind
    box: TimeBox
    tell: Stage
    starts: int | None = None
    """Number of further local searches, from the best of many points; None for the number of the proposal."""
    hold_out: str = AUTO
    keep: Keep | None = None
    """Callback after every evaluation, with the problem and the best point."""
    tried_models: list[TriedModel] = field(default_factory=list[TriedModel])
    notes: list[str] = field(default_factory=list[str])
    stop_reason: str = ""
    """Reason for an early end; empty without one."""

    def run(self, proposals: Sequence[Proposal]) -> None:
        """Try proposals, the simplest first, until the error is within the scatter, or the time is used up.

        Raises:
            SolveError: no proposal can be run.
        """
        waiting = list(proposals)
        while waiting and not self.stop_reason:
            self._try_next(waiting.pop(0))
            if self._is_enough():
                break
            if not waiting and self.tried_models and (more := self._propose_rounder()):
                waiting.append(more)
        if self.stop_reason and waiting:
            names = list_names([one.name for one in waiting])
            self.notes.append(f"Not tried, because of the {self.stop_reason}: {names} (`--time-box`).")
        if not self.tried_models:
            raise SolveError(f"None of the proposed models can be run. {' '.join(self.notes)}")

    def _try_next(self, proposal: Proposal) -> None:
        """Try a proposal, and then a simplified one if parameters are undetermined."""
        try:
            model = self._try_proposal(proposal)
            self.tried_models.append(model)
            simpler = None if self.stop_reason else simplify_proposal(model)
            if simpler is not None:
                self.tried_models.append(self._try_proposal(simpler))
        except (SolveError, ParameterError) as error:
            self.notes.append(f"Left out: {proposal.name}. {error}")
        except OutOfTimeError:
            self.stop_reason = BOX
        except KeyboardInterrupt:
            accept_interrupt()
            self.stop_reason = INTERRUPTION
            if not self.tried_models:
                raise
        if self.box.share >= ENOUGH:
            self.stop_reason = self.stop_reason or BOX

    def _try_proposal(self, proposal: Proposal) -> TriedModel:
        self.tell(proposal.name)
        scenario = read_proposal(proposal)
        problem = arrange_proposal(proposal, scenario)
        fit = replace(self._solve_from_starts(problem, proposal), scenario=scenario)
        if fit.reason == INTERRUPTED:
            self.stop_reason = INTERRUPTION
            return TriedModel(proposal, fit, ())
        try:
            errors = cross_validate(fit, problem.free, kind=self.kind, hold_out=self.hold_out, box=self.box)
        except KeyboardInterrupt:
            accept_interrupt()
            self.stop_reason, errors = INTERRUPTION, []
        return TriedModel(proposal, fit, tuple(errors))

    def _solve_from_starts(self, problem: Problem, proposal: Proposal) -> Fit:
        """Return the best of several local searches, preferably with a transformation."""
        fits: list[Fit] = []
        spread = proposal.spread if self.starts is None else self.starts
        most = EVALUATIONS if spread else 2 * EVALUATIONS  # loops are cheap
        limit = self.box.limit(self.box.share + 0.5 * (1.0 - self.box.share))

        def watch(note: SearchNote) -> None:
            if self.keep is not None and math.isfinite(note.cost):
                self.keep(problem, note)
            limit(note)

        for start in ({}, *proposal.others):
            try:
                trial_problem = with_start(problem, start)
                more = 0 if fits else spread
                fits.append(solve_problem(trial_problem, starts=more, most=most, inputs=False, tell=watch))
            except SolveError:
                continue
            if fits[-1].reason in (INTERRUPTED, OUT_OF_TIME):
                break
        if not fits:
            raise SolveError(f"Every run of the proposal `{proposal.name}` fails.")
        moving = [fit for fit in fits if find_transformed(fit) > TRANSFORMED]
        return min(moving or fits, key=lambda fit: fit.cost)

    def _is_enough(self) -> bool:
        """Return whether the best model has a small error, or an error within the scatter."""
        if not self.tried_models or not self.tried_models[-1].pooled_errors:
            return False
        best = choose_model(self.tried_models)
        pooled = best.pooled_errors[0]
        good = bool(self.kind.axis) and pooled.predicts and pooled.fit_percent >= EXCELLENT
        return good or best.error <= FLOOR * measure_scatter(best)

    def _propose_rounder(self) -> Proposal | None:
        """Return the best proposal of a driven element with rounder transformations, if its error is too large."""
        best = choose_model(self.tried_models)
        if not (self.kind.shows_shape and best.proposal.spread and best.pooled_errors):
            return None
        return add_waist(best.proposal, best.fit.numbers) if best.pooled_errors[0].fit_percent < GOOD else None


def read_proposal(proposal: Proposal) -> Scenario:
    """Return the scenario of a proposal, with the first of its records."""
    return read_scenario(proposal.text, log=proposal.rows[0])


def arrange_proposal(proposal: Proposal, scenario: Scenario) -> Problem:
    """Return the problem of a proposal without held-out data."""
    task = build_task(scenario, list(proposal.rows), list(proposal.free))
    task = task.with_changes(each=list(proposal.each), hold_out="none", columns=list(proposal.columns))
    return task.arrange(check=False).problem


def rebuild_problem(proposals: Sequence[Proposal], model: TriedModel) -> Problem:
    """Return the problem of a model with its document and rows from other proposals.

    Raises:
        SolveError: the proposals do not contain its law.
    """
    name = model.proposal.name
    alike = [one for one in proposals if name == one.name or name.startswith(f"{one.name}, ")]
    if not alike:
        raise SolveError(f"There is no other proposal of `{name}`.")
    same = max(alike, key=lambda one: len(one.name))
    if name.endswith("with a waist") and not same.name.endswith("with a waist"):
        same = add_waist(same, model.fit.numbers)
    proposal = replace(same, free=model.proposal.free, each=model.proposal.each)
    return replace(arrange_proposal(proposal, read_proposal(proposal)), free=model.fit.problem.free)


def choose_model(tried: Sequence[Tried]) -> Tried:
    """Return the simplest model, unless one with more parameters has a clearly smaller held-out error."""
    ranked = sorted(tried, key=lambda one: (len(one.fit.problem.free), one.error))
    best = ranked[0]
    for one in ranked[1:]:
        if one.error < CLEARLY * best.error:
            best = one
    return best


def measure_scatter(model: TriedModel) -> float:
    """Return the root-mean-square scatter of the first measured output [SI], with the jitter of its drive."""
    squares: list[float] = []
    for one in model.fit.problem.experiments:
        y = one.measured[:, 0]
        y = y[np.isfinite(y)]
        squares.append(estimate_scatter(y) ** 2)
        error = model.proposal.jitter.get(one.record.name, 0.0)
        if error:
            path = trace_loop(np.asarray(one.record[one.follows[find_drive(one)]])[one.rows])
            steps = np.diff(path.drive)
            slopes = np.diff(smooth_legs(y, path.turns)[0])[steps != 0.0] / steps[steps != 0.0]
            squares[-1] += error**2 * float(np.mean(slopes**2))
    return math.sqrt(float(np.mean(squares)))


def simplify_proposal(tried: TriedModel) -> Proposal | None:
    """Return the proposal with needless parameters fixed; None if there are none, or if the element is driven.

    A parameter at a bound or without an interval is fixed at its start. One of two confounded parameters is fixed at
    its fitted value, so that the prediction stays. In a driven element they set the scale of others.
    """
    proposal, fit = tried.proposal, tried.fit
    if proposal.spread:
        return None
    names = {text.partition("=")[0].strip() for text in proposal.free}
    undetermined, confounded = (list(dict.fromkeys(n for n in x if n in names)) for x in _list_needless(fit))
    if not undetermined and not confounded:
        return None
    units = {free.name: free.unit for free in fit.problem.free}
    simpler_proposal = proposal
    for name in undetermined:
        simpler_proposal = fix_parameter(simpler_proposal, name)
    for name in confounded:
        simpler_proposal = fix_parameter(simpler_proposal, f"{name}={exact_text(fit[name], units[name])}")
    fixed = len(proposal.free) - len(simpler_proposal.free)
    again = {name: value for name, value in fit.numbers.items() if name not in (*undetermined, *confounded)}
    return replace(simpler_proposal, name=f"{proposal.name}, {fixed} fixed", others=(again,))


def _list_needless(fit: Fit) -> tuple[list[str], list[str]]:
    """Return the undetermined parameters, and of each confounded pair of others the one that is not always free."""
    names = [free.name for free in fit.problem.free if free.record is None]
    can = [name for name in names if name.partition("-")[0] not in ALWAYS_FREE]
    undetermined = [name for name in can if name in fit.undetermined]
    pairs = [(other, one) for one, other, _ in fit.uncertainty.list_confounded(CONFUSED)]
    candidates = [next((name for name in pair if name in can), "") for pair in pairs]
    return undetermined, [name for name in candidates if name and name not in undetermined]


def find_transformed(fit: Fit) -> float:
    """Return the largest range of the martensite fraction in a fitted record."""
    most = 0.0
    for k, one in enumerate(fit.problem.experiments):
        system = fit.system(k)
        runner = one.runner(
            fit.problem.step, [system.label(port, "martensite_fraction") for port in system.actuators()]
        )
        run = runner.run_one(np.array(runner.compiled.values(system)))
        most = max(most, 0.0 if run is None else float(np.ptp(run, axis=0).max()))
    return most
