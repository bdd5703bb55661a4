"""Runs that start elsewhere than at home and at rest.

Source of truth: the free vibration of a damped beam and the energy of what nothing brakes, in closed form; the law and
the balance of forces, for what follows from what is given; the same place reached in another way.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from martensite.actuators.assembly import Machine
from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.base.errors import InputError
from martensite.characterise.free_vibration import log_decrement
from martensite.scenario.running import run
from martensite.scenario.scenario import load
from martensite.signals.constant import Constant
from martensite.simulate.result import Result

EXAMPLES = Path(__file__).parents[2] / "examples"
THESIS: dict[str, Any] = {
    "mass": 0.1961,
    "stiffness": 541.0,
    "damping": 0.2335,
    "unbalance": 0.012,
    "eccentricity": 0.02,
    "rotor_inertia": 0.82e-4,
    "rotor_friction": 8.17e-7,
    "torque_constant": 0.0211,
    "back_emf": 0.0211,
    "resistance": 6.22,
    "inductance": 3.1e-3,
}
"""Beam and motor of Kossoski (2018), as calibrated for the study `sommerfeld`."""
FREE = {"damping": 0.0, "rotor_friction": 0.0, "torque_constant": 0.0, "back_emf": 0.0}
SPEED = 60.0


def swing(changes: dict[str, Any], duration: float, **how: Any) -> Result:
    """The beam with its motor, without a voltage."""
    return run(Machine(mechanism=BeamMotor(**(THESIS | changes))), {"motor": Constant(level=0.0)}, duration, **how)


def test_free_decay_of_the_beam_has_the_frequency_and_damping_of_its_numbers() -> None:
    """The rotor stands at right angles, where the unbalance neither drives it nor is driven."""
    found = swing({}, 2.0, samples=1001, initial={"displacement": "9 mm", "rotor_angle": "90 deg"})
    seen = log_decrement(found.times.tolist(), found["displacement"].tolist())
    omega = math.sqrt(THESIS["stiffness"] / THESIS["mass"])
    assert seen.frequency.value == pytest.approx(omega / (2.0 * math.pi), rel=1e-4)
    assert seen.zeta.value == pytest.approx(0.5 * THESIS["damping"] / (THESIS["mass"] * omega), rel=1e-4)
    assert found.work is not None and found.work.residual is not None and found.work.residual < 1e-3


def test_rotor_that_nothing_brakes_keeps_its_energy_over_ten_thousand_turns() -> None:
    """Balanced, and so alone: steps are as long as the tolerance lets them be, and rounding has no time to gather."""
    end = 1e4 * 2.0 * math.pi / SPEED
    found = swing(FREE | {"unbalance": 0.0}, end, samples=101, initial={"rotor_speed": SPEED})
    assert np.abs(found["rotor_speed"] ** 2 / SPEED**2 - 1.0).max() < 1e-9
    assert found["rotor_angle"][-1] == pytest.approx(SPEED * end, rel=1e-9)


def test_finger_that_is_let_go_comes_to_rest_where_it_was_assembled() -> None:
    """With inertia and damping, its cold wire slack while it is bent; damping takes what the spring held."""
    changes = {
        "mechanism.motion": "dynamic",
        "mechanism.damping": "6e-4 N*m*s/rad",
        "drive.waveform": {"kind": "constant", "level": "0 W"},
    }
    scenario = load(EXAMPLES / "finger.toml", changes | {"run.duration": "0.5 s", "run.samples": 51})
    found = run(scenario, initial={"angle": "30 deg"}, tolerance=1e-3)
    assert found["angle"][0] == pytest.approx(math.radians(30.0)) and found["force"][0] == 0.0
    assert abs(found["angle"][-1]) < 0.01 and found["angle"].min() < 0.0
    assert found.work is not None and found.work.residual is not None and found.work.residual < 1e-3


def test_a_given_temperature_and_phase_are_those_at_the_start_and_the_rest_follows() -> None:
    scenario = load(EXAMPLES / "pwm_bias_spring.toml")
    hot = run(scenario, duration=1.0, samples=3, initial={"temperature": "120 degC", "martensite_fraction": 0.0})
    cold = run(scenario, duration=1.0, samples=3)
    assert (hot["temperature"][0], hot["martensite_fraction"][0]) == (393.15, 0.0)
    spring = scenario.system.mechanism
    assert hot["force"][0] == pytest.approx(spring.preload + spring.stiffness * hot["position"][0], rel=1e-12)  # type: ignore[attr-defined]
    length = scenario.single_system.element.wire_length()  # type: ignore[attr-defined]
    shorter = (cold["strain"][0] - hot["strain"][0]) * length
    assert hot["position"][0] == pytest.approx(shorter, rel=1e-9) and shorter > 5e-3


@pytest.mark.parametrize(
    "example, initial, said",
    [
        ("finger", {"angel": 1.0}, "Did you mean `angle`"),
        ("finger", {"angle": "3 m"}, "`angle`: "),
        ("finger", {"angle": "3 deg"}, "neither inertia nor damping"),
        ("finger", {"temperature": "20 degC", "martensite_fraction": 1.2}, "must be 0 to 1, but is 1.2"),
        ("platform_spring", {"oriented_fraction": 0.5}, "knows oriented martensite only"),
        ("finger", {"temperature": "150 degC"}, "does not keep a martensite fraction of 1"),
        ("finger", {"temperature": "9000 degC", "martensite_fraction": 0.0}, "melting point of NiTi"),
        ("hand", {"thumb_distal_flexor": {"temprature": 300.0}}, "Did you mean `temperature`"),
        ("tensile-test", {"temperature": "20 degC"}, "prescribed by its drive"),
        ("clamped_wire", {"martensite_fraction": 0.5}, "is not uniform"),
        ("closed_loop", {"temperature": "20 degC"}, "no effect on a bench"),
        ("finger", {"at": "equilibrum"}, "Did you mean `equilibrium`"),
        ("finger", {"at": "equilibrium", "angle": 0.1}, "give either `at` or values"),
        ("finger", {"at": "settled cycle"}, 'period = "2 s"'),
        ("finger", {"at": "settled cycle", "period": "2 s"}, "does not repeat"),
    ],
)
def test_what_cannot_be_at_the_start_is_refused_in_a_sentence(example: str, initial: Any, said: str) -> None:
    with pytest.raises(InputError, match=r"\[initial\]") as caught:
        run(EXAMPLES / f"{example}.toml", initial=initial)
    assert said in str(caught.value)


FAN = {
    "environment.cooling": {"kind": "fan"},
    "signals.fan": {"kind": "constant", "level": "1 m/s"},
    "run.duration": "20 ms",
}


@pytest.mark.parametrize(
    "example, changes, initial",
    [
        ("two_motors", FAN, {"displacement": 1e-3, "rotor_speed_2": 5.0, "motor_current_2": 0.1, "temperature": 310.0}),
        ("beam_harvester", {"run.duration": "20 ms"}, {"displacement": 1e-3, "piezo_voltage": 0.5}),
    ],
)
def test_siblings_of_the_beam_start_where_they_are_put_whatever_cools_their_wire(
    example: str, changes: dict[str, Any], initial: dict[str, float]
) -> None:
    found = run(load(EXAMPLES / f"{example}.toml", changes), samples=3, initial=initial)
    for name, value in initial.items():
        assert found[name][0] == pytest.approx(value, rel=1e-12)


def test_equilibrium_under_the_first_drive_is_where_a_long_rest_ends() -> None:
    scenario = load(EXAMPLES / "migaone.toml", {"drive.waveform": {"kind": "constant", "level": "2.2 V"}})
    held = run(scenario, duration=600.0, samples=3)
    found = run(scenario, duration=20.0, samples=3, initial={"at": "equilibrium"})
    assert held["martensite_fraction"][-1] < 0.999
    for name, least in scenario.system.convergence_scales().items():
        assert abs(found[name][0] - held[name][-1]) < 1e-2 * least
        assert np.ptp(found[name]) < 1e-2 * least


def test_settled_cycle_closes_and_one_that_drifts_is_refused() -> None:
    scenario = load(
        EXAMPLES / "migaone.toml",
        {"drive.waveform": {"kind": "sine", "low": "0 V", "high": "2 V", "frequency": "0.1 Hz"}},
    )
    found = run(scenario, duration=10.0, samples=101, initial={"at": "settled cycle"})
    first = run(scenario, duration=10.0, samples=101)
    for name, least in scenario.system.convergence_scales().items():
        reach = max(least, float(np.ptp(found[name])))
        assert abs(found[name][-1] - found[name][0]) < 2e-4 * reach
    assert abs(first["temperature"][-1] - first["temperature"][0]) > 1.0


def test_what_never_rests_has_no_equilibrium() -> None:
    system = Machine(mechanism=BeamMotor(**THESIS))
    with pytest.raises(InputError, match="does not reach a steady state"):
        run(system, {"motor": Constant(level=3.0)}, 1.0, initial={"at": "equilibrium"}, tolerance=0.1)
