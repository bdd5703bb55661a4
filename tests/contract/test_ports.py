"""Ports: one kernel behind every host, its tangent, and steps that are tried many times.

Source of truth: the kernel on plain floats; central differences of it; for its values `material_point`, the testing
machine and the run, which are other ways through the same laws.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builders import example, wire_a
from port_hosts import ZERO, UmatHost, material_of

from martensite.actuators.assembly import System
from martensite.actuators.elements.base import ELEMENTS
from martensite.actuators.mechanisms.testing_machine import TensileTestingMachine
from martensite.base.errors import InputError, ParameterError, SolveError
from martensite.export.ports.batch import PortBatch, UniaxialModel
from martensite.export.ports.element import build_element_port
from martensite.export.ports.kernel import compile_port
from martensite.kernels import floats
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.laws.base import LAWS, Fractions
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.scenario.scenario import load
from martensite.simulate.compiled import bind_system
from martensite.simulate.point import PathLeg, material_point

EXAMPLES = Path(__file__).parents[2] / "examples"
WARM = 335.0
"""[K]; superelastic."""
LAW_NAMES = ("brinson", "mas", "lagoudas", "elahinia", "liang-rogers", "r-phase", "tanaka")
PATH = np.concatenate(
    [np.linspace(0.0, 0.05, 21)[1:], np.linspace(0.05, 0.012, 16)[1:], np.linspace(0.012, 0.03, 8)[1:]]
)
CLOCK = np.arange(1, len(PATH) + 1)
WARMTH = WARM + 4.0 * np.sin(0.3 * CLOCK)


def walk_floats(kernel: Any, state: Any = None) -> list[tuple[float, ...]]:
    """What every step of the path gives, committed one after the other."""
    now = kernel.functions["init"](0.0, WARM) if state is None else state
    rows = []
    for strain, temperature in zip(PATH, WARMTH, strict=True):
        found, solved = kernel.try_step(now, (strain, temperature), 1.0)
        assert solved
        now = found[: kernel.size]
        rows.append(tuple(found))
    return rows


@pytest.mark.parametrize("name", LAW_NAMES)
def test_tangents_are_those_of_differences(name: str) -> None:
    kernel = compile_port(material_of(example(LAWS[name])))
    now, size, checked = kernel.functions["init"](0.0, WARM), kernel.size, 0
    for strain, temperature in zip(PATH, WARMTH, strict=True):
        found, _ = kernel.try_step(now, (strain, temperature), 1.0)
        slopes = np.reshape(found[size + 4 :], (2, 2))
        for place, probe in enumerate((1e-8, 1e-4)):
            ends = []
            for change in (probe, -probe):
                moved = [strain, temperature]
                moved[place] += change
                ends.append(np.array(kernel.try_step(now, moved, 1.0)[0][size + 2 : size + 4]))
            differences = (ends[0] - ends[1]) / (2.0 * probe)
            scale = np.array([3e10, 1e9]) if place == 0 else np.array([1e7, 1e6])
            np.testing.assert_allclose(slopes[:, place] / scale, differences / scale, atol=1e-6)
            checked += int(np.any(np.abs(differences[0]) > 0.0))
        now = found[:size]
    assert checked > len(PATH)


@pytest.mark.usefixtures("c_compiler")
@pytest.mark.parametrize("name", LAW_NAMES[:2])
def test_every_host_has_the_numbers_of_the_kernel(name: str, tmp_path: Path) -> None:
    port = material_of(example(LAWS[name]))
    kernel, count = compile_port(port), len(PATH)
    rows = np.array(walk_floats(kernel))[:, kernel.size + 2 :]
    batch = PortBatch(port, runtime="c")
    umat = UmatHost(tmp_path, port)
    states, statev = batch.start([[0.0, WARM]]), np.zeros(umat.states)
    strain, before = 0.0, WARM
    for k in range(count):
        found = batch.step(states, [[PATH[k], WARMTH[k]]], 1.0)
        whole = np.r_[found.values[0], found.slopes[0].ravel()]
        np.testing.assert_array_equal(whole, rows[k])
        umat.call(statev, [strain], [2.0 * (PATH[k] - strain)], before - ZERO, 0.0, 1.0)  # a trial that is not kept
        stress, tangent, after = umat.call(statev, [strain], [PATH[k] - strain], before - ZERO, WARMTH[k] - before, 1.0)
        answer = [stress[0], tangent[0, 0], umat.answer["ddsddt"][0], umat.answer["rpl"][0]]
        expected = rows[k][[0, 2, 3, 1]] / 1e6
        np.testing.assert_allclose(answer, expected, rtol=1e-9 if name == "mas" else 1e-12, atol=1e-7)
        states, statev, strain, before = found.states, after, PATH[k], WARMTH[k]
    assert statev[0] == 1.0 and 0.0 < statev[1] < 1.0


def test_a_bar_is_the_material_point_and_an_element_the_testing_machine() -> None:
    law = example(LAWS["brinson"])
    kernel = compile_port(material_of(law))
    mounted = law.strain(floats, Fractions(0.0, 0.0), 0.0, WARM)  # thermal: a host counts from where it takes over
    assert mounted < -1e-4
    legs = [PathLeg(strain=e + mounted, temperature=t, steps=1) for e, t in zip(PATH, WARMTH, strict=True)]
    found = material_point(
        law, legs, start=(0.0, WARM), fractions=Fractions(0.0, 0.0), tolerance=None, tension_only=False
    )
    stress = [row[kernel.size + 2] for row in walk_floats(kernel)]
    np.testing.assert_allclose(stress, found.stress[1:], rtol=1e-9, atol=1.0)

    parts = {
        "element": wire_a(law=law),
        "environment": Environment(temperature=300.0, cooling=ConstantCooling(h=80.0)),
        "source": PowerSource(),
    }
    machine = System(**parts, mechanism=TensileTestingMachine(control="elongation", preload=5.0))
    port = build_element_port(machine)
    (ours, _), (theirs, _) = bind_system(port), bind_system(machine)
    mine, other = ours["init"](0.0, 0.0, 300.0), theirs["init"](0.0, 0.0)
    outputs, names = list(machine.outputs()), list(port.outputs())
    for k in range(40):
        power, way = 2.0 * (k < 20), -2e-3 * np.sin(0.2 * k)
        mine = ours["step"](*mine, power, way, 300.0, 0.2)[: len(mine)]
        other = theirs["step"](*other, power, way, 0.2)[: len(other)]
        seen = dict(zip(names, ours["observe"](*mine, power, way, 300.0), strict=True))
        known = dict(zip(outputs, theirs["observe"](*other, power, way), strict=True))
        for name in ("force", "temperature", "resistance", "martensite_fraction"):
            assert seen[name] == pytest.approx(known[name], rel=1e-12)


@pytest.mark.parametrize("name", ["wire", "coil-spring", "bundle"])
def test_an_element_answers_to_its_surroundings_and_end(name: str) -> None:
    port = build_element_port(
        System(
            element=example(ELEMENTS[name]),
            environment=Environment(temperature=300.0, cooling=ConstantCooling(h=80.0)),
            source=PowerSource(),
            mechanism=TensileTestingMachine(control="elongation", preload=5.0),
        )
    )
    kernel = compile_port(port)
    assert kernel.inputs == ("drive", "elongation", "ambient")
    now, size, answers = kernel.functions["init"](0.0, 0.0, 300.0), kernel.size, len(kernel.answers)
    first = dict(zip(kernel.outputs, kernel.functions["observe"](*now, 0.0, 0.0, 300.0), strict=True))
    unit = 5.0 / first["stiffness"]
    probes = np.array([1e-4, 1e-6 * unit, 1e-3])
    scales = np.outer([5.0, 100.0, first["resistance"], 1.0], 1.0 / np.array([10.0, unit, 100.0]))
    begin, end = size + 2, size + 2 + answers
    for k in range(20):
        inputs = [3.0, -0.1 * unit * k, 293.0 + k]
        found, solved = kernel.try_step(now, inputs, 0.2)
        assert solved
        columns = []
        for place, probe in enumerate(probes):
            ends = []
            for change in (probe, -probe):
                moved = list(inputs)
                moved[place] += change
                ends.append(np.array(kernel.try_step(now, moved, 0.2)[0][begin:end]))
            columns.append((ends[0] - ends[1]) / (2.0 * probe))
        slopes = np.reshape(found[end:], (answers, 3))
        np.testing.assert_allclose(slopes / scales, np.transpose(columns) / scales, atol=1e-6)
        now = found[:size]
    assert found[begin] > 5.0 and found[begin + 1] > 330.0 and found[begin + 3] < 0.9


def test_slopes_inside_loops_are_numbers_of_c(c_compiler: str, tmp_path: Path) -> None:
    """Cells of a wire are a loop; C has numbers for the slopes in it, and no vectors."""
    core = compile_port(build_element_port(load(EXAMPLES / "clamped_wire.toml").system)).write_core()
    core.write(tmp_path)
    done = subprocess.run([c_compiler, "-fsyntax-only", f"{core.name}.c"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[:300]


def test_arrays_are_updated_in_place_or_not_at_all() -> None:
    system = System(
        element=wire_a(law=example(LAWS["brinson"]), initial_fraction=0.0),
        environment=Environment(temperature=300.0, cooling=ConstantCooling(h=80.0)),
        source=PowerSource(),
        mechanism=TensileTestingMachine(control="elongation"),
    )
    model = UniaxialModel(system, temperature=WARM, runtime="floats")
    points, stress, tangent = 3, np.zeros(3), np.zeros(3)
    history = model.create_history(points)
    kept = {name: one.copy() for name, one in history.items()}
    pull = np.array([0.002, 0.02, -0.001])
    model.evaluate(0.0, 1.0, pull, stress, tangent, history)
    np.testing.assert_array_equal(history["strain"], pull)
    assert stress[0] > 0.0 > stress[2] and tangent[1] < 0.3 * tangent[0]
    assert model.heat[1] >= 0.0 and model.stress_by_temperature[1] > 0.0
    again, slopes = np.zeros(3), np.zeros(3)
    model.evaluate(0.0, 1.0, pull, again, slopes, kept)
    np.testing.assert_array_equal(again, stress)
    before = history["state"].copy()
    with pytest.raises(InputError, match="finite"):
        model.evaluate(1.0, 1.0, np.array([0.0, np.nan, 0.0]), stress, tangent, history)
    np.testing.assert_array_equal(history["state"], before)
    np.testing.assert_array_equal(again, stress)


def test_slack_and_preload() -> None:
    law = example(LAWS["lagoudas"])
    wire = compile_port(material_of(law, compressed="slack"))
    start = wire.functions["init"](0.0, WARM)
    first, _ = wire.try_step(start, (0.0, WARM), 0.0)
    assert first[wire.size + 2] == 0.0 and first[wire.size + 4] > 1e10  # taut where it begins
    pushed, _ = wire.try_step(start, (-1e-3, WARM), 0.0)
    assert pushed[wire.size + 2] == 0.0 and pushed[wire.size + 4] == 0.0
    loaded = compile_port(material_of(law, preload=5e7))
    found, _ = loaded.try_step(loaded.functions["init"](0.3, WARM), (0.3, WARM), 0.0)
    assert found[loaded.size + 2] == pytest.approx(5e7, rel=1e-9)
    with pytest.raises(ParameterError, match="one phase state"):
        material_of(law).with_parts(element=example(ELEMENTS["axial-wire"]))


def test_a_step_that_no_part_solves_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = compile_port(material_of(example(LAWS["brinson"])))
    batch = PortBatch(kernel.system, runtime="floats")
    states = batch.start([[0.0, WARM]])
    monkeypatch.setattr("martensite.export.ports.kernel.SOLVED", -1.0)
    with pytest.raises(SolveError, match="point 0"):
        batch.step(states, [[0.01, WARM]], 1.0)
