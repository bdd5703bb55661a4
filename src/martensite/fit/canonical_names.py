"""The numbers of an actuator that a material holds, by canonical name."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, UnknownNameError
from martensite.base.parameters import Leaf
from martensite.physics.laws.base import AbstractLaw
from martensite.physics.materials.names import NAMES
from martensite.scenario.law_cautions import law_words
from martensite.search.quantity_text import format_quantity, list_names

Leaves = dict[str, Leaf]


def name_canonically(
    systems: Sequence[AbstractSystem],
    port: str | None = None,
    apart: Callable[[str], bool] = lambda path: False,
) -> Leaves:
    """Canonical name -> number of the elements of some systems, which must agree.

    Args:
        systems: those of several records; the first is read.
        port: the actuator that counts; all must agree if left out.
        apart: paths of numbers that may differ between systems.

    Raises:
        InputError: actuators or systems differ in a number.
        UnknownNameError: there is no such port.
    """
    first, *others = [_list_numbers(system, port) for system in systems]
    for other in others:
        kept = {name: leaf for name, leaf in other.items() if not apart(leaf.path)}
        _refuse_other(first, kept, "The systems of the records")
    return first


def find_law(systems: Sequence[AbstractSystem], port: str | None = None) -> AbstractLaw:
    """The law of an actuator, or of all if none is chosen, in all systems.

    Raises:
        InputError: there is more than one, or one with other options.
    """
    laws = [
        actuator.element.law
        for system in systems
        for name, actuator in system.actuators().items()
        if port in (None, name)
    ]
    first, *others = laws
    if any(law_words(law) != law_words(first) for law in others):
        raise InputError(
            "The fitted elements have different laws, or one law with different options, so that "
            "they are no single material: choose one actuator by `port`, or fit them apart."
        )
    return first


def _list_numbers(system: AbstractSystem, port: str | None) -> Leaves:
    ports = list(system.actuators())
    if port is not None and port not in ports:
        raise UnknownNameError("port", port, ports)
    first, *others = [_list_port(system, one) for one in (ports if port is None else [port])]
    for other in others:
        _refuse_other(first, other, f"The actuators at {list_names(ports)}")
    return first


def _list_port(system: AbstractSystem, port: str) -> Leaves:
    prefix = "element." if len(system.actuators()) == 1 else f"group.{port}.element."
    return {
        leaf.path.rpartition(".")[2]: leaf
        for leaf in system.leaves()
        if leaf.path.startswith(prefix) and leaf.path.rpartition(".")[2] in NAMES
    }


def _refuse_other(first: Leaves, other: Leaves, whose: str) -> None:
    for name, leaf in first.items():
        twin = other.get(name, leaf)
        if not math.isclose(leaf.value, twin.value, rel_tol=1e-12):
            one, two = (format_quantity(x.value, x.declared.unit) for x in (leaf, twin))
            raise InputError(
                f"{whose} differ in `{name}` ({one} and {two}), so that they are no single "
                "material: choose one actuator by `port`, or fit them apart."
            )
