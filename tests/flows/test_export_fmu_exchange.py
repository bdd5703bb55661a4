"""Model exchange: an importer integrates what an FMU gives rates of.

Source of truth: runs of our own at a fine tolerance (Rosenbrock on a load line, small implicit steps with a mass);
FMPy with CVode and its validation, and SciPy as a second importer, which sets inputs wherever it asks for rates.
"""

from __future__ import annotations

import subprocess
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from benchmarks.problem_b import Wire, system
from scipy.integrate import solve_ivp

import martensite as ms
from martensite.base.errors import InputError
from martensite.export.fmu import Fmu, binaries, to_fmu
from martensite.export.rates import trace_rates
from martensite.physics.electrical.sources import PrescribedTemperature
from martensite.scenario.scenario import read_scenario
from martensite.signals.constant import Constant
from martensite.signals.held import Held
from martensite.simulate.api import simulate
from martensite.simulate.compiled import compile_system

fmpy = pytest.importorskip("fmpy")
from fmpy.fmi2 import FMU2Model  # noqa: E402
from fmpy.fmi3 import FMU3Model  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402
from fmu_instance import DISCARD, ERROR, OK, Instance  # noqa: E402
from one_wire import THIN_WIRE  # noqa: E402
from slider import Slider  # noqa: E402

pytestmark = pytest.mark.usefixtures("c_compiler")

LEVELS, HELD = (0.0, 2.0, 0.6), 2.0
CASES = {"2.0": ("mas", {}), "3.0": ("mas-polycrystal", {"groups": "15"})}
"""The law that is exported in each version of FMI."""


class Exchanged(Instance):
    """An instance for model exchange."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, kinds=(FMU2Model, FMU3Model))

    def update(self) -> None:
        """All discrete states are as they are to be."""
        found = self.fmu.newDiscreteStates() if self.second else self.fmu.updateDiscreteStates()
        assert not any(found[:5])

    def begin(self, values: Any = None) -> Exchanged:
        super().begin(values)
        self.update()
        self.fmu.enterContinuousTimeMode()
        return self

    def _call(self, name: str, count: int) -> Any:
        numbers = np.zeros(count)
        pointer = numbers.ctypes.data_as(fmpy.fmi2.POINTER(fmpy.fmi2.c_double))
        getattr(self.fmu, name)(pointer, count)
        return numbers

    def states(self, count: int) -> Any:
        return self._call("getContinuousStates", count)

    def rates(self, count: int) -> Any:
        return self._call("getDerivatives" if self.second else "getContinuousStateDerivatives", count)

    def put(self, numbers: Any) -> int:
        numbers = np.array(numbers, dtype=float)
        pointer = numbers.ctypes.data_as(fmpy.fmi2.POINTER(fmpy.fmi2.c_double))
        return self.status("setContinuousStates", pointer, len(numbers))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Fmu]:
    folder, here = tmp_path_factory.mktemp("exchange"), [binaries.find_target()]
    found: dict[str, Fmu] = {}
    for version, (law, options) in CASES.items():
        posed, path = system(Wire(), law, **options), folder / f"wire{version[0]}.fmu"
        found[version] = to_fmu(posed, path, fmi=version, step=5e-3, platforms=here, model_exchange=True)
    return found


@pytest.fixture(params=CASES)
def wire(request: pytest.FixtureRequest, made: dict[str, Fmu]) -> Iterator[Exchanged]:
    instance = Exchanged(made[request.param].path)
    yield instance
    instance.close()


def test_sources_are_clean(made: dict[str, Fmu], tmp_path: Path, c_compiler: str) -> None:
    """No warning of a compiler, in either version."""
    for version, one in made.items():
        with zipfile.ZipFile(one.path) as archive:
            archive.extractall(tmp_path / version)
        flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]
        subprocess.run([c_compiler, *flags, "all.c"], cwd=tmp_path / version / "sources", check=True)


@pytest.mark.parametrize("version", CASES)
def test_cvode_agrees_with_a_run(version: str, made: dict[str, Fmu]) -> None:
    """All that is observed, with another preload; the description is valid."""
    law, options = CASES[version]
    assert validate_fmu(str(made[version].path)) == []
    signal = [(t + k * HELD, level) for k, level in enumerate(LEVELS) for t in (0.0, HELD)]
    names = [one.name for one in made[version].named("output")]
    found: Any = fmpy.simulate_fmu(
        str(made[version].path),
        fmi_type="ModelExchange",
        stop_time=HELD * len(LEVELS),
        output_interval=0.05,
        input=np.array(signal, dtype=[("time", float), ("drive", float)]),
        output=names,
        start_values={"mechanism.preload": 1.4},
        relative_tolerance=1e-8,
        record_events=False,
    )
    posed = system(Wire(preload=1.4), law, **options)
    waveform = Held(values=LEVELS, frequency=1.0 / HELD)
    wanted = ms.run(posed, waveform, HELD * len(LEVELS), tolerance=1e-8, samples=121)
    assert wanted.range("martensite_fraction") > 0.8
    after = np.arange(121) % 40 != 0  # at a jump a run shows what follows it, an importer what was before
    for name in names:
        column = np.array(wanted[name.removesuffix("_echo")])
        apart = np.abs(found[name] - column)[after].max()
        assert apart < 1e-5 * max(np.ptp(column), 1e-3 * np.abs(column).max()), name


def test_another_importer_hangs_a_mass_on_an_element(made: dict[str, Fmu], tmp_path: Path) -> None:
    """An element by its ports, FMI 3.0: its end goes where SciPy's solver has the mass, within every step."""
    posed = system(Wire())
    slider = Slider(mass=0.4, damping=25.0, stiffness=50.0, preload=Wire().preload, motion="dynamic")
    path = tmp_path / "alone.fmu"
    alone = to_fmu(posed, path, fmi="3.0", step=1e-3, platforms=[binaries.find_target()], ports=True)
    assert [one.name for one in alone.states] == ["variant_plus", "variant_minus", "temperature_state"]
    assert validate_fmu(str(path)) == []
    element = Exchanged(path).begin({"drive": 2.0, "ambient": Wire().T_a})

    def rate(time: float, y: Any) -> Any:
        element.fmu.setTime(time)
        assert element.set({"elongation": -y[0]}) == OK and element.put(y[2:]) == OK
        (force,), s = element.get("force"), slider
        push = force - s.preload - s.stiffness * y[0] - s.damping * y[1]
        return [y[1], push / s.mass, *element.rates(3)]

    begin = [0.0, 0.0, *element.states(3)]
    samples = np.linspace(0.0, 1.5, 41)
    scale = np.array([1e-3, 1e-2, 1.0, 1.0, 100.0])
    found = solve_ivp(rate, (0.0, 1.5), begin, "BDF", samples, rtol=1e-8, atol=1e-8 * scale)
    assert element.status("completedIntegratorStep") == OK
    element.close()
    wanted = simulate(posed.with_parts(mechanism=slider), Constant(level=2.0), 1.5, step=4e-4, samples=41)
    assert wanted.range("martensite_fraction") > 0.5
    for row, name in ((0, "position"), (4, "temperature")):
        assert np.abs(found.y[row] - wanted[name]).max() < 1e-6 * wanted.range(name), name


def test_a_prescribed_temperature_is_no_state(tmp_path: Path) -> None:
    posed = system(Wire()).with_parts(source=PrescribedTemperature())
    warm = to_fmu(posed, tmp_path / "warm.fmu", platforms=[], step=1e-3, model_exchange=True)
    assert [one.name for one in warm.states] == ["variant_plus", "variant_minus"]
    size = compile_system(posed).size
    functions = trace_rates(posed).bind_floats(*(leaf.value for leaf in posed.leaves()))
    rest = functions["init"](300.0)[:size]
    cold = [0.6, 0.0, *rest[2:]]  # populations; stress and force follow
    found = [functions["differentiate"](*cold, drive) for drive in (300.0, 345.0)]
    assert [functions["observe"](*one[:size], 345.0)[1] for one in found] == [300.0, 345.0]
    assert [len(one) for one in found] == [size + 2, size + 2]
    seen = dict(zip(posed.outputs(), functions["observe"](*found[1][:size], 345.0), strict=True))
    assert found[1][2] == pytest.approx(seen["stress"], rel=1e-12) != rest[2]
    assert found[1][size] < found[0][size] - 0.1


def test_states_go_in_and_out(wire: Exchanged) -> None:
    """What is set is got, rates are those of the variables, and what is no number is refused."""
    count = sum(name.startswith("der(") for name in wire.names)
    wire.begin({"drive": 1.5})
    states = wire.states(count)
    states[0], states[-1] = 0.7, 330.0
    assert wire.put(states) == OK and list(wire.states(count)) == list(states)
    rates, seen = wire.rates(count), wire.get("der(temperature_state)", "temperature", "temperature_state")
    assert seen == [rates[-1], 330.0, 330.0] and rates[-1] != 0.0
    assert wire.status("completedIntegratorStep") == OK and list(wire.rates(count)) == list(rates)
    wire.set({"drive": 0.0})
    assert wire.rates(count)[-1] < rates[-1]
    for value, refused in (([np.nan, *states[1:]], DISCARD), (states[:1], ERROR)):
        assert wire.put(value) == refused
    assert list(wire.states(count)) == list(states)
    assert wire.set({"temperature_state": 300.0}) == ERROR and "cannot be set" in wire.said[-1]


def test_calls_in_a_wrong_order_are_refused(wire: Exchanged, made: dict[str, Fmu]) -> None:
    """Between events no event is handled; a step of a co-simulation is none of an integrator, nor are its states."""
    assert wire.status("enterContinuousTimeMode") == ERROR and "after instantiation" in wire.said[-1]
    wire.begin()
    update = "newDiscreteStates" if wire.second else "updateDiscreteStates"
    assert wire.status(update) == ERROR and "between events" in wire.said[-1]
    assert wire.status("enterEventMode") == OK and wire.status(update) == OK
    assert wire.status("setContinuousStates", None, 0) == ERROR and "at an event" in wire.said[-1]
    get, put = ("getFMUstate", "setFMUstate") if wire.second else ("getFMUState", "setFMUState")
    saved = getattr(wire.fmu, get)()
    assert wire.status(put, saved) == OK
    stepping = Instance(made["2.0" if wire.second else "3.0"].path).begin({"drive": 1.0})
    assert stepping.status(put, saved) == ERROR
    before = stepping.get("der(temperature_state)")[0]
    assert stepping.step(0.0, 0.1) == OK
    assert 0.0 < stepping.get("der(temperature_state)")[0] < before
    assert stepping.get("temperature") == stepping.get("temperature_state")
    stepping.close()


def test_a_law_without_rates_is_for_co_simulation_alone(tmp_path: Path) -> None:
    """It is said before anything is written, in the description, and by the binary."""
    text = (
        THIN_WIRE
        + '[drive]\nkind = "power"\nwaveform = { kind = "constant", level = "1 W" }\n[run]\nduration = "1 s"\n'
    )
    posed = read_scenario(text).system
    path = tmp_path / "turns.fmu"
    with pytest.raises(InputError, match="law `liang-rogers` has no rates, and what it remembers of its turns"):
        to_fmu(posed, path, platforms=[], model_exchange=True)
    assert not path.exists()
    made = to_fmu(posed, path, fmi="3.0", platforms=[binaries.find_target()])
    assert made.states == [] and fmpy.read_model_description(str(path)).modelExchange is None
    with pytest.raises(Exception, match="Failed to instantiate"):
        Exchanged(path)
