"""Cooling that is driven: a fan that blows across the element, a Peltier module that pumps heat out of it.

The signal stands beside the signal of the source, has a separate waveform under [signals.NAME], and may come from a
controller. At an instant the model is evaluated at the level of the signal. Over a step its heat flow is averaged over
the signal: at the bounds u₁, u₂ and the mean m of the signal, with weights that give its mean and its variance v,

    ⟨f(u)⟩ = w₁ f(u₁) + w₂ f(u₂) + (1 - w₁ - w₂) f(m),   w₁ = v/[(m - u₁)(u₂ - u₁)],   w₂ = v/[(u₂ - m)(u₂ - u₁)]

which is exact for a signal that is switched between two levels, and Simpson's rule for a ramp. Where its signal is not
known, as in a bound on the temperature, a model stands still: signal 0.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param, part, text
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.fluids.air import Air
from martensite.physics.fluids.base import FLUIDS, AbstractFluid
from martensite.physics.thermal.base import COOLING, AbstractCooling, Cylinder
from martensite.physics.thermal.convection import STILL_NUSSELT, ChurchillChu, correlate_stream
from martensite.signals.moments import Moments

LEAST_REYNOLDS = 1e-24
"""Re that counts as no stream."""


class AbstractActiveCooling(AbstractCooling):
    """Interface of a heat-loss model with a signal; `unit` is the SI unit of that."""

    unit: ClassVar[str] = "1"
    signal: str = text("name of its signal; actuators that name the same one share it", default="cooling")

    @abstractmethod
    def film_at(self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """Return the film coefficient [W/(m² K)] at a level of the signal."""

    def pump_heat_at(
        self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar, shape: Cylinder
    ) -> Scalar | None:
        """Return the heat flow [W] beside that of the film at a level of the signal; None if there is none."""
        return None

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """h [W/(m² K)] as it stands still."""
        return self.film_at(xp, 0.0, temperature, ambient, shape)

    def pump_heat(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar | None:
        """Return the heat flow [W] beside that of the film, as it stands still."""
        return self.pump_heat_at(xp, 0.0, temperature, ambient, shape)

    def signals(self) -> dict[str, str]:
        """Return its own, and those of the models in it."""
        return {self.signal: self.unit} | super().signals()

    def with_signals(self, xp: Namespace, signals: Mapping[str, Scalar | Moments]) -> AbstractCooling:
        """At the level of its signal, or averaged over a step."""
        whole, given = self.drive_models(xp, signals), signals[self.signal]
        held = CoolingAtLevel(model=whole, level=0.0)
        if not isinstance(given, Moments):
            return held.rebuilt({"level": given})
        spread = xp.maximum(given.square - given.mean * given.mean, 0.0)
        below, above, span = given.mean - given.low, given.high - given.mean, given.high - given.low
        at_low, at_high = (
            xp.where(side > 0.0, spread / xp.where(side > 0.0, side * span, 1.0), 0.0) for side in (below, above)
        )
        levels = {"low.level": given.low, "mean.level": given.mean, "high.level": given.high}
        found = AveragedCooling(low=held, mean=held, high=held, at_low=0.0, at_high=0.0)
        return found.rebuilt({**levels, "at_low": at_low, "at_high": at_high})


class CoolingAtLevel(AbstractCooling):
    """A driven model at a level of its signal."""

    model: AbstractActiveCooling = part("the model")
    level: Number = param("1", "level of the signal, in its unit")

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """h [W/(m² K)] at this level."""
        return self.model.film_at(xp, self.level, temperature, ambient, shape)

    def pump_heat(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar | None:
        """Return the heat flow [W] at this level."""
        return self.model.pump_heat_at(xp, self.level, temperature, ambient, shape)


class AveragedCooling(AbstractCooling):
    """A driven model in the mean of a step."""

    low: AbstractCooling = part("at the lowest level")
    mean: AbstractCooling = part("at the mean level")
    high: AbstractCooling = part("at the highest level")
    at_low: Number = param("1", "weight of the lowest level", low=0.0, high=1.0)
    at_high: Number = param("1", "weight of the highest level", low=0.0, high=1.0)

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """Return the mean h [W/(m² K)]."""
        return self._average(*(one.film(xp, temperature, ambient, shape) for one in self._three()))

    def pump_heat(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar | None:
        """Return the mean heat flow [W]."""
        low, mean, high = (one.pump_heat(xp, temperature, ambient, shape) for one in self._three())
        return None if low is None or mean is None or high is None else self._average(low, mean, high)

    def _three(self) -> tuple[AbstractCooling, AbstractCooling, AbstractCooling]:
        return self.low, self.mean, self.high

    def _average(self, low: Scalar, mean: Scalar, high: Scalar) -> Scalar:
        return mean + self.at_low * (low - mean) + self.at_high * (high - mean)


@COOLING.register("fan")
class Fan(AbstractActiveCooling):
    """A stream across the wire whose speed is a signal, in m/s; free convection where it stands.

        h⁴ = h_N⁴ + h_F(u)⁴ - h_F(0)⁴

    with h_N that of the model `still` and h_F = Nu k/d of `churchill-bernstein` at the speed u. Powers of Nu are added
    where a stream crosses what rises by itself, and the exponent 4 is the usual one for a cylinder; what
    `churchill-bernstein` says of no stream at all, Nu = 0.3, is taken off, so that at speed 0 the wire loses what
    `still` says. The signal is the speed of the air at the wire: blades and duct that follow a voltage late are for
    the waveform to say. A speed below 0 is none, one above `highest` is that.

    Source: Churchill and Bernstein (1977) for h_F, Bergman et al. (2011), section 9.9, for the sum; both recalled.
    """

    cites = ("churchill1977", "bergman2011")
    unit = "m/s"

    signal: str = text("name of its signal; actuators that name the same one share it", default="fan")
    highest: Number = param("m/s", "highest speed that it reaches", above=0.0, high=100.0, default=100.0, typical=5.0)
    still: AbstractCooling = part("heat-loss model without a stream", COOLING, default=ChurchillChu())
    fluid: AbstractFluid = part("what it blows", FLUIDS, default=Air())

    def film_at(self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """h [W/(m² K)] at a speed [m/s]."""
        found = self.fluid.properties(xp, 0.5 * (temperature + ambient))
        speed = xp.clip(level, 0.0, self.highest)
        reynolds = xp.maximum(speed * shape.diameter / found.viscosity, LEAST_REYNOLDS)
        unit = found.conductivity / shape.diameter
        conducted = STILL_NUSSELT * unit
        forced = conducted + correlate_stream(xp, reynolds, found.prandtl) * unit
        free = self.still.film(xp, temperature, ambient, shape)
        fourth = _raise_to_fourth(free) + (_raise_to_fourth(forced) - _raise_to_fourth(conducted))
        return xp.sqrt(xp.sqrt(fourth))

    def pump_heat_at(
        self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar, shape: Cylinder
    ) -> Scalar | None:
        """Return the heat that the model without a stream pumps [W]."""
        return self.still.pump_heat(xp, temperature, ambient, shape)


def _raise_to_fourth(base: Scalar) -> Scalar:
    return base * base * (base * base)


@COOLING.register("peltier")
class Peltier(AbstractActiveCooling):
    """A Peltier module whose current is a signal, in A; above 0 it cools.

        G_c (T - T_c) = α I T_c - ½ I² R - K (T_h - T_c)
        G_h (T_h - T_a) = α I T_h + ½ I² R - K (T_h - T_c)

    with the cold side T_c on the wire through a contact G_c, and the hot side T_h on a sink of conductance G_h to the
    surroundings. Both are linear in T_c and T_h, which have no heat capacity here. Heat q = G_c (T - T_c) leaves a
    length `pitch` of wire; a wire of length l has l/`pitch` modules, all in series. `still` is what the film of the
    wire loses besides. Without current the module conducts, as a bridge to the sink.

    At T_c the heat pumped is largest for I = α T_c/R; beyond, the module heats more than it pumps. The current is held
    between -`reverse` and `highest`; below 0 the module heats the wire.

    Source: Goldsmid (2010), chapter 2, with contact and sink added; recalled.
    """

    cites = ("goldsmid2010",)
    unit = "A"

    signal: str = text("name of its signal; actuators that name the same one share it", default="peltier")
    seebeck: Number = param("V/K", "Seebeck coefficient α of the module", above=0.0, high=10.0, typical="0.01 V/K")
    resistance: Number = param("ohm", "resistance R of the module", above=0.0, high=1e4, typical="1 ohm")
    conductance: Number = param("W/K", "conductance K of the module", low=0.0, high=1e3, typical="0.02 W/K")
    contact: Number = param("W/K", "conductance G_c from wire to cold side", above=0.0, high=1e3, typical="0.01 W/K")
    sink: Number = param("W/K", "conductance G_h from hot side to surroundings", above=0.0, high=1e9, typical="2 W/K")
    pitch: Number = param("m", "length of wire that one module cools", above=0.0, high=1e3, typical="50 mm")
    highest: Number = param("A", "largest current", above=0.0, high=1e4, default=10.0, typical="3 A")
    reverse: Number = param("A", "largest current the other way", low=0.0, high=1e4, default=0.0, typical="1 A")
    still: AbstractCooling = part("heat-loss model of the film", COOLING, typical="churchill-chu")

    def check(self) -> None:
        """Raise `ParameterError` if a side cannot be rid of what the module pumps into it."""
        for name, side, sign in (("highest", "sink", 1.0), ("reverse", "contact", -1.0)):
            most = getattr(self, name)
            if self._determinant(sign * self.seebeck * most) <= 0.0:
                raise ParameterError(
                    f"`{name}` of `peltier` is {most:.4g} A, with which the module pumps more than `{side}` takes and "
                    f"heats itself without end; take less current or a larger `{side}`."
                )

    def _determinant(self, pumped: Scalar) -> Scalar:
        cold, hot = self.contact + self.conductance + pumped, self.sink + self.conductance - pumped
        return cold * hot - self.conductance * self.conductance

    def film_at(self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """Return the film coefficient of `still` [W/(m² K)]."""
        return self.still.film(xp, temperature, ambient, shape)

    def cold_side(self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar) -> Scalar:
        """Return the temperature T_c [K] at a current [A]."""
        current = xp.clip(level, -self.reverse, self.highest)
        pumped, heated = self.seebeck * current, 0.5 * current * current * self.resistance
        hot = self.sink + self.conductance - pumped
        given = self.contact * temperature + heated, self.sink * ambient + heated
        return (hot * given[0] + self.conductance * given[1]) / self._determinant(pumped)

    def pump_heat_at(
        self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar, shape: Cylinder
    ) -> Scalar | None:
        """Return the heat [W] out of the wire at a current [A], and what `still` pumps."""
        through = self.contact * (temperature - self.cold_side(xp, level, temperature, ambient))
        own, other = through * (shape.length / self.pitch), self.still.pump_heat(xp, temperature, ambient, shape)
        return own if other is None else own + other
