"""An actuator: element, environment and source."""

from collections.abc import Mapping
from typing import Any, ClassVar, Generic, NamedTuple, Self, TypeVar

from martensite.actuators.assembly.outputs import OBSERVABLES, Observation
from martensite.actuators.elements.base import ELEMENTS, AbstractElement, CellProfile, Heating
from martensite.actuators.mechanisms.base import Load, Output
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import REQUIRED, FieldDeclaration, Parametrised, part
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import SOURCES, AbstractSource
from martensite.physics.thermal.base import Environment
from martensite.signals.moments import Moments

Kind = TypeVar("Kind", bound=Parametrised)


class Members(Parametrised, Generic[Kind]):
    """Components of one kind by name, in the given order."""

    noun: ClassVar[str] = "component"
    kind: ClassVar[type[Parametrised]] = Parametrised
    registry: ClassVar[Registry[Any] | None] = None
    """Registry from which files choose a component by name."""

    def __init__(self, **members: Kind) -> None:
        for name, member in members.items():
            if not isinstance(member, self.kind):
                raise ParameterError(
                    f"{self.noun.capitalize()} `{name}` must be an `{self.kind.__name__}`, but is "
                    f"{type(member).__name__}."
                )
            self.__dict__[name] = member

    @property
    @override
    def declarations(self) -> dict[str, FieldDeclaration]:  # type: ignore[override]
        article = "an" if self.noun[0] in "aeiou" else "a"
        return {name: FieldDeclaration("part", f"{article} {self.noun}", REQUIRED) for name in self.__dict__}

    def members(self) -> dict[str, Kind]:
        """Return the components by name."""
        return dict(self.__dict__)


class Feed(NamedTuple):
    """Input of an element during a time step."""

    moments: Moments
    """Moments of the drive signal."""
    owed: Scalar
    """Heat missing from the previous step [J]."""


class Actuator(Parametrised):
    """Element, environment and source."""

    element: AbstractElement = part("the shape-memory element", ELEMENTS)
    environment: Environment = part("surroundings")
    source: AbstractSource = part("what drives the element", SOURCES)

    def start(self, xp: Namespace, force: Scalar, drive: Scalar) -> Any:
        """Return the equilibrium of the element under a force [N] at ambient temperature."""
        imposed = self.source.sets_temperature
        temperature = drive if imposed else self.environment.temperature
        return self.element.init(xp, force, temperature)

    def load(self, state: Any, drive: Scalar | Feed) -> Load:
        """Return the element in a state, under a drive signal, as a mechanism needs it."""
        signal, owed = drive if isinstance(drive, Feed) else (drive, 0.0)
        heating = Heating(self.environment, self.source, signal, owed)
        return Load(self.element, state, heating)

    def with_cooling_signals(self, xp: Namespace, signals: Mapping[str, Scalar | Moments]) -> Self:
        """Return the actuator under its cooling signals."""
        cooling = self.environment.cooling
        return self.rebuilt({"environment.cooling": cooling.with_signals(xp, signals)}) if cooling.signals() else self

    def observe_element(self, xp: Namespace, state: Any, force: Scalar, drive: Scalar) -> dict[str, Scalar]:
        """Return each output, by name, under a force [N] and a drive signal."""
        condition = self.element.condition(xp, state, force, self.environment)
        current = self.source.current(xp, drive, condition.resistance)
        observation = Observation(drive, force, current, condition)
        return {name: OBSERVABLES[name].compute(observation) for name in self.own_outputs()}

    def own_outputs(self) -> dict[str, Output]:
        """Return the outputs of element and drive."""
        rphase = getattr(self.element.law, "has_rphase", False)  # a user-defined element may have no law
        return {name: one.output for name, one in OBSERVABLES.items() if rphase or not one.of_rphase}

    def profile(self, state: Any) -> CellProfile:
        """Return the quantities of `PROFILES` along the element."""
        return self.element.profile(state)


class Group(Members[Actuator], init=False):
    """Actuators by port name."""

    noun = "actuator"
    kind = Actuator
