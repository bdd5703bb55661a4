"""An element or its material for a host: `export umat`, `export c --part`, `export fmu --ports`.

Source of truth: the options as documented, and a C compiler that lets no warning pass.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from c_cores import STRICT
from command import Command
from fences import ROOT
from port_hosts import FLAGS

from martensite.kernels.compiler import find_compiler

EXAMPLES = ROOT / "examples"
PULL = str(EXAMPLES / "tensile-test.toml")
pytestmark = pytest.mark.usefixtures("c_compiler")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def compile_strictly(flags: tuple[str, ...], file: str) -> None:
    done = subprocess.run([str(find_compiler()), *flags, "-fsyntax-only", file], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_materials_for_hosts() -> None:
    said = Command("export", "umat").fine(PULL, "--name", "niti")
    assert "13 state variables" in said and "Caution: `lagoudas` knows tension only" in said
    deck = Path("niti_umat.inp").read_text()
    assert "*MATERIAL, NAME=NITI\n*DEPVAR\n13,\n" in deck
    assert "element.law.E_A [Pa]" in Path("niti_umat.c").read_text()
    compile_strictly(FLAGS[:4], "niti_umat.c")
    said = Command("export", "umat").fine(PULL, "--name", "loose", "--slack", "--preload", "50 MPa")
    assert "goes slack" in said and "Caution" not in said
    assert "is there already" in Command("export", "umat").refused(PULL, "--name", "niti")
    report = Command("export", "umat").report(PULL, "--name", "niti", "--force", "--preload", "50 MPa")
    assert report["name"] == "niti" and report["states"] == 8


def test_cores_of_a_part() -> None:
    for part, precision in (("material", "float64"), ("material", "float32"), ("element", "float32")):
        Command("export", "c").fine(PULL, "--part", part, "--precision", precision, "--name", part, "--force")
        compile_strictly(tuple(STRICT), f"{part}.c")
    assert not list(Path().glob("*_example.c"))
    assert "int element_try(" in Path("element.h").read_text()


def test_what_is_refused() -> None:
    umat, hand = Command("export", "umat"), str(EXAMPLES / "hand.toml")
    assert "choose the port of one: thumb_proximal_flexor" in umat.refused(hand)
    assert "thumb_proximal_flexor" in umat.refused(hand, "--port", "thumb_proximal_flexr")
    assert "one phase state" in umat.refused(str(EXAMPLES / "clamped_wire.toml"))
    assert "cannot start under compression" in umat.refused(PULL, "--slack", "--preload", "-5 MPa")
    assert "must be an identifier" in umat.refused(PULL, "--name", "ni-ti")
    assert "`--port` goes with" in Command("export", "c").refused(PULL, "--port", "element")
    assert "with `--ports`" in Command("export", "fmu").refused(PULL, "--port", "element")
    said = Command("export", "fmu").fine(PULL, "--ports", "--port", "element", "--sources-only", "--fmi", "3.0")
    assert "drive [K], elongation [m], velocity [m/s], ambient [K]" in said
