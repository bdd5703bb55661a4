"""Measures: one number per run, out of the samples of its columns, and how it depends on them.

    max(stress)   stroke   rise-time   energy   at(position, time=2 s)

A measure looks at one output, or at all outputs of that name of a system with several elements
(`temperature` finds `first.temperature`, `second.temperature` …). It says its number for many runs
at once, and its derivatives by every sample, so that a search may follow its slope through the
march. What lies between samples is not seen.
"""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Parametrised, find_paths, text
from martensite.base.registry import Registry

Numbers: TypeAlias = NDArray[np.float64]
FIRST = ""
"""Stands for the first coordinate of the mechanism."""
_CALL = re.compile(r"^\s*([A-Za-z][\w-]*)\s*(?:\(\s*([^()]*?)\s*\))?\s*$")


class AbstractMeasure(Parametrised):
    """One number per run."""

    of: str = text("output that is looked at; none for the first coordinate", default=FIRST)

    @abstractmethod
    def unit(self, unit: str) -> str:
        """SI unit of the number, from that of the output."""

    @abstractmethod
    def value(self, times: Numbers, seen: Numbers) -> Numbers:
        """The number of every run.

        Args:
            times: of the samples [s], (samples,).
            seen: the columns that are looked at, (columns, samples, runs).

        Returns:
            One number per run, (runs,); infinite where something never happens.
        """

    @abstractmethod
    def weights(self, times: Numbers, seen: Numbers) -> Numbers:
        """Derivatives of the number by every sample, (columns, samples, runs).

        Where there is none, as between two samples that are both the largest, one of both sides.
        """

    def columns(self, system: AbstractSystem) -> tuple[str, ...]:
        """Names of the outputs that are looked at.

        Raises:
            ParameterError: there is no such output.
        """
        names = system.outputs()
        wanted = self.of or next(iter(system.mechanism.outputs()))
        found = find_paths(wanted, names)
        if not found:
            raise ParameterError(
                f"`{self.registered_name}` looks at `{wanted}`, which is no output of this system. "
                f"{suggest_name(wanted, names)}"
            )
        return tuple(found)

    def unit_in(self, system: AbstractSystem) -> str:
        """SI unit of the number for a system."""
        return self.unit(system.outputs()[self.columns(system)[0]].unit)


MEASURES: Registry[AbstractMeasure] = Registry("measure", "martensite.simulate.measures", typical="max")


def parse_measure(words: str) -> AbstractMeasure:
    """The measure that words such as `stroke`, `max(stress)` or `at(position, time=2 s)` name.

    Raises:
        ParameterError: the words name none, or an option of it is wrong.
    """
    found = _CALL.match(words)
    if found is None:
        raise ParameterError(
            f"`{words}` is no measure; write a name, such as `stroke`, or a name and an output, such as `max(stress)`."
        )
    return MEASURES[found[1]](**_parse_options(found[2] or ""))


def _parse_options(words: str) -> dict[str, Any]:
    """What stands in the brackets: an output first, then options by name."""
    given: dict[str, Any] = {}
    for place, piece in enumerate(filter(None, (p.strip() for p in words.split(",")))):
        name, equals, value = (part.strip() for part in piece.partition("="))
        if not equals and place:
            raise ParameterError(f"`{piece}` needs a name, such as `time={piece}`.")
        given[name if equals else "of"] = value if equals else name
    return given


def list_needed(measures: Iterable[AbstractMeasure], system: AbstractSystem) -> tuple[str, ...]:
    """Every output that some measures look at, once."""
    return tuple(dict.fromkeys(n for one in measures for n in one.columns(system)))


def judge_runs(one: AbstractMeasure, system: AbstractSystem, times: Numbers, columns: Mapping[str, Numbers]) -> Numbers:
    """The number of every run, from columns (runs, samples) by name."""
    seen = np.stack([columns[name].T for name in one.columns(system)])
    return one.value(times, seen)
