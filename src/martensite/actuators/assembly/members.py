"""Components by names of the user's own: actuators at ports, sensors, controllers, faults."""

from __future__ import annotations

from typing import Any, ClassVar, Generic, TypeVar

from martensite.base.errors import ParameterError
from martensite.base.parameters import REQUIRED, Declared, Parametrised
from martensite.base.registry import Registry

Kind = TypeVar("Kind", bound=Parametrised)


class Members(Parametrised, Generic[Kind]):
    """Components of one kind by name, in the order in which they were given."""

    noun: ClassVar[str] = "component"
    """What one of them is called."""
    kind: ClassVar[type[Any]] = Parametrised
    registry: ClassVar[Registry[Any] | None] = None
    """Where files choose one by its name, if there are several kinds."""

    def __init__(self, **members: Kind) -> None:
        for name, member in members.items():
            if not isinstance(member, self.kind):
                raise ParameterError(
                    f"{self.noun.capitalize()} `{name}` must be an `{self.kind.__name__}`, but is "
                    f"{type(member).__name__}."
                )
            self.__dict__[name] = member

    @property
    def declarations(self) -> dict[str, Declared]:  # type: ignore[override]
        """One part per component."""
        article = "an" if self.noun[0] in "aeiou" else "a"
        return {name: Declared("part", f"{article} {self.noun}", REQUIRED) for name in self.__dict__}

    def members(self) -> dict[str, Kind]:
        """Name -> component."""
        return dict(self.__dict__)
