"""A registered name belongs to one class, wherever the others come from and whoever is first."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from martensite.base.errors import InputError
from martensite.base.registry import Registry
from martensite.physics.laws.base import LAWS
from martensite.physics.laws.strip_laws import LiangRogers, Tanaka

MINE = """\
from martensite.{module} import {registry}
from martensite.{source} import {base}

@{registry}.register({arguments})
class Mine({base}):
    "A part of my own."
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, which new processes import from."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *filter(None, sys.path)]))
    return tmp_path


def python(*arguments: str) -> subprocess.CompletedProcess[str]:
    """A new process, in which nothing has been imported."""
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False)


def write_law(folder: Path, file: str, arguments: str) -> None:
    """A module with a law, registered as said."""
    law = {"module": "physics.laws.base", "registry": "LAWS", "source": "physics.laws.strip_laws"}
    text = MINE.format(**law, base="LiangRogers", arguments=arguments)
    (folder / file).write_text(text, encoding="utf-8")


def plug_in(folder: Path, name: str, module: str) -> None:
    """An installed package with an entry point."""
    about = folder / f"{module}-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[martensite.laws]\n{name} = {module}\n")


# ---------------------------------------------------------------- taken


def test_the_name_of_a_part_that_nobody_has_imported_is_taken(folder: Path) -> None:
    write_law(folder, "mine.py", '"tanaka"')
    done = python("-m", "martensite", "list", "law", "--import", "mine.py")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("error: The law name `tanaka` belongs to `Tanaka` in ")
    for words in ("strip_laws.py", "`Mine` in ", "mine.py", 'register("tanaka", replace=True)'):
        assert words in done.stderr


def test_a_name_is_taken_though_its_file_is_called_otherwise(folder: Path) -> None:
    part = {"module": "actuators.mechanisms.base", "registry": "MECHANISMS", "base": "DeadWeight"}
    words = '"antagonistic-pulley", replace=False'
    text = MINE.format(**part, source="actuators.mechanisms.load_line", arguments=words)
    (folder / "mine.py").write_text(text, encoding="utf-8")
    done = python("-m", "martensite", "list", "mechanism", "--import", "mine.py")
    assert done.returncode == 2
    taken = "The mechanism name `antagonistic-pulley` belongs to `AntagonisticPulley` in "
    assert taken in done.stderr


def test_the_name_of_a_plug_in_is_taken(folder: Path) -> None:
    plug_in(folder, "bought", "vendor")
    write_law(folder, "vendor.py", '"bought"')
    assert "bought" in python("-m", "martensite", "list", "law").stdout
    write_law(folder, "own.py", '"bought"')
    done = python("-m", "martensite", "list", "law", "--import", "own.py")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "vendor.py" in done.stderr
    assert "own.py" in done.stderr


def test_a_plug_in_that_takes_a_name_is_refused_every_time(folder: Path) -> None:
    plug_in(folder, "anything", "vendor")
    write_law(folder, "vendor.py", '"tanaka"')
    code = (
        "from martensite.base.errors import InputError\n"
        "from martensite.physics.laws.base import LAWS\n"
        "for _ in range(2):\n    try: LAWS.names()\n    except InputError as e: print(e)"
    )
    done = python("-c", code)
    assert done.stdout.count("vendor.py cannot have it") == 2, done.stderr


def test_two_classes_of_one_file_cannot_share_a_name() -> None:
    shelf: Registry[object] = Registry("law", "martensite.physics.laws")

    @shelf.register("test-twice")
    class First:
        pass

    with pytest.raises(InputError, match=r"`test-twice` belongs to .*First` in .*test_registry"):

        @shelf.register("test-twice")
        class Second:
            pass

    assert shelf["test-twice"] is First


def test_parts_of_the_package_are_refused_too() -> None:
    twin = type("Other", (LiangRogers,), {"__module__": "martensite.physics.laws.other"})
    with pytest.raises(InputError, match="cannot have it"):
        LAWS.register("tanaka")(twin)
    again = type("Tanaka", (LiangRogers,), {"__module__": "martensite.physics.laws.strip_laws"})
    with pytest.raises(InputError, match="cannot have it"):
        LAWS.register("tanaka")(again)
    assert LAWS["tanaka"] is Tanaka


# ---------------------------------------------------------------- replaced, and defined anew


def test_a_part_is_replaced_when_it_is_said(folder: Path) -> None:
    write_law(folder, "mine.py", '"tanaka", replace=True')
    code = "import mine; from martensite.physics.laws.base import LAWS; LAWS.names(); print(LAWS['tanaka'])"
    done = python("-c", code)
    assert (done.stdout, done.stderr) == ("<class 'mine.Mine'>\n", "")


def test_a_class_may_be_defined_again() -> None:
    """As in a notebook whose cell is executed twice, or a module that is loaded again."""
    shelf: Registry[object] = Registry("law", "martensite.physics.laws")

    def execute_cell() -> type:
        @shelf.register("test-again")
        class Again:
            pass

        return Again

    first, second = execute_cell(), execute_cell()
    assert shelf["test-again"] is second is not first


def test_a_file_may_be_imported_under_two_names(folder: Path) -> None:
    (folder / "laws").mkdir()
    write_law(folder / "laws", "mine.py", '"my-own"')
    code = (
        "import laws.mine\nfrom martensite.base.registry import import_modules\n"
        "import_modules(['laws/mine.py'])\nfrom martensite.physics.laws.base import LAWS\n"
        "print(LAWS['my-own'])"
    )
    done = python("-c", code)
    assert (done.stdout, done.stderr) == ("<class 'mine.Mine'>\n", "")


def test_files_of_one_name_and_broken_files_are_refused(folder: Path) -> None:
    for place in ("one", "other"):
        (folder / place).mkdir()
        write_law(folder / place, "twin.py", f'"{place}"')
    both = "--import", "one/twin.py", "--import", "other/twin.py"
    done = python("-m", "martensite", "list", "law", *both)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "other/twin.py` cannot be imported, since `twin` is the module" in done.stderr
    done = python("-m", "martensite", "list", "law", "--import", "nowhere.py")
    assert (done.returncode, done.stderr) == (2, "error: There is no file `nowhere.py`.\n")
    for text, words in (
        ("x = = 1\n", "invalid syntax (line 1 of "),
        ("\nmissing\n", "NameError: name 'missing' is not defined (line 2 of "),
    ):
        (folder / "broken.py").write_text(text, encoding="utf-8")
        done = python("-m", "martensite", "list", "law", "--import", "broken.py")
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
        assert f"Cannot import `broken.py`: {words}" in done.stderr
