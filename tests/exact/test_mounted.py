"""A sensor on a bench: sample time, delay, jitter, ages, faults, and what is kept for them.

Source of truth: messages with their times of sending and arrival, followed one by one. The
register of the kernel must tell the same.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from builders import problem_a
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from martensite.base.errors import ParameterError
from martensite.base.parameters import text
from martensite.control.controllers.relay import OnOff
from martensite.control.faults.base import AbstractFault
from martensite.control.faults.sensor import Stuck
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import NEVER, WORST, Controllers, MountedSensor, SensorFaults, Sensors, SensorState
from martensite.control.loop.run import simulate_bench
from martensite.control.sensors.channel import CurrentSensor
from martensite.control.sensors.position import IdealSensor, PositionSensor
from martensite.control.sensors.resistance import ResistanceSensor
from martensite.control.sensors.thermometer import InfraredSensor
from martensite.kernels import floats
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.constant import Constant
from martensite.simulate.result import Result

PERIOD = 0.01
HAIR = 1e-6
COUNT = 60


class Silent(AbstractFault):
    """A sensor that sends nothing."""

    sensor: str = text("name of the sensor")

    def fresh(self, xp: Any, sensor: str, fresh: Any, active: Any) -> Any:
        gone = xp.both(active, sensor == self.sensor)
        return xp.both(fresh, xp.negate(gone))


def followed(
    mounted: MountedSensor, truth: Any, late: Any = None, faults: tuple[AbstractFault, ...] = (), period: float = PERIOD
) -> list[SensorState]:
    """The sensor from rest along a record of what it looks at."""
    rows = np.atleast_2d(np.asarray(truth, float).T).T.tolist()
    late = np.zeros(len(rows)) if late is None else late
    known = [dict(zip(mounted.sees(), row, strict=True)) for row in rows]
    held = mounted.rest(floats, known[0], 0.0, mounted.count_delayed(period))
    found = [held]
    for k in range(1, len(rows)):
        active = [(fault, fault.active(floats, k * period)) for fault in faults]
        numbers = 0.0, float(late[k])
        held = mounted.step(floats, held, known[k], numbers, period, SensorFaults("it", active))
        found.append(held)
    return found


def arrived(mounted: MountedSensor, late: Any, period: float = PERIOD) -> np.ndarray:
    """When what counts in each period was made [periods], by messages one by one.

    What was made before the run is taken to have been made in every period.
    """
    every = max(1, math.ceil(mounted.sample_time / period - HAIR))
    sent = [(k, mounted.delay / period) for k in range(-COUNT, 1)]
    for k in range(every, len(late), every):
        travel = mounted.delay + mounted.jitter * float(np.clip(late[k], -WORST, WORST))
        sent.append((k, travel / period))
    newest = [max(k for k, t in sent if k + max(t, 0.0) <= n + HAIR) for n in range(len(late))]
    return np.array(newest)


def ideal(**timing: Any) -> MountedSensor:
    return MountedSensor(sensor=IdealSensor(), **timing)


RAMP = np.arange(COUNT) * 1.0


def check(mounted: MountedSensor, late: Any = None, begun: int = 1) -> None:
    """Readings and ages are those of the messages; on a ramp a reading is when it was made."""
    late = np.zeros(COUNT) if late is None else late
    made = arrived(mounted, late)
    found = followed(mounted, RAMP, late)[begun:]
    np.testing.assert_array_equal([one.reading for one in found], np.maximum(made, 0)[begun:])
    ages = PERIOD * (np.arange(COUNT) - made)[begun:]
    np.testing.assert_allclose([one.age for one in found], ages, atol=1e-12)


# ---------------------------------------------------------------- delay and sample time


def test_without_a_delay_it_says_the_truth_at_once() -> None:
    found = followed(ideal(), RAMP)
    assert [one.reading for one in found] == RAMP.tolist()
    assert all(one.age == 0.0 and len(one.past) == 1 for one in found)


@pytest.mark.parametrize(
    ("delay", "periods"), [(0.01, 1), (0.03, 3), (0.2, 20), (0.004, 1), (0.0101, 2), (0.025, 3), (0.07, 7)]
)
def test_a_delay_shifts_the_record_by_whole_periods(delay: float, periods: int) -> None:
    mounted = ideal(delay=delay)
    assert mounted.count_delayed(PERIOD) == periods + 1
    truth = np.random.default_rng(2).standard_normal(COUNT)
    found = followed(mounted, truth)
    shifted = np.concatenate([np.full(periods, truth[0]), truth[:-periods]])
    np.testing.assert_array_equal([one.reading for one in found], shifted)
    ages = [one.age for one in found[1:]]
    np.testing.assert_allclose(ages, periods * PERIOD, rtol=1e-12)
    check(mounted)


@pytest.mark.parametrize(("time", "every"), [(0.0, 1), (0.01, 1), (0.03, 3), (0.025, 3), (0.07, 7)])
def test_between_samples_the_last_reading_counts(time: float, every: int) -> None:
    found = followed(ideal(sample_time=time), RAMP)
    assert [one.reading for one in found] == [float(k - k % every) for k in range(COUNT)]
    np.testing.assert_allclose([o.age for o in found], PERIOD * (RAMP % every), atol=1e-12)


@settings(max_examples=60)
@given(
    delay=st.floats(0.0, 0.05),
    time=st.floats(0.0, 0.05),
    jitter=st.just(0.0) | st.floats(1e-4, 0.02),  # a message within a hair of a period may count in it or not
    seed=st.integers(0, 1000),
)
def test_readings_arrive_as_messages_do(delay: float, time: float, jitter: float, seed: int) -> None:
    mounted = ideal(delay=delay, sample_time=time, jitter=jitter)
    late = np.random.default_rng(seed).standard_normal(COUNT)
    travels = (delay + jitter * np.clip(late, -WORST, WORST)) / PERIOD
    assume(jitter == 0.0 or np.min(np.abs(travels - np.round(travels))) > 10.0 * HAIR)
    check(mounted, late)


# ---------------------------------------------------------------- jitter


def test_what_arrives_never_goes_back_in_time_and_keeps_its_bounds() -> None:
    late = 3.0 * np.random.default_rng(1).standard_normal(2000)  # many beyond the limit of 4
    found = followed(ideal(delay=0.05, jitter=0.01), np.arange(2000.0), late)
    made = np.array([one.reading for one in found])
    assert (np.diff(made) >= 0.0).all()
    ages = np.array([one.age for one in found[1:]])
    assert ages.min() >= 0.05 - WORST * 0.01 - 1e-12
    assert ages.max() <= 0.05 + WORST * 0.01 + 1e-12
    assert ages.max() - ages.min() > 0.05


@pytest.mark.parametrize(("number", "periods"), [(4.0, 9), (99.0, 9), (-99.0, 1), (-2.5, 3)])
def test_the_register_holds_the_latest_of_all(number: float, periods: int) -> None:
    mounted = ideal(delay=0.05, jitter=0.01)
    assert mounted.count_delayed(PERIOD) == 10
    ages = [one.age for one in followed(mounted, RAMP, np.full(COUNT, number))[20:]]
    np.testing.assert_allclose(ages, periods * PERIOD, rtol=1e-12)


def test_a_delay_is_never_negative() -> None:
    found = followed(ideal(delay=0.01, jitter=0.01), RAMP, np.full(COUNT, -4.0))
    assert [one.reading for one in found[2:]] == RAMP[2:].tolist()


def test_ages_spread_as_normal_numbers_say() -> None:
    """No message younger than m periods has arrived: Π P(travel > k periods) over k < m."""
    delay, jitter, count = 20.0, 3.0, 20_000
    late = np.random.default_rng(8).standard_normal(count)
    mounted = ideal(delay=delay, jitter=jitter)
    found = followed(mounted, np.arange(float(count)), late, period=1.0)
    ages = np.array([one.age for one in found[40:]])
    beyond = [0.5 * math.erfc((k - delay) / jitter / math.sqrt(2.0)) for k in range(40)]
    older = np.cumprod(beyond)  # P(age > k)
    mean = older.sum()
    spread = math.sqrt(2.0 * (np.arange(40) * older).sum() + mean - mean**2)
    independent = math.sqrt(len(ages) / 10.0)  # neighbours see the same messages
    assert abs(ages.mean() - mean) < 4.0 * spread / independent
    assert abs(ages.std() / spread - 1.0) < 4.0 / math.sqrt(2.0) / independent
    assert mean < delay  # a lucky message overtakes those before


# ---------------------------------------------------------------- faults, nothing to measure


def test_a_silent_sensor_keeps_its_reading_which_gets_older() -> None:
    silent = Silent(sensor="it", start=0.1, end=0.25)
    found = followed(ideal(), RAMP, faults=(silent,))
    expected = [9.0 if 10 <= k < 25 else float(k) for k in range(COUNT)]
    assert [one.reading for one in found] == expected
    np.testing.assert_allclose([one.age for one in found], PERIOD * (RAMP - expected), atol=1e-12)


def test_a_silence_arrives_late_as_well() -> None:
    found = followed(ideal(delay=0.03), RAMP, faults=(Silent(sensor="it", start=0.1, end=0.25),))
    expected = [9.0 if 13 <= k < 28 else max(k - 3.0, 0.0) for k in range(COUNT)]
    assert [one.reading for one in found] == expected
    assert found[27].age == pytest.approx(0.18)


def test_a_stuck_sensor_goes_on_as_if_it_were_new() -> None:
    found = followed(ideal(), RAMP, faults=(Stuck(sensor="it", start=0.1, end=0.25),))
    assert [one.reading for one in found[10:25]] == [9.0] * 15
    assert found[25].reading == 25.0
    assert all(one.age == 0.0 for one in found)


def test_a_fault_of_another_sensor_changes_nothing() -> None:
    faults = Stuck(sensor="other"), Silent(sensor="other")
    assert followed(ideal(), RAMP, faults=faults) == followed(ideal(), RAMP)


def test_without_a_current_there_is_no_new_resistance() -> None:
    mounted = MountedSensor(sensor=ResistanceSensor(relative_noise=0.0), delay=0.01)
    current = np.where((RAMP < 5) | (RAMP % 10 >= 7), 0.0, 0.5)
    found = followed(mounted, np.column_stack([current * (8.0 + 0.01 * RAMP), current]))
    assert all(one.reading == 0.0 and one.age >= NEVER for one in found[:6])
    last = 5
    for k in range(6, COUNT):
        last = k - 1 if current[k - 1] else last
        assert found[k].reading == pytest.approx(8.0 + 0.01 * last, rel=1e-14)
        assert found[k].age == pytest.approx(PERIOD * (k - last), rel=1e-12)


def test_with_a_sample_time_it_measures_as_soon_as_there_is_a_current() -> None:
    mounted = MountedSensor(sensor=ResistanceSensor(relative_noise=0.0), sample_time=0.05)
    current = np.where(RAMP < 7, 0.0, 0.5)
    found = followed(mounted, np.column_stack([8.0 * current, current]))
    assert [one.age < NEVER for one in found] == [k >= 7 for k in range(COUNT)]
    assert [k for k, one in enumerate(found) if one.age == 0.0][:3] == [7, 12, 17]


def test_as_many_outputs_are_named_as_a_sensor_looks_at() -> None:
    assert MountedSensor(sensor=IdealSensor(), of="angle").sees() == ("angle",)
    two = MountedSensor(sensor=InfraredSensor(), of=("left.temperature", "left.ambient"))
    assert two.sees() == ("left.temperature", "left.ambient")
    with pytest.raises(ParameterError, match="temperature and ambient: `of` must name 2, but is h"):
        MountedSensor(sensor=InfraredSensor(), of="hottest")


# ---------------------------------------------------------------- on other runtimes


BENCH = Bench(
    plant=problem_a().with_parts(source=PwmVoltage(supply=6.0)),
    period=0.05,
    substeps=2,
    sensors=Sensors(
        place=MountedSensor(sensor=PositionSensor(backlash=1e-4), delay=0.1),
        late=MountedSensor(sensor=IdealSensor(), delay=0.15),
        slow=MountedSensor(sensor=IdealSensor(), of="temperature", sample_time=0.2, jitter=0.02),
        heat=MountedSensor(sensor=InfraredSensor(mixing="radiance"), delay=0.02, jitter=0.01),
        ohms=MountedSensor(sensor=ResistanceSensor(least_current=0.1)),
        amps=MountedSensor(sensor=CurrentSensor(lag=0.05)),
    ),
    controllers=Controllers(drive=OnOff(measured="place", reference=Constant(level=4e-3), high=0.8, band=1e-3)),
)


def on_the_bench(runtime: str) -> Result:
    return simulate_bench(BENCH, 4.0, seed=3, runtime=runtime)


@pytest.fixture(scope="module")
def run() -> Result:
    return on_the_bench("floats")


def test_on_a_bench_a_delay_is_a_shift_of_the_record(run: Result) -> None:
    truth, late = np.asarray(run["position"]), np.asarray(run["measured.late"])
    assert np.ptp(truth) > 3e-3
    np.testing.assert_array_equal(late[3:], truth[:-3])
    np.testing.assert_array_equal(late[:3], truth[0])


def test_on_a_bench_resistance_is_kept_while_there_is_no_current(run: Result) -> None:
    ohms, current = np.asarray(run["measured.ohms"]), np.asarray(run["current"])
    truth = np.asarray(run["resistance"])
    assert ohms[0] == 0.0
    off = np.flatnonzero(np.diff(ohms) == 0.0)
    assert len(off) > 10
    assert (np.minimum(current[off], current[off + 1]) < 0.1).all()
    new = np.flatnonzero(np.diff(ohms) != 0.0) + 1
    assert np.std(ohms[new] / truth[new] - 1.0) == pytest.approx(0.01, rel=0.5)


# ---------------------------------------------------------------- the checks can fail
