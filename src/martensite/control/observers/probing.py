"""Probing pulses: a wire that is held at rest by a guard is moved, so that its heat loss can be learned.

A resistance at rest does not depend on the heat loss. If a guard limits the signal by a heat loss that is unknown, the
wire can stay at rest, and the heat loss unknown. Therefore, if ln h has been uncertain for `patience` while the wire is
heated, the observer commands

    calm     the probing signal, for `calm`
    pulse    the largest signal, for an energy, at most for `calm`

The motion of the pulse shows the heat loss. The next pulse comes at the earliest after `pause`.
"""

from typing import NamedTuple

from martensite.base.parameters import Number, Parametrised, param
from martensite.kernels.namespace import Flag, Namespace, Scalar


class ProbingState(NamedTuple):
    """Memory of the probing pulses."""

    clock: Scalar = 0.0
    """Time since the heat loss became uncertain; negative after a pulse [s]."""
    energy: Scalar = 0.0
    """Relative energy of the pulse."""


class Probing(Parametrised):
    """Times and energy of probing pulses."""

    patience: Number = param("s", "time for which the heat loss may be uncertain", above=0.0, default=5.0)
    calm: Number = param("s", "time at the probing signal before a pulse", above=0.0, default=4.0)
    pulse: Number = param("1", "energy of the pulse, over that for all but latent heat", above=0.0, default=1.2)
    pause: Number = param("s", "least time between two pulses", low=0.0, default=10.0)
    unsure: Number = param("1", "standard deviation of ln h above which it is uncertain", above=0.0, default=0.2)

    def advance(self, xp: Namespace, before: ProbingState, unsure: Flag, heated: Scalar, dt: Scalar) -> ProbingState:
        """Return the state after a sample.

        Args:
            xp: namespace.
            before: state after the last sample.
            unsure: True if the heat loss is uncertain and the wire is heated.
            heated: energy since the last sample, over the energy of the heating without latent heat.
            dt: time since the last sample [s].
        """
        active, pulses = self.is_active(before), self.is_pulse(before)
        energy = xp.where(pulses, before.energy + heated, 0.0)
        late = before.clock > self.patience + 2.0 * self.calm
        over = xp.both(pulses, xp.either(energy > self.pulse, late))
        goes_on = xp.either(xp.either(active, unsure), before.clock < 0.0)
        clock = xp.where(over, -self.pause, xp.where(goes_on, before.clock + dt, 0.0))
        return ProbingState(clock, energy)

    def is_active(self, now: ProbingState) -> Flag:
        """Return whether the observer commands the signal."""
        return now.clock > self.patience

    def is_pulse(self, now: ProbingState) -> Flag:
        """Return whether the commanded signal is the largest one."""
        return now.clock > self.patience + self.calm
