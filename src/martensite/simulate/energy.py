"""Energies of a run: electrical energy, mechanical work and heat loss.

E = ∫ P dt      Q = ∫ Q̇ dt      W = ∫ F dx for dx > 0, W_back = −∫ F dx for dx < 0

F is the force of an element and x the coordinate along its pull. Springs and weights return work, so the net work
of a cycle is small. The efficiency therefore uses the delivered work: η = W/E. The difference E − Q is stored in
the element as sensible heat, latent heat or work. Over a repeated cycle it equals the net work, which the heat
balance neglects (see the documentation of the heat balance).

Powers of a system in discrete time are constant in a period. Other powers are integrated over the accepted steps,
or by trapezoids over the samples. Work is integrated by trapezoids.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from martensite.actuators.elements.base import AbstractElement
from martensite.actuators.elements.rows import AbstractRow
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.load_line import AbstractLoadLine
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.result import Result


@dataclass(frozen=True, eq=False)
class EnergyCourses:
    """Energies from the start of a run to every sample, shape (samples,) [J]."""

    electrical: Numbers
    """Electrical energy into all elements."""
    lost: Numbers
    """Heat loss to ambient."""
    work: Numbers
    """Work delivered by pulling elements."""
    returned: Numbers
    """Work returned to the elements."""

    @property
    def efficiency(self) -> Numbers:
        """Return the work over electrical energy; NaN without electrical energy."""
        nothing = np.full(len(self.work), np.nan)
        return np.divide(self.work, self.electrical, where=self.electrical > 0.0, out=nothing)


def find_ways(result: Result) -> list[tuple[Numbers, Numbers]] | None:
    """Return the force [N] and stroke [m] of every element; None if one is unknown.

    Straight wires pull by their own shortening −ε ℓ. Other elements need a mechanism with one linear coordinate.
    """
    system, ways = result.system, list[tuple[Numbers, Numbers]]()
    on_line = isinstance(system.mechanism, AbstractLoadLine)
    for port, actuator in system.actuators().items():
        force = np.asarray(result.columns[system.label(port, "force")])
        length = find_length(actuator.element)
        if on_line:
            ways.append((force, np.asarray(result.columns[result.coordinate])))
        elif length is not None:
            strain = np.asarray(result.columns[system.label(port, "strain")])
            ways.append((force, -length * strain))
        else:
            return None
    return ways


def find_length(element: AbstractElement) -> float | None:
    """Return the elongation per strain [m] of straight wires; None for other elements."""
    if isinstance(element, AbstractRow):
        one = find_length(element.one)
        return None if one is None else one * element.behind()
    return element.length if isinstance(element, Wire) else None


def integrate_energies(result: Result, ways: Sequence[tuple[Numbers, Numbers]]) -> EnergyCourses:
    """Return the energies of a run up to its samples.

    `ways` are forces [N] with the coordinates [m] that grow as they pull, or torques with angles.
    """
    work = np.zeros((2, len(result.times)))
    for f, x in ways:
        done = 0.5 * (f[1:] + f[:-1]) * np.diff(x)
        work[0, 1:] += np.cumsum(np.maximum(done, 0.0))
        work[1, 1:] += np.cumsum(np.maximum(-done, 0.0))
    is_held = result.system.sample_time() > 0.0
    given, taken = _integrate_outputs(result, "power", is_held), _integrate_outputs(result, "heat_loss", False)
    return EnergyCourses(given, taken, work[0], work[1])


def _integrate_outputs(result: Result, name: str, is_held: bool) -> Numbers:
    """Return the integral of an output of all elements up to every sample."""
    labels = [result.system.label(port, name) for port in result.system.actuators()]
    if not labels:
        return np.zeros(len(result.times))
    times, columns = result.list_rows(labels)
    values = np.sum([np.asarray(column) for column in columns.values()], axis=0)
    if result.track is None or is_held:
        middles = values[:-1] if is_held else 0.5 * (values[1:] + values[:-1])
        sums = np.concatenate([[0.0], np.cumsum(middles * np.diff(times))])
    else:
        weighted = result.track.weights * values
        sums = np.cumsum(weighted)
        sums[:-1] -= 0.5 * weighted[:-1]
        sums[0] = 0.0
    integral = np.interp(result.times, times, sums)
    integral[-1] = sums[-1]
    return integral
