"""Heat balance of a step, linearised at its start (equations in `lumped`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.base import Fractions


class HeatLine(NamedTuple):
    """Heat balance of a step, linearised at its start: temperature as a function of fractions."""

    fractions: Fractions
    """Initial fractions."""
    start: Scalar
    """Initial temperature [K]."""
    share: Scalar
    """Temperature per heat [K/J]."""
    heat: Scalar
    """Heat without transformation [J]."""
    by_martensite: Scalar
    """Heat per martensite [J]: latent heat, and effect of resistance."""
    by_oriented: Scalar
    by_rphase: Scalar
    """Heat per R-phase ratio, by resistance."""
    latent: Scalar
    """Latent heat of the whole transformation [J]."""
    released_fraction: Callable[[Fractions], Scalar]
    """Released fraction of it in a phase state [-]."""
    bend_martensite: Scalar
    """Change of the latent heat along the step, per martensite, oriented fraction and kelvin."""
    bend_oriented: Scalar
    bend_temperature: Scalar
    ripple: Scalar
    """[K]"""

    def temperature(self, end: Fractions) -> Scalar:
        """Return the temperature at the end of the step [K]."""
        m, o, *more = (a - b for a, b in zip(end, self.fractions, strict=True))
        heat = self.heat + self.by_martensite * m + self.by_oriented * o
        for r in more:
            beyond = self.released_fraction(end) - self.released_fraction(self.fractions) - m
            heat = heat + self.by_rphase * r + self.latent * beyond
        bend = self.bend_martensite * m + self.bend_oriented * o
        bend = bend + self.bend_temperature * (self.share * heat)
        return self.start + self.share * (heat + bend * m)


def compute_relaxation(xp: Namespace, z: Scalar) -> Scalar:
    """Return a Padé approximant of z/(1 - exp(-z)), valid for steps of any length."""
    slow = (1.0 + z * (2.0 / 3.0 + z * (1.0 / 6.0))) / (1.0 + xp.maximum(z, 0.0) * (1.0 / 6.0))
    return xp.where(z > 0.0, slow, xp.maximum(1.0 + 0.5 * z, 0.1))


def compute_lateness(xp: Namespace, z: Scalar) -> Scalar:
    """Return ½ coth(z/2) - 1/z, the extra weight of rising power."""
    later = xp.maximum(z, 0.0)
    return z / (12.0 + 2.0 * later * later / (10.0 + later))


def relax_heat(
    xp: Namespace, dt: Scalar, capacity: Scalar, power: Scalar, change: Scalar, less: Scalar
) -> tuple[Scalar, Scalar]:
    """Return temperature per heat [K/J] and heat [J] of a step of dt [s] without transformation.

    The power [W] at the start has the time derivative `change` [W/s] and falls by `less` [W/K].
    """
    z = dt * less / capacity
    share = 1.0 / (capacity * compute_relaxation(xp, z))
    return share, dt * power + dt * dt * change * compute_lateness(xp, z)
