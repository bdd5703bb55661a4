"""Lengths of elements as a mechanism is assembled, from which it is drawn."""

from collections.abc import Mapping, Sequence
from typing import TypeAlias

from martensite.actuators.assembly.base import AbstractSystem
from martensite.actuators.elements.base import AbstractElement
from martensite.kernels.recordable_numbers import xp
from martensite.signals.sampling.sampled import Numbers

Course: TypeAlias = Sequence[float] | Numbers


def measure_lengths(system: AbstractSystem, columns: Mapping[str, Course]) -> dict[str, float]:
    """Return the length of the element at each port at the start [m], from the first sample of the columns of a run."""
    return {
        port: _find_natural_length(one.element) + elongation
        for (port, one), elongation in zip(system.actuators().items(), _list_elongations(system, columns), strict=True)
    }


def record_lengths(
    system: AbstractSystem, columns: Mapping[str, Course], drawn: AbstractSystem, strains: Mapping[str, float]
) -> dict[str, float]:
    """Return the same lengths as functions of recorded numbers.

    An elongation is proportional to the natural length and to the strain. This is exact for wires; for a coil whose
    numbers differ from those of the run it is an approximation.

    Args:
        system: what was run.
        columns: of the run.
        drawn: the same system with recorded numbers.
        strains: recorded first strain by port.
    """
    found: dict[str, float] = {}
    for (port, one), elongation in zip(system.actuators().items(), _list_elongations(system, columns), strict=True):
        natural = _find_natural_length(drawn.actuators()[port].element)
        strain = columns[system.label(port, "strain")][0]
        share = elongation / _find_natural_length(one.element)
        found[port] = natural * (1.0 + (share / strain * strains[port] if strain else share))
    return found


def _list_elongations(system: AbstractSystem, columns: Mapping[str, Course]) -> list[float]:
    forces = system.mechanism.first_forces(xp, [float(columns[name][0]) for name in system.mechanism.signals()])
    starts = [float(columns[system.label(port, "drive")][0]) for port in system.actuators()]
    return [
        one.element.elongation(xp, one.start(xp, force, drive), force)
        for one, force, drive in zip(system.actuators().values(), forces, starts, strict=True)
    ]


def _find_natural_length(element: AbstractElement) -> float:
    """Return the length from which elongation counts [m]; 0.1 m if the element has no length."""
    one = getattr(element, "one", None)
    if isinstance(one, AbstractElement):
        return _find_natural_length(one) * getattr(element, "behind", lambda: 1.0)()
    return getattr(element, "length", getattr(element, "free_length", 0.1))
