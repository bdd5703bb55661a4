"""Plants and benches in python-control.

Sources of truth: `simulate`, sample by sample, and python-control's own differences.
"""

import numpy as np
import pytest
from builders import problem_a

from martensite.base.errors import InputError
from martensite.control.controllers.pid import Pid, PidLaw
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, MountedSensor, Sensors
from martensite.control.sensors.position import PositionSensor
from martensite.control.synthesis.linear import linearise_plant, realise_readings
from martensite.export.control_systems import (
    compute_rest_state,
    plant_state_space,
    state_names,
    to_nonlinear_system,
    to_state_space,
)
from martensite.signals.constant import Constant
from martensite.signals.held import Held
from martensite.simulate.api import simulate
from martensite.simulate.operating_point import find_operating_level

control = pytest.importorskip("control")
PERIOD, COUNT = 0.02, 200
PLANT = problem_a()
TIMES = PERIOD * np.arange(COUNT)
SHOWN = ("position", "temperature", "resistance")


def held(values: np.ndarray) -> Held:
    return Held(values=tuple(values.tolist()), frequency=1.0 / PERIOD)


def test_a_plant_answers_as_in_simulate():
    u = np.repeat(np.random.default_rng(1).uniform(0.0, 6.0, 10), COUNT // 10)
    system = to_nonlinear_system(PLANT, PERIOD, outputs=SHOWN)
    found = control.input_output_response(system, TIMES, u, compute_rest_state(PLANT, [u[0]]))
    run = simulate(PLANT, held(u), TIMES[-1], step=PERIOD, samples=COUNT)
    for row, name in zip(found.outputs, SHOWN, strict=True):
        np.testing.assert_allclose(row, run[name], rtol=1e-9, atol=1e-12)
    assert np.ptp(run["position"]) > 1e-3
    assert system.dt == PERIOD
    assert list(system.input_labels) == ["drive"]


def test_a_bench_answers_as_in_simulate():
    """Its reference is read at the end of a sample: given one sample earlier."""
    pid = Pid(measured="position", reference=Constant(level=0.0), Kp=300.0, Ki=100.0, law=PidLaw(high=6.0))
    bench = Bench(
        plant=PLANT,
        period=PERIOD,
        sensors=Sensors(position=MountedSensor(sensor=PositionSensor(), delay=0.04)),
        controllers=Controllers(drive=pid),
    )
    r = np.repeat([0.0, 3e-3, 2e-3, 0.0], COUNT // 4)
    system = to_nonlinear_system(bench)
    assert list(system.input_labels) == ["reference"]
    names = list(system.output_labels)
    run = simulate(bench, {"reference": held(r)}, TIMES[-1], samples=COUNT)

    def away(given: np.ndarray, name: str) -> float:
        found = control.input_output_response(system, TIMES, given, compute_rest_state(bench))
        row = found.outputs[names.index(name.replace(".", "_"))]
        return float(np.abs(row - np.array(run[name])).max())

    earlier = np.append(r[1:], r[-1])
    for name in ("position", "measured.position", "drive", "temperature"):
        assert away(earlier, name) < 1e-9
    assert away(r, "temperature") > 1e-3


@pytest.mark.parametrize(
    ("direction", "push"), [pytest.param("heating", 1.001, marks=pytest.mark.slow), ("cooling", 0.999)]
)
def test_a_linear_plant_is_that_of_python_control(direction, push, c_compiler):
    """Exact derivatives against its differences, with the signal that says the direction."""
    point = find_operating_level(PLANT, 3e-3, "position", 0.0, 3.0, direction=direction)
    exact = plant_state_space(point, PERIOD, outputs=("position", "temperature"))
    system = to_nonlinear_system(PLANT, PERIOD, outputs=("position", "temperature"))
    near = control.linearize(system, point.state, [push * point.signal])
    z = np.exp(2j * np.pi * np.array([1e-3, 0.1, 10.0]) * PERIOD)
    assert exact(z) == pytest.approx(near(z), rel=1e-3)
    slim = to_state_space(realise_readings(linearise_plant(point, PERIOD), ("position",)).linear)
    assert slim.nstates == 1
    assert slim(z) == pytest.approx(exact(z)[0, 0], rel=1e-6)
    at_rest = control.linearize(system, point.state, [point.signal])
    assert abs(at_rest(z)[0, 0, 0]) < 0.1 * abs(exact(z)[0, 0, 0])


def test_states_are_called_by_their_place():
    names = state_names(PLANT)
    assert names[0] == "elements0_memory_fraction"
    assert "mechanism_elongation" in names
    assert len(names) == len(compute_rest_state(PLANT)) == len(set(names))


def test_what_is_missing_is_told():
    with pytest.raises(InputError, match="needs a `period`"):
        to_nonlinear_system(PLANT)
    with pytest.raises(InputError, match=r"No output named `positon`.*`position`"):
        to_nonlinear_system(PLANT, PERIOD, outputs=("positon",))
