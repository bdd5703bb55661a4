"""A direction in which parameters move unseen, and the sentence that says so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from martensite.base.formats import choose_difference_unit
from martensite.search.quantity_text import format_change, format_number, format_quotient, join_phrases, list_names
from martensite.search.scaled_jacobian import is_gauge

UNSEEN = 1e-6
"""Change of the error, as a share of its noise, below which no number is given."""


@dataclass(frozen=True)
class WeakDirection:
    """Parameters that the data do not tell apart, or a single one that they do not hold."""

    names: tuple[str, ...]
    """The largest mover, as a share of its range, first."""
    units: tuple[str, ...]
    """SI unit of each."""
    changes: tuple[float, ...]
    """Changes that make up for each other, to first order, each in its SI unit; of a single
    parameter its whole range."""
    relative: tuple[float, ...]
    """The same as shares of the values themselves; NaN where the value is 0."""
    uncertainty: float
    """Standard error along the direction in search ranges; infinite if `exact`."""
    effect: float
    """Root-mean-square change of the error under `changes`, in units of its noise."""
    exact: bool
    """Whether nothing at all is seen: data of this kind, however exact, would not help."""

    @property
    def gauge(self) -> bool:
        """Whether two or more parameters all move in proportion to their own values."""
        return is_gauge(self.relative)

    @property
    def sentence(self) -> str:
        """What is not determined, with amounts in everyday units."""
        if len(self.names) == 1:
            return self._single()
        return f"{self._determined()}: {self._moves()} {self._outcome()}."

    def to_dict(self) -> dict[str, Any]:
        """All fields by name and the sentence, for JSON."""
        return asdict(self) | {"gauge": self.gauge, "sentence": self.sentence}

    def _single(self) -> str:
        name = self.names[0]
        if self.exact:
            return f"`{name}` is not determined: it has no effect on the error."
        move = f"its whole range, {format_change(abs(self.changes[0]), self.units[0])},"
        return f"`{name}` is not determined: {move} {self._outcome()}."

    def _determined(self) -> str:
        first, second, *others = self.names
        if others:
            return f"{list_names(self.names)} are not determined separately"
        if self.gauge:
            ratio = self.relative[0] * self.relative[1] > 0.0
            kind = f"ratio of {list_names(self.names)}" if ratio else f"product of {list_names(self.names)}"
            return f"Only the {kind} is determined"
        (top, one), (bottom, other) = map(choose_difference_unit, self.units)
        slope = -(self.changes[0] / one) / (self.changes[1] / other)
        factor = f"{format_number(abs(slope))} {format_quotient(top, bottom)}".strip()
        sign = "+" if slope > 0.0 else "-"
        return f"Only the combination `{first}` {sign} {factor} × `{second}` is determined"

    def _moves(self) -> str:
        if self.gauge:
            up, down = self._parted(list(self.names), [r / self.relative[0] for r in self.relative])
            dividing = f" and dividing {list_names(down)}" if down else ""
            return f"multiplying {list_names(up)}{dividing} by the same factor"
        amounts = zip(self.names, self.changes, self.units, strict=True)
        phrases = [f"`{name}` by {format_change(abs(move), unit)}" for name, move, unit in amounts]
        up, down = self._parted(phrases, self.changes)
        if not down:
            return f"raising {up[0]} together with {join_phrases(up[1:])}"
        return f"raising {join_phrases(up)} while lowering {join_phrases(down)}"

    def _outcome(self) -> str:
        share = "less than a millionth" if self.effect < UNSEEN else format_number(self.effect, 2)
        factor = f" for a factor of {format_number(1.0 + abs(self.relative[0]))}" if self.gauge else ""
        if not self.exact:
            return f"changes the error by only {share} of its noise{factor}"
        return f"changes nothing (the error changes by {share} of its noise{factor})"

    @staticmethod
    def _parted(phrases: list[str], signs: Sequence[float]) -> tuple[list[str], list[str]]:
        """Phrases of what rises and of what falls."""
        pairs = list(zip(phrases, signs, strict=True))
        return [p for p, s in pairs if s > 0.0], [p for p, s in pairs if not s > 0.0]
