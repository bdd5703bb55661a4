"""Files that are damaged, endless or absurd end in one sentence, never in a traceback or a crash.

Source of truth: the files as they were before the damage; what is read of a damaged one is what
was written, or nothing.
"""

from __future__ import annotations

import random
from pathlib import Path

import h5netcdf
import numpy as np
import pytest
from command import Command
from fences import README, fences
from scipy.io import savemat

from martensite.base.errors import DataError, InputError
from martensite.base.files import read_bounded
from martensite.scenario.sampled_files import read_arrays

TIMES = 0.02 * np.arange(500)
COLUMNS = {"time": TIMES, "duty": np.where(TIMES > 3.0, 20.0, 0.0), "position": 1.5 * TIMES}
FEW = 4
MANY = 100


def write_log(path: Path) -> bytes:
    """A whole log; its bytes."""
    if path.suffix == ".mat":
        savemat(path, COLUMNS, do_compression=path.stem == "packed")
    else:
        with h5netcdf.File(path, "w") as file:
            file.dimensions["time"] = len(TIMES)
            for name, values in COLUMNS.items():
                file.create_variable(name, ("time",), data=values)
    return path.read_bytes()


def damage_bytes(raw: bytes, seed: int) -> bytes:
    """The same with an end that is lost, bits that are flipped, or noise for its beginning."""
    rng = random.Random(seed)
    if seed % 3 == 0:
        return raw[: rng.randrange(len(raw))]
    spoilt = bytearray(raw)
    for _ in range(rng.randrange(1, 40)):
        spoilt[rng.randrange(min(len(raw), 3000))] ^= 1 << rng.randrange(8)
    return bytes(spoilt) if seed % 3 == 1 else rng.randbytes(200) + bytes(spoilt[200:])


@pytest.mark.parametrize("name", ["plain.mat", "packed.mat", "log.nc"])
@pytest.mark.parametrize("seeds", [range(FEW), pytest.param(range(FEW, MANY), marks=pytest.mark.slow)])
def test_damaged_logs_are_refused_or_read(tmp_path: Path, name: str, seeds: range) -> None:
    path = tmp_path / name
    raw = write_log(path)
    whole = {heading.partition(" ")[0]: values for heading, values in read_arrays(path).items()}
    assert all((whole[column] == values).all() for column, values in COLUMNS.items())
    for seed in seeds:
        path.write_bytes(damage_bytes(raw, seed))
        try:
            found = read_arrays(path)
        except DataError as error:
            assert path.name in str(error) and "\n" not in str(error).strip()
        else:
            assert all(values.dtype.kind in "iuf" for values in found.values())


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
