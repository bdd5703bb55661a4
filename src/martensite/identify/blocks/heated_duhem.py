"""A heated shape-memory actuator with few parameters: heat balance, latent heat, hysteresis, lags.

    τ (1 + Λ dz/dθ) dθ/dt = K u exp(ρ z) - θ (1 - r + r |θ|/θ_m)
    z along the branches of `operators.branches`, rising where the right side is above 0
    temperature = T_a + κ (θ through a lag τ_s),    position = S (z through a lag τ_p)

θ is the temperature rise over ambient, u the input (power or duty cycle), z the austenite fraction. Latent heat is a
feedback: during the transformation the heat capacity is 1 + Λ dz/dθ times larger, which blocks in series cannot give.
With the power p of one unit of u, the heat capacity is p τ/K, the loss p/K and the latent heat p τ Λ/K. ρ is the
logarithm of the power in austenite over martensite, r the fraction of the loss at θ_m that grows with θ.

The scale of θ cannot be identified from input, temperature and position: twice all rises with half of κ give the same
outputs. Only the priors determine it; enter a known κ, or measured transformation temperatures, as expected values.
Temperatures are in the unit of the record, degC or K; only `ambient` must fit.

Each step is linearly implicit in the loss and solves the enthalpy of the step by one Newton step after the slope at its
start, within the bounds without transformation and without heat loss. It is stable for every step size.
"""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np

from martensite.base.parameters import Number, option, param
from martensite.base.units import DEGREES
from martensite.identify.blocks.base import BLOCKS, AbstractBlock, Column, Numbers
from martensite.identify.operators import branches
from martensite.identify.operators.sections import first_order
from martensite.kernels.namespace import Namespace, Scalar

MIDDLE = 40.0
"""θ_m [K]."""
TYPICAL = 50.0
"""Default mean rise in the records of an actuator [K]."""
NEWTON = 12
SPREADS = (
    ("log_time_constant", 1.0),
    ("log_gain", 1.0),
    ("loss_logit", 1.5),
    ("log_latent", 1.0),
    ("resistance", 0.3),
    ("ambient", 2.0),
    ("rising_centre1", 15.0),
    ("rising_centre2", 20.0),
    ("log_rising_width1", 1.0),
    ("log_rising_width2", 1.0),
    ("rising_logit", 2.0),
    ("falling_centre1", 15.0),
    ("falling_centre2", 20.0),
    ("log_falling_width1", 1.0),
    ("log_falling_width2", 1.0),
    ("falling_logit", 2.0),
    ("sensor_gain", 0.3),
    ("log_sensor_lag", 1.0),
    ("stroke", np.inf),
    ("log_stroke_lag", 1.0),
)
"""Free numbers and the standard deviations of their priors."""


class _Heat(NamedTuple):
    """Heat balance and branches from the free numbers."""

    tau: Scalar
    gain: Scalar
    growing: Scalar
    latent: Scalar
    resistance: Scalar
    rising: branches.LogisticBranch
    falling: branches.LogisticBranch

    def power(self, xp: Namespace, u: Scalar, z: Scalar) -> Scalar:
        """Return the steady rise of the input [K]."""
        return self.gain * u * xp.exp(self.resistance * z)

    def loss(self, xp: Namespace, rise: Scalar) -> Scalar:
        """Return the heat loss [K], 1 K per K at θ_m."""
        return rise * (1.0 - self.growing + self.growing * xp.abs(rise) / MIDDLE)

    def loss_slope(self, xp: Namespace, rise: Scalar) -> Scalar:
        """Return the derivative of the loss, above 0."""
        return 1.0 - self.growing + 2.0 * self.growing * xp.abs(rise) / MIDDLE


@BLOCKS.register("heated-duhem")
class HeatedDuhem(AbstractBlock):
    """From heating to measured temperature and position, with 20 free numbers.

    The declared parameters are expected values: start of a fit, and centres of priors. All but the gain are typical of
    a wire of half a millimetre in air.
    """

    short = "heated"
    shape = ("gives",)
    fixed = (
        "ambient",
        "gain",
        "time_constant",
        "latent",
        "rising",
        "falling",
        "sensor_gain",
        "sensor_lag",
        "stroke",
        "stroke_lag",
    )
    cites = ("ivshin1994",)

    gives: str = option("outputs", "both", "temperature", "position", default="both")
    ambient: Number = param("1", "temperature of the surroundings [degC or K]", default=23.0)
    gain: Number = param("1", "rise held by one unit of input [K]; 0: 50 K at the mean input", low=0.0, default=0.0)
    time_constant: Number = param("s", "time constant of cooling", above=0.0, default=10.0)
    latent: Number = param(DEGREES, "latent heat over heat capacity", above=0.0, default=30.0)
    rising: Number = param(DEGREES, "rise at which half is austenite on heating", default=65.0)
    falling: Number = param(DEGREES, "rise at which half is austenite on cooling", default=40.0)
    sensor_gain: Number = param("1", "rise measured over rise", default=0.7)
    sensor_lag: Number = param("s", "lag of the temperature sensor", above=0.0, default=0.3)
    stroke: Number = param("1", "position in austenite, in units of the record", default=1.0)
    stroke_lag: Number = param("s", "lag of the position", above=0.0, default=0.05)

    @property
    def outputs(self) -> int:
        return 2 if self.gives == "both" else 1

    def numbers(self) -> tuple[str, ...]:
        return tuple(name for name, _ in SPREADS)

    def states(self) -> int:
        return 4

    def _heat(self, xp: Namespace, theta: Column) -> _Heat:
        return _Heat(
            tau=xp.exp(xp.clip(theta[0], -14.0, 14.0)),
            gain=xp.exp(xp.clip(theta[1], -30.0, 30.0)),
            growing=branches.compute_logistic(xp, xp.clip(theta[2], -9.0, 9.0)),
            latent=xp.exp(xp.clip(theta[3], -30.0, 30.0)),
            resistance=xp.clip(theta[4], -3.0, 3.0),
            rising=branches.branch_of(xp, theta[6:11]),
            falling=branches.branch_of(xp, theta[11:16]),
        )

    def gains(self) -> tuple[str, ...]:
        return {"both": ("", "stroke"), "position": ("stroke",), "temperature": ("",)}[self.gives]

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        heat = self._heat(xp, theta)
        rise = _hold_rise(xp, heat, x[0])
        z = branches.from_below(xp, heat.rising, rise)
        return rise, z, rise, z

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        rise, z, lagged_rise, moved = state
        new_rise, new_z = _heat_step(xp, self._heat(xp, theta), rise, z, x[0], dt)
        temperature = theta[5] + theta[16] * lagged_rise
        position = theta[18] * moved
        after = (
            new_rise,
            new_z,
            _lag_ramp(xp, theta[17], lagged_rise, rise, new_rise, dt),
            _lag_ramp(xp, theta[19], moved, z, new_z, dt),
        )
        if self.gives == "both":
            return (temperature, position), after
        return (temperature if self.gives == "temperature" else position,), after

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        mean = float(np.mean(np.abs(x)))
        return self.with_parts(gain=TYPICAL / max(mean, 1e-12)) if self.gain == 0.0 else self

    def start(self) -> Numbers:
        log, widths = np.log, np.log([3.0, 12.0])
        gain = self.gain if self.gain > 0.0 else TYPICAL
        return np.array(
            [
                log(self.time_constant),
                log(gain),
                -2.0,
                log(self.latent),
                0.0,
                self.ambient,
                self.rising,
                self.rising + 15.0,
                *widths,
                1.5,
                self.falling,
                self.falling - 15.0,
                *widths,
                1.5,
                self.sensor_gain,
                log(self.sensor_lag),
                self.stroke,
                log(self.stroke_lag),
            ]
        )

    def priors(self) -> tuple[Numbers, Numbers]:
        return self.start(), np.array([1.0 / spread for _, spread in SPREADS])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        spread = np.array([s if np.isfinite(s) else 0.0 for _, s in SPREADS])
        return self.start() + 0.5 * spread * rng.uniform(-1.0, 1.0, len(spread))

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        return [self._row(n, float(v), float(theta[5])) for n, v in zip(self.numbers(), theta, strict=True)]

    def _row(self, name: str, value: float, ambient: float) -> tuple[str, float, str]:
        if name.startswith("log_"):
            unit = "s" if name.endswith(("lag", "constant")) else "K"
            return name.removeprefix("log_"), float(np.exp(value)), unit
        if name.endswith("logit"):
            return name.removesuffix("logit") + "share", float(1.0 / (1.0 + np.exp(-value))), "1"
        return name, value + ambient if "centre" in name else value, "1"


def _lag_ramp(xp: Namespace, log_tau: Scalar, y: Scalar, before: Scalar, after: Scalar, dt: Scalar) -> Scalar:
    """Return the exact first-order lag over a step with a linear input."""
    p = first_order(xp, log_tau, dt)
    steps = dt * xp.exp(-xp.clip(log_tau, -14.0, 14.0))
    return y + p * (before - y) + (after - before) * (1.0 - p / steps)


def _heat_step(xp: Namespace, heat: _Heat, rise: Scalar, z: Scalar, u: Scalar, dt: Scalar) -> tuple[Scalar, Scalar]:
    """Return rise and z after a step: θ - θ₀ + Λ (z - z₀) = (dt/τ) (net heat)."""
    part = dt / heat.tau
    net = part * (heat.power(xp, u, z) - heat.loss(xp, rise))
    leg = branches.follow_leg(xp, heat.rising, heat.falling, net > 0.0, rise, z)
    own = 1.0 + part * heat.loss_slope(xp, rise)
    change = net / (own + heat.latent * leg.slope(xp, rise))
    missing = own * change + heat.latent * (leg.fraction(xp, rise + change) - z) - net
    better = change - missing / (own + heat.latent * leg.slope(xp, rise + change))
    most = net / own
    change = xp.clip(better, xp.minimum(most, 0.0), xp.maximum(most, 0.0))
    after = rise + change
    return after, leg.fraction(xp, after)


def _hold_rise(xp: Namespace, heat: _Heat, u: Scalar) -> Scalar:
    """Return the rise at which the loss equals the power, on the rising branch, by Newton's method."""

    def newton(rise: Scalar) -> Scalar:
        z = branches.from_below(xp, heat.rising, rise)
        power = heat.power(xp, u, z)
        away = heat.loss(xp, rise) - power
        slope = heat.loss_slope(xp, rise)
        growth = power * heat.resistance * branches.compute_density(xp, heat.rising, rise)
        return rise - away / xp.maximum(slope - growth, 0.2 * slope)

    bare = heat.power(xp, u, 0.0)
    still = 1.0 - heat.growing
    root = xp.sqrt(still * still + 4.0 * heat.growing * xp.abs(bare) / MIDDLE)
    rise: Scalar = xp.detach(2.0 * bare / (still + root))
    for _ in range(NEWTON):
        rise = xp.detach(newton(rise))
    return xp.implicit_root(rise, newton(rise))
