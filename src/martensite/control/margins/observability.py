"""Observability of the martensite fraction from the resistance, for loops on its estimate.

d ln R/dξ along both branches, and σ_ξ = σ_R/(R |d ln R/dξ|) of one reading
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from martensite.base.errors import InputError
from martensite.base.formats import write_quantity
from martensite.control.loop.findings import LoopFinding
from martensite.control.margins.loop_case import BEYOND, LoopCase
from martensite.control.observers.base import ESTIMATED
from martensite.control.sensors.resistance import ResistanceSensor
from martensite.control.synthesis.rest_curves import RestCurve
from martensite.kernels import floats

BLURRED = 0.25
"""Largest error of the martensite fraction by one reading."""
TURNED = 0.05
"""Fraction of the largest slope above which a slope of opposite sign counts."""
MOVED = 1e-3
"""Least difference of martensite fractions for a slope."""


def check_observability(case: LoopCase) -> Iterator[LoopFinding]:
    """Check that resistance meters resolve the fraction on both branches, and measure at the least signal."""
    if not case.controller.measured.startswith(ESTIMATED):
        return
    plant = case.bench.plant
    port = next((one for one in plant.actuators() if plant.drive_at(one) == case.drive), None)
    if port is None:
        raise InputError(f"`{case.drive}` drives no element")
    for name, mounted in case.bench.sensors.members().items():
        if isinstance(mounted.sensor, ResistanceSensor):
            for curve in (case.heating, case.cooling):
                yield from _judge_branch(case, f"sensors.{name}", mounted.sensor, curve, port)
            yield from _judge_current(case, mounted.sensor, port)


def find_slopes(case: LoopCase, curve: RestCurve, port: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the readings within the range of the reference, with d ln R/dξ and R."""
    fraction, ohms = (curve.outputs[case.bench.plant.label(port, one)] for one in ("martensite_fraction", "resistance"))
    wanted, readings = case.reference, case.read(curve)
    slack = BEYOND * np.ptp(readings)
    inside = (readings >= wanted.min() - slack) & (readings <= wanted.max() + slack)
    moved = np.flatnonzero((np.abs(np.diff(fraction)) > MOVED) & inside[1:] & inside[:-1])
    slopes = np.diff(np.log(ohms))[moved] / np.diff(fraction)[moved]
    return 0.5 * (readings[moved] + readings[moved + 1]), slopes, ohms[moved]


def _judge_branch(
    case: LoopCase, where: str, sensor: ResistanceSensor, curve: RestCurve, port: str
) -> Iterator[LoopFinding]:
    readings, slopes, ohms = find_slopes(case, curve, port)
    if not len(slopes):
        return
    k, size = int(np.argmin(np.abs(slopes))), float(np.max(np.abs(slopes)))
    at, least = write_quantity(float(readings[k]), case.unit, 3), float(slopes[k])
    if slopes.max() > TURNED * size and slopes.min() < -TURNED * size:
        sentence = (
            f"While {curve.direction}, d ln R/dξ goes from {slopes.min():.3g} to {slopes.max():.3g}: one resistance "
            f"stands for two positions, about {at}."
        )
        remedy = "Try another range of the reference, or a position sensor."
        yield case.find("observability", where, (sentence, remedy), (least, 0.0, "1"))
    blur = float(np.hypot(float(sensor.relative_noise), float(sensor.noise) / ohms[k])) / max(abs(least), 1e-12)
    if blur > BLURRED:
        sentence = (
            f"While {curve.direction}, at {at}, d ln R/dξ is {least:.3g}: one reading tells the martensite fraction to "
            f"±{blur:.2g} only."
        )
        remedy = "Try a quieter meter, or an observer that trusts its model more."
        yield case.find("observability", where, (sentence, remedy), (blur, BLURRED, "1"))


def _judge_current(case: LoopCase, sensor: ResistanceSensor, port: str) -> Iterator[LoopFinding]:
    truth = [case.heating.outputs[case.bench.plant.label(port, name)][0] for name in ("voltage", "current")]
    if not sensor.valid(floats, truth):
        sentence = (
            f"Under the least signal, {case.limits[0]:.3g}, the current is {write_quantity(float(truth[1]), 'A', 3)}, "
            "and nothing is read while the element cools."
        )
        numbers = float(truth[1]), float(sensor.least_current), "A"
        where = f"controllers.{case.drive}.low"
        yield case.find("observability", where, (sentence, "Try a least signal that leaves a current."), numbers)
