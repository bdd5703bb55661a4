"""The start of a run is an equilibrium: no drive, no motion, at any ambient temperature.

Sources of truth: the law itself, led from cold martensite to the ambient temperature in small legs; the line
A_f + stress/C_A of austenite finish; the definition of an equilibrium, from which a hold at zero drive moves nothing.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from builders import example_system, examples, label, registered, variants
from one_wire import write_wire

import martensite as ms
from martensite.actuators.assembly import AbstractSystem
from martensite.kernels import floats
from martensite.kernels.compiler import find_compiler
from martensite.physics.laws.base import Fractions
from martensite.scenario.scenario import read_scenario
from martensite.signals.constant import Constant
from martensite.simulate.api import longest_step
from martensite.simulate.closed_loop import simulate_loop
from martensite.simulate.controlled_run import simulate_controlled

ZERO = 273.15
AMBIENTS = range(60, 201, 10)
LEGS = 8
TAIL = 0.011
"""Martensite that an endless law (Tanaka) leaves at its finish line."""
LAWS = [variants(cls)[0] for cls in registered("law")]
PARTS = [*examples("element"), *examples("mechanism")]
WIRE = write_wire()


def warmed(system: AbstractSystem, celsius: float) -> AbstractSystem:
    paths = [leaf.path for leaf in system.leaves() if leaf.path.endswith("environment.temperature")]
    return system.with_values(dict.fromkeys(paths, celsius + ZERO))


def hold(system: AbstractSystem, seconds: float, steps: int = 3) -> tuple[dict[str, float], dict[str, float]]:
    """Return the judged outputs at the start, and after a hold at zero drive."""
    drives = [0.0] * len(system.drives())
    state = system.init(floats, *drives)
    seen = [dict(zip(system.outputs(), system.observe(floats, state, *drives), strict=True))]
    for _ in range(steps):
        state, _ = system.step(floats, state, *drives, dt=seconds / steps)
    seen.append(dict(zip(system.outputs(), system.observe(floats, state, *drives), strict=True)))
    first, last = ({name: one[name] for name in system.convergence_scales()} for one in seen)
    return first, last


def lead_from_cold(law: Any, stress: float, temperature: float) -> float:
    share = law.trained_share(floats, stress)
    memory, found = law.init(floats, Fractions(1.0, share), stress, 250.0), Fractions(1.0, share)
    for k in range(1, LEGS + 1):
        memory, found = law.kinetics(floats, memory, stress, 250.0 + (temperature - 250.0) * k / LEGS, 1.0)
    return found.martensite


@pytest.mark.parametrize("law", LAWS, ids=label)
def test_the_start_of_every_law_is_its_equilibrium(law: Any) -> None:
    xi = 1.0
    for celsius in AMBIENTS:
        system: Any = warmed(example_system(law), celsius)
        first, last = hold(system, 3600.0, 1)
        xi, stress = first["martensite_fraction"], first["stress"]
        assert last["martensite_fraction"] == pytest.approx(xi, abs=1e-3 if law.rate_dependent else 1e-9), celsius
        assert last["position"] == pytest.approx(first["position"], abs=1e-6), celsius
        if not law.rate_dependent:
            assert xi == pytest.approx(lead_from_cold(law, stress, celsius + ZERO), abs=1e-9), celsius
        if hasattr(law, "A_f") and celsius + ZERO >= law.A_f + stress / law.C_A + 1.0:
            assert xi <= (TAIL if getattr(law, "endless", False) else 1e-12), celsius
    assert xi < 1e-12


@pytest.mark.parametrize("part", PARTS, ids=label)
def test_nothing_moves_from_the_start(part: Any) -> None:
    """Every element and mechanism; 46 °C lies in the reverse strip of its law."""
    system = warmed(example_system(part), 46)
    step = longest_step(system)
    first, last = hold(system, 3.0 * (step if step < 1e3 else 10.0))
    for name, least in system.convergence_scales().items():
        assert last[name] == pytest.approx(first[name], abs=1e-6 * least, rel=1e-9), name


def run_wire(runtime: str = "floats", **settings: Any) -> ms.Result:
    named = {name.replace("_", ".", 1): value for name, value in settings.items()}
    return read_scenario(WIRE, overrides=named).run(runtime=runtime)


@pytest.mark.parametrize(
    ("celsius", "settings", "sentence"),
    [
        (22, {}, "in equilibrium at 22 °C and 81.49 MPa, warmed from trained martensite (martensite fraction 1.000)."),
        (95, {}, "in equilibrium at 95 °C and 81.49 MPa, warmed from trained martensite (martensite fraction 0.000)."),
        (22, {"element_initial_fraction": 0.25}, "as given, at 22 °C and 81.49 MPa (martensite fraction 0.250)."),
    ],
)
def test_a_run_reports_its_start(celsius: int, settings: dict[str, Any], sentence: str) -> None:
    result = run_wire(environment_temperature=f"{celsius} degC", **settings)
    assert result.start == f"Start: {sentence}"
    assert result.summary().data["start"] == result.start
    assert f"{result['martensite_fraction'][0]:.3f}" in sentence


def test_loops_and_batches_report_their_start(tmp_path: Path) -> None:
    """The same words as a run; those of a batch have the range of its variants. A saved result keeps them."""
    sentence = (
        "Start: in equilibrium at 22 °C and 81.49 MPa, warmed from trained martensite (martensite fraction 1.000)."
    )
    system: Any = read_scenario(WIRE).system
    looped = simulate_loop(system, Constant(level=0.2), 1.0, 0.5).result
    controlled = simulate_controlled(system, Constant(level=0.2), 1.0, 0.5)
    assert looped.start == controlled.start == sentence
    batch = ms.run(read_scenario(WIRE), over={"environment.temperature": ["22 degC", "95 degC"]})
    found = "at 22 to 95 °C and 81.49 MPa (martensite fraction 0.000 to 1.000)."
    assert batch.start == f"Start of 2 variants: in equilibrium, warmed from trained martensite, {found}"
    batch.save(tmp_path / "batch.nc")
    assert ms.open_result(tmp_path / "batch.nc").start == batch.start


def test_the_start_reports_the_other_history_where_it_matters() -> None:
    """At 80 °C and 81 MPa the wire is in its hysteresis: warmed it is martensite still, cooled it is austenite."""
    assert run_wire(environment_temperature="80 degC").start.endswith(
        "fraction 0.776; 0.000 if cooled from austenite)."
    )


@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
def test_c_starts_as_floats_do() -> None:
    starts = [run_wire(one, environment_temperature="82 degC")["martensite_fraction"][0] for one in ("floats", "c")]
    assert 0.1 < starts[0] < 0.9
    assert starts[0] == pytest.approx(starts[1], abs=1e-12)
