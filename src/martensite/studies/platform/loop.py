"""ON/OFF control of the angle: runs in a loop, and their quantities.

The paper's controller keeps the gate on "until the gyro sets to the desired angle"; dead band, sampling and delay are
not given.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

from martensite.control.controllers.relay import OnOff
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, MountedSensor, Sensors
from martensite.control.loop.run import simulate_bench
from martensite.control.sensors.position import IdealSensor
from martensite.signals.constant import Constant
from martensite.simulate.result import Result
from martensite.studies.platform import bench
from martensite.studies.platform.bench import Case
from martensite.studies.readings import choose_runtime
from martensite.studies.tables import Printed

BAND = 0.5
"""Assumed dead band [°]."""
DELAY = 0.3
"""Assumed measurement delay [s]."""


@dataclass(frozen=True)
class Sampling:
    """Duration and sample time of a run [s]."""

    duration: float
    """[s]"""
    period: float
    """[s]"""


QUICK, CYCLES, LAGGING = Sampling(3.6, 0.005), Sampling(62.0, 0.02), Sampling(62.0, 0.01)
"""Sampling of springs that heat within seconds; of slower springs, over two limit cycles; and of set C."""


def run_controlled(case: Case, printed: Printed, sampling: Sampling, delay: float = 0.0, motion: str = "") -> Result:
    """Return ON/OFF control at the high voltage from the steady state to the target."""
    return _run_controlled(case, bench.without_results(printed), sampling, delay, motion)


@cache
def _run_controlled(case: Case, printed: Printed, sampling: Sampling, delay: float, motion: str) -> Result:
    system = bench.build_machine(case, printed, printed.high, **({"motion": motion} if motion else {}))
    controller = OnOff(
        measured="alpha",
        reference=Constant(level=math.radians(printed.target)),
        band=math.radians(BAND),
        high=printed.high,
    )
    gyro = MountedSensor(sensor=IdealSensor(), of=("alpha",), delay=delay)
    looped = Bench(
        plant=system,
        period=sampling.period,
        substeps=5 if motion else 1,
        sensors=Sensors(alpha=gyro),
        controllers=Controllers(**{bench.HOT: controller}),
    )
    return simulate_bench(looped, sampling.duration, runtime=choose_runtime())


def angle_overshoot(result: Result, printed: Printed) -> float:
    """Return the overshoot of the angle beyond the target [°]."""
    return max(bench.angle_degrees(result)) - printed.target


def switching_times(result: Result) -> list[float]:
    """Return the switching times of the voltage [s]: off, on, off and so on."""
    drive = result[f"{bench.HOT}.drive"]
    return [result.times[k] for k in range(1, len(drive)) if drive[k] != drive[k - 1]]
