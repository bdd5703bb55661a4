"""Status of a time step: each way a step can end, with a remedy.

Failures are data: each step has a status, and no NaN goes unreported.
"""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """End of a step; larger is worse."""

    OK = 0
    LONG_STEP = 1
    UNSOLVED = 2
    OUT_OF_RANGE = 3
    NOT_FINITE = 4
    REFUSED = 5
    LOST = 6
    OUT_OF_ENVELOPE = 7

    @property
    def sentence(self) -> str:
        """Return the sentence with the cause and the remedy."""
        return _SENTENCES[self]

    @property
    def failed(self) -> bool:
        """Return True if the results after this step cannot be trusted."""
        return self >= Status.UNSOLVED


_SENTENCES = {
    Status.OK: "The step was solved.",
    Status.LONG_STEP: (
        "The trial step crossed more than a fifth of a transformation strip; "
        "the result is solved but coarse. Try a smaller tolerance or a shorter step."
    ),
    Status.UNSOLVED: (
        "The coupling of law, heat and mechanism was not solved to its tolerance. "
        "Give a `tolerance` instead of a fixed step, or another step. Check transformation ranges below 0.1 K, "
        "and the input for a jump far beyond the wire's rating."
    ),
    Status.OUT_OF_RANGE: (
        "A phase fraction left the interval from 0 to 1. "
        "Try a shorter step; if it stays, the law's parameters contradict each other."
    ),
    Status.NOT_FINITE: (
        "A number became infinite or undefined. Try a shorter step, and check the parameters for zero widths or masses."
    ),
    Status.REFUSED: (
        "A parameter is out of its range, or contradicts another; nothing was run. "
        "Try a narrower range, or look at this run alone."
    ),
    Status.LOST: (
        "The process that ran this one died, or an error came out of it. "
        "Try this run alone; it may need more memory than there is."
    ),
    Status.OUT_OF_ENVELOPE: (
        "The run left what can be: no wire melts, tears or is stretched that far. "
        "Try less power or a smaller load, and look at the parameters for a wrong unit."
    ),
}
