"""Errors: every one is a sentence a user can act on.

Form: what was given, what is allowed, the nearest valid name. `InputError` and its children mean bad input (exit code
2 on the command line); `SolveError` means that a run started and failed (exit code 1).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from difflib import get_close_matches

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

    def __init__(self, kind: str, name: str, valid: Iterable[str]) -> None:
        super().__init__(f"No {kind} named `{name}`. {suggest_name(name, valid)}")


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


def suggest_name(name: str, valid: Iterable[str]) -> str:
    """Return 'Did you mean …?' for the nearest valid name, or the list of valid names."""
    names = sorted(valid)
    near = get_close_matches(name[:100].lower(), [n.lower() for n in names], n=1, cutoff=0.6)
    listed = ", ".join(f"`{n}`" for n in names) or "none"
    if not near:
        return f"Valid: {listed}."
    best = next(n for n in names if n.lower() == near[0])
    return f"Did you mean `{best}`? Valid: {listed}."
