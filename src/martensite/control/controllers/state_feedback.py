"""State feedback around an operating point, with integral action.

    u = u_0 + N (r - y_0) - Σ K_i (z_i - z_0i) + K_I I,    low ≤ u ≤ high
    I_k = I_k-1 + e_k T,    e = r - y

The states z are readings: sensors, estimates `estimated.NAME` of observers, or without sensors outputs of the plant. N
is the feed-forward gain of the reference. The integral stops where the signal is at a limit and the error drives it
further. `martensite.control.synthesis.lqr` computes all parameters.
"""

from collections.abc import Sequence
from typing import Any, Self

from martensite.base.errors import ParameterError
from martensite.base.parameters import REQUIRED, FieldDeclaration, Number, Parametrised, param, part, text
from martensite.base.units import LEVEL
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings, SignalLimits
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE


@CONTROLLERS.register("state-feedback")
class StateFeedback(AbstractController, SignalLimits):
    """State feedback, for example of a linear-quadratic regulator."""

    states: tuple[str, ...] = text("readings that are the states; default: the measured reading", default=())
    gains: Any = part("gains K, one per state, in signal per SI unit", default=(0.0,))
    at: Any = part("states z_0 of the operating point, in SI", default=(0.0,))
    signal: Number = param(DRIVE, "signal u_0 of the operating point", default=0.0)
    level: Number = param(LEVEL, "reading y_0 of the operating point", default=0.0)
    prefilter: Number = param("1", "gain N of the reference", default=0.0)
    Ki: Number = param("1/s", "gain K_I of the integral of the error", default=0.0)

    def check(self) -> None:
        title = "state-feedback"
        for name in ("gains", "at"):
            row = self.__dict__[name] = as_row(title, name, self.__dict__[name])
            if len(row.numbers) != len(self.state_names):
                raise ParameterError(
                    f"`{name}` of `{title}` must have a number for each of the {len(self.state_names)} states "
                    f"({', '.join(self.state_names)}), but has {len(row.numbers)}."
                )
        super().check()

    @property
    def state_names(self) -> tuple[str, ...]:
        """Return the names of the readings that are the states."""
        states = (self.states,) if isinstance(self.states, str) else self.states
        return states or (self.measured,)

    def reads(self) -> tuple[str, ...]:
        return self.measured, *self.state_names

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        return (0.0,)

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        added = (reference - readings[self.measured]) * dt
        integral = memory[0] + added
        wanted = self.signal + self.prefilter * (reference - self.level) + self.Ki * integral
        rows = zip(self.state_names, self.gains.numbers, self.at.numbers, strict=True)
        for name, gain, value in rows:
            wanted = wanted - gain * (readings[name] - value)
        new_integral = self.hold_integral(xp, wanted, self.Ki * added, memory[0], integral)
        return xp.clip(wanted, self.low, self.high), (new_integral,)


class NumberedGains(Parametrised):
    """A row of numbers n1, n2, …, such as gains or weights.

    As a row they are leaves, `gains.n1`, `gains.n2`, …: they may differ in a batch and have derivatives, and two rows
    of one length share a traced program.
    """

    def __init__(self, **numbers: float) -> None:
        for place, (name, value) in enumerate(numbers.items(), 1):
            if name != f"n{place}":
                raise ParameterError(f"Number {place} of a row is `n{place}`, not `{name}`.")
            self.__dict__[name] = _convert_number(place).convert("row", name, value)

    @classmethod
    def of(cls, numbers: Sequence[float]) -> Self:
        """Return a row of these numbers."""
        return cls(**{f"n{place}": number for place, number in enumerate(numbers, 1)})

    @property
    def declarations(self) -> dict[str, FieldDeclaration]:  # type: ignore[override]
        return {name: _convert_number(place) for place, name in enumerate(self.__dict__, 1)}

    def layout(self) -> tuple[int, ...]:
        return (len(self.__dict__),)

    @property
    def numbers(self) -> tuple[Scalar, ...]:
        """Return all numbers."""
        return tuple(self.__dict__.values())


def _convert_number(place: int) -> FieldDeclaration:
    return FieldDeclaration("parameter", f"number {place} of a row", REQUIRED)


def as_row(owner: str, name: str, given: Any) -> NumberedGains:
    """Return a row or a sequence of numbers as a row; raise `ParameterError` for anything else."""
    if isinstance(given, NumberedGains):
        return given
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise ParameterError(f"`{name}` of `{owner}` must be a list of numbers, not {given!r}.")
    return NumberedGains.of(given)  # type: ignore[arg-type]
