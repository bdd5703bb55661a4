"""Interfaces of resistance models and sources.

A source turns the drive signal u (volt, ampere, watt, kelvin, or duty cycle) and the resistance of the element into a
current. Only I²R of the element heats it; leads and series resistance do not.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar, NamedTuple

from martensite.base.interfaces import override
from martensite.base.parameters import Number, Parametrised, param
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.recordable_numbers import xp
from martensite.signals.moments import Moments

RESISTANCES: Registry[AbstractResistance] = Registry(
    "resistance", "martensite.physics.electrical", typical="per-length"
)
SOURCES: Registry[AbstractSource] = Registry("drive", "martensite.physics.electrical", typical="current")
STRAIGHT = 1e-9
"""Relative deviation from a straight line that counts as zero."""


class Conductor(NamedTuple):
    """Shape that carries the current."""

    area: Scalar
    """Cross-section [m²]."""
    length: Scalar
    """[m]"""


class SignalRange(NamedTuple):
    """Drive signals that a source can deliver, in its unit."""

    least: float
    most: float


class Heat(NamedTuple):
    """Power [W] in an element during an interval."""

    mean: Scalar
    doubt: Scalar
    """Error bound of the mean if the source follows the drive in a part of its range only."""
    peak: Scalar
    slope: Scalar = 0.0
    """Slope of the best straight line [W/s]."""


class AbstractResistance(Parametrised):
    """Interface of a resistance model."""

    three_phases: ClassVar[bool] = False
    """True if the R-phase has a separate resistivity."""

    @abstractmethod
    def resistance(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        """Return the resistance [ohm] at martensite `fraction`, `strain` and `temperature` [K]."""

    def mix_phases(
        self, xp: Namespace, fraction: Scalar, rphase: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        """Return the resistance [ohm] with an R-phase; two-phase models count it as austenite."""
        return self.resistance(xp, fraction, strain, temperature, shape)


class AbstractSource(Parametrised):
    """Interface of a source; `unit` is the SI unit of its drive signal."""

    unit: ClassVar[str] = "1"
    sets_temperature: ClassVar[bool] = False
    """True if the signal is the temperature of the element."""
    supplied_by: ClassVar[tuple[str, ...]] = ()
    """Parameters that are supply voltages."""
    linear: ClassVar[str] = "current"
    """Quantity that is linear in the drive, within limits: `current` or `power`."""

    @abstractmethod
    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Return the current [A] through an element of `resistance` [ohm]; rms if pulsed."""

    def power(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Return the power [W] in an element of `resistance` [ohm] under a constant drive signal."""
        current = self.current(xp, drive, resistance)
        return current * current * resistance

    def supply_current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Return the (mean) current [A] drawn from the supply."""
        return xp.abs(self.current(xp, drive, resistance))

    def heat(self, xp: Namespace, drive: Moments, resistance: Scalar) -> Heat:
        """Return the power in an element of `resistance` [ohm] under a drive with these moments.

        The result is exact if the source is linear over the range of the drive, or the drive constant. If a limit lies
        within the range, the error bound is the difference of the powers at both ends.
        """
        square = self.linear == "current"

        def answer(drive: Scalar) -> Scalar:
            return (self.current if square else self.power)(xp, drive, resistance)

        span = drive.high - drive.low
        varies = span > 0.0
        low, high = answer(drive.low), answer(drive.high)
        slope = (high - low) / xp.where(varies, span, 1.0)
        middle = low + slope * (drive.mean - drive.low)
        off = xp.abs(answer(drive.mean) - middle)
        off = xp.maximum(off, xp.abs(answer(drive.low + 0.25 * span) - (low + 0.25 * slope * span)))
        bent = xp.both(varies, off > STRAIGHT * (xp.abs(low) + xp.abs(high)))
        least, most = xp.minimum(low, high), xp.maximum(low, high)
        if square:
            spread = xp.maximum(drive.square - drive.mean * drive.mean, 0.0)
            mean = middle * middle + slope * slope * spread
            crosses = xp.both(least < 0.0, most > 0.0)
            least, most = low * low, high * high
            least, most = xp.minimum(least, most), xp.maximum(least, most)
            least = resistance * xp.where(crosses, 0.0, least)
            mean, most = resistance * mean, resistance * most
            level = low - slope * drive.low
            by_square = slope * slope * drive.square_slope
            change = resistance * (2.0 * level * slope * drive.slope + by_square)
        else:
            mean, change = middle, slope * drive.slope
        return Heat(mean, xp.where(bent, most - least, 0.0), most, change)

    def reach(self, resistance: float) -> SignalRange:
        """Return the deliverable signals for an element of `resistance` [ohm]; unlimited by default."""
        return SignalRange(-math.inf, math.inf)


class AbstractSupply(AbstractSource):
    """Interface of a source with limited current and voltage."""

    supplied_by: ClassVar[tuple[str, ...]] = ("voltage_limit",)

    series_resistance: Number = param(
        "ohm", "resistance outside: leads, contacts, driver", low=0.0, high=1e6, default=0.0, typical="0.5 ohm"
    )
    current_limit: Number = param("A", "current limit", above=0.0, high=1e6, default=1e6, typical="0.6 A")
    voltage_limit: Number = param("V", "supply voltage", above=0.0, high=1e9, default=1e9, typical="6 V")

    def most(self, xp: Namespace, resistance: Scalar) -> Scalar:
        """Return the largest current [A] through an element of `resistance` [ohm]."""
        reachable = self.voltage_limit / (resistance + self.series_resistance)
        return xp.minimum(reachable, self.current_limit)


class AbstractSwitch(AbstractSource):
    """Interface of a constant supply behind a switch with a duty cycle.

    While the switch is closed, the current is U/(R + R_s), within the limit. Averaged over periods, the element is
    heated by the rms current: √duty times the closed current.
    """

    supplied_by: ClassVar[tuple[str, ...]] = ("supply",)
    linear: ClassVar[str] = "power"

    supply: Number = param("V", "supply voltage", above=0.0, high=1e4, typical="6 V")
    series_resistance: Number = param(
        "ohm", "resistance outside the element: leads, contacts, closed switch", low=0.0, high=1e6, default=0.0
    )
    current_limit: Number = param("A", "current limit while the switch is closed", above=0.0, high=1e6, default=1e6)

    def closed_current(self, xp: Namespace, resistance: Scalar) -> Scalar:
        """Return the current [A] through `resistance` [ohm] while the switch is closed."""
        return xp.minimum(self.supply / (resistance + self.series_resistance), self.current_limit)

    @override
    def supply_current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        return self.share(xp, drive, getattr(self, "frequency", 0.0)) * self.closed_current(xp, resistance)

    def share(self, xp: Namespace, drive: Scalar, frequency: Scalar) -> Scalar:
        """Return the effective duty cycle.

        Args:
            xp: namespace.
            drive: demanded duty cycle.
            frequency: pulse frequency [Hz], for losses per pulse.
        """
        return xp.clip(drive, 0.0, 1.0)

    def reach(self, resistance: float) -> SignalRange:
        """Return the range 0 to 1."""
        return SignalRange(0.0, 1.0)

    def largest_power(self, resistance: float) -> float:
        """Return the power [W] in an element of `resistance` [ohm] while the switch is closed."""
        current = self.closed_current(xp, resistance)
        return current * current * resistance
