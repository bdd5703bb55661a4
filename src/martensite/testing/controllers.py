"""Suite for controllers: a memory that keeps its shape, rest, the same on a bench."""

import math
from typing import Any

import numpy as np

from martensite.base.errors import ParameterError
from martensite.control.controllers.base import AHEAD, AbstractController
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers
from martensite.control.loop.run import open_loop, simulate_bench
from martensite.kernels import floats
from martensite.kernels.dual import value_and_slope
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import flatten_numbers
from martensite.signals.constant import Constant
from martensite.signals.held import Held
from martensite.testing.conformance import require_condition
from martensite.testing.examples import build_plant
from martensite.testing.readings import PERIOD, find_range, observe_rest

SAMPLES = 40
"""Number of samples of a run on a bench."""


def list_readings(controller: AbstractController) -> dict[str, float]:
    """Return the plant at rest with all other readings, and references ahead that need no action."""
    others = {name: sum(find_range(name)) / 2.0 for name in controller.reads()}
    found = others | observe_rest()
    previews = controller.list_previews().items()
    ahead = [f"{AHEAD}{drive}.{k}" for drive, times in previews for k in range(len(times) + 1)]
    return found | dict.fromkeys(ahead, found.get(controller.measured, 0.0))


def find_target(controller: AbstractController) -> float:
    """Return a reference at which a plant at rest needs nothing."""
    return list_readings(controller).get(controller.measured, 0.0)


def check_reads(controller: AbstractController) -> None:
    """A missing reading is reported by name, with the nearest existing name."""
    readings = list_readings(controller)
    for name in controller.reads():
        known = {f"{n}s" if n == name else n: value for n, value in readings.items()}
        try:
            controller(0.0, known, controller.init())
        except ParameterError as error:
            said = f"`{name}`" in str(error) and f"`{name}s`" in str(error)
        else:
            said = False
        require_condition(said, f"Without the reading `{name}` it does not say that it is missing.")


def check_memory(controller: AbstractController) -> None:
    """The memory of a controller consists of numbers, equally many at every sample."""
    readings, target = list_readings(controller), find_target(controller)
    memory = tuple(flatten_numbers(tuple(controller.rest(floats, target, readings))))
    count = len(memory)
    for k in range(5):
        found = {name: value * (1.0 + 0.01 * k) for name, value in readings.items()}
        wanted = target + 1e-3 * (k - 2)
        signal, memory = controller.answer(floats, memory, wanted, found, PERIOD)
        held = len(memory) == count and all(isinstance(x, float | int) for x in memory)
        require_condition(held, f"It remembers {count} numbers first, after {k + 1} samples {list(memory)}.")
        require_condition(math.isfinite(signal), f"Its signal is {signal}.")


def check_no_time(controller: AbstractController) -> None:
    """Without time between samples it answers, with a finite slope by the reference."""
    readings, target = list_readings(controller), find_target(controller)

    def answer(xp: Namespace, reference: Scalar) -> Scalar:
        memory, signal = controller.rest(xp, reference, readings), 0.0
        for _ in range(2):
            signal, memory = controller.answer(xp, memory, reference, readings, 0.0)
        return signal

    value, slope = value_and_slope(floats, answer, target + 2e-3)
    finite = math.isfinite(value) and (slope is None or math.isfinite(slope))
    require_condition(finite, f"Called twice at one time it says {value}, with a slope of {slope}.")


def check_rest(controller: AbstractController) -> None:
    """With its plant at rest and nothing to do, its signal stays as it is."""
    resting = controller.with_parts(reference=Constant(level=find_target(controller)))
    memory, signals = resting.init(), list[float]()
    for k in range(20):
        signal, memory = resting(k * PERIOD, list_readings(controller), memory)
        signals.append(signal)
    apart = max(signals) - min(signals)
    require_condition(
        apart <= 1e-9 * (1.0 + abs(signals[0])),
        f"With nothing to do its signal goes from {signals[0]:.6g} to {signals[-1]:.6g}.",
    )


def find_limits(controller: AbstractController) -> tuple[float, float] | None:
    """Return the least and largest signal that a controller declares, itself or in its law."""
    for part in (controller, getattr(controller, "law", None)):
        levels = [getattr(part, name) for name in ("low", "high", "near") if hasattr(part, name)]
        if "high" in getattr(part, "declarations", {}):
            return min([0.0, *levels]), max(levels)
    return None


def check_limits(controller: AbstractController) -> None:
    """Whatever is read, its signal stays within the limits that it declares."""
    limits, readings = find_limits(controller), list_readings(controller)
    if limits is None:
        return
    target = find_target(controller)
    memory = controller.rest(floats, target, readings)
    for k in range(200):
        found = {name: value + (k % 7 - 3) * 0.1 * k for name, value in readings.items()}
        wanted = target + (k % 5 - 2) * 0.1
        signal, memory = controller.answer(floats, memory, wanted, found, PERIOD)
        low, high = limits
        require_condition(low <= signal <= high, f"Its signal is {signal:.6g}, beyond {low:g} to {high:g}.")


def check_bench(controller: AbstractController) -> None:
    """On a bench, traced, it does what it does as a drive on plain floats beside it."""
    plant = build_plant()
    if not set(controller.reads()) <= set(plant.outputs()):
        return
    low, high = find_range(controller.measured)
    low = find_target(controller)
    ways = np.interp(np.arange(SAMPLES + 1), [5, 15, 35], [low, low + 0.3 * (high - low), low])
    reference = Held(values=tuple(ways.tolist()), frequency=1.0 / PERIOD)
    tried: Any = controller.with_parts(reference=reference)
    bench = Bench(plant=plant, period=PERIOD, substeps=1, controllers=Controllers(drive=tried))
    inside = simulate_bench(bench, SAMPLES * PERIOD, runtime="floats")
    rest, drive = open_loop(bench, "drive")
    outside = simulate_bench(rest, SAMPLES * PERIOD, outside={"drive": drive})
    one, other = (np.array(run["drive"])[:-1] for run in (inside, outside))
    apart = np.abs(one - other)
    require_condition(
        apart.max() <= 1e-9 * (1.0 + np.abs(one).max()),
        f"At {PERIOD * int(np.argmax(apart)):.2f} s its signal is {one[apart.argmax()]:.6g} on a "
        f"bench, and {other[apart.argmax()]:.6g} as a drive beside it.",
    )
