"""Initial lengths of the elements on a mechanism, for drawings."""

from collections.abc import Mapping, Sequence
from typing import TypeAlias

from martensite.actuators.assembly.base import AbstractSystem
from martensite.actuators.elements.base import AbstractElement
from martensite.kernels.recordable_numbers import xp
from martensite.signals.sampling.sampled import Numbers

Course: TypeAlias = Sequence[float] | Numbers


def measure_lengths(system: AbstractSystem, columns: Mapping[str, Course]) -> dict[str, float]:
    """Return the initial length of the element at each port [m], from the first sample of a run."""
    return {
        port: _find_natural_length(one.element) + elongation
        for (port, one), elongation in zip(system.actuators().items(), _list_elongations(system, columns), strict=True)
    }


def record_lengths(
    system: AbstractSystem, columns: Mapping[str, Course], recorded_system: AbstractSystem, strains: Mapping[str, float]
) -> dict[str, float]:
    """Return the initial lengths as functions of recorded parameters.

    Elongation is proportional to natural length and strain: exact for wires, approximate for a coil with other
    parameters.

    Args:
        system: simulated system.
        columns: columns of the run.
        recorded_system: the same system with recorded parameters.
        strains: recorded first strain by port.
    """
    lengths: dict[str, float] = {}
    for (port, one), elongation in zip(system.actuators().items(), _list_elongations(system, columns), strict=True):
        natural = _find_natural_length(recorded_system.actuators()[port].element)
        strain = columns[system.label(port, "strain")][0]
        share = elongation / _find_natural_length(one.element)
        lengths[port] = natural * (1.0 + (share / strain * strains[port] if strain else share))
    return lengths


def _list_elongations(system: AbstractSystem, columns: Mapping[str, Course]) -> list[float]:
    forces = system.mechanism.first_forces(xp, [float(columns[name][0]) for name in system.mechanism.signals()])
    starts = [float(columns[system.label(port, "drive")][0]) for port in system.actuators()]
    return [
        one.element.elongation(xp, one.start(xp, force, drive), force)
        for one, force, drive in zip(system.actuators().values(), forces, starts, strict=True)
    ]


def _find_natural_length(element: AbstractElement) -> float:
    """Return the length at zero elongation [m]; 0.1 m for an element without length."""
    one = getattr(element, "one", None)
    if isinstance(one, AbstractElement):
        return _find_natural_length(one) * getattr(element, "behind", lambda: 1.0)()
    return getattr(element, "length", getattr(element, "free_length", 0.1))
