"""Suite for controllers: size of the memory, steady state, limits, agreement of a bench with a plain loop."""

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

SAMPLES = 24


def list_readings(controller: AbstractController) -> dict[str, float]:
    """Return readings of the plant at rest, mid-range values for others, and constant previewed references."""
    others = {name: sum(find_range(name)) / 2.0 for name in controller.reads()}
    readings = others | observe_rest()
    previews = controller.list_previews().items()
    ahead = [f"{AHEAD}{drive}.{k}" for drive, times in previews for k in range(len(times) + 1)]
    return readings | dict.fromkeys(ahead, readings.get(controller.measured, 0.0))


def find_target(controller: AbstractController) -> float:
    """Return a reference that needs no action of a plant at rest."""
    return list_readings(controller).get(controller.measured, 0.0)


def check_reads(controller: AbstractController) -> None:
    """A missing reading is reported by name, with the nearest existing name."""
    readings = list_readings(controller)
    for name in controller.reads():
        renamed = {f"{n}s" if n == name else n: value for n, value in readings.items()}
        try:
            controller(0.0, renamed, controller.init())
        except ParameterError as error:
            named = f"`{name}`" in str(error) and f"`{name}s`" in str(error)
        else:
            named = False
        require_condition(named, f"Without the reading `{name}` it does not say that it is missing.")


def check_memory(controller: AbstractController) -> None:
    """The memory of a controller is a constant number of floats."""
    readings, target = list_readings(controller), find_target(controller)
    memory = tuple(flatten_numbers(tuple(controller.rest(floats, target, readings))))
    count = len(memory)
    for k in range(5):
        scaled = {name: value * (1.0 + 0.01 * k) for name, value in readings.items()}
        reference = target + 1e-3 * (k - 2)
        signal, memory = controller.answer(floats, memory, reference, scaled, PERIOD)
        numeric = len(memory) == count and all(isinstance(x, float | int) for x in memory)
        require_condition(numeric, f"It remembers {count} numbers first, after {k + 1} samples {list(memory)}.")
        require_condition(math.isfinite(signal), f"Its signal is {signal}.")


def check_no_time(controller: AbstractController) -> None:
    """With zero time between samples, the signal and its derivative by the reference are finite."""
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
    """With its plant at rest at the reference, the signal is constant."""
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
    """Return the lowest and highest declared signal of a controller or its law; None without limits."""
    for part in (controller, getattr(controller, "law", None)):
        levels = [getattr(part, name) for name in ("low", "high", "near") if hasattr(part, name)]
        if "high" in getattr(part, "declarations", {}):
            return min([0.0, *levels]), max(levels)
    return None


def check_limits(controller: AbstractController) -> None:
    """For any readings, its signal stays within its declared limits."""
    limits, readings = find_limits(controller), list_readings(controller)
    if limits is None:
        return
    target = find_target(controller)
    memory = controller.rest(floats, target, readings)
    for k in range(0, 200, 6):  # all pairs of remainders
        scaled = {name: value + (k % 7 - 3) * 0.1 * k for name, value in readings.items()}
        reference = target + (k % 5 - 2) * 0.1
        signal, memory = controller.answer(floats, memory, reference, scaled, PERIOD)
        low, high = limits
        require_condition(low <= signal <= high, f"Its signal is {signal:.6g}, beyond {low:g} to {high:g}.")


def check_bench(controller: AbstractController) -> None:
    """Traced on a bench, it gives the same signals as on plain floats in an outside loop."""
    plant = build_plant()
    if not set(controller.reads()) <= set(plant.outputs()):
        return
    low, high = find_range(controller.measured)
    low = find_target(controller)
    levels = np.interp(np.arange(SAMPLES + 1), [3, 9, 21], [low, low + 0.3 * (high - low), low])
    reference = Held(values=tuple(levels.tolist()), frequency=1.0 / PERIOD)
    moved: Any = controller.with_parts(reference=reference)
    bench = Bench(plant=plant, period=PERIOD, substeps=1, controllers=Controllers(drive=moved))
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
