"""Files that are damaged, endless or absurd end in one sentence, never in a traceback or a crash.

Source of truth: the files as they were before the damage; what is read of a damaged one is what
was written, or nothing.
"""

from __future__ import annotations

import itertools
import os
from importlib.util import find_spec
from pathlib import Path

import h5py
import pytest
from command import Command
from fault_experiments import save_log
from fences import README, fences

from martensite.base.errors import DataError, InputError
from martensite.base.files import read_bounded
from martensite.logs import binary_files
from martensite.logs.binary_files import read_arrays

pytestmark = pytest.mark.usefixtures("apart")


@pytest.mark.parametrize("name", ["plain.mat", "packed.mat", "log.nc"])
def test_a_whole_log_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """What `binary logs` of the laboratory of faults damages."""
    monkeypatch.chdir(tmp_path)
    raw, columns = save_log(name)
    Path(name).write_bytes(raw)
    whole = {heading.partition(" ")[0]: values for heading, values in read_arrays(Path(name)).items()}
    assert all((whole[column] == values).all() for column, values in columns.items())


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    """The scenario of README.md."""
    path = tmp_path / "wire.toml"
    path.write_text(next(f.text for f in fences(README) if f.text.startswith("# wire.toml")))
    return path


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="has no device that never ends")
@pytest.mark.parametrize("given", ["element.material=/dev/zero", "element.material=" + 100_000 * "a"])
def test_an_absurd_material_is_a_short_sentence(scenario: Path, given: str) -> None:
    done = Command("check", str(scenario), "--set", given)()
    assert done.exit_code == 2
    assert len(done.output) < 2000
    assert "Traceback" not in done.output


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="has no pipes with a name")
@pytest.mark.parametrize("ending", [".csv", ".mat", ".nc", ".toml", ".json"])
def test_what_never_ends_is_no_file(tmp_path: Path, scenario: Path, ending: str) -> None:
    """A pipe and a device are refused, and a folder is told from a file, wherever a file is named."""
    pipe, device, folder = (tmp_path / f"{name}{ending}" for name in ("pipe", "device", "folder"))
    os.mkfifo(pipe)
    device.symlink_to("/dev/zero")
    folder.mkdir()
    settings = {"drive.waveform": '{{kind = "table", file = "{}", column = "voltage"}}', "measured": '{{file = "{}"}}'}
    if ending == ".toml":
        settings = {"element.material": "{}"}
    if ending == ".json":
        settings = {"model.file": "{}"}
    for given, path in itertools.product(settings.items(), (pipe, device, folder)):
        if ending == ".json":
            scenario.write_text(f'[model]\nfile = "{path}"\n[run]\nduration = "1 s"\n')
            done = Command("check", str(scenario))()
        else:
            change = f"{given[0]}={given[1].format(path)}"
            done = Command("run", str(scenario), "--no-figure", "--out", str(tmp_path / "o.nc"), "--set", change)()
        assert (done.exit_code, done.stdout) == (2, ""), done.output
        words = (
            ("is a folder", "Is a directory") if path is folder else ("is a device or a pipe; name an ordinary file.",)
        )
        assert any(one in done.stderr for one in words), done.stderr


def test_a_name_that_no_file_can_have_is_a_sentence(tmp_path: Path, scenario: Path) -> None:
    long = str(tmp_path / (5000 * "a"))
    for words in (["run", str(scenario), "--out", f"{long}.nc"], ["run", str(scenario), "--log", f"{long}.nc"]):
        said = Command(*words).refused()
        assert "File name too long" in said and len(said) < 400
    for given in (
        'drive.waveform={kind = "table", file = "a\\u0000b", column = "x"}',
        'element.material="./a\\u0000b.toml"',
    ):
        assert "No file has the name" in Command("check", str(scenario), "--set", given).refused()


def test_a_reader_that_does_not_come_back_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("log.nc").write_bytes(save_log("log.nc")[0])
    monkeypatch.setattr(binary_files, "LONGEST", 1e-3)
    with pytest.raises(DataError, match=r"`log\.nc` is damaged: it was not read within"):
        read_arrays(tmp_path / "log.nc")


@pytest.mark.skipif(find_spec("resource") is None, reason="has no bound of memory")
def test_a_reader_has_so_much_memory(tmp_path: Path) -> None:
    """A file of kilobytes that unpacks to more than there may be."""
    with h5py.File(tmp_path / "bomb.nc", "w") as file:
        file.create_dataset("time", (2 * binary_files.MOST_MEMORY // 8,), "f8", chunks=(2**20,), compression="gzip")
    with pytest.raises(DataError, match=r"`bomb\.nc` cannot be read"):
        read_arrays(tmp_path / "bomb.nc")


def test_a_file_is_read_up_to_a_bound(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_bytes(b"#" * 1000)
    assert len(read_bounded(path, 1000)) == 1000
    with pytest.raises(DataError, match=r"large\.toml` is larger than"):
        read_bounded(path, 999)


def test_a_word_without_end_is_shown_by_its_beginning() -> None:
    said = str(InputError(f"There is no `{'x' * 600}` in `{'y' * 400}`."))
    assert said == f"There is no `{'x' * 60}… (600 characters)` in `{'y' * 400}`."
