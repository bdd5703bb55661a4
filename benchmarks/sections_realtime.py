"""The section of the benchmark on real time: one control step, called from Python.

What: the wire of `examples/pwm_bias_spring.toml` behind a switch, with an encoder. A step of the
user's own loop takes readings and gives a signal: a PID alone as a drive; the compiled loop with
a PID, and with an extended Kalman filter, whose model steps the law, before it; a period of the
whole bench, plant and sensors included, in C; a period of a predictive controller. Wall times of
single calls, the reading changed before each; the bar is `BAR` for the median.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np

from benchmarks.harness import latencies
from benchmarks.process import ROOT
from benchmarks.report import Table
from benchmarks.sections import Options, section
from martensite.actuators.assembly import System
from martensite.control.controllers.mpc import Mpc
from martensite.control.controllers.pid import Pid
from martensite.control.controllers.planning import Price
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, MountedSensor, Observers, Sensors
from martensite.control.loop.realtime import RealtimeStep
from martensite.control.observers.extended import ExtendedKalman
from martensite.control.sensors.position import PositionSensor
from martensite.kernels.compiler import find_compiler
from martensite.physics.electrical.switches import PwmVoltage
from martensite.scenario.scenario import load
from martensite.signals.sine import Sine
from martensite.simulate.lanes import Lanes

EXAMPLE = ROOT / "examples/pwm_bias_spring.toml"
PERIOD, BAR = 0.02, 200e-6  # [s]
COURSE = Sine(low=1e-3, high=4e-3, frequency=0.2)
QUANTILES = {"median": 0.5, "p99": 0.99, "p99.9": 0.999}
SLOWER = 50  # fewer calls of a predictive controller

Call = Callable[[int], Any]


def plant() -> System:
    """The wire of the example behind a switch."""
    return cast("System", load(EXAMPLE).system).with_parts(source=PwmVoltage(supply=4.0, series_resistance=0.2))


def bench(observed: bool) -> Bench:
    """The wire under a PID, which follows the encoder or what a filter makes of it."""
    found = Observers()
    if observed:
        found = Observers(filter=ExtendedKalman(model=plant(), measured=("position",)))
    name = "estimated.position" if observed else "position"
    pid = Pid(measured=name, reference=COURSE, Kp=300.0, Ki=100.0, Kd=2.0)
    return Bench(
        plant=plant(),
        period=PERIOD,
        substeps=1,
        observers=found,
        sensors=Sensors(position=MountedSensor(sensor=PositionSensor())),
        controllers=Controllers(drive=pid),
    )


def reading(i: int) -> float:
    """What the encoder says at a sample [m]."""
    return COURSE.value(i * PERIOD)


def drive(controller: Any) -> Call:
    """A controller called as a drive, on floats."""
    memory = [controller.init()]

    def call(i: int) -> None:
        _, memory[0] = controller(i * PERIOD, {"position": reading(i)}, memory[0])

    return call


def loop(whole: Bench, native: bool) -> Call:
    """The loop of a bench without its plant."""
    step = RealtimeStep(whole, native).step
    return lambda i: step({"position": reading(i)})


def period(observed: bool) -> Call:
    """A period of a whole bench in C."""
    lanes = Lanes(bench(observed), 1)
    signals = np.zeros((1, len(lanes.drives), 1))
    lanes.reset(signals[0])

    def call(i: int) -> None:
        signals[0, 0, 0] = reading(i)
        lanes.advance(signals, PERIOD)

    return call


def predictive() -> Bench:
    """The wire under a predictive controller."""
    planned = Mpc.for_system(plant(), measured="position", reference=COURSE, period=PERIOD, price=Price(error=1e-4))
    return bench(False).with_parts(controllers=Controllers(drive=planned))


def calls() -> dict[str, Call]:
    """What is timed, by name."""
    found = {
        "pid, floats": drive(bench(False).controllers.members()["drive"]),
        "loop pid, floats": loop(bench(False), native=False),
        "loop filter + pid, floats": loop(bench(True), native=False),
    }
    if find_compiler() is None:
        return found
    return found | {
        "loop pid, C": loop(bench(False), native=True),
        "loop filter + pid, C": loop(bench(True), native=True),
        "period of the bench with pid, C": period(False),
        "period of the bench with filter + pid, C": period(True),
        "loop mpc, 20 blocks, C": loop(predictive(), native=True),
    }


@section
def realtime(options: Options) -> list[Table]:
    """One control step of every kind."""
    rows: list[dict[str, Any]] = []
    for name, call in calls().items():
        count = options.calls // SLOWER if "mpc" in name else options.calls
        times = latencies(call, max(count, 1), warm=min(500, count))
        row: dict[str, Any] = {"step": name}
        row |= {f"{k} [us]": 1e6 * times[int(q * len(times))] for k, q in QUANTILES.items()}
        row["ratio"] = row["median [us]"] / (rows[0]["median [us]"] if rows else row["median [us]"])
        row["bar"] = "below" if row["median [us]"] < 1e6 * BAR else "above"
        rows.append(row)
    note = f"Wall time of single calls. Bar of the median: {1e6 * BAR:.0f} us."
    return [Table(f"Control step, period {1e3 * PERIOD:g} ms", rows, note)]
