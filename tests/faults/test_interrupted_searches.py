"""Searches that are interrupted: the best so far is a scenario to go on from.

Source of truth: the scenario that is written, loaded again, beside the one that was given.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from command import Command
from design_cases import BUNDLE

import martensite.cli.commands.design
import martensite.cli.tune_run
from martensite.scenario.scenario import load

LOOP = (Path(__file__).parents[2] / "examples" / "closed_loop.toml").read_text(encoding="utf-8")
pytestmark = pytest.mark.usefixtures("c_compiler")


@contextmanager
def interrupting_share(label: str) -> Iterator[Callable[[str, float], None]]:
    """A bar in which Ctrl-C is heard once a first sample was judged."""

    def tell(text: str, share: float) -> None:
        if share > 0.0 or text == "search 1":
            raise KeyboardInterrupt

    yield tell


def interrupt(command: Command, module: object, patch: pytest.MonkeyPatch, *words: str) -> str:
    """The sentence with which a command ends that is interrupted."""
    with patch.context() as changed:
        changed.setattr(module, "show_share", interrupting_share)
        done = command(*words)
    assert (done.exit_code, done.stdout) == (130, ""), done.output
    assert done.stderr.count("\n") == 1
    return done.stderr


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "bundle.toml").write_text(BUNDLE.replace("[run]", '[run]\nstep = "25 ms"'), encoding="utf-8")
    (tmp_path / "loop.toml").write_text(LOOP, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_design_goes_on_from_the_best_so_far(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = "--free", "strand.diameter=0.08..0.14 mm", "--free", "element.count=2..3", "--subject", "stroke >= 7 mm"
    quick = *words, "--sample", "16", "--descents", "1"
    said = interrupt(Command("design"), martensite.cli.commands.design, monkeypatch, "bundle.toml", *quick)
    assert "the best so far is in `bundle-interrupted.toml`" in said
    text = Path("bundle-interrupted.toml").read_text(encoding="utf-8")
    assert text.startswith("# best so far")
    best, given = load("bundle-interrupted.toml"), load("bundle.toml")
    assert float(best.system.value_of("element.count")) in (2.0, 3.0)
    diameter = [float(one.system.value_of("element.strand.diameter")) for one in (best, given)]
    assert 0.08e-3 <= diameter[0] <= 0.14e-3
    assert diameter[0] != diameter[1]
    interrupt(
        Command("design"), martensite.cli.commands.design, monkeypatch, "bundle.toml", *quick, "--out", "found.toml"
    )
    assert Path("found.toml").read_text(encoding="utf-8") == text


def test_a_tuning_goes_on_from_the_best_so_far(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    quick = "--free", "Kp=1..1000,Ki=1..1000", "--duration", "2 s"
    said = interrupt(Command("tune"), martensite.cli.tune_run, monkeypatch, "loop.toml", *quick)
    assert "the best so far is in `loop-interrupted.toml`: the same command with it goes on from there." in said
    before, after = (load(name).bench for name in ("loop.toml", "loop-interrupted.toml"))
    assert before is not None
    assert after is not None
    gains = [{leaf.path: leaf.value for leaf in one.controllers.leaves()} for one in (before, after)]
    changed = {path.rpartition(".")[2] for path in gains[0] if gains[0][path] != gains[1][path]}
    assert changed <= {"Kp", "Ki"}
    assert changed
