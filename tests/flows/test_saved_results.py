"""Saved results: a file opens as the result that was saved, in the format that its suffix names.

Source of truth: the result itself, field by field.
"""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np
import pytest
from fences import ROOT

import martensite as ms
from martensite.base.object_text import decode, encode
from martensite.scenario.netcdf import KEPT_RESULT

KINDS = {
    "a wire with warnings": ("pwm_bias_spring", {"drive.waveform.high": "20 V"}),
    "a profile": ("clamped_wire", {}),
    "several actuators": ("antagonistic_wires", {}),
    "a mechanism without elements": ("sommerfeld_beam", {}),
    "a closed loop": ("closed_loop", {}),
}


def same(one: object, other: object) -> bool:
    try:
        np.testing.assert_equal(other, one)
    except AssertionError:
        return False
    return True


@pytest.mark.parametrize("kind", KINDS)
def test_a_saved_result_is_opened_as_it_was(kind: str, tmp_path: Path) -> None:
    name, changes = KINDS[kind]
    scenario = ms.load(ROOT / "examples" / f"{name}.toml", changes)
    result = ms.run(scenario, duration=2.0, samples=21, restart_at=[1.0])
    result.save(tmp_path / "a.nc")
    opened = ms.open_result(tmp_path / "a.nc")
    for one in fields(result):
        assert one.name in ("trace", "begin", "judged") or same(getattr(result, one.name), getattr(opened, one.name)), (
            one.name
        )
    assert (str(opened), opened.start, opened.stroke) == (str(result), result.start, result.stroke)
    assert (opened.alarms, opened.warnings) == (result.alarms, result.warnings)
    assert opened.summary().data == result.summary().data
    assert opened.plot().axes and len(opened.restarts) == 2
    assert same(ms.run(scenario, duration=3.0, start=opened).times[-1], 3.0)


def test_a_saved_batch_is_opened_as_it_was(tmp_path: Path) -> None:
    wire = ms.load(ROOT / "examples" / "pwm_bias_spring.toml")
    batch = ms.run(wire, over={"preload": ["1 N", "2 N"]}, duration="2 s", samples=5)
    for ending in ("nc", "csv"):
        batch.save(tmp_path / f"a.{ending}")
    opened = ms.open_result(tmp_path / "a.nc")
    assert str(opened) == str(batch) and opened.variants is not None
    assert opened.stroke.tolist() == batch.stroke.tolist() and opened.plot().axes
    table = (tmp_path / "a.csv").read_text().splitlines()
    assert table[0].startswith("variant [1],mechanism.preload [N],time [s],") and len(table) == 11
    last = dict(zip(table[0].split(","), table[-1].split(","), strict=True))
    assert float(last["position [m]"]) == batch["position"][1, -1] and last["mechanism.preload [N]"] == "2.0"


def test_the_suffix_chooses_the_format_or_is_refused(tmp_path: Path) -> None:
    result = ms.run(ms.load(ROOT / "examples" / "pwm_bias_spring.toml"), duration=1.0, samples=5)
    result.save(tmp_path / "a.csv")
    assert ms.read_table(tmp_path / "a.csv")["position"].tolist() == result["position"].tolist()
    for name in ("a.txt", "a", "a.h5"):
        with pytest.raises(ms.InputError, match=r"use \.nc, \.csv, \.parquet"):
            result.save(tmp_path / name)
    assert [one.name for one in tmp_path.iterdir()] == ["a.csv"]


def test_parquet_holds_the_columns(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra `parquet` is not installed")
    result = ms.run(ms.load(ROOT / "examples" / "pwm_bias_spring.toml"), duration=1.0, samples=5)
    result.save(tmp_path / "a.parquet")
    assert parquet.read_table(tmp_path / "a.parquet")["position [m]"].to_pylist() == result["position"].tolist()


class Saw(ms.parts.AbstractWaveform):
    """A waveform of a user's own."""

    def value(self, time: float) -> float:
        return time % 1.0


@pytest.mark.parametrize(
    ("kept", "words"),
    [
        ({"class": "os:system", "items": ["echo"]}, "no class of a part"),
        ({"class": "subprocess:Popen", "named": {"args": "echo"}}, "no class of a part"),
        ({"class": "hostile_module:Part", "named": {}}, "import that module first"),
        ({"class": "martensite.base.files:write_file", "items": ["x", "y"]}, "no class of a part"),
    ],
)
def test_a_file_cannot_name_arbitrary_code(kept: object, words: str, tmp_path: Path) -> None:
    result = ms.run(ms.load(ROOT / "examples" / "pwm_bias_spring.toml"), duration=1.0, samples=5)
    result.save(tmp_path / "a.nc")
    with h5netcdf.File(tmp_path / "a.nc", "a") as file:
        text: Any = file.attrs[KEPT_RESULT]
        own = json.loads(text)
        file.attrs[KEPT_RESULT] = json.dumps(own | {"table": [*own["table"], ["system", kept]]})
    with pytest.raises(ms.InputError, match=f"cannot be opened as a result: .*{words}"):
        ms.open_result(tmp_path / "a.nc")


def test_objects_come_back_equal() -> None:
    for one in (Saw(), (1.0, [None, True, "a"]), {("a", 1): {"b": float("inf")}}, ms.Brinson):
        assert decode(json.loads(json.dumps(encode(one)))) == one
    with pytest.raises(ms.InputError, match="class `function` cannot be written"):
        encode(encode)
