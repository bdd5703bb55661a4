"""Parameters of a fitted actuator under canonical names, each with its kind and source.

A common parameter of all records is `fitted`, unless the records do not determine it. Other parameters keep kind and
source of the scenario's material, if the value is unchanged. Otherwise they are `assumed`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, require_known
from martensite.base.parameters import Leaf
from martensite.fit.fit import Fit
from martensite.fit.fit_provenance import NOT_DETERMINED, PACKAGE, format_interval
from martensite.fit.free_parameters import is_nuisance
from martensite.physics.laws.base import AbstractLaw
from martensite.physics.materials.base import NAMES, Material, MaterialNumber, Source
from martensite.scenario.assemble import scenario_path
from martensite.scenario.exact_text import exact_text, format_quantity, shown_range
from martensite.scenario.laws import law_words
from martensite.scenario.scenario import Scenario
from martensite.search.free_numbers import FreeNumber
from martensite.search.quantity_text import list_names

Leaves = dict[str, Leaf]
FIT, SCENARIO, DEFAULT = "fit", "scenario", "default"
"""Keys of the sources that a fit adds."""


@dataclass(frozen=True)
class MaterialNumbers:
    """Material parameters of a fit, from the fitted system and its scenario."""

    fit: Fit
    scenario: Scenario | None = None
    port: str | None = None
    digits: int | None = None
    sources: dict[str, Source] = field(default_factory=dict[str, Source])
    """Sources of the fixed parameters; filled by `values`."""

    @property
    def law(self) -> AbstractLaw:
        """Return the law of the actuator.

        Raises:
            InputError: actuators, or the systems of several records, have different laws.
        """
        return find_law(self._systems(), self.port)

    @property
    def material(self) -> Material | None:
        """Return the material of the scenario."""
        return self.scenario.material if self.scenario else None

    def law_table(self) -> dict[str, str]:
        """Return the law in scenario form: kind, options, and parameters without a canonical name."""
        law = self.law
        own = {
            name: exact_text(getattr(law, name), declared.unit)
            for name, declared in law.declarations.items()
            if declared.kind == "parameter" and name not in NAMES
        }
        return law_words(law) | own

    def values(self) -> dict[str, MaterialNumber]:
        """Return all parameters by canonical name, in the order of the names.

        Raises:
            InputError: actuators, or the systems of several records, differ in a parameter.
        """
        leaves = self._leaves()
        finite = {name: leaf for name, leaf in leaves.items() if math.isfinite(leaf.value)}
        numbers = {name: self._number(name, leaf) for name, leaf in finite.items()}
        numbers |= dict(self._carry_numbers(leaves))
        return {name: numbers[name] for name in NAMES if name in numbers}

    def others(self) -> list[FreeNumber]:
        """Return the common fitted parameters that do not belong to the material."""
        material_names = {*NAMES, *self.law.declarations}
        shared = (free for free in self.fit.problem.free if free.record is None)
        return [free for free in shared if free.path.rpartition(".")[2] not in material_names]

    def _leaves(self) -> Leaves:
        """Return the canonical parameters of the actuator, with all fitted values."""
        own = [free for free in self.fit.problem.free if free.record is not None]
        return name_canonically(self._systems(), self.port, lambda path: any(free.moves(path) for free in own))

    def _systems(self) -> list[AbstractSystem]:
        return [self.fit.system(k) for k in range(len(self.fit.problem.experiments))]

    def _number(self, name: str, leaf: Leaf) -> MaterialNumber:
        physical = [free for free in self.fit.problem.free if not is_nuisance(free.path)]
        moving = [free for free in physical if free.moves(leaf.path)]
        if not moving:
            return self._inherit_number(name, leaf)
        if moving[0].name in self.fit.identifiability.without_effect:
            return self._idle(name, leaf, moving[0])
        if moving[0].record is None:
            value = self.fit[moving[0].name] if moving[1:] else leaf.value  # a centre with random effects
            text = exact_text(value, leaf.declared.unit, self.digits)
            return _build_number(leaf, text, "fitted", FIT, describe_trust(self.fit, moving[0]))
        return self._each(moving, leaf)

    def _each(self, moving: list[FreeNumber], leaf: Leaf) -> MaterialNumber:
        """Return a separate parameter of records at its start, as it does not belong to the material."""
        fitted = ", ".join(f"{format_quantity(self.fit[f.name], f.unit)} in {f.record}" for f in moving)
        text = exact_text(moving[0].start, leaf.declared.unit)
        note = f"where the fit began; fitted to every record for itself: {fitted}"
        return _build_number(leaf, text, "assumed", self._scenario_source(), note)

    def _idle(self, name: str, leaf: Leaf, free: FreeNumber) -> MaterialNumber:
        """Return an idle parameter as not fitted."""
        start_leaf = replace(leaf, value=free.start)
        number = self._inherit_number(name, start_leaf)
        words = "free in the fit, but without effect on it: as at the start"
        return replace(number, note="; ".join(filter(None, (number.note, words))))

    def _inherit_number(self, name: str, leaf: Leaf) -> MaterialNumber:
        if self.material and name in self.material.values:
            number = self.material.values[name]
            if number.value == leaf.value:
                return self._copy_number(self.material, number)
        text = exact_text(leaf.value, leaf.declared.unit)
        origins = self.scenario.origins if self.scenario else {}
        if origins.get(scenario_path(leaf.path)) == DEFAULT:
            self.sources[DEFAULT] = Source(PACKAGE, "Default of the parameter")
            return _build_number(leaf, text, "assumed", DEFAULT, "")
        return _build_number(leaf, text, "assumed", self._scenario_source(), "held fixed in the fit")

    def _carry_numbers(self, leaves: Leaves) -> Iterator[tuple[str, MaterialNumber]]:
        """Yield the material parameters of the scenario that the fitted system does not use."""
        if self.material:
            for name, number in self.material.values.items():
                if name not in leaves:
                    yield name, self._copy_number(self.material, number)

    def _copy_number(self, material: Material, number: MaterialNumber) -> MaterialNumber:
        """Return a parameter of another material, with its source."""
        key = number.source
        if key in (FIT, SCENARIO, DEFAULT):
            key = f"{key}-of-{material.name}"
        self.sources[key] = material.sources[number.source]
        return replace(number, source=key)

    def _scenario_source(self) -> str:
        which = f"`{self.scenario.title}`" if self.scenario else "of the fit"
        self.sources[SCENARIO] = Source(PACKAGE, f"Scenario {which}")
        return SCENARIO


def describe_trust(fit: Fit, free: FreeNumber) -> str:
    """Describe the interval and bounds of a fitted parameter, with their problems."""
    uncertainty = fit.uncertainty
    wide = format_interval(uncertainty.widen_interval(free.name), free.unit)
    plain = format_interval(uncertainty.interval(free.name), free.unit)
    of = f" of {free.name}" if free.base else ""
    words = [f"{wide}{of}" if wide == NOT_DETERMINED else f"95 % interval{of} {wide}"]
    if plain != wide:
        words.append(f"{plain} if all samples were independent")
    words.append(f"searched from {shown_range((free.low, free.high), free.unit)}")
    if free.name in fit.at_bound():
        words.append("ended on a bound, which decides instead of the data")
    for weak in fit.identifiability.weak:
        others = [name for name in weak.names if name != free.name]
        if others and free.name in weak.names:
            words.append(f"not determined apart from {', '.join(others)}")
    return "; ".join(words)


def _build_number(leaf: Leaf, text: str, kind: str, source: str, note: str) -> MaterialNumber:
    return MaterialNumber(leaf.value, text, leaf.declared.unit, kind, source, "", note)


# ---------------------------------------------------------------- canonical names


def name_canonically(
    systems: Sequence[AbstractSystem], port: str | None = None, apart: Callable[[str], bool] = lambda path: False
) -> Leaves:
    """Return canonical name -> parameter of the elements of some systems, which must agree.

    Args:
        systems: systems of several records. The first is read.
        port: selected actuator, by default all must agree.
        apart: paths of parameters that may differ between systems.

    Raises:
        InputError: actuators or systems differ in a parameter.
        UnknownNameError: the port does not exist.
    """
    first, *others = [_list_numbers(system, port) for system in systems]
    for other in others:
        common_leaves = {name: leaf for name, leaf in other.items() if not apart(leaf.path)}
        _refuse_other(first, common_leaves, "The systems of the records")
    return first


def find_law(systems: Sequence[AbstractSystem], port: str | None = None) -> AbstractLaw:
    """Return the law of an actuator, or by default of all, in all systems.

    Raises:
        InputError: there is more than one law, or one with other options.
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
    if port is not None:
        require_known("port", port, ports)
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
