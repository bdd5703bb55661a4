"""Errors: every one is a sentence a user can act on.

Form: what was given, what is allowed, the nearest valid name. `InputError` and its children mean bad input (exit code
2 on the command line); `SolveError` means that a run started and failed (exit code 1).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from difflib import get_close_matches

MOST_LISTED = 40
"""Most names that a sentence lists."""
LONG_WORD = re.compile(r"[^\s`]{500,}")
"""Words that a sentence does not repeat in full."""


class MartensiteError(Exception):
    """Base of all errors raised on purpose by this package."""

    exit_code = 1

    def __str__(self) -> str:
        """Return the sentence; of a word without end its beginning."""
        said = super().__str__()
        return LONG_WORD.sub(lambda word: f"{word[0][:60]}… ({len(word[0])} characters)", said)


class InputError(MartensiteError):
    """Something the user gave is wrong; nothing was changed or written."""

    exit_code = 2


class UnknownNameError(InputError):
    """A name is not one of the valid ones."""

    def __init__(self, kind: str, name: str, valid: Iterable[str], where: str = "") -> None:
        super().__init__(f"No {kind} named `{name}`. {suggest_name(name, valid, where)}")


def require_known(kind: str, name: str, valid: Collection[str]) -> None:
    """Raise `UnknownNameError` unless a name is one of the valid ones."""
    if name not in valid:
        raise UnknownNameError(kind, name, valid)


class MissingMethodError(InputError, NotImplementedError):
    """A class lacks methods that its kind must have."""


class KernelError(InputError, TypeError):
    """A kernel does what cannot be traced; the sentence says what to write instead."""


class UnknownOperationError(KernelError, AttributeError):
    """A kernel uses an operation that there is not."""


class UnitError(InputError):
    """A quantity cannot be read, or has the wrong unit."""


class ParameterError(InputError):
    """A parameter is missing, unknown or out of range."""


class DataError(InputError):
    """A data file is missing, malformed or does not hold what is needed."""


class SolveError(MartensiteError):
    """A simulation could not be completed; the sentence says where and what to try."""


class BudgetError(SolveError):
    """The CPU time that a run may take is spent."""


class StoppedError(MartensiteError):
    """Something stopped on the way; what was made is kept, and the sentence says how to go on."""


class CompileError(MartensiteError):
    """A program could not be compiled on this machine; on floats it runs all the same."""


def suggest_name(name: str, valid: Iterable[str], where: str = "") -> str:
    """Return 'Did you mean …?' for the nearest valid names, and all valid names if they are few.

    Args:
        name: what was given.
        valid: names that are allowed.
        where: words on where a long list is found, such as "`martensite list` lists them".
    """
    names = sorted({*valid})
    lower = {one.lower(): one for one in reversed(names)}
    long = len(names) > MOST_LISTED
    near = get_close_matches(name[:100].lower(), lower, n=3 if long else 1, cutoff=0.6)
    meant = f"Did you mean {' or '.join(f'`{lower[one]}`' for one in near)}? " if near else ""
    if long:
        return f"{meant}{len(names)} names are valid{f'; {where}' if where else ''}."
    return f"{meant}Valid: {', '.join(f'`{one}`' for one in names) or 'none'}."
