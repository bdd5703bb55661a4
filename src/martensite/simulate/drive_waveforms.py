"""Assignment of waveforms to drives: one waveform, or a table by drive name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.assembly.base import DriveSignal
from martensite.base.errors import InputError, suggest_name
from martensite.base.remember_results import remember
from martensite.signals.base import AbstractDrive, AbstractWaveform
from martensite.signals.constant import Constant
from martensite.simulate.grid import TimeGrid, build_grid, grid_of_samples, require_unit

Waveforms = AbstractWaveform | Mapping[str, AbstractWaveform]
"""Waveform, or waveforms by drive name; other drives get 0."""

Kind = TypeVar("Kind", bound=AbstractDrive)


def by_name(system: AbstractSystem, given: Kind | Mapping[str, Kind]) -> dict[str, Kind]:
    """Return the waveforms by drive name.

    Raises:
        InputError: a named drive does not exist, or one waveform is given for several drives.
    """
    return _assign_drives(list_drive_signals(system), given)


@remember
def list_drive_signals(system: AbstractSystem) -> tuple[DriveSignal, ...]:
    """Return the drive signals of a system, in order."""
    return tuple(system.drives())


def _assign_drives(signals: Sequence[DriveSignal], given: Kind | Mapping[str, Kind]) -> dict[str, Kind]:
    names = [signal.name for signal in signals]
    if not isinstance(given, Mapping):
        _require_drive(given)
        if len(names) != 1:
            raise InputError(
                f"This system has {len(names)} drives ({', '.join(names)}). Give a waveform for each by name, "
                f"such as {{'{names[0]}': ...}}."
            )
        return {names[0]: given}
    for name, one in given.items():
        if name not in names:
            raise InputError(f"There is no drive `{name}`. {suggest_name(str(name), names)}")
        _require_drive(one)
    return dict(given)


def _require_drive(given: Any) -> None:
    """Raise `InputError` with an example if a drive is not a waveform."""
    if isinstance(given, AbstractDrive):
        return
    kind, remedy = f"`{type(given).__name__}`", "write for example `ms.Step(high=0.6, at=1.0)`"
    if isinstance(given, type):
        kind, remedy = f"the class `{given.__name__}`", f"give an object, such as `{given.__name__}(...)`"
    elif isinstance(given, int | float):
        kind, remedy = f"the number {given}", f"write `ms.Constant(level={given})`"
    elif hasattr(given, "__len__") and not isinstance(given, str):
        remedy = "write `ms.signals.Table(times=..., values=...)`"
    elif callable(given):
        remedy = "write a class derived from `ms.parts.AbstractWaveform`, or `ms.signals.Table(times=..., values=...)`"
    raise InputError(f"A drive must be a waveform, or a table of waveforms by name, but is {kind}; {remedy}.")


def arrange_waveforms(system: AbstractSystem, given: Kind | Mapping[str, Kind]) -> list[Kind | Constant]:
    """Return the waveforms of all drives in order; a drive without a waveform gets 0.

    Raises:
        InputError: a name or a unit does not fit, or a temperature is prescribed by nothing.
    """
    signals = list_drive_signals(system)
    assignment = _assign_drives(signals, given)
    waveforms: list[Kind | Constant] = []
    for name, unit, *_ in signals:
        if name not in assignment and unit == "K":
            raise InputError(f"Drive `{name}` sets a temperature and needs a waveform.")
        one = assignment[name] if name in assignment else Constant(level=0.0)
        if isinstance(one, AbstractWaveform):
            require_unit(one, unit)
        waveforms.append(one)
    return waveforms


def grid_of(
    system: AbstractSystem, waveform: Waveforms, duration: float, samples: int, step: float, *, every: bool = False
) -> TimeGrid:
    """Return the time grid of a run; a system in discrete time has its own steps.

    With `every`, outputs are stored at the ends of steps, for measures.
    """
    waves, interval = arrange_waveforms(system, waveform), system.sample_time()
    if interval:
        ahead = [drive.ahead for drive in list_drive_signals(system)]
        return grid_of_samples(waves, duration, samples, interval, ahead, every)
    at_end = [drive.at_end for drive in list_drive_signals(system)]
    grid = build_grid(waves, duration, samples, step, at_end)
    return grid.keep_steps(waves) if every else grid
