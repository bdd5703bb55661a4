"""Which columns go in and which come out, where the command line does not say."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from martensite.base.errors import InputError


def list_columns(log: str) -> list[str]:
    """Names of the columns of a log, without its time."""
    from martensite.scenario.binary_files import name_column, read_arrays
    from martensite.scenario.sampled_files import is_text
    from martensite.scenario.tables import read_table

    known = read_table(log, gaps=True).columns if is_text(log) else map(name_column, read_arrays(Path(log)))
    return [name for name in known if name != "time"]


def choose_columns(log: str, inputs: Sequence[str], output: str | None, named: Sequence[str]) -> tuple[list[str], str]:
    """Inputs and last output: those given, else what alone is left in the log.

    Args:
        log: the first log.
        inputs: columns given as inputs.
        output: the column given as output.
        named: columns that stages name as what they give, in their order.

    Raises:
        InputError: the log leaves a choice.
    """
    if inputs and output is not None:
        return list(inputs), output
    found = list_columns(log)
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


def _explain_lack(option: str, found: Sequence[str]) -> str:
    listed = f": {', '.join(f'`{name}`' for name in found)}" if found else ""
    return f"Identification needs {option}, a column of the logs{listed}; none given."
