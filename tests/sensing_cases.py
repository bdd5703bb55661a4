"""A wire that senses itself: plant, bench and references of the tests of self-sensing.

The wire of problem A under a switched voltage, with a resistance that depends on phase, strain and
temperature. Resistivities and their temperature coefficients are plausible, of no particular wire.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from builders import problem_a, wire_a

from martensite.actuators.assembly import AbstractSystem, System
from martensite.control.controllers.pid import Pid, PidLaw
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, MountedSensor, Observers, Sensors
from martensite.control.loop.run import simulate_bench
from martensite.control.observers.base import AbstractObserver
from martensite.control.observers.hidden_states import ProcessNoisePlant
from martensite.control.sensors.resistance import ResistanceSensor
from martensite.physics.electrical.resistances import FurstSeeleckeResistance
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.table import Table

PERIOD = 0.02
LEAST_DUTY = 0.02
"""So that there is always a current to measure with."""
STROKE = 9.99e-3
"""Of the wire from cold to hot [m]."""

RESISTANCE = FurstSeeleckeResistance(rho_A=0.90e-6, rho_M=0.97e-6, a_rho_A=5e-4, a_rho_M=8e-4, T_rho=293.15, nu=0.33)
SMOOTH = tuple(np.arange(0.0, 60.01, 0.1).tolist())
SINE = Table(times=SMOOTH, values=tuple(4.5e-3 - 3.5e-3 * math.cos(0.1 * math.pi * t) for t in SMOOTH))
STEPS = Table(
    times=(0.0, 15.0, 15.001, 30.0, 30.001, 45.0, 45.001, 60.0), values=(2e-3, 2e-3, 7e-3, 7e-3, 4e-3, 4e-3, 1e-3, 1e-3)
)


def sensing_plant(**changes: Any) -> System:
    """The wire; keyword arguments replace whole parts."""
    parts: dict[str, Any] = {"element": wire_a().with_parts(resistance=RESISTANCE), "source": PwmVoltage(supply=6.0)}
    return problem_a(**(parts | changes))


def sensing_bench(
    plant: AbstractSystem,
    observer: AbstractObserver | None,
    reference: Table | None = None,
    noise: float = 0.01,
    **changes: Any,
) -> Bench:
    """A bench whose only sensor is a resistance meter; with a reference, a sensorless loop."""
    meter = MountedSensor(sensor=ResistanceSensor(relative_noise=noise))
    parts: dict[str, Any] = {"plant": plant, "period": PERIOD, "sensors": Sensors(resistance=meter)}
    if observer is not None:
        parts["observers"] = Observers(wire=observer)
    if reference is not None:
        law = PidLaw(low=LEAST_DUTY)
        loop = Pid(measured="estimated.position", reference=reference, Kp=400.0, Ki=200.0, law=law)
        parts["controllers"] = Controllers(drive=loop)
    return Bench(**(parts | changes))


def shaken(plant: AbstractSystem, **noise: float) -> ProcessNoisePlant:
    """The plant with a random walk of temperature and fraction."""
    parts: dict[str, Any] = {"plant": plant, "held": PERIOD, **noise}
    return ProcessNoisePlant(**parts)


def run(bench: Bench, seconds: float = 60.0, **options: Any) -> dict[str, np.ndarray]:
    """Columns of a run, and `times`."""
    found = simulate_bench(bench, seconds, **options)
    return {"times": np.array(found.times)} | {n: np.array(c) for n, c in found.columns.items()}


def rms(numbers: Any) -> float:
    return float(np.sqrt(np.mean(np.square(numbers))))
