"""Lengths of elements as a mechanism is assembled, from which it is drawn."""

from collections.abc import Mapping, Sequence

from martensite.actuators.assembly.base import AbstractSystem
from martensite.actuators.elements.base import AbstractElement
from martensite.kernels.recordable_numbers import xp


def measure_lengths(
    system: AbstractSystem, columns: Mapping[str, Sequence[float]], drawn: AbstractSystem | None = None
) -> dict[str, float]:
    """Return the length of the element at each port at the start [m], from the first sample of the columns of a run.

    Args:
        system: what was run.
        columns: of the run.
        drawn: the same system with recorded numbers: lengths follow its natural lengths, the elongations are those
            of the run.
    """
    forces = system.mechanism.first_forces(xp, [columns[name][0] for name in system.mechanism.signals()])
    starts = [columns[system.label(port, "drive")][0] for port in system.actuators()]
    named = (drawn or system).actuators()
    return {
        port: _find_natural_length(named[port].element) + one.element.elongation(xp, one.start(xp, force, drive), force)
        for (port, one), force, drive in zip(system.actuators().items(), forces, starts, strict=True)
    }


def _find_natural_length(element: AbstractElement) -> float:
    """Length from which elongation counts [m]; 0.1 m if it has none of its own."""
    one = getattr(element, "one", None)
    if isinstance(one, AbstractElement):
        return _find_natural_length(one) * getattr(element, "behind", lambda: 1.0)()
    return getattr(element, "length", getattr(element, "free_length", 0.1))
