"""Driven cooling: a fan that blows across the element, a Peltier module that pumps heat out of it.

The cooling signal has a separate waveform under [signals.NAME], or comes from a controller. At an instant the model is
evaluated at the signal. Over a step its heat flow is averaged: at the bounds u₁, u₂ and the mean m of the signal, with
weights that reproduce mean and variance v,

    ⟨f(u)⟩ = w₁ f(u₁) + w₂ f(u₂) + (1 - w₁ - w₂) f(m),   w₁ = v/[(m - u₁)(u₂ - u₁)],   w₂ = v/[(u₂ - m)(u₂ - u₁)]

This is exact for a signal that switches between two levels, and Simpson's rule for a ramp. Bounds on the temperature,
which have no signal, use signal 0.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param, part, text
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.fluids.air import Air
from martensite.physics.fluids.base import FLUIDS, AbstractFluid
from martensite.physics.thermal.base import COOLING, AbstractCooling, Cylinder
from martensite.physics.thermal.convection import STILL_NUSSELT, ChurchillChu, correlate_stream
from martensite.signals.moments import Moments

LEAST_REYNOLDS = 1e-24
"""Re that counts as no flow."""


class AbstractActiveCooling(AbstractCooling):
    """Interface of a heat-loss model with a signal; `unit` is the SI unit of the signal."""

    unit: ClassVar[str] = "1"
    signal: str = text("name of its signal; actuators that name the same one share it", default="cooling")

    @abstractmethod
    def film_at(self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """Return the film coefficient [W/(m² K)] at a level of the signal."""

    def pump_heat_at(
        self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar, shape: Cylinder
    ) -> Scalar | None:
        """Return the heat flow [W] in addition to the film at a level of the signal; None without such a flow."""
        return None

    @override
    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        return self.film_at(xp, 0.0, temperature, ambient, shape)

    def pump_heat(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar | None:
        """Return the heat flow [W] in addition to the film at signal 0."""
        return self.pump_heat_at(xp, 0.0, temperature, ambient, shape)

    @override
    def signals(self) -> dict[str, str]:
        return {self.signal: self.unit} | super().signals()

    @override
    def with_signals(self, xp: Namespace, signals: Mapping[str, Scalar | Moments]) -> AbstractCooling:
        whole, signal = self.drive_models(xp, signals), signals[self.signal]
        fixed = CoolingAtLevel(model=whole, level=0.0)
        if not isinstance(signal, Moments):
            return fixed.rebuilt({"level": signal})
        spread = xp.maximum(signal.square - signal.mean * signal.mean, 0.0)
        below, above, span = signal.mean - signal.low, signal.high - signal.mean, signal.high - signal.low
        at_low, at_high = (
            xp.where(side > 0.0, spread / xp.where(side > 0.0, side * span, 1.0), 0.0) for side in (below, above)
        )
        levels = {"low.level": signal.low, "mean.level": signal.mean, "high.level": signal.high}
        averaged = AveragedCooling(low=fixed, mean=fixed, high=fixed, at_low=0.0, at_high=0.0)
        return averaged.rebuilt({**levels, "at_low": at_low, "at_high": at_high})


class CoolingAtLevel(AbstractCooling):
    """Driven model at a level of its signal."""

    model: AbstractActiveCooling = part("the model")
    level: Number = param("1", "level of the signal, in its unit")

    @override
    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        return self.model.film_at(xp, self.level, temperature, ambient, shape)

    @override
    def pump_heat(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar | None:
        return self.model.pump_heat_at(xp, self.level, temperature, ambient, shape)


class AveragedCooling(AbstractCooling):
    """Driven model averaged over a step."""

    low: AbstractCooling = part("at the lowest level")
    mean: AbstractCooling = part("at the mean level")
    high: AbstractCooling = part("at the highest level")
    at_low: Number = param("1", "weight of the lowest level", low=0.0, high=1.0)
    at_high: Number = param("1", "weight of the highest level", low=0.0, high=1.0)

    @override
    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        return self._average(*(one.film(xp, temperature, ambient, shape) for one in self._three()))

    @override
    def pump_heat(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar | None:
        low, mean, high = (one.pump_heat(xp, temperature, ambient, shape) for one in self._three())
        return None if low is None or mean is None or high is None else self._average(low, mean, high)

    def _three(self) -> tuple[AbstractCooling, AbstractCooling, AbstractCooling]:
        return self.low, self.mean, self.high

    def _average(self, low: Scalar, mean: Scalar, high: Scalar) -> Scalar:
        return mean + self.at_low * (low - mean) + self.at_high * (high - mean)


@COOLING.register("fan")
class Fan(AbstractActiveCooling):
    """Air stream across the wire with the speed as signal, in m/s; free convection at zero speed.

        h⁴ = h_N⁴ + h_F(u)⁴ - h_F(0)⁴

    with h_N of the model `still` and h_F = Nu k/d of `churchill-bernstein` at the speed u. Mixed convection adds powers
    of Nu; 4 is the usual exponent for a cylinder. The value Nu = 0.3 of `churchill-bernstein` at zero speed is
    subtracted, so that the wire then loses the heat of `still`. The signal is the air speed at the wire; describe the
    lag of blades and duct by the waveform. Speeds are limited to 0 … `highest`.

    Source: Churchill and Bernstein (1977) for h_F, Bergman et al. (2011), section 9.9, for the sum; both recalled.
    """

    cites = ("churchill1977", "bergman2011")
    unit = "m/s"

    signal: str = text("name of its signal; actuators that name the same one share it", default="fan")
    highest: Number = param("m/s", "highest speed that it reaches", above=0.0, high=100.0, default=100.0, typical=5.0)
    still: AbstractCooling = part("heat-loss model without a stream", COOLING, default=ChurchillChu())
    fluid: AbstractFluid = part("what it blows", FLUIDS, default=Air())

    def film_at(self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """Return h [W/(m² K)] at a speed [m/s]."""
        fluid = self.fluid.properties(xp, 0.5 * (temperature + ambient))
        speed = xp.clip(level, 0.0, self.highest)
        reynolds = xp.maximum(speed * shape.diameter / fluid.viscosity, LEAST_REYNOLDS)
        unit = fluid.conductivity / shape.diameter
        conducted = STILL_NUSSELT * unit
        forced = conducted + correlate_stream(xp, reynolds, fluid.prandtl) * unit
        free = self.still.film(xp, temperature, ambient, shape)
        fourth = _raise_to_fourth(free) + (_raise_to_fourth(forced) - _raise_to_fourth(conducted))
        return xp.sqrt(xp.sqrt(fourth))

    @override
    def pump_heat_at(
        self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar, shape: Cylinder
    ) -> Scalar | None:
        return self.still.pump_heat(xp, temperature, ambient, shape)


def _raise_to_fourth(base: Scalar) -> Scalar:
    return base * base * (base * base)


@COOLING.register("peltier")
class Peltier(AbstractActiveCooling):
    """Peltier module with the current as signal, in A; positive currents cool.

        G_c (T - T_c) = α I T_c - ½ I² R - K (T_h - T_c)
        G_h (T_h - T_a) = α I T_h + ½ I² R - K (T_h - T_c)

    with the cold side T_c on the wire through a contact G_c, and the hot side T_h on a sink of conductance G_h to the
    ambient. Both are linear in T_c and T_h, which have no heat capacity here. The heat q = G_c (T - T_c) leaves a
    length `pitch` of wire; a wire of length l has l/`pitch` modules, all in series. `still` is the additional film of
    the wire. Without current the module conducts to the sink.

    At T_c the pumped heat is largest for I = α T_c/R; beyond, the module heats more than it pumps. The current is
    limited to -`reverse` … `highest`; negative currents heat the wire.

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

    @override
    def check(self) -> None:
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

    @override
    def film_at(self, xp: Namespace, level: Scalar, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
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
        """Return the heat [W] out of the wire at a current [A], including that of `still`."""
        through = self.contact * (temperature - self.cold_side(xp, level, temperature, ambient))
        own, other = through * (shape.length / self.pitch), self.still.pump_heat(xp, temperature, ambient, shape)
        return own if other is None else own + other
