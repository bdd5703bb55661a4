"""Benches that tests of tuning share: one whose plant is known exactly, and a thin wire."""

from __future__ import annotations

from functools import cache

import numpy as np
from builders import problem_a, wire_a

from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.control.controllers.pid import Pid
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, MountedSensor, Sensors
from martensite.control.sensors.position import PositionSensor
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.plant import build_plant
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.constant import Constant
from martensite.signals.staircase import Staircase

DT, DELAY = 0.05, 8.0


@cache
def linear_bench(gain: float = 2.0) -> Bench:
    """y = gain x + 0.5, x following u with a lag of 1 s, eight samples late."""
    line = Polynomial(degree=1.0, low=-1.0, high=1.0)
    blocks = (TransferFunction(nb=1.0, nf=1.0, nk=DELAY), line)
    chain = Chain(blocks, np.array([0.0, *line.line(gain, 0.5)]), DT)
    pid = Pid(measured=chain.output_names[0], reference=Constant(level=1.0), Kp=1.0)
    return Bench(plant=build_plant(chain), period=DT, controllers=Controllers(**{chain.input_names[0]: pid}))


@cache
def wire_bench(sensed: bool = True) -> Bench:
    """A wire of 0.15 mm against a spring under a PID controller, asked for 3 mm, then 5 mm."""
    system = problem_a(
        element=wire_a(diameter=0.15e-3),
        mechanism=BiasSpring(stiffness=150.0, preload=1.8),
        source=PwmVoltage(supply=1.8),
    )
    levels = Staircase(first=0.003, increment=0.002, hold=4.0, count=2)
    pid = Pid(measured="position", reference=levels, Kp=300.0, Ki=200.0, Kd=80.0)
    encoder = Sensors(position=MountedSensor(sensor=PositionSensor(), delay=0.1))
    return Bench(
        plant=system,
        period=0.05,
        substeps=2,
        sensors=encoder if sensed else Sensors(),
        controllers=Controllers(drive=pid),
    )
