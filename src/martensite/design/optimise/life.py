"""Life of a design: it stays within the limits that its elements declare, with a margin.

    max(stress)      <= (1 - m) stress_limit
    stroke(strain)   <= (1 - m) strain_limit
    max(hottest)     <= T_a + (1 - m) (temperature_limit - T_a)

m is the margin and T_a the ambient temperature. The limits are those of the material, each with its
source there: a working stress such as the 172 MPa of the maker of Flexinol, a largest strain, a
highest temperature. There is no law of fatigue here, since none with a source is at hand: no number
of cycles follows from a design that keeps these limits.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from martensite.actuators.assembly import Actuator
from martensite.base.errors import ParameterError
from martensite.design.optimise.question import Constraint, read_aim
from martensite.search.free_numbers import FreeNumber
from martensite.simulate.waveform_levels import WaveformLevels

NOTE = "limit of the element"


def build_life_constraints(
    steering: WaveformLevels, freed: Sequence[FreeNumber], margin: float = 0.0
) -> list[Constraint]:
    """What keeps every element within its limits.

    Args:
        steering: the system.
        freed: its free numbers.
        margin: share of every limit that is left, 0 to below 1.

    Raises:
        ParameterError: the margin is none, or no element declares a limit.
    """
    if not 0.0 <= margin < 1.0:
        raise ParameterError(f"A margin of life must be at least 0 and below 1, but is {margin}.")
    system, found = steering.system, list[Constraint]()
    for port, one in system.actuators().items():
        for form, name, limit in _list_limits(one, margin):
            aim = read_aim(form.format(system.label(port, name)), steering, freed)
            found.append(Constraint(aim, True, limit, NOTE))
    if not found:
        raise ParameterError(
            "No element declares a limit, so nothing is known of its life; give it some, such as "
            'stress_limit = "172 MPa" in `limits` of the element, or constrain the stress itself.'
        )
    return found


def _list_limits(one: Actuator, margin: float) -> Iterator[tuple[str, str, float]]:
    """Measure, output and limit [SI] of everything that is limited."""
    limits, ambient = one.element.limits, one.environment.temperature
    above = ambient + (1.0 - margin) * (limits.temperature_limit - ambient)
    rows = (
        ("max({})", "stress", (1.0 - margin) * limits.stress_limit),
        ("stroke({})", "strain", (1.0 - margin) * limits.strain_limit),
        ("max({})", "hottest", above),
    )
    for form, name, limit in rows:
        if math.isfinite(limit):
            yield form, name, limit


def describe_life(constraints: Sequence[Constraint], margin: float) -> str:
    """What is claimed of the life, and what is not."""
    kept = ", ".join(f"{one.words}" for one in constraints)
    left = f" with {100.0 * margin:.3g} % to spare" if margin else ""
    return (
        f"Life: the limits that the elements declare are kept{left} ({kept}). No law of fatigue is "
        "known here, so this is no number of cycles."
    )
