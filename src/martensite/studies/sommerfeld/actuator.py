"""The wire on its own test bench: 100 mm under 500 g, heated by nine voltages and cooled.

Closure B of study `wire-heating` with the law of the beam's wire. The alloy is assumed, so transformation temperatures
and strokes are no predictions.
"""

from __future__ import annotations

import math
from functools import cache

from martensite.scenario.scenario import Scenario, load
from martensite.signals.step import Step
from martensite.simulate.api import simulate
from martensite.simulate.result import Result
from martensite.studies.tables import Printed
from martensite.studies.wire_heating.bench import CLOSURES

HEATED, LENGTH = 60.0, 120.0
"""Time with the voltage on, and duration of a run [s]."""
COMPLETE = 0.01
"""Martensite fraction of a complete transformation."""


@cache
def load_scenario() -> Scenario:
    """Return closure B with the Elahinia–Ashrafiuon law."""
    return load(CLOSURES["b"], {"element.law": "elahinia"})


@cache
def run_heated(volts: float) -> Result:
    """Return a run with the voltage [V] on for 60 s, then off for 60 s."""
    wave = Step(high=volts, until=HEATED)
    return simulate(load_scenario().system, wave, LENGTH, tolerance=1e-3, samples=601)


def at_end(volts: float, name: str) -> float:
    """Return a column just before switch-off."""
    run = run_heated(volts)
    return run[name][round(HEATED / LENGTH * (len(run.times) - 1)) - 1]


def recovered_strain(volts: float) -> float:
    """Return the strain recovered at the end of heating."""
    start = run_heated(volts)["strain"][0]
    return start - at_end(volts, "strain")


def complete_from(printed: Printed) -> float:
    """Return the lowest voltage that transforms the whole wire [V]; NaN without one."""
    voltages = (volts for volts in printed.heating_voltages if at_end(volts, "martensite_fraction") < COMPLETE)
    return next(voltages, math.nan)
