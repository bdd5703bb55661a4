"""Every part of this package keeps what its interface promises, by the suites that it ships.

Each check of each suite is shown to fail: on parts that are wrong on purpose.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import pytest
from builders import label, variants
from command import Command
from one_wire import hang, write_wire
from typer.core import TyperCommand
from wrong_parts import WRONG

from martensite.actuators.mechanisms.load_line import DeadWeight
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param
from martensite.base.registry import Registry
from martensite.cli.commands.conform import find_kind, list_commands
from martensite.fit.experiment_kinds.base import EXPERIMENT_KINDS, AbstractExperimentKind, recognise_experiment
from martensite.identify.blocks.base import BLOCKS
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.side_by_side import SideBySide
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.materials.base import Material, material_names
from martensite.physics.thermal.base import COOLING
from martensite.physics.thermal.films import ConstantCooling
from martensite.scenario.catalogue import list_registries
from martensite.studies.base import AbstractStudy
from martensite.testing import check_command, check_conformance, check_material, observers
from martensite.testing.conformance import SUITES, check_part, find_checks

SLOW = {
    "lagoudas-none-waisted-work",
    "lagoudas-none-smooth-curved",
    "lagoudas-symmetric-smooth-work",
    "lagoudas-asymmetric-smooth-work",
    "brinson-resume-symmetric",
    "elahinia-resume-asymmetric",
    "tanaka-resume-symmetric-austenite",
    "liang-rogers-resume-symmetric-austenite-strain-cosine-straight",
    "mas-polycrystal-constant-15-internal-stress",
}
SLOW |= {"r-phase-restart", "r-phase-return-point", "self-sensing-sheet"}
"""Second forms of the parts that take longest."""
REGISTRIES = list_registries(blocks=True) | {"experiment": EXPERIMENT_KINDS}
CASES = [
    pytest.param(kind, cls, id=f"{kind}-{cls.registered_name}")
    for kind, registry in REGISTRIES.items()
    for cls in (registry[name] for name in registry.names())
]


@pytest.mark.parametrize(("kind", "cls"), CASES)
def test_every_part_keeps_its_promises(kind: str, cls: Any) -> None:
    declared = not issubclass(cls, AbstractExperimentKind)
    parts = [part for part in variants(cls) if label(part) not in SLOW] if declared else []
    found = check_conformance(cls, kind, parts)
    assert found.holds, found.faults


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(SLOW))
def test_second_forms_of_long_parts_keep_their_promises(name: str) -> None:
    kind = "observer" if name.startswith("self-sensing") else "law"
    known = REGISTRIES[kind]
    (cls, part), *_ = [(known[n], p) for n in known.names() for p in variants(known[n]) if label(p) == name]
    assert check_conformance(cls, kind, [part]).faults == []


@pytest.mark.parametrize("name", material_names())
def test_every_material_keeps_its_promises(name: str) -> None:
    assert check_material(name).faults == []


@pytest.mark.parametrize(("name", "command"), [pytest.param(*one, id=one[0]) for one in list_commands()])
def test_every_command_keeps_its_promises(name: str, command: Any) -> None:
    assert check_command(command, name, find_kind(name)).faults == []


def test_blocks_that_differ_stand_side_by_side() -> None:
    both = SideBySide(blocks=(Polynomial(degree=3.0), BLOCKS["transfer-function"]()))
    assert check_conformance(SideBySide, "block", [both]).faults == []


def test_observers_without_sigma_points_rest_to_the_last_digits(monkeypatch: Any) -> None:
    monkeypatch.setattr(observers, "WITHIN", 0.0)
    for name in ("inverse-model", "extended-kalman"):
        (observer,) = variants(REGISTRIES["observer"][name])
        observers.check_rest(observer)


OTHERS: dict[str, type[Any]] = {
    "material": Material,
    "study": AbstractStudy,
    "command": TyperCommand,
    "exporter": TyperCommand,
}
"""Kinds that no scenario names."""


def test_every_kind_has_a_suite() -> None:
    assert set(SUITES) == {*REGISTRIES, *OTHERS}


# ---------------------------------------------------------------- the suites can fail


@pytest.mark.parametrize("kind", SUITES)
def test_every_check_notices_a_wrong_part(kind: str) -> None:
    registry = REGISTRIES.get(kind)
    classes = [OTHERS[kind]] if registry is None else [registry[name] for name in registry.names()]
    checks = {check.__name__ for cls in classes for check in find_checks(kind, cls)}
    found = [check_part(part, check) for part in WRONG[kind] for check in find_checks(kind, type(part))]
    assert {one.check for one in found if one.fault} == checks


# ---------------------------------------------------------------- parts of one's own


WRONG_FILM = """
from martensite.physics.thermal.base import COOLING
from martensite.physics.thermal.films import ConstantCooling


@COOLING.register("wrong-way")
class WrongWay(ConstantCooling):
    '''It heats a warm wire.'''

    def film(self, xp, temperature, ambient, shape):
        return -self.h
"""


OWN_KIND = """
from martensite.fit.experiment_kinds.base import EXPERIMENT_KINDS
from martensite.fit.experiment_kinds.isobaric import Isobaric


@EXPERIMENT_KINDS.register("own-loops")
class OwnLoops(Isobaric):
    '''Loops of temperature, recognised before all others.'''

    order = 1.0
"""


OWN_FILM = """
from martensite.physics.thermal.base import COOLING
from martensite.physics.thermal.films import ConstantCooling


@COOLING.register("own-film")
class OwnFilm(ConstantCooling):
    '''A constant film, by another name.'''
"""


@pytest.fixture
def folder(tmp_path: Any, monkeypatch: Any) -> Any:
    """With two films of somebody's own, and a cache of its own."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    files = {"wrong-way": ("wrong_way_film", WRONG_FILM), "own-film": ("an_own_film", OWN_FILM)}
    for module, text in files.values():
        (tmp_path / f"{module}.py").write_text(text)
    yield tmp_path
    for name, (module, _) in files.items():
        COOLING._entries.pop(name, None)
        sys.modules.pop(module, None)


def test_a_film_that_heats_is_refused(folder: Any) -> None:
    found = Command("conform", str(folder / "wrong_way_film.py"))()
    assert found.exit_code == 1
    assert "cooling `wrong-way` does not conform" in found.stdout


def test_a_kind_of_experiment_is_one_file(tmp_path: Any) -> None:
    file = tmp_path / "own_loops_kind.py"
    file.write_text(OWN_KIND)
    try:
        assert Command("conform", str(file))().exit_code == 0
        assert recognise_experiment(EXPERIMENT_KINDS["isobaric"]().make_example()).name == "own-loops"
    finally:
        EXPERIMENT_KINDS._entries.pop("own-loops", None)
        sys.modules.pop("own_loops_kind", None)


def test_an_unknown_name_is_answered_with_the_nearest_names() -> None:
    sentence = Command("conform").refused("flexinol-9")
    assert "Did you mean `flexinol-90` or `flexinol-70`?" in sentence
    assert "`martensite list`" in sentence
    assert len(sentence) < 400


SCENARIO = write_wire(
    cooling='{ kind = "own-film", h = "70 W/m^2/K" }',
    mechanism=hang("500 g"),
    drive='kind = "current"\nwaveform = { kind = "step", high = "0.1 A" }',
    run='duration = "1 s"',
)


def test_a_run_says_whether_a_foreign_part_was_tried(folder: Any) -> None:
    scenario, film = folder / "own.toml", str(folder / "an_own_film.py")
    scenario.write_text(SCENARIO)
    out = ["--json", "--force", "--no-figure", "--out", str(folder / "own.nc")]
    call = Command("run", str(scenario), "--import", film, *out)
    assert json.loads(call().stdout)["conformance"] == {"own-film": "not tried"}
    assert Command("conform", film)().exit_code == 0
    assert json.loads(call().stdout)["conformance"] == {"own-film": "conforms"}
    (folder / "an_own_film.py").write_text(OWN_FILM + "# another\n")
    assert json.loads(call().stdout)["conformance"] == {"own-film": "not tried"}
    plain = json.loads(Command("run", "examples/pwm_bias_spring.toml", *out)().stdout)
    assert plain["conformance"] == {}


def test_conformance_is_there_as_json() -> None:
    (found,) = json.loads(Command("conform", "dead-weight", "--json")().stdout)
    assert (found["name"], found["kind"], found["holds"]) == ("dead-weight", "mechanism", True)
    assert {one["check"] for one in found["findings"]} == {
        check.__name__ for check in find_checks("mechanism", DeadWeight)
    }


def test_an_unknown_part_is_named_with_the_nearest(tmp_path: Any) -> None:
    found = Command("conform", "tanaki")()
    assert found.exit_code == 2
    assert "Did you mean `tanaka`?" in found.stderr
    empty = tmp_path / "without_parts.py"
    empty.write_text("x = 1\n")
    assert "registers no part" in Command("conform", str(empty))().stderr


def test_a_part_without_typical_values_is_told_what_to_declare() -> None:
    class Bare(ConstantCooling):
        """Needs a number of no typical size."""

        more: Number = param("1", "something")

    with pytest.raises(ParameterError, match=r"`more` of `Bare` has neither a default nor a"):
        check_conformance(Bare, "cooling")


def test_a_registry_of_no_suite_is_said() -> None:
    kinds: Registry[Any] = Registry("toy", "martensite.physics.laws")
    with pytest.raises(Exception, match="There is no suite for the kind `toy`"):
        check_conformance(LiangRogers, kinds.kind)
