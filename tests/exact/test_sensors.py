"""What single sensors do; what all promise is in their suite.

Sources of truth: closed forms, numbers worked out by hand, and statistics.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from martensite.base.errors import InputError, ParameterError, UnitError
from martensite.control.sensors.base import SENSORS, AbstractSensor, Probe, simulate_readings
from martensite.control.sensors.channel import CurrentSensor, ForceSensor, GyroscopeSensor, TiltSensor
from martensite.control.sensors.position import EncoderSensor, IdealSensor, PositionSensor
from martensite.control.sensors.resistance import ResistanceSensor
from martensite.control.sensors.thermometer import InfraredSensor, ThermocoupleSensor
from martensite.kernels import floats

AMBIENT = 296.15


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_names() -> None:
    assert SENSORS.names() == [
        "current",
        "encoder",
        "force",
        "gyroscope",
        "ideal",
        "infrared",
        "position",
        "resistance",
        "thermocouple",
        "tilt",
        "voltage",
    ]


def test_a_step_of_temperature_is_followed_with_the_lag() -> None:
    sensor = InfraredSensor(noise=0.0, resolution=0.0)
    truth = np.full((500, 2), AMBIENT)
    truth[1:, 0] += 50.0
    found = simulate_readings(sensor, truth, 0.01, rng())
    times = 0.01 * np.arange(500)
    expected = AMBIENT + 0.6 * 50.0 * (1.0 - np.exp(-times / 0.25))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-10)


def test_it_starts_at_rest_and_drifts_with_time() -> None:
    sensor = InfraredSensor(noise=0.0, resolution=0.0, lag=1e-3, drift=0.01)
    truth = np.tile([AMBIENT + 100.0, AMBIENT], (11, 1))
    found = simulate_readings(sensor, truth, 1.0, rng())
    np.testing.assert_allclose(found, AMBIENT + 60.0 + np.arange(11.0), atol=1e-9)


@pytest.mark.parametrize(
    ("sensor", "truth"),
    [(PositionSensor(noise=3e-6), (2e-3,)), (InfraredSensor(noise=0.1), (AMBIENT, AMBIENT))],
    ids=["position", "infrared"],
)
def test_noise_has_its_size_and_readings_are_whole_steps(sensor: AbstractSensor, truth: tuple[float, ...]) -> None:
    found = simulate_readings(sensor, np.tile(truth, (20_000, 1)), 0.002, rng(1))
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
    whole = simulate_readings(sensor, truth, 0.002, rng(2))
    np.testing.assert_allclose(one_by_one, whole, rtol=0.0, atol=1e-9 * abs(whole[0]))


def test_without_a_resolution_nothing_is_rounded() -> None:
    sensor = PositionSensor(resolution=0.0, noise=0.0)
    assert sensor.digits(floats, 0.12345678) == 0.12345678
    assert Probe(sensor, rng()).read((0.12345678,), 0.0) == 0.12345678


def test_a_truth_of_the_wrong_width_is_refused() -> None:
    with pytest.raises(InputError, match="looks at temperature and ambient"):
        simulate_readings(InfraredSensor(), np.zeros((3, 1)), 0.1, rng())


# ---------------------------------------------------------------- one by one


def told(sensor: AbstractSensor, truth: object, interval: float = 0.01) -> np.ndarray:
    return simulate_readings(sensor, np.asarray(truth, float), interval, rng(5))


def test_an_ideal_sensor_says_the_truth() -> None:
    truth = rng(3).standard_normal(100)
    np.testing.assert_array_equal(told(IdealSensor(), truth), truth)


def test_backlash_keeps_the_slider_until_the_play_is_used_up() -> None:
    sensor = PositionSensor(noise=0.0, resolution=0.0, backlash=0.2)
    truth = [0.0, 0.05, 0.1, 0.5, 1.0, 0.9, 0.8, 0.5, 0.65, 0.7, 0.75]
    found = told(sensor, truth)
    expected = [0.0, 0.0, 0.0, 0.4, 0.9, 0.9, 0.9, 0.6, 0.6, 0.6, 0.65]
    np.testing.assert_allclose(found, expected, atol=1e-15)


def test_a_full_stroke_with_backlash_is_short_by_it() -> None:
    """A loop of the width of the play, whatever the amplitude."""
    truth = np.sin(np.linspace(0.0, 4.0 * math.pi, 4001))
    found = told(PositionSensor(noise=0.0, resolution=0.0, backlash=0.3), truth)[2000:]
    assert np.ptp(found) == pytest.approx(2.0 - 0.3)
    assert np.max(np.abs(found - truth[2000:])) == pytest.approx(0.15)


def test_the_zero_of_a_position_sensor_drifts() -> None:
    sensor = PositionSensor(noise=0.0, resolution=0.0, offset=1e-3, drift=-2e-4)
    found = told(sensor, np.full(11, 5e-3), 1.0)
    np.testing.assert_allclose(found, 6e-3 - 2e-4 * np.arange(11), rtol=1e-13)


def test_an_encoder_counts_four_edges_a_line() -> None:
    sensor = EncoderSensor(lines=500.0)
    assert sensor.resolution == pytest.approx(2.0 * math.pi / 2000.0)
    fine: Any = {"motion": "linear", "pitch": "20 um"}
    assert EncoderSensor(**fine).resolution == pytest.approx(5e-6)
    turn = np.linspace(0.0, 2.0 * math.pi, 100_001)
    found = told(sensor, turn)
    assert len(np.unique(np.round(found / sensor.resolution))) == 2001
    assert np.max(np.abs(found - turn)) <= 0.5 * sensor.resolution * (1.0 + 1e-9)
    assert found[-1] == pytest.approx(2.0 * math.pi)


def test_an_encoder_without_a_mark_counts_from_where_it_is_switched_on() -> None:
    sensor = EncoderSensor(motion="linear", pitch=4e-3, zero="start")
    found = told(sensor, [0.0104, 0.0113, 0.0115, 0.0084])
    np.testing.assert_allclose(found, [0.0, 1e-3, 1e-3, -2e-3], atol=1e-15)


@pytest.mark.parametrize("kelvin", [296.15, 330.0, 400.0])
def test_radiation_is_mixed_by_the_fourth_power(kelvin: float) -> None:
    sensor = InfraredSensor(noise=0.0, resolution=0.0, mixing="radiance", factor=0.5, emissivity=0.6, setting=0.8)
    (found,) = told(sensor, [(kelvin, AMBIENT)])
    expected = (AMBIENT**4 + 0.375 * (kelvin**4 - AMBIENT**4)) ** 0.25
    assert found == pytest.approx(expected, rel=1e-14)
    linear = told(sensor.with_parts(mixing="linear"), [(kelvin, AMBIENT)])[0]
    assert linear <= found
    assert linear == pytest.approx(AMBIENT + 0.375 * (kelvin - AMBIENT), rel=1e-14)


def test_a_thermometer_stops_at_the_ends_of_its_range() -> None:
    ends: Any = {"lowest": "0 degC", "highest": "100 degC"}
    sensor = InfraredSensor(noise=0.0, factor=1.0, lag=1e-9, **ends)
    found = told(sensor, [(250.0, 250.0), (300.0, 300.0), (400.0, 300.0)])
    np.testing.assert_allclose(found, [273.15, 300.0, 373.15], atol=1e-9)
    with pytest.raises(ParameterError, match="range of a thermometer must not be empty"):
        InfraredSensor(**{**ends, "lowest": "110 degC"})


def test_the_noise_of_a_thermometer_is_a_difference_of_temperatures() -> None:
    kelvin: Any = "0.2 K"
    assert InfraredSensor(noise=kelvin).noise == pytest.approx(0.2, rel=1e-15)
    celsius: Any = "0.2 degC"
    with pytest.raises(UnitError, match="degC"):
        InfraredSensor(noise=celsius)


def test_a_bead_stays_below_the_wire_and_follows_late() -> None:
    sensor = ThermocoupleSensor(noise=0.0, resolution=0.0, attachment=0.8, lag=0.5, offset=0.3)
    truth = np.full((101, 2), AMBIENT)
    truth[1:, 0] += 50.0
    times = 0.02 * np.arange(101)
    expected = AMBIENT + 0.3 + 40.0 * (1.0 - np.exp(-times / 0.5))
    np.testing.assert_allclose(told(sensor, truth, 0.02), expected, rtol=1e-14)


def test_a_gyroscope_follows_a_constant_rate_with_its_lag() -> None:
    sensor = GyroscopeSensor(noise=0.0, resolution=0.0, lag=0.05, bias=0.01)
    times = 0.002 * np.arange(200)
    expected = 0.01 + 3.0 * (1.0 - np.exp(-times / 0.05))
    np.testing.assert_allclose(told(sensor, 1.0 + 3.0 * times, 0.002), expected, atol=1e-11)


def test_the_integral_of_a_gyroscope_is_the_way_gone() -> None:
    sensor = GyroscopeSensor(noise=0.0, resolution=0.0, lag=0.0)
    angle = np.cumsum(rng(4).standard_normal(500)) * 1e-3
    found = told(sensor, angle, 0.01)
    np.testing.assert_allclose(np.cumsum(found) * 0.01, angle - angle[0], atol=1e-14)


def test_a_gyroscope_saturates() -> None:
    sensor = GyroscopeSensor(noise=0.0, range=1.0, lag=0.0)
    np.testing.assert_array_equal(told(sensor, [0.0, 1.0, -1.0]), [0.0, 1.0, -1.0])


def test_an_inclinometer_is_late_by_its_lag_on_a_ramp() -> None:
    times = 0.001 * np.arange(2000)
    found = told(TiltSensor(noise=0.0, resolution=0.0, lag=0.05), 0.2 * times, 0.001)
    assert found[-1] == pytest.approx(0.2 * (times[-1] - 0.05), abs=0.2 * 0.001)


def test_a_load_cell_bows_most_at_half_of_its_range() -> None:
    sensor = ForceSensor(noise=0.0, resolution=0.0, range=40.0, nonlinearity=0.01)
    force = np.linspace(-40.0, 40.0, 81)
    bow = told(sensor, force) - force
    assert force[np.argmax(bow)] == 20.0
    assert bow.max() == pytest.approx(0.4)
    np.testing.assert_allclose(bow, -bow[::-1], atol=1e-14)
    np.testing.assert_allclose(bow[[0, 40, 80]], 0.0, atol=1e-14)


def test_a_channel_has_errors_of_gain_and_offset() -> None:
    sensor = CurrentSensor(noise=0.0, resolution=0.0, gain_error=0.02, offset=-0.1, range=1.0)
    np.testing.assert_allclose(told(sensor, [0.5, 0.0, 2.0, -2.0]), [0.41, -0.1, 1.0, -1.0])


def test_resistance_is_measured_while_there_is_a_current() -> None:
    sensor = ResistanceSensor(relative_noise=0.0, least_current=0.1, first=7.0)
    truth = [(0.0, 0.0), (0.2, 0.05), (4.0, 0.5), (0.1, 0.05), (0.0, 0.0), (-3.0, -0.5)]
    np.testing.assert_allclose(told(sensor, truth), [7.0, 7.0, 8.0, 8.0, 8.0, 6.0])
    found = [sensor.valid(floats, row) for row in truth]
    assert found == [False, False, True, False, False, True]


def test_the_noise_of_a_resistance_is_a_share_of_it() -> None:
    sensor = ResistanceSensor(relative_noise=0.01, noise=0.02)
    truth = np.tile([4.0, 0.5], (20_000, 1))
    found = told(sensor, truth)
    assert np.std(found) == pytest.approx(math.hypot(0.08, 0.02), rel=0.02)
    assert np.mean(found) == pytest.approx(8.0, abs=4.0 * 0.083 / math.sqrt(20_000))
    truth[1::2] = 0.0
    kept = told(sensor, truth)
    np.testing.assert_array_equal(kept[1::2], kept[::2])
