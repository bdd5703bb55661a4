"""Rows of numbers: how many there are is structure, each is a parameter of its own.

Gains of a state feedback or weights of a hysteresis come in any number. As a row they are leaves
like all others, `gains.n1`, `gains.n2`, …: they may differ from lane to lane and have derivatives,
and two rows of one length share a traced program.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

from martensite.base.errors import ParameterError
from martensite.base.parameters import REQUIRED, Declared, Parametrised
from martensite.kernels.namespace import Scalar


class NumberedGains(Parametrised):
    """Numbers n1, n2, … in their order."""

    def __init__(self, **numbers: float) -> None:
        for place, (name, value) in enumerate(numbers.items(), 1):
            if name != f"n{place}":
                raise ParameterError(f"Number {place} of a row is `n{place}`, not `{name}`.")
            self.__dict__[name] = _convert_number(place).convert("row", name, value)

    @classmethod
    def of(cls, numbers: Sequence[float]) -> Self:
        """A row of these numbers."""
        return cls(**{f"n{place}": number for place, number in enumerate(numbers, 1)})

    @property
    def declarations(self) -> dict[str, Declared]:  # type: ignore[override]
        """One parameter per number."""
        return {name: _convert_number(place) for place, name in enumerate(self.__dict__, 1)}

    def layout(self) -> tuple[int, ...]:
        """How many there are."""
        return (len(self.__dict__),)

    @property
    def numbers(self) -> tuple[Scalar, ...]:
        """All of them."""
        return tuple(self.__dict__.values())


def _convert_number(place: int) -> Declared:
    return Declared("parameter", f"number {place} of a row", REQUIRED)


def as_row(owner: str, name: str, given: Any) -> NumberedGains:
    """A row, of a sequence of numbers too.

    Raises:
        ParameterError: it is neither.
    """
    if isinstance(given, NumberedGains):
        return given
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise ParameterError(f"`{name}` of `{owner}` must be a list of numbers, not {given!r}.")
    return NumberedGains.of(given)  # type: ignore[arg-type]
