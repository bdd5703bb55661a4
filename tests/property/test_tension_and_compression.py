"""Random cycles of tension and compression through every law that knows both.

Source of truth: what every law promises, mirror symmetry, and the same law of tension where nothing is compressed.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from martensite.physics.laws.base import LAWS
from martensite.testing.examples import build_example
from martensite.testing.laws import Point, find_end, find_strain, follow_path, trace_kinetics

FORMS: dict[str, dict[str, Any]] = {
    "liang-rogers": {"compression": "symmetric"},
    "tanaka": {"compression": "symmetric"},
    "elahinia": {"compression": "symmetric", "history": "restart"},
    "brinson": {"compression": "symmetric"},
    "lagoudas": {"compression": "symmetric", "H_min": 0.0, "H_k": 1e-6},
}
BOTH = pytest.mark.parametrize("name", FORMS)


def draw_cycles(seed: int, legs: int = 8) -> list[list[Point]]:
    """Paths of isothermal turns between tension and compression, with changes of temperature at constant stress."""
    rng, found = np.random.default_rng(seed), list[list[Point]]()
    for _ in range(6):
        points = [(0.0, float(rng.uniform(290.0, 390.0)))]
        for _ in range(legs):
            kelvin = points[-1][1]
            to = float(rng.uniform(-700e6, 700e6))
            points += [(to, kelvin), (to, float(rng.uniform(280.0, 400.0)))] if rng.random() < 0.3 else [(to, kelvin)]
        found.append(points)
    return found


def mirror(points: list[Point]) -> list[Point]:
    return [(-s, t) for s, t in points]


@BOTH
def test_compression_mirrors_tension(name: str) -> None:
    law = build_example(LAWS[name], **FORMS[name])
    for points in draw_cycles(1):
        one, other = (follow_path(law, path, 0.0, 3) for path in (points, mirror(points)))
        for a, b in zip(one, other, strict=True):
            first, second = law.fractions(a), law.fractions(b)
            assert first.martensite == pytest.approx(second.martensite, abs=1e-12)
            assert first.oriented == pytest.approx(-second.oriented, abs=1e-12)


@BOTH
def test_tension_alone_is_as_without_compression(name: str) -> None:
    choices = {**FORMS[name], "H_k": 1e-5} if name == "lagoudas" else FORMS[name]
    both, plain = (build_example(LAWS[name], **{**choices, "compression": one}) for one in ("symmetric", "none"))
    for points in draw_cycles(2):
        pulled = [(abs(s) + 1e6, t) for s, t in points]
        one, other = ([find_strain(law, m) for m in follow_path(law, pulled, 0.0, 3)] for law in (both, plain))
        assert one == pytest.approx(other, abs=2e-5 * 0.05)


@BOTH
def test_cycles_keep_bounds_and_their_cuts_do_not_matter(name: str) -> None:
    law = build_example(LAWS[name], **FORMS[name])
    for points in draw_cycles(3):
        isothermal = [(s, points[0][1]) for s, _ in points]
        for memory in follow_path(law, isothermal, 0.0, 3):
            found = law.fractions(memory)
            assert abs(found.oriented) <= found.martensite + 1e-12 <= 1.0 + 2e-12
        whole, cut = (find_end(law, isothermal, 0.0, n) for n in (1, 13))
        assert [*whole] == pytest.approx([*cut], abs={"lagoudas": 2e-3, "tanaka": 1e-5}.get(name, 1e-9))


@BOTH
def test_strain_rises_and_does_not_jump_with_stress(name: str) -> None:
    law = build_example(LAWS[name], **FORMS[name])
    advance = trace_kinetics(law)
    stresses = np.linspace(-600e6, 600e6, 121).tolist()
    for points in draw_cycles(4):
        memory, (_, kelvin) = follow_path(law, points, 0.0, 3)[-1], points[-1]
        strains = [find_strain(law, advance(memory, s, kelvin, 1.0)) for s in stresses]
        assert min(b - a for a, b in pairwise(strains)) > -1e-12
        finer = [find_strain(law, advance(memory, 1e-3 * s, kelvin, 1.0)) for s in stresses]
        assert max(abs(b - a) for a, b in pairwise(finer)) < 2e-3


@BOTH
def test_loops_close(name: str) -> None:
    law = build_example(LAWS[name], **FORMS[name])
    for kelvin in (345.0, 365.0, 385.0):
        cycle = [(450e6, kelvin), (-500e6, kelvin)]
        ends = follow_path(law, [(0.0, kelvin), *cycle * 4], 0.0, 20)
        strains = [find_strain(law, memory) for memory in ends[1:]]
        assert strains[4:6] == pytest.approx(strains[6:8], abs=1e-9)
