"""DSC: tangents, areas, R-phase, rates and zero lines against closed forms.

Source of truth: Gaussian peaks h exp(-((T - T_p)/w)²). Their tangents at the inflections meet the baseline √2 w from
the peak, and their area is √π h w. Rates shift a peak by lag · rate.
"""

from __future__ import annotations

import json
import math
import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import Command
from fault_trials import spoil_bytes

import martensite as ms
from martensite.base.errors import DataError, MartensiteError
from martensite.logs.reader import read_parts
from martensite.physics.materials.base import load_material
from martensite.signals.records import Record

Peaks = Sequence[tuple[float, float, float]]
"""Peak [degC], width [K] and area [J/g] of each."""
HEATING: Peaks = [(66.0, 5.0, 20.0)]
COOLING: Peaks = [(20.0, 5.0, 14.0), (48.0, 3.5, 6.0)]
LAG = 18.0
"""Delay of the sample [s]."""


def make_record(
    rates: Sequence[float] = (10.0,),
    *,
    cooling: Peaks = COOLING,
    c: tuple[float, float] = (0.45, 0.47),
    sign: float = 1.0,
    zero: float = 0.02,
    noise: float = 0.0005,
    lag: float = 0.0,
    seed: int = 1,
) -> Record:
    """Return heating and cooling at each rate [K/min], in W/kg; a hold of one minute before each ramp."""
    chance = np.random.default_rng(seed)
    times, kelvin, heat = [np.zeros(1)], [np.full(1, -40.0)], list[Any]([np.zeros(1)])
    for rate in rates:
        for way, peaks in ((1.0, HEATING), (-1.0, cooling)):
            speed = way * rate / 60.0
            span = np.linspace(-40.0, 130.0, 1700)
            T = span if way > 0.0 else span[::-1]
            shift = lag * speed
            xi = sum(np.clip((T - shift - p) / (4.0 * w) + 0.5, 0.0, 1.0) * a for p, w, a in peaks)
            capacity = c[1] + (c[0] - c[1]) * xi / sum(a for _, _, a in peaks)
            for p, w, a in peaks:
                capacity = capacity + a / math.sqrt(math.pi) / w * np.exp(-(((T - shift - p) / w) ** 2))
            hold = np.arange(1.0, 60.0, 5.0)
            times += [times[-1][-1] + hold, times[-1][-1] + 60.0 + np.abs(T - T[0]) / abs(speed)]
            kelvin += [np.full(len(hold), T[0]), T]
            heat += [np.zeros(len(hold)), capacity * speed + zero]
    q = sign * (np.concatenate(heat) + noise * chance.standard_normal(sum(map(len, heat))))
    columns = {"time": np.concatenate(times), "temperature": np.concatenate(kelvin) + 273.15, "heat_flow": 1e3 * q}
    units = {"time": "s", "temperature": "K", "heat_flow": "W/kg"}
    return Record("dsc", {name: one.tolist() for name, one in columns.items()}, units)


def check_ends(found: ms.characterise.Calorimetry, within: float = 0.5) -> None:
    truth = {"A_s": (66.0, -5.0), "A_f": (66.0, 5.0), "M_s": (20.0, 5.0), "M_f": (20.0, -5.0)}
    for name, (peak, width) in truth.items():
        assert found.values[name].value - 273.15 == pytest.approx(peak + math.sqrt(2.0) * width, abs=within), name


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("baseline", ["sigmoid", "line"])
def test_tangents_areas_and_heat_capacities_are_found_in_files_of_either_sign(sign: float, baseline: str) -> None:
    found = ms.characterise.fit_calorimetry(make_record(sign=sign), baseline=baseline)
    check_ends(found)
    assert found.latent_heat is not None and found.latent_heat.value == pytest.approx(20e3, rel=0.02)
    assert found.values["R_s"].value - 273.15 == pytest.approx(48.0 + math.sqrt(2.0) * 3.5, abs=0.5)
    assert found.values["R_f"].value - 273.15 == pytest.approx(48.0 - math.sqrt(2.0) * 3.5, abs=0.5)
    assert found.heat_capacity["A"].value == pytest.approx(450.0, rel=0.02)
    assert found.heat_capacity["M"].value == pytest.approx(470.0, rel=0.02)
    areas = [peak.enthalpy for one in found.list_ramps(False) for peak in one.peaks]
    assert areas == pytest.approx([14e3, 6e3], rel=0.05)


def test_several_rates_are_extrapolated_to_rate_0_with_intervals() -> None:
    found = ms.characterise.fit_calorimetry(make_record((5.0, 10.0, 20.0, 40.0), lag=LAG, cooling=COOLING[:1]))
    check_ends(found, 1.0)
    slow = ms.characterise.fit_calorimetry(make_record((40.0,), lag=LAG, cooling=COOLING[:1]))
    assert slow.values["A_s"].value - found.values["A_s"].value == pytest.approx(LAG * 40.0 / 60.0, abs=1.0)
    low, high = found.values["A_f"].interval()
    assert high - low < 3.0


def test_a_ramp_that_ends_within_its_peak_is_left_out_or_refused() -> None:
    record = make_record()
    rows = [k for k, x in enumerate(record["temperature"]) if x < 273.15 + 66.0]
    part = Record("dsc", {n: [c[k] for k in rows] for n, c in record.columns.items()}, record.units)
    found = ms.characterise.fit_calorimetry(part)
    assert "A_s" not in found.values and "M_s" in found.values
    assert "within the peak" in " ".join(found.remarks)
    half = Record("dsc", {n: [c[k] for k in rows[: len(rows) // 2]] for n, c in record.columns.items()}, record.units)
    with pytest.raises(DataError, match="within the peak"):
        ms.characterise.fit_calorimetry(half)


def write_plain(path: Path, unit: str, factor: float) -> Path:
    record = make_record(cooling=COOLING[:1])
    rows = zip(record.times, record["temperature"], record["heat_flow"], strict=True)
    text = "\n".join(f"{t / 60:.6f},{T - 273.15:.4f},{q * factor:.6f}" for t, T, q in rows)
    path.write_text(f"Time (min),Temperature (°C),Heat Flow{unit}\n{text}\n", encoding="utf-8")
    return path


def evaluate(path: Path, *options: str) -> dict[str, Any]:
    done = Command("fit", "dsc", str(path), *options, "--json")()
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def test_the_unit_decides_what_is_asked_and_what_is_assumed(tmp_path: Path) -> None:
    plain, watts = write_plain(tmp_path / "a.csv", "", 1e-3), write_plain(tmp_path / "b.csv", " (mW)", 1e-2)
    told = evaluate(plain)
    assert told["assumed_unit"] == "W/g" and told["latent_heat"]["value"] == pytest.approx(17e3, rel=0.1)
    assert "--mass" in Command("fit", "dsc", str(watts))().stderr
    told = evaluate(watts, "--mass", "10 mg")
    assert told["assumed_unit"] == "" and told["latent_heat"]["value"] == pytest.approx(17e3, rel=0.1)
    assert "martensite fit dsc FILE" in Command("fit", str(watts))().stderr


def test_a_material_file_holds_what_was_measured(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    evaluate(write_plain(tmp_path / "a.csv", " (W/g)", 1e-3), "--out", str(path))
    found = load_material(path)
    assert found.values["A_s"].kind == "measured"
    assert found.values["A_s"].value - 273.15 == pytest.approx(66.0 - math.sqrt(2.0) * 5.0, abs=0.5)
    assert found.values["latent_heat"].value == pytest.approx(17e3, rel=0.1)


def test_spoilt_files_end_in_a_sentence(tmp_path: Path) -> None:
    """Cut, flipped, doubled or empty pieces: a result or one sentence, and no warning of a library."""
    rng = random.Random(5)
    good = write_plain(tmp_path / "good.csv", " (W/g)", 1e-3).read_bytes().splitlines(keepends=True)
    raw, found = b"".join([good[0], *good[1::12]]), 0
    for k in range(30):
        path = tmp_path / f"{k}.csv"
        path.write_bytes(spoil_bytes(raw, rng))
        try:
            files = read_parts(path, known=True)
            found += bool(ms.characterise.fit_calorimetry([one.record for one in files], mass=1e-5).values)
        except MartensiteError as error:
            assert str(error).endswith((".", "?"))
    assert found > 5
