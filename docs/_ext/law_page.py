"""What the pages of laws have in common: minor loops with the path in the phase diagram, and inner loops by numbers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from martensite.physics.laws.base import LAWS, AbstractLaw
from martensite.scenario.laws import configure_laws
from martensite.show.figures.law_paths import plot_point
from martensite.simulate.path_layout import Choices, Guide
from martensite.simulate.paths import build_paths
from martensite.simulate.point import PathLeg, material_point

STRESS = 100e6
"""Of the isobars [Pa]."""
TOLERANCE = 1e-2


def build_law(name: str, **settings: str) -> AbstractLaw:
    """A law with the numbers of the first material that has them all."""
    (one,) = configure_laws([name], None, settings)
    return one.law


def plot_minor_loops(name: str, **settings: str) -> Any:
    """A whole cycle and partial heatings under 100 MPa, with the path in the phase diagram."""
    law = build_law(name, **settings)
    courses = build_paths("minor-loops", law, Choices(stresses=(STRESS,)))
    return plot_point([course.follow(law, steps=40, tolerance=TOLERANCE) for course in courses])


def measure_inner_loops(law: AbstractLaw) -> tuple[float, float, float]:
    """How far a first inner loop is open, its height, and that of one between the same two temperatures elsewhere.

    Turning points lie three quarters into both strips; the first loop leaves the outer one on cooling, the other on
    heating. Martensite fractions.
    """
    marks = Guide(law, Choices()).marks_at(STRESS)
    hot, cold = marks.A_f + 10.0, marks.M_f - 10.0
    low, high = marks.M_s - 0.75 * (marks.M_s - marks.M_f), marks.A_s + 0.75 * (marks.A_f - marks.A_s)
    first = _cycle(law, [hot, low, high, low])
    second = _cycle(law, [hot, cold, high, low, high])
    return abs(first[3] - first[1]), first[1] - first[2], second[3] - second[4]


def _cycle(law: AbstractLaw, kelvin: Sequence[float]) -> list[float]:
    """Martensite fraction at every turning point."""
    legs = [PathLeg(temperature=b, duration=max(abs(b - a), 1e-3)) for a, b in pairwise(kelvin)]
    found = material_point(law, legs, start=(STRESS, kelvin[0]), steps=10, tolerance=1e-3)
    return [found.martensite[k] for k in found.ends]


def tell_inner_loops(name: str) -> str:
    """Inner loops by numbers, one line per history rule."""
    rules = ("resume", "return-point") if "history" in LAWS[name].declarations else ("",)
    lines: list[str] = []
    for rule in rules:
        opened, height, other = measure_inner_loops(build_law(name, **({"history": rule} if rule else {})))
        apart = abs(height - other) / max(height, other, 1e-12)
        lines.append(f"{name:16}{rule:14}open by {opened:.4f}, heights {height:.4f} and {other:.4f}: {apart:.2%} apart")
    return "\n".join(lines)
