"""`martensite fit vibration` and `fit motor`: columns, units, printed numbers, bad input.

Source of truth: the options and columns as documented, and records in closed form.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from command import Command

R, K, B, F_C, TAU = 6.0, 0.02, 2e-6, 4e-4, 1.5
VIBRATION = ("vibration", "beam.csv")
MOTOR = ("motor", "steady.csv")
FIT = Command("fit")
fine, report, refused = FIT.fine, FIT.report, FIT.refused


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    times = np.arange(1000) / 250.0
    deflection = 9.0 * np.exp(-times) * np.cos(2 * np.pi * 8.0 * times)
    table("beam.csv", "time [s],position [mm]", times, deflection)
    currents = np.array([0.1, 0.2, 0.3, 0.4])
    table("locked.csv", "voltage [V],current [mA]", R * currents, 1e3 * currents)
    speeds = np.array([50.0, 100.0, 200.0, 300.0])
    currents = (B * speeds + F_C) / K
    table(
        "steady.csv",
        "voltage [V],current [mA],speed [rpm]",
        R * currents + K * speeds,
        1e3 * currents,
        speeds * 30.0 / math.pi,
    )
    times = np.linspace(0.0, 6.0, 60)
    table("run_up.csv", "time [ms],speed [rad/s]", 1e3 * times, 250 * (1 - np.exp(-times / TAU)))
    table("rise.csv", "time [s],current [A]", times, 1 - np.exp(-times / 0.2))
    return tmp_path


def table(name: str, headings: str, *columns: np.ndarray) -> None:
    rows = (",".join(f"{number:.12g}" for number in row) for row in zip(*columns, strict=True))
    Path(name).write_text("\n".join([headings, *rows, ""]), encoding="utf-8")


# ---------------------------------------------------------------- vibration


def test_vibration() -> None:
    omega = math.hypot(2 * math.pi * 8.0, 1.0)
    found = report(*VIBRATION, "--stiffness", "0.5401 N/mm")
    assert found["decay"]["zeta"]["value"] == pytest.approx(1.0 / omega, rel=1e-5)
    assert found["decay"]["damped_frequency"]["value"] == pytest.approx(8.0, rel=1e-6)
    assert found["spectrum"]["resolution"] == pytest.approx(0.25)
    mass = 540.1 / omega**2
    assert found["derived"]["moving_mass"]["value"] == pytest.approx(mass, rel=1e-5)
    assert found["derived"]["damping"]["value"] == pytest.approx(2.0 * mass, rel=1e-5)
    by_mass = report(*VIBRATION, "--mass", f"{1e3 * mass:.9g} g")["derived"]
    assert by_mass["stiffness"]["value"] == pytest.approx(540.1, rel=1e-5)
    assert by_mass["damping"]["value"] == pytest.approx(2.0 * mass, rel=1e-5)
    assert report(*VIBRATION)["derived"] == {}


def test_what_is_printed_of_a_vibration() -> None:
    text = fine(*VIBRATION, "--stiffness", "540.1 N/m", "--cycles", "10")
    for part in (
        "`position` [m], 1000 rows, 10 cycles",
        "resolution 0.25 Hz",
        "damped frequency",
        "moving mass",
        "N*s/m",
    ):
        assert part in text
    assert "moving mass" not in fine(*VIBRATION)


def test_part_of_a_record() -> None:
    times = np.arange(1000) / 250.0
    held = np.where(times < 1.0, 9.0, 9.0 * np.cos(2 * np.pi * 8.0 * (times - 1.0)))
    table("held.csv", "time [s],position [mm],force [N]", times, held, held)
    assert "Give --column: record `held` has 2 columns" in refused("vibration", "held.csv")
    options = ("vibration", "held.csv", "--column", "position", "--start", "1 s")
    found = report(*options, "--end", "3500 ms")
    assert found["decay"]["extreme_times"][0] > 1.0
    assert found["decay"]["extreme_times"][-1] < 3.5
    assert "No vibration stands out" in refused(*options, "--end", "1.08 s")
    assert "no rows between" in refused(*options, "--end", "0.5 s")
    assert "no column `speed`" in refused("vibration", "held.csv", "--column", "speed")


def test_bad_vibrations() -> None:
    assert "not both" in refused(*VIBRATION, "--mass", "1 kg", "--stiffness", "540 N/m")
    assert "`--mass` must be above 0" in refused(*VIBRATION, "--mass", "0 kg")
    assert "`--stiffness`" in refused(*VIBRATION, "--stiffness", "540 kg")
    assert "`cycles` must be at least 2" in refused(*VIBRATION, "--cycles", "1")
    assert "Did you mean `beam.csv`" in refused("vibration", "beams.csv")
    assert "no column `time`" in refused("vibration", "locked.csv", "--column", "current")
    assert "No vibration stands out" in refused("vibration", "run_up.csv")
    Path("bare.csv").write_text("time,position [mm]\n0,1\n", encoding="utf-8")
    assert "its column of time holds 1 times" in refused("vibration", "bare.csv")


# ---------------------------------------------------------------- motor


def test_motor() -> None:
    found = report(*MOTOR, "--locked", "locked.csv", "--current-rise", "rise.csv", "--run-up", "run_up.csv")
    coil = 0.2 * R
    inertia = TAU * (B + K**2 / (R - coil / TAU))
    truth = {"resistance": R, "constant": K, "friction": B, "dry_friction": F_C, "inductance": coil, "inertia": inertia}
    for name, value in truth.items():
        assert found[name]["value"] == pytest.approx(value, rel=1e-7)
    assert found["run_up_time"] == pytest.approx(R * inertia / K**2)
    assert found["remarks"] == []


def test_numbers_that_are_given() -> None:
    found = report(*MOTOR, "--resistance", "6 ohm", "--inductance", "3.1 mH")
    assert found["resistance"] == {"value": 6.0, "standard_error": 0.0, "interval": [6.0, 6.0]}
    assert found["inductance"]["value"] == pytest.approx(3.1e-3)
    assert (found["inertia"], found["run_up_time"]) == (None, None)


def test_what_is_printed_of_a_motor() -> None:
    text = fine(*MOTOR, "--resistance", "6 ohm", "--run-up", "run_up.csv")
    for part in (
        "DC motor from 4 steady states",
        "K_T = K_B",
        "N*m/A",
        "F_c, dry friction",
        "J, inertia",
        "kg*m^2",
        "R J/(K_T K_B) = 1.5",
    ):
        assert part in text
    assert "inductance" not in text


def test_bad_motors() -> None:
    assert "resistance in one way" in refused(*MOTOR)
    assert "resistance in one way" in refused(*MOTOR, "--locked", "locked.csv", "--resistance", "6 ohm")
    given = (*MOTOR, "--resistance", "6 ohm")
    assert "not both" in refused(*given, "--inductance", "3 mH", "--current-rise", "rise.csv")
    assert "`--inductance` must be above 0" in refused(*given, "--inductance", "0 H")
    assert "`--resistance`" in refused(*MOTOR, "--resistance", "6 V")
    assert "motor constant K is" in refused(*MOTOR, "--resistance", "600 ohm")
    assert "no column `speed`" in refused(*given, "--run-up", "rise.csv")
    assert "no column `time`" in refused(*given, "--run-up", "steady.csv")
    assert "no column `voltage`" in refused("motor", "beam.csv", "--resistance", "6 ohm")
    assert "There is no file" in refused("motor", "absent.csv", "--resistance", "6 ohm")


def test_a_speed_in_hertz_is_refused() -> None:
    table("steady.csv", "voltage [V],current [A],speed [Hz]", *np.ones((3, 3)))
    assert "must be in rad/s or rpm" in refused(*MOTOR, "--resistance", "6 ohm")
