"""An element alone as an FMU, hung on a mass, a spring and a damper that are integrated outside.

Source of truth: the run of a mechanism of the same mass, spring and damper; the order of the coupling; the work that
the host receives; FMPy's validation and the schema of terminals; libcosim as a second importer.
"""

from __future__ import annotations

import math
import zipfile
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from martensite.base.errors import InputError
from martensite.export.fmu import Fmu, binaries, to_fmu
from martensite.export.fmu.terminals import TERMINALS, draw_icon
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.signals.constant import Constant
from martensite.simulate.api import simulate

fmpy = pytest.importorskip("fmpy")
from fmpy.validation import validate_fmu  # noqa: E402
from fmu_instance import ERROR, OK, Instance  # noqa: E402
from one_wire import THIN_WIRE  # noqa: E402
from slider import Slider  # noqa: E402

pytestmark = pytest.mark.usefixtures("c_compiler")

SCENARIO = f"""{THIN_WIRE}
[drive]
kind = "power"
waveform = {{ kind = "constant", level = "6 W" }}

[run]
duration = "0.5 s"
step = "1 ms"
"""
POWER, AMBIENT, DURATION = 6.0, 295.15, 0.5
VERSIONS = ("2.0", "3.0")


SLIDER = Slider(mass=0.4, damping=25.0, stiffness=300.0, preload=1.2, motion="dynamic")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return read_scenario(SCENARIO)


@pytest.fixture(scope="module")
def made(scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Fmu]:
    folder, here = tmp_path_factory.mktemp("ports"), [binaries.find_target()]
    return {v: to_fmu(scenario, folder / f"p{v[0]}.fmu", fmi=v, platforms=here, ports=True) for v in VERSIONS}


@pytest.fixture(params=VERSIONS)
def element(request: pytest.FixtureRequest, made: dict[str, Fmu]) -> Any:
    instance = Instance(made[request.param].path)
    yield instance.begin({"drive": POWER, "ambient": AMBIENT})
    instance.close()


class Host:
    """The slider outside: exact under a force that is linear in time."""

    def __init__(self, step: float) -> None:
        s, self.step = SLIDER, step
        system = np.zeros((4, 4))  # x, v, force above the preload, its rate
        system[0, 1] = system[2, 3] = 1.0
        system[1] = [-s.stiffness / s.mass, -s.damping / s.mass, 1.0 / s.mass, 0.0]
        self.whole, self.half = expm(step * system), expm(0.5 * step * system)

    def move(self, state: Any, begin: float, end: float) -> tuple[Any, float]:
        """State after a step, and the work received, by Simpson's rule."""
        given = np.r_[state, begin - SLIDER.preload, (end - begin) / self.step]
        middle, after = self.half @ given, self.whole @ given
        powers = begin * state[1], 0.5 * (begin + end) * middle[1], end * after[1]
        return after[:2], self.step * (powers[0] + 4.0 * powers[1] + powers[2]) / 6.0


def couple(element: Any, count: int, order: int) -> tuple[Any, float, float]:
    """Positions at every step; work that the host received, and that the element gave.

    First order holds what the other side said last; second order hands over the velocity, and the force is a line.
    """
    step = DURATION / count
    host, state, positions = Host(step), np.zeros(2), [0.0]
    (force,), received, given, at = element.get("force"), 0.0, 0.0, 0.0
    for k in range(count):
        velocity = -state[1] if order == 2 else 0.0
        assert element.set({"elongation": -state[0], "velocity": velocity, "drive": POWER, "ambient": AMBIENT}) == OK
        assert element.step(k * step, step) == OK
        after, now = element.get("force", "elongation_echo")
        begin, end = (force, after) if order == 2 else (force, force)
        state, work = host.move(state, begin, end)
        received, given = received + work, given + 0.5 * (force + after) * (at - now)
        force, at = after, now
        positions.append(state[0])
    return np.array(positions), received, given


@pytest.fixture(scope="module")
def alone(scenario: Scenario) -> Any:
    """The same in one run of our own."""
    system = scenario.system.with_parts(mechanism=SLIDER)
    run = simulate(system, Constant(level=POWER), DURATION, step=1e-4, samples=251)
    assert run.range("martensite_fraction") > 0.5
    return np.array(run.columns["position"])


@pytest.mark.parametrize("order", [1, 2])
def test_coupled_it_equals_our_own_run(order: int, made: dict[str, Fmu], alone: Any) -> None:
    errors, losses = [], []
    for count in (250, 500, 1000):
        instance = Instance(made["2.0" if order == 1 else "3.0"].path).begin({"drive": POWER, "ambient": AMBIENT})
        found, received, given = couple(instance, count, order)
        instance.close()
        errors.append(np.abs(found[:: count // 250] - alone).max())
        losses.append(abs(received - given))
        work = received
    ratio = 2.0**order
    for a, b in pairwise(errors):
        assert ratio * 0.75 < a / b < ratio * 1.4
    assert errors[-1] < (2e-2 if order == 1 else 1e-3) * np.abs(alone).max()
    assert losses[-1] < (2e-2 if order == 1 else 1e-3) * work
    assert losses[0] / losses[-1] > 0.8 * ratio**2


def test_a_step_may_be_tried_again(element: Any) -> None:
    """From a saved state the same step gives the same, whatever was tried in between."""
    get, put = ("getFMUstate", "setFMUstate") if element.second else ("getFMUState", "setFMUState")
    saved = getattr(element.fmu, get)()
    found = []
    for elongation, velocity in ((-1e-4, 0.0), (3e-4, 0.02), (-1e-4, 0.0)):
        assert element.status(put, saved) == OK
        assert element.set({"elongation": elongation, "velocity": velocity, "drive": POWER, "ambient": AMBIENT}) == OK
        assert element.step(0.0, 0.01) == OK
        found.append(element.get("force", "temperature", "resistance", "martensite_fraction", "elongation_echo"))
    assert found[0] == found[2] and found[0][0] != found[1][0]
    assert found[1][4] == pytest.approx(3e-4 + 0.02 * 0.01, rel=1e-12)
    assert found[0][4] == -1e-4
    assert element.set({"elongation": math.inf}) == ERROR
    getattr(element.fmu, put.replace("set", "free"))(saved)


def test_descriptions_terminals_and_icon(made: dict[str, Fmu], tmp_path: Path) -> None:
    for one in made.values():
        assert validate_fmu(str(one.path)) == []
        assert [v.name for v in one.select_variables("input")] == ["drive", "elongation", "velocity", "ambient"]
        assert not any("environment.temperature" == v.name for v in one.variables)
        ambient = next(v for v in one.variables if v.name == "ambient")
        assert ambient.start == pytest.approx(AMBIENT)
    names = zipfile.ZipFile(made["3.0"].path).namelist()
    assert not any("terminals" in name.lower() for name in zipfile.ZipFile(made["2.0"].path).namelist())
    assert "terminalsAndIcons/icon.png" in names and draw_icon().startswith(b"\x89PNG")
    etree = pytest.importorskip("lxml.etree")
    schema = Path(fmpy.__file__).parent / "schema/fmi3/fmi3TerminalsAndIcons.xsd"
    read = etree.fromstring(zipfile.ZipFile(made["3.0"].path).read("terminalsAndIcons/terminalsAndIcons.xml"))
    etree.XMLSchema(etree.parse(str(schema))).assertValid(read)
    members = {one.get("variableName") for one in read.iter("TerminalMemberVariable")}
    assert members == {name for _, listed in TERMINALS.values() for name in listed}
    assert members <= {one.name for one in made["3.0"].variables}


def test_a_second_importer(made: dict[str, Fmu]) -> None:
    """libcosim, FMI 2.0: an end that is moved to and fro."""
    pytest.importorskip("libcosimpy")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.FATAL)
    step = 0.01
    execution = CosimExecution.from_step_size(step_size=int(step * 1e9))
    slave = execution.add_local_slave(CosimLocalSlave(str(made["2.0"].path), "element"))
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer)
    execution.add_manipulator(manipulator)
    references = {one.name: one.reference for one in made["2.0"].variables}
    seen = [references[name] for name in ("force", "temperature", "martensite_fraction")]
    other = Instance(made["2.0"].path).begin({"drive": POWER, "ambient": AMBIENT})
    for k in range(40):
        given: dict[str | int, float] = {
            "drive": POWER,
            "elongation": -5e-4 * math.sin(0.3 * k),
            "velocity": 0.0,
            "ambient": AMBIENT,
        }
        manipulator.slave_real_values(slave, [references[str(name)] for name in given], list(given.values()))
        execution.step()
        other.set(given)
        assert other.step(k * step, step) == OK
        known = other.get("force", "temperature", "martensite_fraction")
        assert list(observer.last_real_values(slave, seen)) == pytest.approx(known, rel=1e-12)
    other.close()


def test_ports_are_chosen_by_name(scenario: Scenario, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="with ports"):
        to_fmu(scenario, tmp_path / "a.fmu", port="element", platforms=[])
    with pytest.raises(InputError, match="No element at port named `elemnt`"):
        to_fmu(scenario, tmp_path / "a.fmu", ports=True, port="elemnt", platforms=[])
