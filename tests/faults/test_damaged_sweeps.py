"""Stores of sweeps that were damaged: read as a sentence, and whole again after the same command.

Source of truth: the same store before it was damaged, array by array.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from command import Command
from sweep_cases import AXES, WIRE, arrays, wanted, wire

from martensite.base.errors import DataError
from martensite.design.sweep.api import Progress, SweepExecution, begin_sweep
from martensite.design.sweep.reading import open_sweep, read_sweep

Damage = Callable[[Path], object]
SERIAL = SweepExecution("serial")
TRACES = (("temperature", 4),)


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sound") / "s.zarr"
    sweep(path)
    return path


@pytest.fixture
def store(sound: Path, tmp_path: Path) -> Path:
    """A store that may be damaged."""
    return Path(shutil.copytree(sound, tmp_path / "s.zarr"))


def sweep(path: Path) -> Progress:
    return begin_sweep(wire(), wanted(traces=TRACES), path, SERIAL).run()


def flip_bit(file: Path) -> None:
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)


DAMAGES: dict[str, Damage] = {
    "flipped bit": flip_bit,
    "truncated": lambda file: file.write_bytes(file.read_bytes()[:-2]),
    "empty": lambda file: file.write_bytes(b""),
    "gone": Path.unlink,
    "a folder in its place": lambda file: (file.unlink(), file.mkdir()),
}


def spoil(store: Path, sound: Path, pattern: str) -> Iterator[str]:
    """Every damage to every file of a pattern, one after another."""
    files = sorted(file.relative_to(sound) for file in sound.glob(pattern) if file.is_file())
    assert files
    for file in files:
        for name, damage in DAMAGES.items():
            damage(store / file)
            yield f"{name}: {file}"
            shutil.rmtree(store)
            shutil.copytree(sound, store)


def refuse(path: Path) -> str:
    """The sentence with which both ways to read a store refuse it."""
    with pytest.raises(DataError) as first:
        read_sweep(path)
    with pytest.raises(DataError) as second:
        open_sweep(path)
    assert str(first.value) == str(second.value)
    return str(first.value)


def test_a_damaged_chunk_is_refused_and_made_again(store: Path, sound: Path) -> None:
    expected = dict(arrays(sound))
    for case in spoil(store, sound, "temperature/c/3/0"):
        assert "is damaged: 1 of 4 chunks are not what was written" in refuse(store), case
        again = sweep(store)
        assert (again.new_runs, again.remarks) == (3, ["1 chunk was damaged and had to be made again."]), case
        assert dict(arrays(store)) == expected, case


@pytest.mark.parametrize("name", ["made", "time of temperature"])
def test_damaged_metadata_are_refused_and_restored(store: Path, sound: Path, name: str) -> None:
    expected = dict(arrays(sound))
    for case in spoil(store, sound, f"{name}/zarr.json"):
        assert f"is damaged: `{name}`." in refuse(store), case
        assert sweep(store).new_runs == 0, case
        assert dict(arrays(store)) == expected, case
    shutil.rmtree(store / name)
    assert f"is damaged: `{name}`" in refuse(store)
    sweep(store)
    assert dict(arrays(store)) == expected


def test_a_damaged_checksum_is_one_of_a_damaged_chunk(store: Path, sound: Path) -> None:
    expected = dict(arrays(sound))
    for case in spoil(store, sound, "made/c/2"):
        if not case.startswith("gone"):  # then it is not made
            assert "(chunk 2)" in refuse(store), case
        assert sweep(store).new_runs == 3, case
        assert dict(arrays(store)) == expected, case


def test_times_that_are_damaged_are_made_again(store: Path, sound: Path) -> None:
    for case in spoil(store, sound, "time of temperature/c/0"):
        assert "`time of temperature`" in refuse(store), case
        sweep(store)
        assert dict(arrays(store)) == dict(arrays(sound)), case


def test_a_damaged_request_is_never_taken_for_another(store: Path, sound: Path) -> None:
    """A digit that is another is still a sweep, but nobody's."""
    root = store / "zarr.json"
    text = root.read_text()
    assert "0.12..0.2 mm" in text
    root.write_text(text.replace("0.12..0.2 mm", "0.13..0.2 mm"))
    assert "says of its sweep is damaged" in refuse(store)
    with pytest.raises(DataError, match="says of its sweep is damaged"):
        sweep(store)
    begin_sweep(wire(), wanted(traces=TRACES), store, SweepExecution("serial", force=True)).run()
    assert dict(arrays(store)) == dict(arrays(sound))


@pytest.mark.parametrize("command", [("sensitivity",), ("pareto", "--minimise", "stroke")])
def test_commands_say_what_is_damaged(store: Path, tmp_path: Path, command: tuple[str, ...]) -> None:
    flip_bit(store / "stroke" / "c" / "0")
    said = Command(command[0]).refused(str(store), *command[1:])
    assert "1 of 4 chunks are not what was written (chunk 0). Give the same `martensite sweep` command again" in said
    log = tmp_path / "run.nc"
    log.write_bytes(b"CDF")
    assert "is a file, and a sweep is a folder" in Command(command[0]).refused(str(log), *command[1:])


def test_the_command_goes_on_from_a_damaged_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "wire.toml").write_text(WIRE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    words = "wire.toml", *AXES, "--runtime", "floats", "--backend", "serial", "--chunk-size", "3"
    shown = Command("sweep").fine(*words)
    flip_bit(tmp_path / "wire.zarr" / "stroke" / "c" / "0")
    again = Command("sweep").fine(*words)
    assert "Warning: 1 chunk was damaged and had to be made again." in again
    assert "3 of them now" in again
    assert shown.splitlines()[0] == again.splitlines()[0]
