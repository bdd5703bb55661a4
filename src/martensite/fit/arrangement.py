"""From a task to a problem: what is compared, what is kept back, and with which steps.

Every log gets a scenario of its own, built with it where the scenario follows a log. Then what
drives is told from what is compared, parts are kept back, steps are chosen, and the whole is
looked at (`checks`) before anything is searched for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from martensite.base.errors import InputError
from martensite.fit.column_matching import match_columns
from martensite.fit.columns import ComparedColumn, read_columns, read_noise
from martensite.fit.experiment import Experiment
from martensite.fit.fit_task import ArrangedFit, FitTask
from martensite.fit.free_parameters import DELAY, OFFSET, read_ranges
from martensite.fit.hold_out import ALL, AUTO, NONE, choose_held_out
from martensite.fit.logs import LoadedLog, describe_gaps, describe_untimed, read_logs
from martensite.fit.problem import build_problem
from martensite.fit.start_checks import check_start, find_silent_outputs
from martensite.fit.step_choice import choose_step
from martensite.search.free_numbers import SearchRange


def arrange_task(task: FitTask) -> ArrangedFit:
    """The problem of a task.

    Raises:
        InputError: logs, scenario and free parameters do not fit each other.
        SolveError: a run that is to show the step fails.
    """
    if not task.logs:
        raise InputError("A fit needs at least one log; none given.")
    found = read_logs(task.logs)
    systems = [one.scenario.system for one in found]
    free, each = read_ranges(task.free, systems), read_ranges(task.each, systems, own=True)
    noise, wanted = read_noise(task.noise, systems), read_columns(task.columns)
    made, notes = _build_experiments(found, task, wanted)
    if not wanted:
        made, more = _drop_silent_outputs(made, free, each)
        notes += more
    stepped, more = _choose_steps(made, found, task.step)
    whole = build_problem(stepped, free, each=each, noise=noise)
    follows = list(dict.fromkeys(found[0].scenario.follows.values()))
    notes += [*more, *check_start(whole.training, follows)]
    models = {one.name: (one.scenario, one.log.model) for one in found}
    return ArrangedFit(whole, models, task.search, tuple(notes))


def _choose_steps(
    made: Sequence[Experiment], found: Sequence[LoadedLog], step: float | None
) -> tuple[list[Experiment], list[str]]:
    """Experiments with their steps: as asked for, of the scenario, or to its tolerance."""
    stepped: list[Experiment] = []
    notes: list[str] = []
    for one, source in zip(made, found, strict=True):
        given = source.scenario.step if step is None else step
        if given is None:
            one, more = choose_step(one, source.scenario.tolerance)
            notes += more
        else:
            one = replace(one, step=given)
        stepped.append(one)
    return stepped, notes


def _build_experiments(
    found: Sequence[LoadedLog], task: FitTask, wanted: Sequence[ComparedColumn]
) -> tuple[list[Experiment], list[str]]:
    """One experiment per record, without steps, and what to say of its columns."""
    held = _choose_held_out(found, task.hold_out)
    made: list[Experiment] = []
    notes: list[str] = []
    for one, stretches in zip(found, held, strict=True):
        system, follows = one.scenario.system, one.scenario.follows
        columns, record, more = match_columns(one.record, system, wanted, follows)
        notes += [*more, *describe_gaps(one, columns.values())]
        made.append(
            Experiment(
                one.name,
                system,
                one.scenario.waveform,
                record,
                columns,
                held=stretches,
                weights=dict.fromkeys(columns, one.log.weight),
                lead=one.scenario.lead,
            )
        )
    return made, [*notes, *describe_untimed(found)]


def _choose_held_out(found: Sequence[LoadedLog], hold_out: str | Sequence[str]) -> list[Any]:
    names, flags = [one.name for one in found], [one.log.held for one in found]
    if all(flags):
        raise InputError("All records are held out, and none is left to be fitted.")
    rule = NONE if any(flags) and hold_out == AUTO else hold_out
    held = choose_held_out(rule, names, [one.record.times for one in found])
    return [ALL if flag else one for flag, one in zip(flags, held, strict=True)]


def _drop_silent_outputs(
    made: list[Experiment], free: Sequence[SearchRange], each: Sequence[SearchRange]
) -> tuple[list[Experiment], list[str]]:
    """Experiments without the outputs that no free parameter moves in any record."""
    training = build_problem(made, free, each=_select_system_ranges(each)).training
    quiet = find_silent_outputs(training)
    heard = {
        output
        for one in training.experiments
        for output in one.outputs
        if (one.name, output) not in quiet
    }
    lost = [name for name in dict.fromkeys(name for _, name in quiet) if name not in heard]
    kept = [{n: c for n, c in one.columns.items() if n not in lost} for one in made]
    if not lost or not all(kept):
        return made, []
    notes = [f"Nothing that is free moves `{name}`, which is not compared." for name in lost]
    return [replace(one, columns=c) for one, c in zip(made, kept, strict=True)], notes


def _select_system_ranges(each: Sequence[SearchRange]) -> list[SearchRange]:
    """Those that move a system, not what is read off it."""
    return [one for one in each if one.name != DELAY and one.name.partition(".")[0] != OFFSET]
