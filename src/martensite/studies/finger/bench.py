"""The simulated finger, its inputs, and quantities of its runs.

Runs have fixed steps: 20 ms for the trapezoid, 50 ms and more for slow loops. Halving them changes no angle by more
than 0.02° (asserted in the tests).
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import cast

from martensite.actuators.assembly import System
from martensite.actuators.elements.wire import Wire
from martensite.scenario.laws import configure_laws
from martensite.signals.constant import Constant
from martensite.signals.sampling.sampled import Numbers
from martensite.signals.sine import Sine
from martensite.signals.table import Table
from martensite.simulate.api import simulate
from martensite.simulate.result import Result
from martensite.studies.readings import choose_runtime, level_time, load_once, passing_time
from martensite.studies.tables import Printed

SCENARIO = Path(__file__).with_name("scenario.toml")
load_scenario = partial(load_once, SCENARIO)
POLYCRYSTAL = ("mas-polycrystal", (("spread", "20 MPa"),))
"""Polycrystal law: barriers spread by 20 MPa (standard deviation)."""
SINGLE = ("mas", ())
STATIC = (("latent_heat", 0.0), ("heat_capacity", 5.0))
"""A wire with negligible heat storage, always at steady state."""
SAFE_ARM, FAR_ARM = 6e-3, 25e-3
"""Other places of the spring [m]."""
STEP = 0.02
Law = tuple[str, tuple[tuple[str, str], ...]]


def get_wire() -> Wire:
    """Return the wire of the scenario."""
    return cast("Wire", cast("System", load_scenario().system).element)


def surface_conductance(printed: Printed) -> float:
    """Return h S of the whole wire [W/K]."""
    return printed.film * get_wire().surface()


@cache
def build_finger(law: Law = SINGLE, values: tuple[tuple[str, float], ...] = ()) -> System:
    """Return the finger with another law and changed parameters."""
    system = cast("System", load_scenario().system)
    if law != SINGLE:
        name, settings = law
        (dressed,) = configure_laws([name], "finger-mas", dict(settings))
        system = system.with_parts(element=get_wire().with_parts(law=dressed.law))
    return system.with_values(dict(values))


def power_trapezoid(watts: float, printed: Printed) -> Table:
    """Return the power of section 5 [W]."""
    begin, rise, fall = printed.start, printed.ramp, printed.fall
    times = (0.0, begin, begin + rise, fall, fall + rise, 25.0)
    return Table(times=times, values=(0.0, 0.0, watts, watts, 0.0, 0.0))


@cache
def run_bending(
    watts: float, offset: float, printed: Printed, arm: float | None = None, law: Law = SINGLE, step: float = STEP
) -> Result:
    """Return a trapezoid run at a power [W], for a wire at r = `offset` and a spring at a = `arm` [m]."""
    places = {"mechanism.offset": offset} | ({} if arm is None else {"mechanism.arm": arm})
    return run_trapezoid(build_finger(law, tuple(places.items())), watts, printed, step)


def run_trapezoid(system: System, watts: float, printed: Printed, step: float = STEP) -> Result:
    """Return a trapezoid run at a power [W] of any system."""
    wave = power_trapezoid(watts, printed)
    return simulate(system, wave, 25.0, step=step, samples=501, runtime=choose_runtime())


def top_angle(result: Result, printed: Printed) -> float:
    """Return the angle at the end of the full power [°]."""
    return math.degrees(column_at(result, "angle", printed.fall))


def column_at(result: Result, name: str, time: float) -> float:
    """Return a column at a sample time [s]."""
    return float(result[name][round(time / result.times[-1] * (len(result.times) - 1))])


def rise_time(result: Result, share: float, printed: Printed) -> float:
    """Return the time from the start of the power to a fraction of the final angle [s]."""
    level = share * math.radians(top_angle(result, printed))
    last = round(printed.fall / result.times[-1] * (len(result.times) - 1))
    return passing_time(result.times[: last + 1], result.columns["angle"][: last + 1], level) - printed.start


@cache
def run_loop(
    frequency: float, arm: float | None, printed: Printed, values: tuple[tuple[str, float], ...] = (), law: Law = SINGLE
) -> Result:
    """Return two periods of a raised cosine from 0 to 2 W at r = 1.5 mm."""
    places = {"mechanism.offset": printed.offsets[0]} | dict(values)
    if arm is not None:
        places["mechanism.arm"] = arm
    wave = Sine(low=0.0, high=max(printed.powers), frequency=frequency)
    system = build_finger(law, tuple(places.items()))
    step = 0.05 * printed.frequency / frequency
    return simulate(system, wave, 2.0 / frequency, step=step, samples=2001, runtime=choose_runtime())


def loop_width(result: Result) -> float:
    """Return the width in power of the second loop at half of its largest angle [W]."""
    half = len(result.times) // 2
    power, angle = result.columns["power"][half:], result.columns["angle"][half:]
    peak = max(range(len(angle)), key=angle.__getitem__)
    level = 0.5 * max(angle)
    rising, falling = range(peak, 0, -1), range(peak, len(angle) - 1)
    up = next(k for k in rising if angle[k - 1] < level <= angle[k])
    down = next(k for k in falling if angle[k] >= level > angle[k + 1])
    return level_time(power, angle, up - 1, level) - level_time(power, angle, down, level)


@cache
def steady_temperature(watts: float, printed: Printed) -> float:
    """Return the simulated steady temperature under a power [K]."""
    run = simulate(build_finger(), Constant(level=watts), 60.0, step=STEP, samples=61, runtime=choose_runtime())
    return run["temperature"][-1]


def energy_imbalance(result: Result, values: Mapping[str, float]) -> float:
    """Return the energy error of a run, as a fraction of the electrical work.

    Heat loss, stored heat and latent heat are integrated by trapezoids of the samples.
    """
    times = result.times
    gain = [p - q for p, q in zip(result.columns["power"], result.columns["heat_loss"], strict=True)]
    put = _integrate_power(times, result.columns["power"])
    mass, capacity, latent = (values[name] for name in ("mass", "heat_capacity", "latent_heat"))
    warmer = result["temperature"][-1] - result["temperature"][0]
    formed = result["martensite_fraction"][-1] - result["martensite_fraction"][0]
    stored = mass * (capacity * warmer - latent * formed)
    return abs(_integrate_power(times, gain) - stored) / put


def _integrate_power(times: Sequence[float] | Numbers, values: Sequence[float] | Numbers) -> float:
    steps = zip(times, times[1:], values, values[1:], strict=False)
    return math.fsum(0.5 * (t1 - t0) * (a + b) for t0, t1, a, b in steps)


def full_stroke(offset: float, arm: float, printed: Printed) -> float:
    """Return the angle at full austenite, in closed form by bisection [°].

    ε_0 - 2 n ΔL/l = σ/E_A, with the stress of the spring at that angle.
    """
    system = build_finger(SINGLE, (("mechanism.offset", offset), ("mechanism.arm", arm)))
    g, k, extension = (system.value_of(f"mechanism.{name}") for name in ("bracket", "stiffness", "extension"))
    section, E_A = get_wire().section(), system.value_of("E_A")

    def stress(angle: float) -> float:
        lever = offset * math.cos(0.5 * angle) + g * math.sin(0.5 * angle)
        return k * arm * (extension + arm * angle) / (2.0 * section * lever)

    def missing(angle: float) -> float:
        bow = 2.0 * (offset * math.sin(0.5 * angle) + g * (1.0 - math.cos(0.5 * angle)))
        begin = printed.eps_T + stress(0.0) / printed.E_M
        return begin - 2.0 * bow / printed.length - stress(angle) / E_A

    angles = [math.radians(0.001 * i) for i in range(180_000)]
    return math.degrees(angles[bisect_left(angles, 0.0, key=lambda a: -missing(a))])
