"""What is compiled is checked before it is loaded, and a cache that cannot be written stops nothing.

Source of truth: the same program with a whole cache.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from builders import hanging_wire

from martensite.base import files
from martensite.base.caches import make_cache
from martensite.base.errors import CompileError
from martensite.kernels import compiler
from martensite.kernels.compiler import find_compiler, is_compiled, load_library
from martensite.signals.constant import Constant
from martensite.simulate import provenance
from martensite.simulate.batch import simulate_batch

SOURCE = "long three(void) { return 3; }\n"
pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of its own, and nothing said yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("MARTENSITE_QUICK_C", "off")
    monkeypatch.setattr(files, "_TOLD", set())
    return tmp_path / "cache"


def cut_short(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:4096])


def empty(path: Path) -> None:
    path.write_bytes(b"")


def flip_a_bit(path: Path) -> None:
    raw = bytearray(path.read_bytes())
    raw[len(raw) // 2] ^= 1
    path.write_bytes(raw)


def lose_its_digest(path: Path) -> None:
    path.with_suffix(".sha256").unlink()


def come_from_another_machine(path: Path) -> None:
    """A whole library whose header names another processor."""
    raw = bytearray(path.read_bytes())
    raw[18:20] = b"\xf3\x00" if raw[18:20] != b"\xf3\x00" else b"\xb7\x00"
    path.write_bytes(raw)
    path.with_suffix(".sha256").write_text(hashlib.sha256(raw).hexdigest())


def keep_library(source: str, content: str = "") -> Path:
    """Compile a source, or another content in its place with digest and mark, into the cache without loading it."""
    command = compiler._build_command(())
    path = make_cache("c") / compiler._name_library(command, source)
    compiler._compile_source(command, content or source, path)
    return path


@pytest.mark.parametrize("damage", [cut_short, empty, flip_a_bit, lose_its_digest, come_from_another_machine])
def test_a_damaged_library_is_made_anew(cache: Path, damage: Callable[[Path], None]) -> None:
    source = f"/* {damage.__name__} */ {SOURCE}"  # a library is loaded once in a process
    path = keep_library(source)
    whole = path.read_bytes()
    assert is_compiled(source)
    damage(path)
    assert is_compiled(source) == (damage is come_from_another_machine)
    assert load_library(source).three() == 3
    assert path.read_bytes() == whole
    assert is_compiled(source)
    assert {one.stat().st_mode & 0o777 for one in path.parent.iterdir()} == {0o600}
    assert {one.stat().st_mode & 0o777 for one in (path.parent, path.parent.parent)} == {0o700}


def own_user_is_another(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every folder and file now belongs to somebody else."""
    known = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: known + 1)


def others_write_the_folder(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (cache / "martensite" / "c").chmod(0o777)


def the_group_writes_the_folder_above(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (cache / "martensite").chmod(0o770)


def others_rename_the_cache(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache.chmod(0o777)


@pytest.mark.skipif(os.name != "posix", reason="owners and modes are those of POSIX")
@pytest.mark.parametrize(
    "share", [own_user_is_another, others_write_the_folder, the_group_writes_the_folder_above, others_rename_the_cache]
)
def test_a_cache_that_others_may_write_is_not_loaded(
    cache: Path,
    share: Callable[[Path, pytest.MonkeyPatch], None],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The planted library, sound and with its digest, returns another number than its source says."""
    source = f"/* {share.__name__} */ {SOURCE}"
    path = keep_library(source, "long three(void) { return 4; }")
    planted = path.read_bytes()
    share(cache, monkeypatch)
    assert not is_compiled(source)
    assert load_library(source).three() == 3
    assert path.read_bytes() == planted
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "is not trusted" in said


@pytest.mark.skipif(os.name != "posix", reason="modes are those of POSIX")
def test_a_library_that_others_may_write_is_made_again(cache: Path) -> None:
    source = f"/* a library of mode 666 */ {SOURCE}"
    path = keep_library(source, "long three(void) { return 4; }")
    path.chmod(0o666)
    assert load_library(source).three() == 3


def test_a_library_without_its_symbols_is_made_again(cache: Path) -> None:
    """The planted library is sound, private and has its digest, but was made of another source."""
    source = f"/* a library of another source */ {SOURCE}"
    path = keep_library(source)
    other = keep_library("long two(void) { return 2; }\n")
    path.write_bytes(other.read_bytes())
    path.with_suffix(".sha256").write_bytes(other.with_suffix(".sha256").read_bytes())
    assert load_library(source).three() == 3


def test_a_whole_library_is_not_made_again(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert load_library(SOURCE).three() == 3
    monkeypatch.setattr(compiler, "_compile_source", None)
    assert load_library(SOURCE).three() == 3


def test_without_a_cache_a_folder_of_the_process_is_taken(cache: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cache.write_text("a file where the folder should be")
    for number in (4, 5):
        assert load_library(f"long number(void) {{ return {number}; }}").number() == number
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert said.startswith("Warning: what is compiled cannot be kept in the cache folder (Not a directory)")
    assert cache.read_text() == "a file where the folder should be"


def test_without_any_folder_a_batch_runs_on_floats(
    cache: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(**_: Any) -> str:
        raise OSError(28, "No space left on device")

    cache.write_text("a file where the folder should be")
    monkeypatch.setattr(tempfile, "mkdtemp", refuse)
    monkeypatch.setattr(compiler, "_make_own_folder", compiler._make_own_folder.__wrapped__)
    with pytest.raises(CompileError, match=r"no folder to compile in \(Not a directory; No space left on device\)"):
        load_library("long six(void) { return 6; }")
    masses = {"mechanism.mass": [0.5, 0.7]}
    given: tuple[Any, ...] = (hanging_wire(mass=0.6), Constant(level=1.0), 0.3, masses)
    # outputs that no other test asks for together: a program that is loaded already needs no folder
    options: dict[str, Any] = {"samples": 4, "outputs": ("strain", "heat_loss", "resistance")}
    found = simulate_batch(*given, **options)
    meant = simulate_batch(*given, **options, runtime="floats")
    assert found.runtime == meant.runtime == "floats"
    assert (found["strain"] == meant["strain"]).all()
    assert "goes on on floats" in capsys.readouterr().err


class Foreign(Constant):
    """A part that is none of this package's."""


def test_a_damaged_record_of_promises_is_none(cache: Path, capsys: pytest.CaptureFixture[str]) -> None:
    provenance.keep_record(Foreign, True, 3)
    assert provenance.find_record(Foreign) == "conforms"
    (path,) = (cache / "martensite" / "conformance").iterdir()
    for text in ("", "{}", "[]", '{"holds": 3}', "\x00"):
        path.write_text(text)
        assert provenance.find_record(Foreign) == provenance.NOT_TRIED
    path.unlink()
    path.parent.rmdir()
    path.parent.write_text("a file where the folder should be")
    provenance.keep_record(Foreign, True, 3)
    assert capsys.readouterr().err.startswith("Warning: what was found of `constant` cannot be kept")
