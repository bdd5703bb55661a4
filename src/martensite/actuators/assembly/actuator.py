"""An actuator: an element, its surroundings, and what drives it."""

from collections.abc import Mapping
from typing import Any, ClassVar, Generic, NamedTuple, Self, TypeVar

from martensite.actuators.assembly.outputs import OBSERVABLES, Observation
from martensite.actuators.elements.base import ELEMENTS, AbstractElement, CellProfile, Heating
from martensite.actuators.mechanisms.base import Load, Output
from martensite.base.errors import ParameterError
from martensite.base.parameters import REQUIRED, Declared, Parametrised, part
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import SOURCES, AbstractSource
from martensite.physics.thermal.base import Environment
from martensite.signals.moments import Moments

Kind = TypeVar("Kind", bound=Parametrised)


class Members(Parametrised, Generic[Kind]):
    """Components of one kind by name, in the order in which they were given."""

    noun: ClassVar[str] = "component"
    """Noun for a component of this kind."""
    kind: ClassVar[type[Any]] = Parametrised
    registry: ClassVar[Registry[Any] | None] = None
    """Registry from which files choose a component by its name, if there are several kinds."""

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
        """Declare one part per component."""
        article = "an" if self.noun[0] in "aeiou" else "a"
        return {name: Declared("part", f"{article} {self.noun}", REQUIRED) for name in self.__dict__}

    def members(self) -> dict[str, Kind]:
        """Return the components by name."""
        return dict(self.__dict__)


class Feed(NamedTuple):
    """Input of an element during a step of a march."""

    moments: Moments
    """Moments of its drive signal."""
    owed: Scalar
    """Heat that the step before should have brought as well [J]."""


class Actuator(Parametrised):
    """An element, its environment and a source."""

    element: AbstractElement = part("the shape-memory element", ELEMENTS)
    environment: Environment = part("surroundings")
    source: AbstractSource = part("what drives the element", SOURCES)

    def start(self, xp: Namespace, force: Scalar, drive: Scalar) -> Any:
        """Return the state of the element at rest under a force [N], as warm as its surroundings."""
        imposed = self.source.sets_temperature
        temperature = drive if imposed else self.environment.temperature
        return self.element.init(xp, force, temperature)

    def load(self, state: Any, drive: Scalar | Feed) -> Load:
        """Return the element in a state, under a drive signal, as a mechanism sees it."""
        signal, owed = drive if isinstance(drive, Feed) else (drive, 0.0)
        heating = Heating(self.environment, self.source, signal, owed)
        return Load(self.element, state, heating)

    def with_cooling_signals(self, xp: Namespace, signals: Mapping[str, Scalar | Moments]) -> Self:
        """Return the actuator under the signals of what cools it."""
        cooling = self.environment.cooling
        return self.rebuilt({"environment.cooling": cooling.with_signals(xp, signals)}) if cooling.signals() else self

    def observe_element(self, xp: Namespace, state: Any, force: Scalar, drive: Scalar) -> dict[str, Scalar]:
        """Return every output, by name, under a force [N] and a drive signal."""
        condition = self.element.condition(xp, state, force, self.environment)
        current = self.source.current(xp, drive, condition.resistance)
        seen = Observation(drive, force, current, condition)
        return {name: OBSERVABLES[name].compute(seen) for name in self.own_outputs()}

    def own_outputs(self) -> dict[str, Output]:
        """Return the outputs of the element and of its drive."""
        rphase = getattr(self.element.law, "rphase", False)  # a user-defined element may have no law
        return {name: one.output for name, one in OBSERVABLES.items() if rphase or not one.of_rphase}

    def profile(self, state: Any) -> CellProfile:
        """Return the quantities that vary along the element; described in `PROFILES`."""
        return self.element.profile(state)


class Group(Members[Actuator], init=False):
    """Actuators by the names of the ports that they stand at."""

    noun = "actuator"
    kind = Actuator
