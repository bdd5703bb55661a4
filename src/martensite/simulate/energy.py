"""Energies of a run: electrical, mechanical, and what is lost as heat.

    E = ∫ P dt      Q = ∫ Q̇ dt      W = ∫ F dx where x grows, W_back = −∫ F dx where it does not

with F the force of an element and x the coordinate along which it pulls. A spring gives back what
it was given and a weight is lowered again, so the net work of a cycle is small, and the efficiency
counts what the element gave: η = W/E. What E − Q leaves is in the element, as heat, as latent heat
or as work; over a cycle that repeats it is 0 but for the net work, which these heat balances leave
out (see the documentation of the heat balance).

Powers of a system in discrete time hold for a period. Powers of other systems are integrated over
the accepted steps of the run, or by trapezoids over the samples where only samples are known. Work
is integrated by trapezoids over both.
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
    """Into all elements."""
    lost: Numbers
    """Heat loss to the surroundings."""
    work: Numbers
    """Work that the elements gave while they pulled."""
    returned: Numbers
    """Work that the elements took while they were stretched again."""

    @property
    def efficiency(self) -> Numbers:
        """Return the work over electrical energy; NaN without any."""
        nothing = np.full(len(self.work), np.nan)
        return np.divide(self.work, self.electrical, where=self.electrical > 0.0, out=nothing)


def find_ways(result: Result) -> list[tuple[Numbers, Numbers]] | None:
    """Return the force [N] and way [m] of every element, for `integrate_energies`; None if one is not known.

    An element that is a straight wire, or several, pulls by its own shortening −ε ℓ; others need a
    mechanism with one coordinate on a line.
    """
    system, found = result.system, list[tuple[Numbers, Numbers]]()
    on_line = isinstance(system.mechanism, AbstractLoadLine)
    for port, actuator in system.actuators().items():
        force = np.asarray(result.columns[system.label(port, "force")])
        length = find_length(actuator.element)
        if on_line:
            found.append((force, np.asarray(result.columns[result.coordinate])))
        elif length is not None:
            strain = np.asarray(result.columns[system.label(port, "strain")])
            found.append((force, -length * strain))
        else:
            return None
    return found


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
    held = result.system.sample_time() > 0.0
    given, taken = _integrate_outputs(result, "power", held), _integrate_outputs(result, "heat_loss", False)
    return EnergyCourses(given, taken, work[0], work[1])


def _integrate_outputs(result: Result, name: str, held: bool) -> Numbers:
    """Return the integral of an output of all elements up to every sample."""
    labels = [result.system.label(port, name) for port in result.system.actuators()]
    if not labels:
        return np.zeros(len(result.times))
    times, columns = result.list_rows(labels)
    values = np.sum([np.asarray(column) for column in columns.values()], axis=0)
    if result.track is None or held:
        middles = values[:-1] if held else 0.5 * (values[1:] + values[:-1])
        sums = np.concatenate([[0.0], np.cumsum(middles * np.diff(times))])
    else:
        weighted = result.track.weights * values
        sums = np.cumsum(weighted)
        sums[:-1] -= 0.5 * weighted[:-1]
        sums[0] = 0.0
    found = np.interp(result.times, times, sums)
    found[-1] = sums[-1]
    return found
