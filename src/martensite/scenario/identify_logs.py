"""Models from log files without settings.

The columns are the given ones, else the only columns of the log, else those with telling headings: a drive (duty,
voltage, current, power) is the input, and a motion, a force or a temperature the output.
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
"""Names of input columns, in order of preference."""
ANSWERING = (
    *(*reversed(list_quantities("shape")), "angle", *reversed(list_quantities("load"))),
    *("temperature", "resistance", "rotor_speed", "y", "output"),
)
"""Names of output columns, in order of preference."""


def list_columns(log: str, given: Mapping[str, str] | None = None) -> list[str]:
    """Return the names of the columns of a log, without its time."""
    if given or not is_columnar(log):
        names = list(read_log_table(log, new_headings=given).columns)
    else:
        names = [name_column(column.heading) for column in read_container(Path(log)).columns]
    return [name for name in names if name != "time"]


def choose_columns(
    log: str, inputs: Sequence[str], output: str | None, named: Sequence[str], given: Mapping[str, str] | None = None
) -> tuple[list[str], str]:
    """Return the inputs and the last output: the given columns, else the only remaining ones.

    Raises:
        InputError: the log leaves a choice.
    """
    if inputs and output is not None:
        return list(inputs), output
    columns = list_columns(log, given)
    free = [name for name in columns if name not in (*inputs, *named, output)]
    if not inputs:
        last = output is not None or bool(named)
        if len(free) != (1 if last else 2):
            raise InputError(_explain_lack("--input", columns))
        inputs, free = free[:1], free[1:]
    if output is None and named:
        output = named[-1]
    if output is None:
        if len(free) != 1:
            raise InputError(_explain_lack("--output", columns))
        output = free[0]
    return list(inputs), output


def guess_columns(
    log: str, inputs: Sequence[str], output: str | None, given: Mapping[str, str] | None = None
) -> tuple[list[str], str, str]:
    """Return the inputs, the output and the reason: given, the only ones, or by their names.

    Raises:
        InputError: the headings leave a choice.
    """
    try:
        chosen = choose_columns(log, inputs, output, (), given)
        why = "as given" if inputs and output else "there are no others"
    except InputError:
        columns = list_columns(log, given)
        left = [name for name in columns if name not in (*inputs, output)]
        drives = list(inputs) or _find_first(left, DRIVING)
        answers = [output] if output else _find_first([name for name in left if name not in drives], ANSWERING)
        if not drives or not answers:
            raise
        chosen, why = (drives, answers[0]), f"by their names, of {', '.join(f'`{name}`' for name in columns)}"
    names = ", ".join(f"`{name}`" for name in chosen[0])
    return *chosen, f"Input {names}, output `{chosen[1]}`: {why}; --input and --output name others."


def _find_first(columns: Sequence[str], words: Sequence[str]) -> list[str]:
    """Return the first column whose name or meaning is one of some words."""
    meant = {name: (name.rpartition(".")[2].lower(), guess_heading(name).name.rpartition(".")[2]) for name in columns}
    first = next(([name] for word in words for name in columns if word in meant[name]), [])
    return first or [name for name in columns if {"input", "output"} & set(words) & set(name.lower().split("_"))][:1]


def _explain_lack(option: str, columns: Sequence[str]) -> str:
    listed = f": {', '.join(f'`{name}`' for name in columns)}" if columns else ""
    return f"Identification needs {option}, a column of the logs{listed}; none given."


def read_logs(
    logs: Sequence[str],
    inputs: Sequence[str],
    outputs: Sequence[str],
    interval: float | None = None,
    units: Mapping[str, str] | None = None,
    new_headings: Mapping[str, str] | None = None,
) -> list[Sampled]:
    """Return the records of logs, at their own sample time by default; a log with gaps gives several."""
    both = set(inputs) & set(outputs)
    if both:
        raise InputError(
            f"Column `{min(both)}` is given as input and as output; a column says nothing about itself, so name "
            "another one."
        )
    return [record for log in logs for record in read_pieces(log, inputs, outputs, interval, units, new_headings)]


def identify_log(
    path: str | Path | Sequence[str | Path],
    inputs: Sequence[str] = (),
    output: str | None = None,
    *,
    validation: Sequence[str | Path] = (),
    other: Sequence[str | Path] = (),
    interval: float | None = None,
    units: Mapping[str, str] | None = None,
    new_headings: Mapping[str, str] | None = None,
    options: Options | None = None,
    time_box: float = TIME_BOX,
    watch: Watch | None = None,
    keep: Keep | None = None,
) -> Ladder:
    """Return the simplest model with the best prediction of a log, as `martensite identify LOG` does.

    Args:
        path: one log or several; logs of another regime than the first are set apart.
        inputs: input columns; guessed by default.
        output: output column, or several with commas.
        validation: logs for the choice, instead of blocks of the first.
        other: held-out logs, instead of the last block.
        interval: sample time [s], by default as in the log.
        units: units of columns, such as `{"duty": "%"}`.
        new_headings: meaning of columns without a telling heading (`read_lab_file`).
        options: estimation of the best structure of each rung.
        time_box: processor time [s].
        watch: called with a sentence and the used fraction of the time.
        keep: called with every better model.

    Raises:
        DataError: a log cannot be read.
        InputError: the columns leave a choice or hold no information.
        SolveError: no model was found.
    """
    logs = [str(path)] if isinstance(path, str | Path) else [str(one) for one in path]
    names, last, why = guess_columns(logs[0], inputs, output, new_headings)
    ends = [name.strip() for name in last.split(",") if name.strip()]
    fitted = read_logs(logs, names, ends, interval, units, new_headings)
    chosen_by, held_out = (
        read_logs([str(one) for one in group], names, ends, fitted[0].interval, units, new_headings)
        for group in (validation, other)
    )
    ladder = climb_ladder(fitted, chosen_by, held_out, options, time_box, watch, keep)
    return replace(ladder, tests=(why, *ladder.tests))
