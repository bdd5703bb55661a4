"""Sensors: lag, mixture, noise, rounding. Sources of truth: closed forms and statistics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from martensite.errors import InputError
from martensite.runtimes import floats
from martensite.runtimes.graph import VARYING
from martensite.runtimes.program import Function, Program
from martensite.sensors.base import SENSORS, AbstractSensor, Probe, readings
from martensite.sensors.infrared import InfraredSensor
from martensite.sensors.position import PositionSensor

AMBIENT = 296.15


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_names() -> None:
    assert SENSORS.names() == ["infrared", "position"]


def test_a_step_of_temperature_is_followed_with_the_lag() -> None:
    sensor = InfraredSensor(noise=0.0, resolution=0.0)
    truth = np.full((500, 2), AMBIENT)
    truth[1:, 0] += 50.0
    found = readings(sensor, truth, 0.01, rng())
    times = 0.01 * np.arange(500)
    expected = AMBIENT + 0.6 * 50.0 * (1.0 - np.exp(-times / 0.25))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-10)


def test_it_starts_at_rest_and_drifts_with_time() -> None:
    sensor = InfraredSensor(noise=0.0, resolution=0.0, lag=1e-3, drift=0.01)
    truth = np.tile([AMBIENT + 100.0, AMBIENT], (11, 1))
    found = readings(sensor, truth, 1.0, rng())
    np.testing.assert_allclose(found, AMBIENT + 60.0 + np.arange(11.0), atol=1e-9)


@pytest.mark.parametrize(
    ("sensor", "truth"),
    [
        (PositionSensor(noise=3e-6), (2e-3,)),
        (InfraredSensor(noise=0.1), (AMBIENT, AMBIENT)),
    ],
    ids=["position", "infrared"],
)
def test_noise_has_its_size_and_readings_are_whole_steps(
    sensor: AbstractSensor, truth: tuple[float, ...]
) -> None:
    found = readings(sensor, np.tile(truth, (20_000, 1)), 0.002, rng(1))
    steps = found / sensor.resolution
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    size = math.hypot(sensor.noise, sensor.resolution / math.sqrt(12.0))
    assert np.std(found) == pytest.approx(size, rel=0.03)
    assert np.mean(found) == pytest.approx(truth[0], abs=5.0 * size / math.sqrt(20_000))


def test_the_default_encoder_has_4096_steps_in_2_mm() -> None:
    assert PositionSensor().resolution * 4096 == pytest.approx(2e-3)


@pytest.mark.parametrize("sensor", [PositionSensor(), InfraredSensor()])
def test_a_probe_reads_what_a_whole_record_gives(sensor: AbstractSensor) -> None:
    truth = np.tile([AMBIENT + 30.0, AMBIENT], (3000, 1))[:, : len(sensor.sees)]
    truth[:, 0] += 10.0 * np.sin(0.01 * np.arange(3000))
    probe = Probe(sensor, rng(2))
    one_by_one = [probe.read(row, 0.002) for row in truth.tolist()]
    whole = readings(sensor, truth, 0.002, rng(2))
    np.testing.assert_allclose(one_by_one, whole, rtol=0.0, atol=1e-9 * abs(whole[0]))


def test_without_a_resolution_nothing_is_rounded() -> None:
    sensor = PositionSensor(resolution=0.0, noise=0.0)
    assert sensor.digits(0.12345678) == 0.12345678
    assert Probe(sensor, rng()).read((0.12345678,), 0.0) == 0.12345678


def test_a_truth_of_the_wrong_width_is_refused() -> None:
    with pytest.raises(InputError, match="looks at temperature and ambient"):
        readings(InfraredSensor(), np.zeros((3, 1)), 0.1, rng())


@pytest.mark.parametrize("name", SENSORS.names())
def test_kernels_trace_and_agree_with_floats(name: str) -> None:
    made: Any = SENSORS[name]
    sensor = made()
    width = len(sensor.sees)
    held = len(sensor.rest(floats, [300.0] * width))
    names = [f"x{k}" for k in range(width + held + 2)]
    program = Program()
    inputs = [program.graph.input(n, VARYING) for n in names]

    def kernel(xp, values):
        state, truth = values[:held], values[held : held + width]
        value, after = sensor.step(xp, state, truth, *values[held + width :])
        return value, *after

    made_of: Any = tuple(kernel(program.xp, inputs))
    program.functions["kernel"] = Function("kernel", tuple(names), made_of)
    numbers = [310.0, 3.0, 350.0, 296.0, 0.7, 0.002][-len(names) :]
    found = program.bind_floats()["kernel"](*numbers)
    assert found == pytest.approx(kernel(floats, numbers), rel=1e-14)
