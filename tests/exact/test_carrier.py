"""The carrier: pulses at exact times, duties held from the start of a period, shortest pulses."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from builders import hanging_wire
from one_wire import cool, hang, write_wire
from typer.testing import CliRunner

from martensite.base.errors import InputError, ParameterError, UnitError
from martensite.cli import app
from martensite.physics.electrical.sources import VoltageSource
from martensite.physics.electrical.switches import PwmVoltage
from martensite.scenario.scenario import read_scenario
from martensite.signals.carrier import Carrier, limit_duty
from martensite.signals.constant import Constant
from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.ramp import Ramp
from martensite.simulate.api import simulate
from martensite.simulate.batch import simulate_batch


@pytest.mark.parametrize("duty", [0.1, 0.3, 1.0 / 3.0, 0.9])
@pytest.mark.parametrize("frequency", [0.7, 10.0, 100.0])
def test_a_constant_duty_is_pulse_width_modulation(duty: float, frequency: float) -> None:
    carrier = Carrier(duty=Constant(level=duty), frequency=frequency)
    pwm = PulseWidthModulation(high=1.0, frequency=frequency, duty=duty)
    assert carrier.edges(7.3) == pwm.edges(7.3)
    for edge in [0.0, *pwm.edges(7.3)]:
        for time in (edge, math.nextafter(edge, 9.0), math.nextafter(edge, 0.0)):
            assert carrier.value(time) == pwm.value(time)


def test_the_duty_is_read_at_the_start_of_a_period_and_held() -> None:
    carrier = Carrier(duty=Ramp(high=1.0, end=1.0), frequency=4.0)
    assert carrier.edges(1.0) == [0.25, 0.25 + 0.0625, 0.5, 0.625, 0.75, 0.75 + 0.1875]
    assert [carrier.value(t) for t in (0.0, 0.25, 0.3124, 0.3125)] == [0.0, 1.0, 1.0, 0.0]


@pytest.mark.parametrize(("duty", "level"), [(0.0, 0.0), (-2.0, 0.0), (1.0, 1.0), (3.0, 1.0)])
def test_never_and_always_on(duty: float, level: float) -> None:
    carrier = Carrier(duty=Constant(level=duty), frequency=3.0)
    assert {carrier.value(t / 97) for t in range(300)} == {level}


@pytest.mark.parametrize(
    ("duty", "share"),
    [
        (0.0, 0.0),
        (0.04, 0.0),
        (0.05, 0.1),
        (0.1, 0.1),
        (0.3, 0.3),
        (0.9, 0.9),
        (0.93, 0.9),
        (0.96, 1.0),
        (1.0, 1.0),
        (1.5, 1.0),
    ],
)
def test_short_pulses_and_gaps_are_rounded(duty: float, share: float) -> None:
    assert limit_duty(duty, 0.1) == pytest.approx(share, abs=1e-15)


def test_a_pulse_longer_than_half_a_period_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"at most half a period, 0.005 s, but is 0.006 s"):
        Carrier(duty=Constant(level=0.5), frequency=100.0, shortest=0.006)


def test_too_many_pulses_are_refused() -> None:
    with pytest.raises(ParameterError, match="lower frequency"):
        Carrier(duty=Constant(level=0.5), frequency=1e8).edges(100.0)


def test_a_carrier_drives_a_switch_only() -> None:
    carrier = Carrier(duty=Constant(level=0.5), frequency=10.0)
    volts = hanging_wire(source=VoltageSource())
    with pytest.raises(UnitError, match="is a plain number, but the drive needs V"):
        simulate(volts, carrier, 1.0)
    with pytest.raises(UnitError, match="For a duty cycle, use the drive `pwm-voltage`"):
        simulate_batch(volts, carrier, 1.0, {"voltage_limit": [5.0]}, step=0.1)
    assert simulate(hanging_wire(source=PwmVoltage(supply=1.0)), carrier, 1.0, step=0.1)


# ---------------------------------------------------------------- in scenarios

SCENARIO = write_wire(
    diameter="0.381 mm",
    length="250 mm",
    cooling=cool(60),
    mechanism=hang("500 g"),
    drive='kind = "power-pwm"\nsupply = "5 V"\nseries_resistance = "0.3 ohm"\n'
    'waveform = { kind = "ramp", high = "20 W", end = "4 s" }',
    run='duration = "3 s"\ntolerance = 1e-3',
)
NESTED = """kind = "pwm-voltage"
supply = "5 V"
series_resistance = "0.3 ohm"
waveform = { kind = "carrier", frequency = "50 Hz", duty = { kind = "ramp", high = "30 %", \
end = "4 s" } }
"""


def nested() -> str:
    head, _, tail = SCENARIO.partition("[drive]\n")
    return head + "[drive]\n" + NESTED + tail[tail.index("[run]") :]


def test_a_waveform_may_hold_another() -> None:
    scenario = read_scenario(nested())
    assert scenario.waveform == Carrier(duty=Ramp(high=0.3, end=4.0), frequency=50.0)
    assert scenario.origins["drive.waveform.duty.high"] == "scenario"
    assert scenario.run().stroke >= 0.0


def test_a_carrier_on_another_drive_is_refused_with_its_section() -> None:
    text = nested().replace('kind = "pwm-voltage"', 'kind = "power-pwm"')
    with pytest.raises(InputError, match=r"\[drive.waveform\] The signal of waveform `carrier`"):
        read_scenario(text)


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "wire.toml").write_text(SCENARIO, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return "wire.toml"


def test_run_tells_what_averaging_leaves_out(file: str) -> None:
    asked = ["run", file, "--no-figure", "--force", "--carrier", "100 Hz"]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 0, done.output
    assert "pulses - average" in done.stdout
    assert "Pulses of 100 Hz cause a temperature ripple of up to 0.15" in " ".join(done.stdout.split())
    found = json.loads(CliRunner().invoke(app, [*asked, "--json"]).stdout)
    assert found["averaging"]["frequency"] == 100.0
    assert set(found["averaging"]["differences"]) == {"temperature", "position", "power"}
    assert found["averaging"]["ripple"] == pytest.approx(found["averaging"]["estimate"], rel=0.02)
    (alarm,) = found["alarms"]
    assert (alarm["kind"], alarm["worst"], alarm["unit"]) == ("supply", 15.0, "W")
    assert alarm["sentence"] in found["warnings"]
    (pulsed,) = found["averaging"]["alarms"]
    assert pulsed["first"] == pytest.approx(alarm["first"], abs=0.02)


def test_run_without_a_carrier_says_nothing_of_it(file: str) -> None:
    done = CliRunner().invoke(app, ["run", file, "--no-figure", "--json"])
    assert json.loads(done.stdout)["averaging"] is None


@pytest.mark.parametrize(("frequency", "sentence"), [("100", "Hz"), ("0.1 Hz", "at least one period"), ("100 V", "Hz")])
def test_a_wrong_frequency_is_refused(file: str, frequency: str, sentence: str) -> None:
    done = CliRunner().invoke(app, ["run", file, "--no-figure", "--carrier", frequency])
    assert done.exit_code == 2
    assert sentence in done.stderr
    assert not Path("wire.nc").exists()
