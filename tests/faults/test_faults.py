"""Faults on a bench without a loop: what each one changes, from when to when, and where.

Source of truth: the same run without a fault, and the numbers of the plant.
"""

import math
from typing import Any

import pytest
from benchmarks.control.faults import build_faults
from builders import plain_system, problem_a

from martensite.actuators.assembly import Actuator, Group, Machine
from martensite.actuators.mechanisms.load_line import DeadWeight
from martensite.actuators.mechanisms.pulley import AntagonisticPulley
from martensite.base.errors import ParameterError
from martensite.control.faults.base import FAULTS
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import FaultTable, MountedSensor, Sensors
from martensite.control.loop.run import noise_waveforms, simulate_bench
from martensite.control.sensors.position import IdealSensor
from martensite.kernels import floats
from martensite.physics.electrical.sources import CurrentSource, PrescribedTemperature, VoltageSource
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.constant import Constant

PLANT = problem_a(source=PwmVoltage(supply=6.0))
DUTY = 0.2
NUMBERS = {
    "drop-out": {"sensor": "felt"},
    "stuck": {"sensor": "felt"},
    "drift": {"sensor": "felt", "bias": 1.0},
    "supply-sag": {"share": 0.5},
    "ambient-step": {"by": 20.0},
    "draught": {"factor": 2.0},
    "slack": {"length": 1e-3},
    "contact-resistance": {"resistance": 1.0},
    "stuck-on": {"level": 0.4},
    "supply-surge": {"share": 1.3},
    "late-readings": {"sensor": "felt", "by": 0.1},
    "noise-burst": {"sensor": "felt", "deviation": 2.0},
}


def bench(plant=PLANT, **faults):
    felt = MountedSensor(sensor=IdealSensor(), of=("temperature",))
    return Bench(plant=plant, period=0.05, sensors=Sensors(felt=felt), faults=FaultTable(**faults))


def run(*, plant=PLANT, level=DUTY, seconds=1.0, **faults):
    waves = {drive.name: Constant(level=level) for drive in plant.drives()}
    return simulate_bench(bench(plant, **faults), seconds, waveforms=waves, runtime="floats")


def fault(name, **changes):
    return FAULTS[name](**(NUMBERS.get(name, {}) | {"start": 0.5, "end": 0.75} | changes))


HEALTHY = run()


@pytest.mark.parametrize("name", FAULTS.names())
def test_a_fault_changes_nothing_before_it_begins(name):
    found = run(one=fault(name))
    for column in ("temperature", "current", "measured.felt", "position"):
        assert found[column][:10].tolist() == HEALTHY[column][:10].tolist()
    assert any((found[c] != HEALTHY[c]).any() for c in ("temperature", "measured.felt", "position"))


@pytest.mark.parametrize("name", ["supply-sag", "open-circuit"])
def test_of_the_current_a_share_is_left(name):
    found, share = run(one=fault(name)), {"supply-sag": 0.5, "open-circuit": 0.0}[name]
    ratios = [
        a * R / (b * S)
        for a, b, R, S in zip(
            found["current"], HEALTHY["current"], found["resistance"], HEALTHY["resistance"], strict=True
        )
    ]
    during = [0.5 - 1e-9 <= t < 0.75 - 1e-9 for t in found.times]
    assert ratios == pytest.approx([share if now else 1.0 for now in during], rel=1e-12)


@pytest.mark.parametrize(("name", "age"), [("drop-out", 0.55), ("stuck", 0.0)])
def test_only_a_drop_out_is_seen_in_the_age(name, age):
    one = bench(one=fault(name, end=math.inf))
    found = simulate_bench(one, 1.0, waveforms={"drive": Constant(level=DUTY)}, runtime="floats")
    assert found["measured.felt"][10:].tolist() == [found.columns["measured.felt"][9]] * 11
    assert HEALTHY["measured.felt"].tolist() == HEALTHY["temperature"].tolist()
    state = one.init(floats, DUTY, 0.0, 0.0)
    for _ in range(20):
        state, _ = one.step(floats, state, DUTY, 0.0, 0.0, dt=0.05)
    assert state.sensors[0].age == pytest.approx(age, abs=1e-12)


def test_a_drift_grows_from_where_it_begins():
    found = run(one=fault("drift", bias=2.0, rate=4.0))
    off = [r - T for r, T in zip(found["measured.felt"], found["temperature"], strict=True)]
    expected = [2.0 + 4.0 * (t - 0.5) if 0.5 - 1e-9 <= t < 0.75 - 1e-9 else 0.0 for t in found.times]
    assert off == pytest.approx(expected, abs=1e-9)


def slope(found, k, wire=PLANT.element):
    """Change of the heat content of a wire without latent heat, over a period [W]."""
    return wire.heat_capacity_total() * (found["temperature"][k + 1] - found["temperature"][k]) / 0.05


def test_surroundings_and_draught_change_the_heat_loss():
    """Q = f h S (T - T_a): read off the heat balance, h constant, no latent heat."""
    plain = plain_system(source=PwmVoltage(supply=3.0))
    healthy = run(plant=plain)
    film = healthy["heat_loss"][9] / (healthy["temperature"][9] - 293.15)
    cases = {"ambient-step": (1.0, 313.15), "draught": (2.0, 293.15)}
    for name, (factor, ambient) in cases.items():
        found = run(plant=plain, one=fault(name))
        loss = found["heat_loss"][12]
        expected = factor * film * (found["temperature"][12] - ambient)
        assert loss == pytest.approx(expected, rel=1e-12)
        mean = 0.5 * (loss + found["heat_loss"][13])
        power = found["power"][12]
        assert slope(found, 12, plain.element) == pytest.approx(power - mean, rel=1e-3)


def test_the_supply_of_other_sources_is_their_limit():
    """0.9 V of 1 V are asked for; at half the supply 0.5 V are there."""
    volts = problem_a(source=VoltageSource(voltage_limit=1.0))
    found = run(plant=volts, level=0.9, one=fault("supply-sag"))
    assert found.columns["voltage"][8:12] == pytest.approx([0.9, 0.9, 0.5, 0.5])
    amperes = problem_a(source=CurrentSource())
    assert run(plant=amperes, level=0.5, one=fault("supply-sag"))["current"].tolist() == [0.5] * 21


def test_a_chamber_has_no_circuit():
    chamber = problem_a(source=PrescribedTemperature())
    for name in ("open-circuit", "supply-sag"):
        found = run(plant=chamber, level=320.0, one=fault(name))
        assert found.columns["temperature"] == pytest.approx([320.0] * 21)


def test_faults_add_up():
    """A draught of 2 and one of 1/2 are none."""
    found = run(one=fault("draught"), two=fault("draught", factor=0.5))
    assert found.columns["temperature"] == pytest.approx(HEALTHY.columns["temperature"], rel=1e-13)


def test_a_sag_is_felt_behind_a_contact():
    """In whatever order faults are named: the contact is closed again, the supply is not."""
    faults: Any = {"loose": fault("open-circuit", end=0.6), "sag": fault("supply-sag")}
    found, other = run(**faults), run(**dict(reversed(faults.items())))
    assert found["current"].tolist() == other["current"].tolist()
    ratio = found["current"][13] * found["resistance"][13] / HEALTHY["current"][13]
    assert ratio / HEALTHY.columns["resistance"][13] == pytest.approx(0.5, rel=1e-12)


def test_slack_takes_its_length_of_a_lift_and_a_clamp_all_of_it():
    """A weight hangs lower by the slack, and as before without it; what is clamped stays, whatever the element does."""
    weight = problem_a(source=PwmVoltage(supply=6.0), mechanism=DeadWeight(mass=2.0))
    free = run(plant=weight, level=0.6, seconds=2.0)
    low = run(plant=weight, level=0.6, seconds=2.0, one=fault("slack", start=1.0, end=1.5))
    lost = free["position"] - low["position"]
    assert lost == pytest.approx([1e-3 if 20 <= k < 30 else 0.0 for k in range(41)], abs=1e-12)
    spring = run(level=0.6, seconds=2.0)
    held = run(level=0.6, seconds=2.0, one=fault("clamped", start=1.0, end=1.5))
    assert held["position"][20:30] == pytest.approx([held["position"][20]] * 10, rel=1e-12)
    assert held["strain"][21:30] == pytest.approx([held["strain"][21]] * 9, rel=1e-9)
    assert held["force"][29] > spring["force"][29]
    assert held["position"][40] > held["position"][29]


def test_what_is_no_load_line_has_neither_slack_nor_clamp():
    one = Actuator(element=PLANT.element, environment=PLANT.environment, source=PLANT.source)
    pair = Group(protagonist=one, antagonist=one)
    pulley = Machine(mechanism=AntagonisticPulley(radius=8e-3, preload=3.0), group=pair)
    with pytest.raises(ParameterError, match="`clamped` is for a mechanism of one element on a load line"):
        fault("clamped").plant(floats, pulley, True)


def test_a_contact_is_in_a_row_with_the_element():
    """I = √D U/(R + R_c); a surge is a share of more than 1."""
    found = run(one=fault("contact-resistance"), two=fault("supply-surge", start=0.6))
    during = [(1.0 if 10 <= k < 15 else 0.0, 1.3 if 12 <= k < 15 else 1.0) for k in range(20)]
    rows = zip(during, found["resistance"], strict=False)
    expected = [math.sqrt(DUTY) * share * 6.0 / (ohms + more) for (more, share), ohms in rows]
    assert found.columns["current"][:20] == pytest.approx(expected, rel=1e-12)


def test_a_switch_that_is_stuck_obeys_nobody():
    found, never = run(one=fault("stuck-on")), run(level=0.4)
    rows = zip(found["current"], found["resistance"], strict=True)
    on = [current * ohms / 6.0 for current, ohms in rows]
    assert on == pytest.approx([math.sqrt(0.4 if 10 <= k < 15 else DUTY) for k in range(21)], rel=1e-12)
    assert found["temperature"][15] < never["temperature"][15]


def test_readings_are_late_by_what_it_says():
    """Two periods late, and at once again; what was overtaken is lost."""
    found = run(one=fault("late-readings"))
    truth, read = found["temperature"], found["measured.felt"].tolist()
    assert read[:10] == truth[:10].tolist()
    assert read[12:15] == truth[10:13].tolist()
    assert read[10:12] == [truth[9], truth[9]]
    assert read[15:] == truth[15:].tolist()


def test_a_burst_adds_the_normal_number_of_the_noise():
    off = {}
    for deviation in (0.0, 2.0):
        one = bench(one=fault("noise-burst", deviation=deviation))
        waves = {"drive": Constant(level=DUTY)}
        found = simulate_bench(one, 1.0, waveforms=waves, runtime="floats", seed=4)
        off[deviation] = found["measured.felt"] - found["temperature"]
    assert set(off[0.0]) == {0.0}
    noise: Any = noise_waveforms(bench(), 1.0, 4)["noise.felt"]
    drawn = noise.values
    assert off[2.0] == pytest.approx([2.0 * drawn[k] if 10 <= k < 15 else 0.0 for k in range(21)], abs=1e-9)


def test_the_benchmark_has_one_case_of_every_fault():
    one = bench(anything=fault("draught"))
    found = build_faults(one, 30.0, sensor="felt", span=50.0)
    assert len(found) == 12
    assert set(found) <= set(FAULTS.names())
    assert {case.start for case in found.values()} == {10.0}
    known: Any = found
    assert (known["drift"].rate, known["drop-out"].end, known["stuck"].end) == (2.5, 20.0, math.inf)
    cold = HEALTHY["resistance"][0]
    assert known["contact-resistance"].resistance == pytest.approx(0.2 * cold)
    with pytest.raises(ParameterError, match="Give the span of the reading of `felt`"):
        build_faults(one, 30.0)


# ---------------------------------------------------------------- one of several actuators


def test_a_fault_of_one_drive_leaves_the_others_alone():
    one = Actuator(element=PLANT.element, environment=PLANT.environment, source=PLANT.source)
    pulley = AntagonisticPulley(radius=5e-3, preload=3.0)
    pair = Machine(mechanism=pulley, group=Group(protagonist=one, antagonist=one))
    first, second = pair.actuators()
    waves = {first: Constant(level=0.3), second: Constant(level=0.3)}
    found = simulate_bench(
        Bench(plant=pair, period=0.05, faults=FaultTable(one=fault("open-circuit", drive=second))),
        0.7,
        waveforms=waves,
        runtime="floats",
    )
    assert found[f"{second}.current"][11] == 0.0
    assert found[f"{first}.current"][11] > 0.0


# ---------------------------------------------------------------- what does not fit


def test_a_fault_must_end_after_it_begins():
    with pytest.raises(ParameterError, match="must end after it begins"):
        fault("draught", start=1.0, end=0.5)


@pytest.mark.parametrize("name", [n for n in FAULTS.names() if {"sensor", "drive"} & set(FAULTS[n].declarations)])
def test_names_that_do_not_exist_are_refused(name):
    place = "sensor" if "sensor" in FAULTS[name].declarations else "drive"
    with pytest.raises(ParameterError, match=f"there is no {place} `nothing`"):
        bench(one=fault(name, **{place: "nothing"}))
