"""Results of studies that are kept: found again by the same program, made anew otherwise."""

from pathlib import Path

import pytest

from martensite.studies import result_cache as module
from martensite.studies.result_cache import cache_results, find_program_folder

MADE: list[float] = []


def doubled(number: float) -> dict[str, float]:
    MADE.append(number)
    return {"twice": 2.0 * number}


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    MADE.clear()
    return tmp_path


def test_a_result_is_made_once_and_found_by_another_process() -> None:
    one = cache_results(doubled)
    assert one(1.5) == one(1.5) == cache_results(doubled)(1.5) == {"twice": 3.0}
    assert MADE == [1.5]


def test_other_arguments_have_another_result() -> None:
    assert cache_results(doubled)(1.5) != cache_results(doubled)(2.5)
    assert MADE == [1.5, 2.5]


def test_another_program_makes_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    cache_results(doubled)(1.5)
    monkeypatch.setattr(module, "_fingerprint_program", lambda: "another")
    assert cache_results(doubled)(1.5) == {"twice": 3.0}
    assert MADE == [1.5, 1.5]


@pytest.mark.parametrize("package", ["martensite", "martensite.studies"])
def test_the_program_is_its_source(package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "package" / "law.py"
    source.parent.mkdir()
    source.write_text("E_A = 75e9")
    monkeypatch.setattr(f"{package}.__path__", [str(source.parent)])
    tell = module._fingerprint_program.__wrapped__
    before = tell()
    assert tell() == before
    source.write_text("E_A = 74e9")
    assert tell() != before


def test_what_cannot_be_read_is_made_anew() -> None:
    cache_results(doubled)(1.5)
    (path,) = find_program_folder().iterdir()
    for spoiled in (b"", path.read_bytes()[:-5], b"no pickle"):
        path.write_bytes(spoiled)
        assert cache_results(doubled)(1.5) == {"twice": 3.0}
    assert len(MADE) == 4


def test_a_folder_that_cannot_be_written_to_keeps_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert cache_results(doubled)(1.5) == cache_results(doubled)(1.5) == {"twice": 3.0}
    assert MADE == [1.5, 1.5]


def test_old_programs_are_forgotten(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("a", "b", "c", "d", "e"):
        monkeypatch.setattr(module, "_fingerprint_program", lambda name=name: name)
        cache_results(doubled)(1.5)
    left = {path.name for path in (place / "martensite" / "studies").iterdir()}
    assert len(left) == module.PROGRAMS and "e" in left
