"""ON/OFF control: when it switches, what delay and band do, what it refuses.

Sources of truth: the switching rule applied by hand to ramps, and in a loop the time constant of a
wire that is heated and left to cool.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest
from builders import ZERO, hanging_wire

from martensite.controllers.on_off import OnOff, Switch
from martensite.electrical.power import PowerSource
from martensite.errors import ParameterError
from martensite.simulate.controlled import simulate_controlled
from martensite.simulate.result import Result

PERIOD = 0.1


def played(controller: OnOff, values: Sequence[float], period: float = PERIOD) -> list[float]:
    """Signals for what is measured at the starts of periods."""
    memory, found = controller.init(), list[float]()
    for k, value in enumerate(values):
        signal, memory = controller(k * period, {"angle": value}, memory)
        found.append(signal)
    return found


def on_off(**changes: float) -> OnOff:
    numbers = {"target": 10.0, "high": 5.0} | changes
    return OnOff(measured="angle", **numbers)


# ---------------------------------------------------------------- the rule


def test_it_switches_at_target_and_below_the_band() -> None:
    values = [0.0, 9.9, 10.0, 10.5, 9.5, 9.0, 8.99, 9.5, 9.99, 10.0, 9.0]
    expected = [5.0, 5.0, 0.0, 0.0, 0.0, 0.0, 5.0, 5.0, 5.0, 0.0, 0.0]
    assert played(on_off(band=1.0), values) == expected


def test_without_band_it_compares_only() -> None:
    assert played(on_off(low=1.0), [9.9, 10.0, 9.9, 10.1]) == [5.0, 1.0, 5.0, 1.0]


def test_it_rests_inside_the_band_at_first() -> None:
    assert played(on_off(band=1.0), [9.5, 9.2, 8.0, 9.5]) == [0.0, 0.0, 5.0, 5.0]


@pytest.mark.parametrize("late", [1, 3, 7])
def test_delay_shifts_the_answer_by_whole_periods(late: int) -> None:
    """Every sample but the first acts so many periods later; before, the first one does."""
    values = [math.sin(0.7 * k) + 10.0 for k in range(60)]
    prompt, delayed = (played(on_off(band=0.3, delay=d), values) for d in (0.0, late * PERIOD))
    assert delayed[late:] == prompt[: len(values) - late]
    assert delayed[:late] == prompt[:1] * late


def test_delay_between_periods_takes_the_older_sample() -> None:
    values = [0.0, 5.0, 10.0, 10.0, 10.0, 10.0]
    assert played(on_off(delay=1.5 * PERIOD), values) == [5.0, 5.0, 5.0, 5.0, 0.0, 0.0]


def test_it_remembers_no_more_than_the_delay_needs() -> None:
    controller = on_off(delay=4 * PERIOD)
    memory = controller.init()
    for k in range(100):
        _, memory = controller(k * PERIOD, {"angle": 0.0}, memory)
    assert isinstance(memory, Switch)
    assert len(memory.samples) == 5


def test_a_signal_that_lowers_the_measured() -> None:
    """A heater whose wire shortens: `high` below `low`."""
    assert played(on_off(high=0.0, low=2.0), [9.0, 11.0]) == [0.0, 2.0]


# ---------------------------------------------------------------- in a loop

TARGET, WATTS, BAND = 40.0 + ZERO, 2.0, 2.0
"""Below the transformation: the wire only warms up, with one time constant."""


def heated(period: float = 0.01, **changes: float) -> Result:
    system = hanging_wire(source=PowerSource())
    numbers = {"target": TARGET, "high": WATTS, "band": BAND} | changes
    controller = OnOff(measured="temperature", **numbers)
    return simulate_controlled(system, {"drive": controller}, 10.0, period)


def switched(result: Result) -> list[float]:
    """Times at which the drive changes [s]."""
    drive = result["drive"]
    return [result.times[k] for k in range(1, len(drive)) if drive[k] != drive[k - 1]]


def test_a_wire_in_the_loop_cycles_as_its_time_constant_says() -> None:
    result = heated()
    wire, surroundings = result.system.element, result.system.environment
    capacity = wire.heat_capacity_total()
    conductance = surroundings.cooling.h * wire.surface()
    constant, final = capacity / conductance, WATTS / conductance
    above = TARGET - surroundings.temperature
    first = -constant * math.log(1.0 - above / final)
    cool = constant * math.log(above / (above - BAND))
    warm = constant * math.log((final - above + BAND) / (final - above))
    times = switched(result)
    assert times[0] == pytest.approx(first, abs=0.011)
    for begin, end in zip(times[::2], times[1::2], strict=False):
        assert end - begin == pytest.approx(cool, abs=0.025)
    for begin, end in zip(times[1::2], times[2::2], strict=False):
        assert end - begin == pytest.approx(warm, abs=0.025)
    assert len(times) > 4


def test_overshoot_is_rate_times_delay() -> None:
    prompt, late = (max(heated(delay=d)["temperature"]) for d in (0.0, 0.2))
    result = heated()
    k = round(switched(result)[0] / 0.01)
    rate = (result["temperature"][k] - result["temperature"][k - 1]) / 0.01
    assert late - prompt == pytest.approx(0.2 * rate, rel=0.05)


def test_a_wrong_band_is_noticed() -> None:
    assert switched(heated(band=4.0))[1] > switched(heated())[1] + 0.05


# ---------------------------------------------------------------- refusals


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"cannot measure `temprature`.*`temperature`"):
        simulate_controlled(
            hanging_wire(), OnOff(measured="temprature", target=300.0, high=1.0), 1.0, 0.5
        )
    with pytest.raises(ParameterError, match="`band`"):
        on_off(band=-1.0)
    with pytest.raises(ParameterError, match="`delay`"):
        on_off(delay=-0.1)
    with pytest.raises(ParameterError, match="needs `high`"):
        OnOff(**{"measured": "angle", "target": 1.0})
