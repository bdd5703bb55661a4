"""A model from log files without any choice: columns, regimes, structure and verdict are found and said.

Columns are those that are given; else those that alone are left in the log; else those whose headings say what
they are: what drives (duty, voltage, current, power) goes in, a motion or else a force or a temperature comes out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from martensite.base.errors import InputError
from martensite.identify.chains.estimate import Options
from martensite.identify.ladder.climb import TIME_BOX, Keep, Watch, climb_ladder
from martensite.identify.ladder.ladder_result import Ladder
from martensite.logs.container_files import read_container
from martensite.logs.heading_guess import guess_heading
from martensite.logs.layout import list_quantities, name_column
from martensite.logs.reader import is_columnar, read_log_table
from martensite.logs.sampled_files import read_pieces
from martensite.signals.sampling.sampled import Sampled

DRIVING = (*list_quantities("drive"), "u", "input")
"""Columns taken as input: the first that a log has."""
ANSWERING = (*reversed(list_quantities("shape")), "angle", *reversed(list_quantities("load")), "temperature")
ANSWERING += ("resistance", "rotor_speed", "y", "output")
"""Columns taken as output: the first that a log has."""


def list_columns(log: str, given: Mapping[str, str] | None = None) -> list[str]:
    """Return the names of the columns of a log, without its time."""
    if given or not is_columnar(log):
        known = list(read_log_table(log, named=given).columns)
    else:
        known = [name_column(column.heading) for column in read_container(Path(log)).columns]
    return [name for name in known if name != "time"]


def choose_columns(
    log: str, inputs: Sequence[str], output: str | None, named: Sequence[str], given: Mapping[str, str] | None = None
) -> tuple[list[str], str]:
    """Return the inputs and last output: those given, else what alone is left in the log.

    Raises:
        InputError: the log leaves a choice.
    """
    if inputs and output is not None:
        return list(inputs), output
    found = list_columns(log, given)
    free = [name for name in found if name not in (*inputs, *named, output)]
    if not inputs:
        last = output is not None or bool(named)
        if len(free) != (1 if last else 2):
            raise InputError(_explain_lack("--input", found))
        inputs, free = free[:1], free[1:]
    if output is None and named:
        output = named[-1]
    if output is None:
        if len(free) != 1:
            raise InputError(_explain_lack("--output", found))
        output = free[0]
    return list(inputs), output


def guess_columns(
    log: str, inputs: Sequence[str], output: str | None, given: Mapping[str, str] | None = None
) -> tuple[list[str], str, str]:
    """Return the inputs, output and why these: given, alone in the log, or named like what drives and what answers.

    Raises:
        InputError: the headings leave a choice.
    """
    try:
        found = choose_columns(log, inputs, output, (), given)
        why = "as given" if inputs and output else "there are no others"
    except InputError:
        columns = list_columns(log, given)
        left = [name for name in columns if name not in (*inputs, output)]
        drives = list(inputs) or _find_first(left, DRIVING)
        answers = [output] if output else _find_first([name for name in left if name not in drives], ANSWERING)
        if not drives or not answers:
            raise
        found, why = (drives, answers[0]), f"by their names, of {', '.join(f'`{name}`' for name in columns)}"
    names = ", ".join(f"`{name}`" for name in found[0])
    return *found, f"Input {names}, output `{found[1]}`: {why}; --input and --output name others."


def _find_first(columns: Sequence[str], words: Sequence[str]) -> list[str]:
    """Return the column that is called, or means, the first of some words that any does."""
    meant = {name: (name.rpartition(".")[2].lower(), guess_heading(name).name.rpartition(".")[2]) for name in columns}
    spoken = next(([name] for word in words for name in columns if word in meant[name]), [])
    return spoken or [name for name in columns if {"input", "output"} & set(words) & set(name.lower().split("_"))][:1]


def _explain_lack(option: str, found: Sequence[str]) -> str:
    listed = f": {', '.join(f'`{name}`' for name in found)}" if found else ""
    return f"Identification needs {option}, a column of the logs{listed}; none given."


def read_logs(
    logs: Sequence[str],
    inputs: Sequence[str],
    outputs: Sequence[str],
    interval: float | None = None,
    units: Mapping[str, str] | None = None,
    named: Mapping[str, str] | None = None,
) -> list[Sampled]:
    """Return the records of logs, each at its own sample time unless one is given; more than one of a log with gaps."""
    both = set(inputs) & set(outputs)
    if both:
        raise InputError(
            f"Column `{min(both)}` is given as input and as output; a column says nothing about itself, so name "
            "another one."
        )
    return [record for log in logs for record in read_pieces(log, inputs, outputs, interval, units, named)]


def identify_log(
    path: str | Path | Sequence[str | Path],
    inputs: Sequence[str] = (),
    output: str | None = None,
    *,
    validation: Sequence[str | Path] = (),
    other: Sequence[str | Path] = (),
    interval: float | None = None,
    units: Mapping[str, str] | None = None,
    named: Mapping[str, str] | None = None,
    options: Options | None = None,
    time_box: float = TIME_BOX,
    watch: Watch | None = None,
    keep: Keep | None = None,
) -> Ladder:
    """Return the simplest model that predicts a log best, as `martensite identify LOG` finds it.

    Args:
        path: one log or several; those of another regime than the first are set apart.
        inputs: columns that go in; found by themselves if left out.
        output: column that comes out; several with commas.
        validation: logs to choose by, instead of blocks of the first.
        other: logs that are held out, instead of the last block.
        interval: sample time [s]; by default that of the log.
        units: of columns, such as `{"duty": "%"}`.
        named: what columns are whose headings do not say it (`read_lab_file`).
        options: how the best structure of each rung is estimated.
        time_box: processor time [s].
        watch: called with a sentence and the share of the time that is used.
        keep: called with every better model as soon as it is found.

    Raises:
        DataError: a log cannot be read.
        InputError: the columns leave a choice, or say nothing at all.
        SolveError: not even a linear model was found.
    """
    logs = [str(path)] if isinstance(path, str | Path) else [str(one) for one in path]
    names, last, why = guess_columns(logs[0], inputs, output, named)
    ends = [name.strip() for name in last.split(",") if name.strip()]
    fitted = read_logs(logs, names, ends, interval, units, named)
    chosen_by, held = (
        read_logs([str(one) for one in group], names, ends, fitted[0].interval, units, named)
        for group in (validation, other)
    )
    found = climb_ladder(fitted, chosen_by, held, options, time_box, watch, keep)
    return replace(found, tests=(why, *found.tests))
