"""The rule return-point: loops close within loops, wiping-out is exact, first branches are those of relays.

Sources of truth: points that a path has met before; a program of relays that switch at two temperatures
(Preisach), which shares nothing with the law.
"""

from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
import pytest
from builders import ZERO, Swings, along, build_example, isobar, problem_a
from strip_cases import CASES, NUMBERS

from martensite.kernels import floats
from martensite.kernels.compiled_program import CompiledProgram
from martensite.kernels.compiler import call_compiled
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.physics.kinetics.return_points import DEPTH
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.brinson import Brinson
from martensite.physics.laws.lagoudas import Lagoudas
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.signals.moments import Tone
from martensite.simulate.api import simulate
from martensite.simulate.batch import compute_sensitivity
from martensite.simulate.compiled_law import compile_law
from martensite.simulate.point import PathLeg, material_point
from martensite.testing.laws import trace_kinetics

COLDEST, HOTTEST = 43.0, 77.0
LAWS = pytest.mark.parametrize("name", ["liang-rogers mixture", "elahinia", "tanaka austenite"])


class Walk:
    """Turning points at random, nested in those that are not wiped out yet, and what the law met at each."""

    def __init__(self, law, traced=True):
        self.law = law
        plain = lambda memory, *to: law.kinetics(floats, memory, *to)[0]  # noqa: E731
        self.advance = trace_kinetics(law) if traced else plain
        self.memory = law.init(floats, Fractions(1.0, 1.0), 0.0, COLDEST - 20.0 + ZERO)
        self.met, self.worst, self.rng = [], 0.0, np.random.default_rng(5)
        for celsius in (HOTTEST, COLDEST):
            self.turn(celsius)

    def go(self, celsius):
        """The fraction at a temperature [°C]."""
        self.memory = self.advance(self.memory, 0.0, celsius + ZERO, 0.0)
        return self.memory.fraction

    def turn(self, celsius):
        """Go to a turning point; whatever it passes is met as it was, and wiped out."""
        sign = 1.0 if celsius > (self.met[-1][0] if self.met else -ZERO) else -1.0
        while len(self.met) > 1 and sign * (celsius - self.met[-2][0]) >= 0.0:
            again, before = self.met[-2]
            self.worst = max(self.worst, abs(self.go(again) - before))
            del self.met[-2:]
        self.met.append((celsius, self.go(celsius)))

    def wander(self, count):
        """So many turns between the outermost ones, no more of them open than are remembered."""
        for _ in range(count):
            heats, limits = len(self.met) % 2 == 0, (COLDEST, HOTTEST)
            if len(self.met) >= 2 * DEPTH - 2:
                celsius = limits[heats]
            else:
                strip = (68.5, HOTTEST) if heats else (COLDEST, 51.5)
                celsius = self.rng.uniform(*strip)
            self.turn(float(celsius))
        return self.worst


@LAWS
def test_loops_close_within_loops(name):
    """Of 1000 random reversals each turning point that is passed again is met as it was."""
    walk = Walk(CASES[name].law("return-point"))
    assert walk.wander(1000) < 1e-9
    assert walk.memory.points.forgotten == 0.0


@LAWS
def test_one_leg_wipes_out_any_number_of_loops(name):
    """Where many loops end in one leg, what comes after does not know of them; to the last digit at completion."""
    law, nested = CASES[name].law("return-point"), [c for k in range(6) for c in (75.0 - k, 45.0 + k)]
    short = along(law, isobar(20, 76, 44, 75.5, 43.5, 74), 1.0)
    long = along(law, isobar(20, 76, 44, *nested, 75.5, 43.5, 74), 1.0)
    assert long[-1].fraction == pytest.approx(short[-1].fraction, abs=1e-14)
    short, long = (along(law, isobar(*way, 95, 44, 74), 1.0)[-1] for way in ((20,), (20, 76, 44, *nested)))
    assert long.fraction == pytest.approx(short.fraction, abs=1e-15)
    assert long.points.forwards == short.points.forwards


def test_lagoudas_closes_loops_without_a_rule():
    """Elastic inside of a loop, it is a play operator, which remembers every turn by itself."""
    law = build_example(Lagoudas)
    shares = (0.8, 0.7, 0.6, 0.6, 0.5, 0.5, 0.5, 0.6, 0.6, 0.7, 0.8)  # of either range in turn, in and out again
    lines = ((law.A_s, law.A_f), (law.M_s, law.M_f))
    turns = [a + x * (b - a) for k, x in enumerate(shares) for a, b in [lines[k % 2]]]
    memories = along(law, [(0.0, law.M_f - 10.0), *((0.0, t) for t in turns)], 1.0)[1:]
    found = [law.fractions(m).martensite for m in memories]
    assert found[5:] == pytest.approx(found[5::-1], abs=1e-12)
    assert np.ptp(found) > 0.4


@LAWS
def test_loops_between_two_temperatures_are_congruent(name):
    """A loop between 73 and 47 °C has the same height wherever it lies, as of a Preisach operator."""
    heights = []
    for first in (73.5, 75.0, 76.5):
        ends = [m.fraction for m in along(CASES[name].law("return-point"), isobar(20, first, 47, 73, 47), 1.0)]
        heights.append(ends[2] - ends[3])
    assert heights == pytest.approx([heights[0]] * 3, abs=1e-12)
    assert ends[2] == pytest.approx(ends[4], abs=1e-12)


def test_depth_is_bounded_and_what_is_forgotten_is_known():
    """Ever smaller loops: beyond the depth the innermost ones go, and outer ones still close."""
    law = CASES["elahinia"].law("return-point")
    nested = [c for k in range(DEPTH + 6) for c in (75.0 - 0.4 * k, 44.0 + 0.4 * k)]
    memories = along(law, isobar(20, 76, 43, *nested, 76), 1.0)
    lost = memories[-1].points.forgotten
    assert 1e-4 < lost < 0.05
    assert memories[-1].fraction == pytest.approx(memories[1].fraction, abs=1e-12)
    assert memories[2 * DEPTH - 2].points.forgotten == 0.0


@LAWS
def test_return_points_go_along_with_a_correction(name):
    """At the same point nothing changes; elsewhere the loop closes where as large a share is left."""
    law = CASES[name].law("return-point")
    memory = along(law, isobar(20, 75, 46, 73, 48, 71), 1.0)[-1]
    assert law.relocate(floats, memory, law.fractions(memory), 0.0, 71 + ZERO) == memory
    there = 0.9 * memory.fraction
    moved = law.relocate(floats, memory, Fractions(there, there), 0.0, 71 + ZERO)
    first, second = (law.kinetics(floats, m, 0.0, 74 + ZERO, 0.0)[1].martensite for m in (memory, moved))
    assert second == pytest.approx(0.9 * first, abs=1e-12)


# ---------------------------------------------------------------- two fractions


def brinson():
    changes = {"A_s": 48.0, "A_f": 58.0, "M_s": 32.0, "M_f": 22.0}
    numbers: dict[str, Any] = {name: value for name, value in NUMBERS.items() if name in Brinson.declarations}
    numbers |= {name: celsius + ZERO for name, celsius in changes.items()}
    return Brinson(**numbers, sigma_s=80e6, sigma_f=150e6, history="return-point")


def walk(law, points):
    """Martensite and oriented fraction along a path from austenite."""
    first, *others = points
    advance, memory = trace_kinetics(law), law.init(floats, Fractions(0.0, 0.0), first[0], first[1])
    found = [law.fractions(memory)]
    for stress, kelvin in others:
        memory = advance(memory, stress, kelvin, 0.0)
        found.append(law.fractions(memory))
    return np.array(found)


@pytest.mark.parametrize("isothermal", [True, False])
def test_stress_alone_makes_brinson_the_law_of_one_fraction(isothermal):
    """Above M_s, at constant temperature or stress: the strips of S and reverse are those of Liang and Rogers."""
    two = brinson()
    shared: dict[str, Any] = {name: getattr(two, name) for name in LiangRogers.declarations if name in two.declarations}
    strip = {"M_s": two.M_s - two.sigma_s / two.C_M, "M_f": two.M_s - two.sigma_f / two.C_M}
    numbers: dict[str, Any] = shared | strip
    one, rng = LiangRogers(**numbers), np.random.default_rng(0)
    if isothermal:
        points = [(0.0, 70 + ZERO), *((x, 70 + ZERO) for x in rng.uniform(130e6, 445e6, 300).tolist())]
    else:
        points = [(250e6, 150 + ZERO), *((250e6, x + ZERO) for x in rng.uniform(45.5, 82, 300).tolist())]
    wanted, found = walk(one, points), walk(two, points)
    assert np.abs(found - wanted).max() < 1e-12
    assert np.mean((found[:, 0] > 0.01) & (found[:, 0] < 0.99)) > 0.8


def test_loops_of_twins_close():
    """Without stress T and reverse make loops within loops, and ξ_S stays 0."""
    turns = (0, 55, 28, 53, 29, 52, 30, 53, 28, 55)
    found = walk(brinson(), [(0.0, c + ZERO) for c in (90, *turns)])[1:]
    pairs = ((3, 7), (2, 8), (1, 9))
    assert [found[b] for _, b in pairs] == [pytest.approx(found[a], abs=1e-12) for a, _ in pairs]
    assert found[:, 1].max() == 0.0
    assert 0.1 < found[1, 0] < found[2, 0] < 0.9


def test_both_processes_and_steps_of_any_length():
    """S, T and reverse in any order: fractions in their bounds, the same however a leg is cut."""
    law, rng = brinson(), np.random.default_rng(4)
    x: Any
    advance = trace_kinetics(law)
    for start in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)) * 25:
        stresses, celsius = rng.uniform(0.0, 250e6, 8), rng.uniform(5.0, 70.0, 8)
        points = np.column_stack([stresses, celsius + ZERO])
        ends = []
        for cuts in (1, 5):
            memory = law.init(floats, Fractions(*start), *points[0].tolist())
            for a, b in pairwise(points):
                for share in np.linspace(0.0, 1.0, cuts + 1)[1:]:
                    x = b if share == 1.0 else a + share * (b - a)
                    memory = advance(memory, float(x[0]), float(x[1]), 0.0)
                assert 0.0 <= memory.oriented <= memory.martensite + 1e-14 <= 1.0 + 2e-14
            ends.append((memory.martensite, memory.oriented))
        assert ends[1] == pytest.approx(ends[0], abs=1e-11)


# ---------------------------------------------------------------- relays


def relays(up, down, weights, celsius):
    """Martensite of relays that turn to it at or below `up` and from it at or above `down`, all of it at first."""
    on, found = np.ones(len(weights), bool), [1.0]
    for t in celsius[1:]:
        on = (t <= up) | (on & (t < down))
        found.append(float(weights @ on))
    return np.array(found)


def path(*turns, step=1.0):
    """Temperatures from one turning point to the next."""
    legs = (np.linspace(a, b, round(abs(b - a) / step) + 1)[1:].tolist() for a, b in pairwise(turns))
    return [turns[0], *(t for leg in legs for t in leg)]


def follow(law, celsius):
    memory, found = law.init(floats, Fractions(1.0, 1.0), 0.0, celsius[0] + ZERO), [1.0]
    for t in celsius[1:]:
        memory, fractions = law.kinetics(floats, memory, 0.0, t + ZERO, 0.0)
        found.append(fractions.martensite)
    return np.array(found)


def fit(measured, computed):
    """Share of the measured variation that is explained [%]."""
    return 100.0 * (1.0 - np.linalg.norm(measured - computed) / np.linalg.norm(measured - measured.mean()))


class Tabulated(LiangRogers):
    """With the curve of a measured loop, between its points."""

    curve: ClassVar[Any] = ()

    def remaining_fraction(self, xp, distance):
        return float(np.interp(distance, *self.curve))


def cosine_relays(count=80):
    """Two independent switching temperatures, so that the outer loop is that of problem A."""
    inside = 2.0 / np.pi * np.arcsin(np.sqrt((np.arange(count) + 0.5) / count))
    up, down = (x.ravel() for x in np.meshgrid(42.0 + 10.0 * inside, 78.0 - 10.0 * inside))
    return up, down, np.full(len(up), 1.0 / len(up)), LiangRogers(**NUMBERS, history="return-point")


def gaussian_relays(centre, half, count=80):
    """Centres about 60 °C and half-widths about 13 K, independent of each other with these standard deviations."""
    at = np.linspace(-3.5, 3.5, count)
    c, h = (x.ravel() for x in np.meshgrid(60.0 + centre * at, 13.0 + half * at))
    bell = np.exp(-0.5 * at**2)
    weights = np.outer(bell, bell).ravel() / bell.sum() ** 2
    reach = 3.5 * (centre + half)
    lines = {"M_f": 47 - reach, "M_s": 47 + reach, "A_s": 73 - reach, "A_f": 73 + reach}
    order = np.argsort(c - h)  # one process ends as the other one begins: both have this curve
    shares = ((c - h)[order] - (47 - reach)) / (2 * reach)
    curve = np.r_[0.0, shares, 1.0], np.r_[0.0, np.cumsum(weights[order]), 1.0]
    cls = type("Measured", (Tabulated,), {"curve": curve})
    law = cls(**NUMBERS | {name: celsius + ZERO for name, celsius in lines.items()}, history="return-point")
    return c - h, c + h, weights, law


@pytest.mark.parametrize(
    ("case", "least"),
    [(cosine_relays(), 98.5), (gaussian_relays(1.4, 1.0), 95.0)],
    ids=["product, cosine", "gaussian, correlation 0.32"],
)
def test_branches_of_relays_follow_from_their_outer_loop(case, least):
    """First-order branches, cooled from five temperatures of the heating branch; then loops within loops."""
    up, down, weights, law = case
    wanted, found = [], []
    for hot in (71, 72, 73, 74, 75):
        way, begin = path(30, hot, 30), hot - 30
        wanted.append(relays(up, down, weights, way)[begin:])
        found.append(follow(law, way)[begin:])
    loops = path(30, 75, 46, 74, 47, 73, 48, 90, 30)
    fits = fit(np.concatenate(wanted), np.concatenate(found)), fit(relays(up, down, weights, loops), follow(law, loops))
    assert min(fits) > least


# ---------------------------------------------------------------- runs


def nested_legs(count):
    """Legs at no stress through ever smaller loops."""
    turns = [76.0, 43.0, *(c for k in range(count) for c in (75.0 - 0.4 * k, 44.0 + 0.4 * k))]
    return [PathLeg(temperature=celsius + ZERO, duration=1.0, stress=0.0) for celsius in turns]


def test_a_run_says_what_was_forgotten():
    """In so many words, and only where it matters."""
    law, start = CASES["elahinia"].law("return-point"), {"start": (0.0, 20 + ZERO), "fractions": Fractions(1.0, 1.0)}
    deep, shallow = (material_point(law, nested_legs(n), **start, steps=3, tolerance=None) for n in (DEPTH + 4, 4))
    (sentence,) = deep.warnings
    assert "more than 8 loops" in sentence and "9.7e-03" in sentence
    assert not shallow.warnings
    resumed = material_point(CASES["elahinia"].law(), nested_legs(12), **start, steps=3, tolerance=None)
    assert not resumed.warnings


RIPPLE = """
void ripple(long reversals, const double *restrict c, double *restrict memory) {{
    double x[{size} + 3], y[{size} + 5];
    memcpy(x, memory, sizeof(double) * {size});
    for (long k = 0; k < reversals; k++) {{
        x[{size}] = x[{size} + 2] = 0.0;
        x[{size} + 1] = 273.15 + (k % 2 ? 46.0 : 73.0 + 0.1 * (k % 22 ? k * k % 7 : 20.0));
        k_stress_step(1, c, x, y);
        memcpy(x, y, sizeof(double) * {size});
    }}
    memcpy(memory, x, sizeof(double) * {size});
}}
"""
"""Heating pulses of seven sizes and, once in a while, one as far as the first."""


@pytest.mark.usefixtures("c_compiler")
def test_a_million_reversals_neither_drift_nor_grow():
    """After half a million pulses the largest one still ends where it ended first, to the last digits."""
    law = CASES["liang-rogers mixture"].law("return-point")
    compiled, shape = compile_law(law), NestedShape(law.init(floats, Fractions(1.0, 1.0), 0.0, 300.0))
    constants = np.array([*compiled.values(law), 0.0], float)[:, None]
    program = CompiledProgram(compiled.program, ("stress_step",), constants, RIPPLE.format(size=compiled.size))

    def ripple(reversals):
        numbers = np.array(flatten_numbers(law.init(floats, Fractions(1.0, 1.0), 0.0, 20 + ZERO)), float)
        call_compiled(program.library.ripple, reversals, program.constants, numbers)
        return shape.rebuild(numbers.tolist())

    first, last = ripple(1), ripple(22 * 45_455 + 1)
    assert last.fraction == pytest.approx(first.fraction, abs=1e-14)
    assert max(last.points.forwards, last.points.reverses) <= 2.0
    assert last.points.forgotten == 0.0


@pytest.mark.usefixtures("c_compiler")
def test_slopes_of_a_run_are_those_of_differences():
    """Of a wire on a spring that goes through loops within loops, where the rule matters."""
    drive = Swings(level=1.886, swings=(Tone(-0.301, 0.068 * np.pi), Tone(-0.661, 0.27 * np.pi)))
    system, names, run = problem_a("return-point"), ["A_f", "C_A", "diameter"], {"step": 20e-3, "samples": 301}
    found = compute_sensitivity(system, drive, 45.0, names, **run)
    resumed = simulate(problem_a("resume"), drive, 45.0, **run, runtime="c")["position"]
    assert np.abs(found.column - resumed).max() > 3e-4
    for path, slope in found.slopes.items():
        x, width = system.value_of(path), 1e-4 * (10.0 if path.endswith("A_f") else system.value_of(path))
        above, below = (
            np.array(simulate(system.with_values({path: x + way}), drive, 45.0, **run, runtime="c")["position"])
            for way in (width, -width)
        )
        wanted = (above - below) / (2 * width)
        assert slope == pytest.approx(wanted, abs=1e-4 * np.abs(wanted).max()), path
