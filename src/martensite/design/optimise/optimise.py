"""Optimisation of the numbers of an actuator: the best goal with all limits kept.

The box is sampled, then searched by descents with exact derivatives; whole numbers are rounded together with their
neighbours (`search`). Runs have fixed steps, at most a tenth of the smallest thermal time constant in the box. At the
final design the steps are halved until the change is small, and the design is adjusted.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError, SolveError
from martensite.design.optimise.evaluate import DesignEvaluator, Numbers, apply_numbers
from martensite.design.optimise.optimised_design import (
    OptimisedDesign,
    ReportedMeasure,
    RoundedDesign,
    find_multipliers,
)
from martensite.design.optimise.question import (
    Constraint,
    DesignAim,
    DesignQuestion,
    build_life_constraints,
    describe_life,
    read_aim,
    read_question,
)
from martensite.design.optimise.search import DesignSearch, Keep, round_design, search_designs, start_search
from martensite.search.box_search import FEASIBLE_VIOLATION, BoxPoint, SearchMark, Tell
from martensite.search.free_numbers import BOX_TEMPERATURE
from martensite.simulate.api import longest_step, simulate
from martensite.simulate.drive_waveforms import Waveforms
from martensite.simulate.judgement import Judgement, describe_excess, judge_run
from martensite.simulate.waveform_levels import WaveformLevels

ACCURACY = 1e-3
"""Accepted change on halving the step, as a fraction of limits and of the goal."""
HALVINGS = 5
SHOWN = (
    "stroke",
    "rise-time",
    "fall-time",
    "energy",
    "max({stress})",
    "stroke({strain})",
    "max({hottest})",
    "max({power})",
    "max({current})",
    "max({voltage})",
)
"""Measures that are always reported."""


def optimise_design(
    system: AbstractSystem,
    waveform: Waveforms,
    duration: float,
    free: Sequence[str],
    *,
    minimise: str | None = None,
    maximise: str | None = None,
    subject: Sequence[str] = (),
    life: float | None = 0.0,
    cases: Sequence[str] = (),
    samples: int = 1001,
    step: float | None = None,
    accuracy: float = ACCURACY,
    search: DesignSearch | None = None,
    scenario_paths: Mapping[str, str] | None = None,
    watch: Tell | None = None,
    keep: Keep | None = None,
    native: bool | None = None,
) -> OptimisedDesign:
    """Return the best design of a system in a run from the steady state.

    Args:
        system: a `System` of one element, or a `Machine` of several, as the start of the search.
        waveform: drive signal, or signals by name.
        duration: length of the run [s].
        free: free parameters, such as `element.diameter=0.05..0.5 mm` or `drive.peak=1..5 W`.
        minimise: measure to minimise, by default `energy`.
        maximise: measure to maximise.
        subject: constraints, such as `max(stress) <= 200 MPa` or `stroke >= 30 deg`.
        life: margin to the declared limits of the elements (stress, strain, temperature), as a fraction of them; None
            ignores the limits.
        cases: further cases, such as `environment.temperature=35 degC`.
        samples: number of samples for the measures.
        step: longest step [s], by default chosen and refined.
        accuracy: accepted change on halving the step, as a fraction of limits and of the goal.
        search: options of the search.
        scenario_paths: path in the scenario by path in the system.
        watch: called with a sentence and the finished fraction.
        keep: called with every better design, at first with continuous whole numbers.
        native: run in C, by default if there is a compiler.

    Raises:
        InputError: a text is malformed, a name or unit is wrong, or bounds are invalid.
        SolveError: no design can be run.
    """
    goal, most = _choose_goal(minimise, maximise), maximise is not None
    steering = WaveformLevels(system, waveform, duration)
    question = read_question(steering, free, goal, subject, most=most, cases=cases, scenario_paths=scenario_paths)
    question, limits = _add_limits(steering, question, life)
    first = step or min(_find_longest_step(steering, question), duration / (samples - 1))
    also = _list_measures(steering, {aim.words for aim in question.aims})
    designs = DesignEvaluator(steering, question, samples=samples, step=first, also=also, native=native)
    how = search or DesignSearch()
    begin = np.array([one.share(one.start) for one in question.free])
    hunt = search_designs(designs, begin, how, watch, keep)
    history = list(hunt.history)
    point, tried, relaxed = round_design(hunt, question.free, hunt.best_point)
    if tried:
        history.append(_mark_progress(designs, point))
    halvings = HALVINGS if step is None else 0
    finer, point, apart = _refine_step(designs, point, how, watch, accuracy, halvings)
    history.append(_mark_progress(finer, point))
    answer = _build_answer(steering, finer, point, apart)
    exceeded = list_exceeded(answer, duration, samples)
    binding = () if life is None else exceeded
    if tried:
        answer = replace(
            answer,
            rounded_designs=tuple(_describe_rounded(designs, *one) for one in tried.items()),
            relaxed_numbers=tuple(designs.numbers(relaxed.z).tolist()),
            relaxed_goal=designs.restore_goal(relaxed.goal),
        )
    return replace(
        answer,
        feasible=answer.feasible and not binding,
        violated_constraints=(*answer.violated_constraints, *binding),
        exceeded_limits=exceeded,
        history=tuple(m._replace(goal=designs.restore_goal(m.goal)) for m in history),
        life=describe_life(limits, life, answer.violated_constraints, exceeded),
    )


def _choose_goal(minimise: str | None, maximise: str | None) -> str:
    if minimise is not None and maximise is not None:
        raise ParameterError("A design has one goal: name what to minimise, or what to maximise.")
    return maximise or minimise or "energy"


def _add_limits(
    steering: WaveformLevels, question: DesignQuestion, life: float | None
) -> tuple[DesignQuestion, list[Constraint]]:
    """Return a question with the limits of the elements, which every case must allow, and these limits."""
    limits = [] if life is None else build_life_constraints(steering, question.free, life)
    for case in question.cases:
        steering.system.with_values(case)
    return replace(question, subject=(*question.subject, *limits)), limits


def list_exceeded(design: OptimisedDesign, duration: float, samples: int) -> tuple[str, ...]:
    """Return the limits that a design exceeds in any case, as `run` and `check` find them.

    An excess within the accuracy of the design, as a fraction of the limit (of 50 K for a temperature), is ignored,
    because an active limit is met to that accuracy only.
    """
    exceeded: list[str] = []
    slack = max(design.accuracy, ACCURACY)
    for case in design.question.cases:
        system = design.steering.system.with_values(case)
        try:
            judged = judge_run(simulate(system, design.steering.waveforms, duration, samples=samples))
        except SolveError as error:
            judged = Judgement((), str(error))
        beyond = [
            one
            for one in judged.alarms
            if one.excess > slack * (BOX_TEMPERATURE if one.unit == "K" else abs(one.limit))
        ]
        exceeded += [words.rstrip(".") for words in (judged.outside, *map(describe_excess, beyond)) if words]
    return tuple(dict.fromkeys(exceeded))


def _find_longest_step(steering: WaveformLevels, question: DesignQuestion) -> float:
    """Return the shortest suitable step at the corners of the box [s]."""
    ends = [[(c.path, v) for v in (one.low, one.high)] for one in question.free for c in one.targets if c.level is None]
    corners = itertools.islice(itertools.product(*ends), 256)
    return min(longest_step(steering.system.rebuilt(dict(corner))) for corner in corners)


def _refine_step(
    designs: DesignEvaluator, point: BoxPoint, how: DesignSearch, watch: Tell | None, accuracy: float, halvings: int
) -> tuple[DesignEvaluator, BoxPoint, float]:
    """Return the design adjusted in sufficiently short steps, and its change on halving them."""
    fixed = np.array([one.whole for one in designs.question.free])
    finer = _halve_step(designs)
    apart = _compare_steps(designs, finer, point.z)
    for _ in range(halvings):
        if apart <= accuracy:
            break
        designs, finer = finer, _halve_step(finer)
        hunt = start_search(designs, how, watch)
        hunt.tell("shorter steps", 0.9)
        hunt.judge(point.z[None])
        hunt.descend(point.z, fixed)
        point = hunt.best_point
        apart = _compare_steps(designs, finer, point.z)
    return designs, point, apart


def _halve_step(old: DesignEvaluator) -> DesignEvaluator:
    """Return the evaluator with half the step; the counts continue."""
    designs = DesignEvaluator(
        old.steering, old.question, samples=old.samples, step=0.5 * old.grid.longest, also=old.also, native=old.native
    )
    designs.counts, designs.goal_size = old.counts, old.goal_size
    return designs


def _compare_steps(designs: DesignEvaluator, finer: DesignEvaluator, z: Numbers) -> float:
    """Return the largest change of goal and slacks."""
    both = [one.judge(z[None]) for one in (designs, finer)]
    goal = abs(both[0].goal[0] - both[1].goal[0])
    slack = np.abs(both[0].slack - both[1].slack)
    return float(max(goal, slack.max(initial=0.0)))


def _build_answer(steering: WaveformLevels, designs: DesignEvaluator, point: BoxPoint, apart: float) -> OptimisedDesign:
    """Return the optimised design without the history of the search."""
    question = designs.question
    numbers = tuple(designs.numbers(point.z).tolist())
    exact = tuple(float(round(v)) if one.whole else v for v, one in zip(numbers, question.free, strict=True))
    slack = designs.judge(point.z[None]).slack[0].reshape(-1, len(question.subject) or 1)
    missed = [c.words for k, c in enumerate(question.subject) if (slack[:, k] < -FEASIBLE_VIOLATION).any()]
    notes: list[str] = []
    if not point.feasible:
        notes.append(
            "No design in the box was found that keeps all constraints; this one misses least. "
            "Widen the bounds, or ask for less."
        )
    return OptimisedDesign(
        designs=designs,
        steering=apply_numbers(steering, question, exact),
        z=tuple(point.z.tolist()),
        numbers=exact,
        feasible=point.feasible,
        violated_constraints=tuple(missed),
        measures=_report_measures(designs, exact),
        balance=find_multipliers(designs, point.z),
        accuracy=apart,
        notes=notes,
    )


def _report_measures(designs: DesignEvaluator, numbers: Sequence[float]) -> tuple[ReportedMeasure, ...]:
    """Return all measures for the scenario and for the design."""
    start = [one.start for one in designs.question.free]
    aims = {aim.words: aim for aim in (*designs.question.aims, *designs.also)}
    before, after = designs.evaluate_aims(np.array([start, numbers]), list(aims.values()))
    return tuple(
        ReportedMeasure(aim.words, aim.unit, tuple(before[:, k].tolist()), tuple(after[:, k].tolist()))
        for k, aim in enumerate(aims.values())
    )


def _list_measures(steering: WaveformLevels, aim_words: set[str]) -> list[DesignAim]:
    """Return further measures of the actuators of a system."""
    system = steering.system
    aims: list[DesignAim] = []
    for form in SHOWN:
        name = form.partition("{")[2].partition("}")[0]
        ports = list(system.actuators()) if name else [""]
        for port in ports:
            words = form.format(**{name: system.label(port, name)}) if name else form
            if words not in aim_words:
                aims.append(read_aim(words, steering, ()))
    return aims


def _describe_rounded(designs: DesignEvaluator, whole: tuple[int, ...], point: BoxPoint) -> RoundedDesign:
    numbers = tuple(designs.numbers(point.z).tolist())
    goal = designs.restore_goal(point.goal)
    return RoundedDesign(whole, numbers, goal, point.feasible, point.violation)


def _mark_progress(designs: DesignEvaluator, point: BoxPoint) -> SearchMark:
    return SearchMark(designs.runs, point.goal, point.violation)
