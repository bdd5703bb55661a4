"""Subjects of steady states: a scenario or a system, constant drives, and the varied parameter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, require_known
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.drive_waveforms import Waveforms, by_name
from martensite.simulate.steady.periodic_motion import VariedNumber, index_drives

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario
    from martensite.search.free_numbers import Target


@dataclass(frozen=True)
class Subject:
    """System with its drives."""

    system: AbstractSystem
    waveforms: dict[str, AbstractWaveform]
    title: str
    scenario: Scenario | None = None

    @classmethod
    def read(cls, given: Scenario | AbstractSystem, waveform: Waveforms | None = None) -> Subject:
        """Read a scenario, or a system with waveforms.

        Raises:
            InputError: the scenario has a controller.
        """
        if not isinstance(given, AbstractSystem):
            if given.bench is not None:
                raise InputError(
                    f"Scenario `{given.title}` has sensors or controllers; steady states need a plant. "
                    "For an ON/OFF loop, compute the cycle."
                )
            own = by_name(given.system, given.waveform if waveform is None else waveform)
            return cls(given.system, own, given.title, given)
        return cls(given, by_name(given, waveform or {}), given.description())

    def names(self) -> list[str]:
        """Return the names of the drives."""
        return [one.name for one in self.system.drives()]

    def hold(self, levels: Mapping[str, float] | float | None) -> Numbers:
        """Return constant signals of all drives: given levels, else constants of the scenario.

        Args:
            levels: levels by drive name; a single number for the first drive.

        Raises:
            InputError: the drive does not exist, or a varying drive has no level.
        """
        names = self.names()
        if isinstance(levels, int | float) and not names:
            raise InputError("This system has no drive that could be held.")
        given = {names[0]: float(levels)} if isinstance(levels, int | float) else dict(levels or {})
        for name in given:
            require_known("drive", name, names)
        for name, one in self.waveforms.items():
            if name not in given:
                if not isinstance(one, Constant):
                    raise InputError(
                        f"Drive `{name}` changes in time (`{one.registered_name}`); give the level at which it is "
                        "held, or compute the cycle."
                    )
                given[name] = one.value(0.0)
        return index_drives(self.system, given)

    def highest(self, duration: float) -> dict[str, float]:
        """Return the highest level of each drive within a time [s]."""
        return {name: one.moments(0.0, duration).high for name, one in self.waveforms.items()}

    def vary(self, name: str, low: float, high: float) -> VariedNumber:
        """Return a drive, a level of its waveform or a system parameter, by name or path.

        Raises:
            ParameterError: the name is unknown or ambiguous.
        """
        drives = {one.name: one.unit for one in self.system.drives()}
        span = abs(high - low)
        if name in drives:
            return VariedNumber(name, drives[name], None, self.names().index(name), span)
        target = self.find_target(name)
        if target is None:
            path = self.system.resolve(name)
            leaf = next(one for one in self.system.leaves() if one.path == path)
            return VariedNumber(path, leaf.declared.unit, path, -1, span)
        if target.drive is not None:
            return VariedNumber(target.name, target.unit, None, self.names().index(target.drive), span)
        return VariedNumber(target.name, target.unit, target.path, -1, span)

    def find_target(self, name: str) -> Target | None:
        """Return a parameter of the scenario; None for a bare system."""
        return None if self.scenario is None else self.scenario.find_target(name)

    def value(self, varied: VariedNumber, signals: Numbers) -> float:
        """Return the present value of a varied parameter."""
        if varied.path is None:
            return float(signals[varied.drive])
        return float(next(one.value for one in self.system.leaves() if one.path == varied.path))

    def at(self, varied: VariedNumber, value: float, signals: Numbers) -> tuple[AbstractSystem, Numbers]:
        """Return system and signals with another value of a varied parameter."""
        if varied.path is None:
            moved = np.array(signals)
            moved[varied.drive] = value
            return self.system, moved
        return self.system.with_values({varied.path: value}), signals
