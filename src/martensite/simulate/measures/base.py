"""Measures: one value per run from the rows of a `RunTable`, and its derivatives by every row.

max(stress)   stroke   rise-time   energy   at(position, time=2 s)

A measure reads one output, or all outputs of a name in a system with several elements (`temperature` finds
`first.temperature`, `second.temperature` …). Rows are the accepted steps of a run (`martensite.simulate.track`),
which include short pulses of long runs.
"""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Parametrised, find_paths, text
from martensite.base.registry import Registry
from martensite.simulate.measures.run_table import Numbers, RunTable, tabulate_samples

FIRST = ""
"""Placeholder for the first coordinate of the mechanism."""
_CALL = re.compile(r"^\s*([A-Za-z][\w-]*)\s*(?:\(\s*([^()]*?)\s*\))?\s*$")


class AbstractMeasure(Parametrised):
    """Measure with one value per run."""

    averages: ClassVar[bool] = False
    """True if the measure is an integral over time."""
    follows_curve: ClassVar[bool] = False
    """True if the measure needs the curve between steps in addition to extremes and integrals."""

    seeks_turn: ClassVar[bool] = False
    """True if the measure depends on the value farthest from the first."""

    of: str = text("output that is looked at; none for the first coordinate", default=FIRST)

    @abstractmethod
    def unit(self, unit: str) -> str:
        """Return the SI unit of the value for the unit of the output."""

    @abstractmethod
    def value(self, table: RunTable) -> Numbers:
        """Return the value of every run, (runs,); infinite for events that never happen."""

    @abstractmethod
    def derivatives(self, table: RunTable) -> Numbers:
        """Return the derivatives of the measure by every value, (columns, rows, runs).

        At nondifferentiable points, such as equal maxima, the derivative is one-sided.
        """

    def spread(self, table: RunTable, off: Numbers) -> float:
        """Return the error bound of the measure for the first run.

        Args:
            table: table of the run.
            off: error bounds of the values, (columns,).
        """
        slopes = np.abs(self.derivatives(table)[:, :, 0])
        most = np.minimum(np.abs(table.values[:, :, 0]), off[:, None]) if self.averages else off[:, None]
        return float((slopes * most).sum())

    def columns(self, system: AbstractSystem) -> tuple[str, ...]:
        """Return the names of the required outputs.

        Raises:
            ParameterError: the output does not exist.
        """
        names = system.outputs()
        wanted = self.of or next(iter(system.mechanism.outputs()))
        matches = find_paths(wanted, names)
        if not matches:
            raise ParameterError(
                f"`{self.registered_name}` looks at `{wanted}`, which is no output of this system. "
                f"{suggest_name(wanted, names)}"
            )
        return tuple(matches)

    def unit_in(self, system: AbstractSystem) -> str:
        """Return the SI unit of the measure for a system."""
        return self.unit(system.outputs()[self.columns(system)[0]].unit)


MEASURES: Registry[AbstractMeasure] = Registry("measure", "martensite.simulate.measures", typical="max")


def parse_measure(words: str) -> AbstractMeasure:
    """Return the measure for text such as `stroke`, `max(stress)` or `at(position, time=2 s)`.

    Raises:
        ParameterError: the measure is unknown, or an option is wrong.
    """
    call = _CALL.match(words)
    if call is None:
        raise ParameterError(
            f"`{words}` is no measure; write a name, such as `stroke`, or a name and an output, such as `max(stress)`."
        )
    return MEASURES[call[1]](**_parse_options(call[2] or ""))


def _parse_options(words: str) -> dict[str, Any]:
    """Return the options in the brackets: an output first, then options by name."""
    given: dict[str, Any] = {}
    for place, piece in enumerate(filter(None, (p.strip() for p in words.split(",")))):
        name, equals, value = (part.strip() for part in piece.partition("="))
        if not equals and place:
            raise ParameterError(f"`{piece}` needs a name, such as `time={piece}`.")
        given[name if equals else "of"] = value if equals else name
    return given


def list_needed(measures: Iterable[AbstractMeasure], system: AbstractSystem) -> tuple[str, ...]:
    """Return the required outputs of several measures, without duplicates."""
    return tuple(dict.fromkeys(n for one in measures for n in one.columns(system)))


def measure_samples(
    one: AbstractMeasure, system: AbstractSystem, times: Numbers, columns: Mapping[str, Numbers]
) -> Numbers:
    """Return the measure of every run from stored samples, (runs, samples) by name."""
    return one.value(tabulate_samples(times, np.stack([columns[name].T for name in one.columns(system)])))
