"""Files that are damaged, endless or absurd end in one sentence, never in a traceback or a crash.

Source of truth: the files as they were before the damage; what is read of a damaged one is what
was written, or nothing.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from command import Command
from fault_experiments import save_log
from fences import README, fences

from martensite.base.errors import DataError, InputError
from martensite.base.files import read_bounded
from martensite.scenario.sampled_files import read_arrays


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


def test_a_file_is_read_up_to_a_bound(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_bytes(b"#" * 1000)
    assert len(read_bounded(path, 1000)) == 1000
    with pytest.raises(DataError, match=r"large\.toml` is larger than"):
        read_bounded(path, 999)


def test_a_word_without_end_is_shown_by_its_beginning() -> None:
    said = str(InputError(f"There is no `{'x' * 600}` in `{'y' * 400}`."))
    assert said == f"There is no `{'x' * 60}… (600 characters)` in `{'y' * 400}`."
