"""Errors: each is one sentence that states the given value, the allowed values and the remedy.

`InputError` and its subclasses mean bad input (exit code 2); `SolveError` means that a run failed (exit code 1).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from difflib import get_close_matches

MOST_LISTED = 40
"""Largest number of names that a sentence lists."""
LONG_WORD = re.compile(r"[^\s`]{500,}")
"""Words that a sentence shortens."""


class MartensiteError(Exception):
    """Base of all errors that this package raises on purpose."""

    exit_code = 1

    def __str__(self) -> str:
        return LONG_WORD.sub(lambda word: f"{word[0][:60]}… ({len(word[0])} characters)", super().__str__())


class InputError(MartensiteError):
    """Invalid input; nothing was changed or written."""

    exit_code = 2


class UnknownNameError(InputError):
    """Name that is not valid."""

    def __init__(self, kind: str, name: str, valid: Iterable[str], where: str = "") -> None:
        super().__init__(f"No {kind} named `{name}`. {suggest_name(name, valid, where)}")


def require_known(kind: str, name: str, valid: Collection[str]) -> None:
    """Raise `UnknownNameError` unless a name is valid."""
    if name not in valid:
        raise UnknownNameError(kind, name, valid)


class MissingMethodError(InputError, NotImplementedError):
    """Class that lacks methods its kind must have."""


class KernelError(InputError, TypeError):
    """Kernel code that cannot be traced."""


class UnknownOperationError(KernelError, AttributeError):
    """Operation that kernels do not have."""


class UnitError(InputError):
    """Quantity that cannot be read, or has the wrong unit."""


class ParameterError(InputError):
    """Parameter that is missing, unknown or out of range."""


class DataError(InputError):
    """Data file that is missing, malformed or incomplete."""


class SolveError(MartensiteError):
    """Simulation that could not be completed."""


class BudgetError(SolveError):
    """CPU time limit reached."""


class StoppedError(MartensiteError):
    """Computation that stopped early; results so far are kept, and the sentence explains how to resume."""


class CompileError(MartensiteError):
    """Program that could not be compiled; the Python runtime still works."""


def suggest_name(name: str, valid: Iterable[str], where: str = "") -> str:
    """Return 'Did you mean …?' for the nearest valid names, and all valid names if they are few.

    Args:
        name: given name.
        valid: allowed names.
        where: hint where a long list is found, such as "`martensite list` lists them".
    """
    names = sorted({*valid})
    lower = {one.lower(): one for one in reversed(names)}
    long = len(names) > MOST_LISTED
    near = get_close_matches(name[:100].lower(), lower, n=3 if long else 1, cutoff=0.6)
    meant = f"Did you mean {' or '.join(f'`{lower[one]}`' for one in near)}? " if near else ""
    if long:
        return f"{meant}{len(names)} names are valid{f'; {where}' if where else ''}."
    return f"{meant}Valid: {', '.join(f'`{one}`' for one in names) or 'none'}."
