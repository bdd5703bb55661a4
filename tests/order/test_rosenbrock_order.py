"""A Rosenbrock step of a law of rates: its order, that of its middle, and what it is beside.

The order shows on a run that is smooth: a wire of thin layers on a spring, heated by a tone of
power or voltage, from a state amid its transformation, in ever shorter steps.
"""

import math
from typing import Any

import numpy as np
import pytest
from benchmarks.problem_b import Wire, system

from martensite.actuators.assembly import System
from martensite.physics.electrical.sources import VoltageSource
from martensite.signals.moments import Moments
from martensite.simulate.compiled import bind_march, feed_step

POWER, SWING, RATE = 1.0, 0.3, 2.0
SLOW = Wire()._replace(layer_volume=5e-24, layer_time=5e-2)
SPAN = 0.4
OHMS = 126.0 * SLOW.length
AT, SHARE = np.polynomial.legendre.leggauss(12)
CASES = {
    "mas": {},
    "mas, barrier, work": {"rates": "barrier", "heat_model": "stress"},
    "mas-polycrystal": {"groups": "15"},
}
Row = tuple[float, ...]


def drive(voltage: bool, begin: float, end: float) -> tuple[float, ...]:
    """Moments of a power, or of the voltage that brings it, over the wire."""

    def mean(weight: Any) -> float:
        t = 0.5 * (begin + end) + 0.5 * (end - begin) * AT
        level = POWER + SWING * np.sin(RATE * t)
        level = np.sqrt(OHMS * level) if voltage else level
        return float(np.sum(0.5 * SHARE * weight(level, AT)))

    length = end - begin
    squares = (mean(lambda u, x: u * u), 6.0 / length * mean(lambda u, x: u * u * x))
    first = (mean(lambda u, x: u), 6.0 / length * mean(lambda u, x: u * x))
    low, high = mean(lambda u, x: u) - 1e-9, mean(lambda u, x: u) + 1e-9
    return feed_step(Moments(first[0], squares[0], low, high, 0.0, first[1], squares[1]))


class Course:
    """Runs from one warm state."""

    def __init__(self, posed: System, voltage: bool) -> None:
        self.functions, self.size = bind_march(posed)
        self.voltage = voltage
        self.start = self.functions["init"](0.0)[: self.size]
        warm = feed_step(Moments.constant(math.sqrt(OHMS * POWER) if voltage else POWER))
        for _ in range(200):
            self.start = self.functions["step"](*self.start, *warm, 15e-3)[: self.size]

    def step(self, state: Row, begin: float, end: float) -> list[Row]:
        """End, middle, and end to the lower order."""
        inputs = drive(self.voltage, begin, end)
        ends = self.functions["rosenbrock"](*state, *inputs, end - begin)
        return [ends[k * self.size : (k + 1) * self.size] for k in range(3)]

    def end(self, steps: int, span: float = SPAN) -> np.ndarray:
        """Temperature, martensite fraction and stress after equal steps."""
        state = self.start
        for k in range(steps):
            state = self.step(state, span * k / steps, span * (k + 1) / steps)[0]
        return self.read_outputs(state)

    def read_outputs(self, state: Row) -> np.ndarray:
        return np.array(self.functions["judge"](*state, 0.0)[:3])


@pytest.mark.parametrize(
    ("case", "voltage"), [("mas", False), ("mas, barrier, work", True), ("mas-polycrystal", False)]
)
def test_the_order_is_four(case: str, voltage: bool) -> None:
    posed = system(SLOW, case.split(",")[0], **CASES[case])
    if voltage:
        posed = System(
            element=posed.element, environment=posed.environment, source=VoltageSource(), mechanism=posed.mechanism
        )
    course = Course(posed, voltage)
    exact = course.end(160)
    assert 0.05 < exact[1] < 0.95  # amid the transformation
    errors = [np.abs(course.end(steps) - exact).max() for steps in (20, 40)]
    assert np.log2(errors[0] / errors[1]) > 3.5


@pytest.mark.parametrize("case", list(CASES)[:2])
def test_one_step_and_what_is_inside(case: str) -> None:
    """Local errors: of order five at the end, four in the middle and for the lower order."""
    course = Course(system(SLOW, case.split(",")[0], **CASES[case]), False)
    rows = []
    for length in (0.02, 0.01):
        exact = [course.end(64, length), course.end(64, 0.5 * length), course.end(64, length)]
        found = course.step(course.start, 0.0, length)
        rows.append([abs(course.read_outputs(a)[1] - b[1]) for a, b in zip(found, exact, strict=True)])
    orders = np.log2(np.divide(rows[0], rows[1]))
    assert orders[0] > 4.3
    assert orders[1] > 3.5
    assert orders[2] == pytest.approx(4.0, abs=0.6)
