"""One declaration per parameter: unit, meaning, bounds and default in one line.

    E_A: Number = param("Pa", "Young's modulus of austenite", low=1e8, high=2e11)

This line gives unit conversion, range checks, command-line parameters, documentation tables, search bounds and saved
units. `option` declares a choice between words, `text` a free text such as the name of a signal, `part` a component
from a registry.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, ClassVar, Generic, Self, TypeVar, cast, dataclass_transform

from martensite.base import units
from martensite.base.errors import ParameterError, UnitError, suggest_name
from martensite.base.field_types import Given as Given
from martensite.base.field_types import Number as Number
from martensite.base.interfaces import require_methods
from martensite.base.part_kinds import refuse_unnamed, require_part
from martensite.base.registry import Registry

REQUIRED: Any = object()
LEAST_LIKENESS = 0.75
"""Smallest similarity of a probable name."""
SHOWN = 6
"""Largest number of list values in `repr`."""
FROM_MATERIAL: Any = REQUIRED
"""Default of a parameter that a `material` can supply; required without a material."""


class ByUnit(dict[str, Any]):
    """Typical values by SI unit, for a parameter whose unit depends on its place."""


@dataclass(frozen=True)
class FieldDeclaration:
    """Declaration of one field; `kind` is parameter, option, text or part."""

    kind: str
    doc: str
    default: Any
    unit: str = "1"
    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    choices: tuple[str, ...] = ()
    registry: Registry[Any] | None = None
    typical: Any = None
    """Ordinary value, as in a file, for forms and examples; assumed, never data."""

    def typical_in(self, unit: str) -> Any:
        """Return the typical value where the SI unit is `unit`; None without a typical value."""
        if self.typical is None and self.registry is not None:
            return self.registry.typical or None
        return self.typical.get(unit) if isinstance(self.typical, ByUnit) else self.typical

    def convert(self, owner: str, name: str, value: Any) -> Any:
        """Return the checked value in SI; errors name owner and parameter."""
        if self.kind == "parameter":
            return self._number(owner, name, value)
        if self.kind == "text":
            return _convert_texts(owner, name, value)
        if self.kind == "option" and isinstance(value, int):
            value = str(value)  # a count, such as `cells = 20`
        if self.kind == "option" and value not in self.choices:
            raise ParameterError(f"Option `{name}` of `{owner}` is `{value}`. {suggest_name(str(value), self.choices)}")
        return value

    def _number(self, owner: str, name: str, value: Any) -> float:
        title = f"Parameter `{name}` of `{owner}`"
        if self.unit in units.OF_PLACE and (isinstance(value, str) or units.is_quantity(value)):
            raise UnitError(f"{title} takes {self._sort()}, but is `{value}`; leave the unit out.")
        try:
            number = units.convert_number(value, self.unit)
        except UnitError as error:
            raise UnitError(f"{title}: {error}") from None
        except (TypeError, ValueError):
            raise ParameterError(f"{title} must be {self._sort()}, but is {value!r}.") from None
        if math.isinf(number):
            if number == self.default:
                return number  # not given
            raise ParameterError(f"{title} must be finite, but is {value}.")
        too_low = number <= self.low if self.open_low else number < self.low
        if too_low or number > self.high or math.isnan(number):
            label = "" if isinstance(value, str) else self._label(self.unit)
            raise ParameterError(f"{title} must be {self.describe_range()}, but is {value}{label}.")
        return number

    def describe_range(self) -> str:
        """Return the allowed range in words, in readable units."""
        unit = self._readable()
        label = self._label(unit)
        low, high = (f"{units.from_si(v, unit, self.unit):.6g}{label}" for v in self.bounds)
        if math.isinf(self.low) and math.isinf(self.high):
            return "finite"
        if math.isinf(self.high):
            return f"above {low}" if self.open_low else f"at least {low}"
        if math.isinf(self.low):
            return f"at most {high}"
        return f"above {low} and at most {high}" if self.open_low else f"between {low} and {high}"

    def _sort(self) -> str:
        """Return the accepted values in words."""
        if self.unit == units.DRIVE:
            return "a plain number in the SI unit of what it drives"
        if self.unit in units.OF_LOOPS:
            return f"a number in SI, in {self.unit}"
        if self.unit in units.OF_READINGS:
            return "a number in the SI unit of the reading"
        return f"a number in {self.unit} or a text with a unit"

    @staticmethod
    def _label(unit: str) -> str:
        """Return the suffix of a number; empty for a unit that depends on the place."""
        return "" if unit in ("1", *units.OF_PLACE) else f" {unit}"

    def _readable(self) -> str:
        """Return the readable unit, or the SI unit if the bounds become unwieldy."""
        unit = units.choose_readable_unit(self.unit)
        sizes = [abs(units.from_si(v, unit, self.unit)) for v in self.bounds if math.isfinite(v)]
        return unit if all(size == 0.0 or 1e-3 <= size < 1e5 for size in sizes) else self.unit

    @property
    def bounds(self) -> tuple[float, float]:
        """Return the lowest and highest allowed value in SI."""
        return self.low, self.high


def param(
    unit: str,
    doc: str,
    *,
    low: float = -math.inf,
    high: float = math.inf,
    above: float | None = None,
    default: float = REQUIRED,
    typical: float | str | ByUnit | None = None,
) -> Any:
    """Declare a number in the SI `unit`.

    Args:
        unit: SI unit.
        doc: meaning.
        low: lowest allowed value.
        high: highest allowed value.
        above: excluded lower bound, instead of `low`.
        default: default value; without a default, the parameter is required.
        typical: ordinary value, in SI or as text with a unit (`FieldDeclaration.typical`).
    """
    least = low if above is None else above
    return FieldDeclaration("parameter", doc, default, unit, least, high, above is not None, typical=typical)


def option(doc: str, *choices: str, default: str = REQUIRED) -> Any:
    """Declare a choice between words; each choice is a different program."""
    return FieldDeclaration("option", doc, default, choices=choices, typical=choices[0])


def text(doc: str, *, default: str | tuple[str, ...] = REQUIRED, typical: str | None = None) -> Any:
    """Declare a free text or list of texts, such as names of signals; each text is a different program.

    A typical text `=name` equals the entry `name`.
    """
    return FieldDeclaration("text", doc, default, typical=typical)


def part(doc: str, registry: Registry[Any] | None = None, *, default: Any = REQUIRED, typical: Any = None) -> Any:
    """Declare a component, chosen by name from `registry` in files; `typical` is a name or a table."""
    return FieldDeclaration("part", doc, default, registry=registry, typical=typical)


@dataclass(frozen=True)
class Leaf:
    """One parameter of a tree: dotted path, declaration, value, owner."""

    path: str
    declared: FieldDeclaration
    value: Any
    owner: str = field(default="")


def _convert_texts(owner: str, name: str, value: Any) -> str | tuple[str, ...]:
    if isinstance(value, str):
        return value
    texts: tuple[Any, ...] = tuple(cast("Any", value)) if isinstance(value, (list, tuple)) else (0,)
    if not all(isinstance(one, str) for one in texts):
        raise ParameterError(f"`{name}` of `{owner}` must be a text or a list of texts, but is {value!r}.")
    return texts


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(param, option, text, part))
class Parametrised:
    """Frozen object whose fields are declared by `param`, `option`, `text` and `part`."""

    registered_name: ClassVar[str] = ""
    cites: ClassVar[tuple[str, ...]] = ()
    declarations: ClassVar[dict[str, FieldDeclaration]] = {}
    names_reading: ClassVar[tuple[str, ...]] = ()
    """Text fields that may name a reading; the first named reading gives the unit of levels and differences here and in
    components.
    """
    unit_of_signal: ClassVar[str] = ""
    """SI unit of the signal in components, if not the unit of the drive."""
    unit_of_reading: ClassVar[str] = ""
    """SI unit of the reading in components, if not the unit of the named reading."""

    def __init_subclass__(cls, *, init: bool = True) -> None:
        """Collect declarations; `init=False` stops type checkers from deriving arguments."""
        super().__init_subclass__()
        if isinstance(cls.declarations, property):  # computed by the class
            return
        own = {name: d for name, d in vars(cls).items() if isinstance(d, FieldDeclaration)}
        inherited: dict[str, FieldDeclaration] = {}
        for base in cls.__bases__:
            inherited |= getattr(base, "declarations", {})
        cls.declarations = {**inherited, **own}
        for name in own:
            delattr(cls, name)

    def __init__(self, *unnamed: Any, **values: Any) -> None:
        require_methods(type(self))
        owner = type(self).registered_name or type(self).__name__
        refuse_unnamed(type(self).__name__, unnamed, self.declarations)
        unknown = next((name for name in values if name not in self.declarations), None)
        if unknown is not None:
            raise ParameterError(f"`{owner}` has no parameter `{unknown}`. {suggest_name(unknown, self.declarations)}")
        for name, declared in self.declarations.items():
            value = values.get(name, declared.default)
            if value is REQUIRED:
                raise ParameterError(f"`{owner}` needs `{name}` [{declared.unit}] ({declared.doc}); none given.")
            if declared.kind == "part":
                require_part(type(self), owner, name, value, Parametrised)
            self.__dict__[name] = declared.convert(owner, name, value)
        self.check()

    def check(self) -> None:
        """Raise `ParameterError` if values contradict each other; override as needed."""

    def layout(self) -> tuple[int, ...]:
        """Return the counts that set the size of a traced program; `check` derives them as `_layout`."""
        return self.__dict__.get("_layout", ())

    def cautions(self) -> list[str]:
        """Return sentences about values that are allowed but probably unintended."""
        return []

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"`{type(self).__name__}` is frozen; use `.with_values(...)`.")

    def __repr__(self) -> str:
        settings = (
            (name, self.__dict__[name]) for name, d in self.declarations.items() if self.__dict__[name] != d.default
        )
        return f"{type(self).__name__}({', '.join(f'{name}={_shorten(value)}' for name, value in settings)})"

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash((type(self), *(repr(self.__dict__[name]) for name in self.declarations)))

    def children(self) -> Iterator[tuple[str, Parametrised]]:
        """Yield name and value of the parametrised components."""
        for name in self.declarations:
            value = self.__dict__[name]
            if isinstance(value, Parametrised):
                yield name, value

    def leaves(self, prefix: str = "") -> Iterator[Leaf]:
        """Yield all parameters of the tree with dotted paths, depth first."""
        owner = type(self).registered_name or type(self).__name__
        for name, declared in self.declarations.items():
            if declared.kind == "parameter":
                yield Leaf(prefix + name, declared, self.__dict__[name], owner)
        for name, child in self.children():
            yield from child.leaves(f"{prefix}{name}.")

    def tree(self) -> Iterator[Parametrised]:
        """Yield this object and all components below it."""
        yield self
        for _, child in self.children():
            yield from child.tree()

    def rebuilt(self, values: Mapping[str, Any], prefix: str = "") -> Self:
        """Return an unchecked copy with values replaced by path, for tracing kernels."""
        twin = object.__new__(type(self))
        for name, value in self.__dict__.items():
            if isinstance(value, Parametrised):
                value = value.rebuilt(values, f"{prefix}{name}.")
            twin.__dict__[name] = values.get(prefix + name, value)
        return twin

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """Return a checked copy with changed values, by path or unique ending of a path."""
        if not hasattr(values, "items"):
            raise ParameterError(f"Values must be a table by name, such as `{{'diameter': 2e-4}}`, but are {values!r}.")
        paths = [leaf.path for leaf in self.leaves()]
        return self._with_paths({resolve_path(name, paths): value for name, value in values.items()})

    def with_parts(self, **parts: Any) -> Self:
        """Return a checked copy with some fields exchanged."""
        return type(self)(**{**self.arguments(), **parts})

    def arguments(self) -> dict[str, Any]:
        """Return the arguments that make an equal object."""
        return {name: self.__dict__[name] for name in self.declarations}

    def _with_paths(self, values: Mapping[str, Any]) -> Self:
        own = self.arguments()
        for name, child in self.children():
            below = {p[len(name) + 1 :]: v for p, v in values.items() if p.startswith(name + ".")}
            own[name] = child._with_paths(below) if below else child
        own.update({path: v for path, v in values.items() if "." not in path})
        return type(self)(**own)

    def value_of(self, name: str) -> float:
        """Return the value [SI] of a parameter, by path or unique ending of a path."""
        full = self.resolve(name)
        return next(leaf.value for leaf in self.leaves() if leaf.path == full)

    def resolve(self, name: str) -> str:
        """Return the full path of a parameter, by path or unique ending of a path."""
        return resolve_path(name, [leaf.path for leaf in self.leaves()])


def _shorten(value: Any) -> str:
    """Return a value as text; long lists are shortened."""
    listed = cast("list[Any]", value)
    if not isinstance(value, (tuple, list)) or len(listed) <= SHOWN:
        return repr(listed)
    return f"({', '.join(map(repr, listed[:3]))}, … {len(listed)} values)"


def find_paths(name: str, paths: Iterable[str]) -> list[str]:
    """Return the path equal to `name`, or else all paths that end with it."""
    paths = list(paths)
    return [name] if name in paths else [p for p in paths if p.endswith(f".{name}")]


def resolve_path(name: str, paths: Sequence[str]) -> str:
    """Return the path that a name gives in full or by a unique ending; `ParameterError` if there is no such path."""
    matches = find_paths(name, paths)
    if len(matches) == 1:
        return matches[0]
    if matches:
        raise ParameterError(f"`{name}` is ambiguous: {', '.join(matches)}.")
    ending = name.rpartition(".")[2]
    near = [p for p in paths if get_close_matches(ending, [p.rpartition(".")[2]], cutoff=LEAST_LIKENESS)]
    hint = f"Did you mean `{near[0]}`?" if len(near) == 1 else suggest_name(name, near or paths)
    raise ParameterError(f"There is no parameter `{name}`. {hint}")


Part = TypeVar("Part", bound=Parametrised)


def describe_structure(part: Parametrised) -> tuple[Any, ...]:
    """Return a hashable description of everything but the parameter values."""
    options = tuple(
        (name, getattr(part, name))
        for name, declared in part.declarations.items()
        if declared.kind in ("option", "text")
    )
    return (
        type(part),
        options,
        part.layout(),
        tuple((name, describe_structure(child)) for name, child in part.children()),
    )


class StructureKey(Generic[Part]):
    """Hashable key of a parametrised object: objects of equal structure are equal."""

    __slots__ = ("key", "part")

    def __init__(self, part: Part) -> None:
        self.key, self.part = describe_structure(part), part

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, StructureKey) and self.key == cast("StructureKey[Any]", other).key


def values_at(part: Parametrised, paths: Sequence[str]) -> list[Any]:
    """Return the values at some paths, in the given order."""
    values: list[Any] = []
    for path in paths:
        value: Any = part
        for name in path.split("."):
            value = value.__dict__[name]
        values.append(value)
    return values
