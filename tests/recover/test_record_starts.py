"""How records begin, where they end, and what a search keeps that is interrupted.

Source of truth: systems that are computed here, in motion at their first sample or with a hole in their table;
the best that any choice of `--initial` reaches; the same table split by hand.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from martensite.base.errors import ParameterError
from martensite.control.controllers.pid import PidLaw
from martensite.control.tuning.closed_loop import ControlledModel
from martensite.control.tuning.tuning import ModelTuning, tune_model
from martensite.identify.chains.estimate import Options, estimate_chain
from martensite.identify.chains.record_starts import shows_rest
from martensite.identify.chains.scores import score_chain
from martensite.identify.chains.stages import identify_stages
from martensite.identify.chains.validation import validate_chain
from martensite.logs.sampled_files import read_pieces, write_sampled
from martensite.scenario.model_files import read_model, write_model
from martensite.signals.sampling.sampled import Sampled

FEW = Options(starts=4, refined=2, anchor=0.1, start="auto")
NAMES = ("duty",), ("position",)
CURVED = "oe(1,1,1) | sigmoid3"


def curved(seed: int, before: float, share: float = 0.006, count: int = 1000, held: int = 0) -> Sampled:
    """A slow lag and a curve behind it; the lag is at `before` when the record begins."""
    chance = np.random.default_rng(seed)
    u = np.repeat(chance.uniform(0.0, 10.0, count // 25), 25)
    u[:held] = 0.0
    x, y = before, np.empty(count)
    for k, level in enumerate(u):
        y[k] = 8.0 / (1.0 + np.exp(-(x - 5.0) / 2.0))
        x += share * (level - x)
    return Sampled("log", 0.1, u, y + chance.normal(0.0, 0.02, count), *NAMES, {"position": "mm"})


def swinging(seed: int) -> Sampled:
    """A mass on a spring that is let go at 6."""
    chance = np.random.default_rng(seed)
    u = 3.0 * np.convolve(chance.normal(0.0, 1.0, 1000), np.full(20, 0.05), "same")
    x, v, y = 6.0, 0.0, np.empty(1000)
    for k, force in enumerate(u):
        y[k] = x
        v += 0.05 * (force - x - 0.15 * v)
        x += 0.1 * v
    return Sampled("swing", 0.1, u, y + chance.normal(0.0, 0.02, 1000), ("u",), ("y",))


def errors(structure: str, record: Sampled) -> dict[str, float]:
    """Root mean square of the error by the choice of the initial state, as the command has it."""
    found: dict[str, float] = {}
    for start in ("rest", "estimate", "auto"):
        options = replace(FEW, start=start, anchor=0.1 if start in ("rest", "auto") else 0.0)
        (score,) = score_chain(estimate_chain(structure, record, options).chain, [record], "estimation", start)
        found[start] = score.rms
    return found


@pytest.mark.parametrize(
    ("structure", "record"),
    [
        pytest.param(CURVED, curved(1, 14.0), marks=pytest.mark.slow),
        (CURVED, curved(2, 11.0)),
        ("poly1 | oe(2,2,1)", swinging(1)),
    ],
    ids=["hot", "warm", "swinging"],
)
def test_the_default_is_as_good_as_the_best_choice(structure: str, record: Sampled) -> None:
    found = errors(structure, record)
    best = min(found[start] for start in ("rest", "estimate"))
    assert found["auto"] <= 1.05 * best
    assert found["rest"] > 1.3 * best, "the record says nothing about the choice"


def test_a_record_that_shows_rest_is_taken_to_be_at_rest() -> None:
    record = curved(3, 0.0, 0.02, held=100)
    assert shows_rest(record)
    assert not shows_rest(curved(3, 9.0, 0.02, held=50))
    found = estimate_chain(CURVED, record, FEW)
    assert [start.kind for start in found.chain.starts.values()] == ["rest"]
    assert not found.remarks


def test_rest_that_a_record_contradicts_is_said() -> None:
    found = estimate_chain(CURVED, curved(1, 14.0), replace(FEW, start="rest"))
    assert any("does not begin at rest" in one for one in found.remarks)


def test_a_stored_model_begins_its_record_as_at_the_fit(tmp_path: Path) -> None:
    record = curved(1, 14.0, count=2000)
    found = identify_stages(record, CURVED, options=FEW)
    (score,) = found.scores
    write_model(found.model, tmp_path / "model.json")
    again = read_model(tmp_path / "model.json")
    judged = validate_chain(again, record)
    assert judged.fit == pytest.approx(score.fit, abs=1e-9)
    assert "as at the fit" in " ".join(judged.sentences)
    assert again.ranges["duty"] == (record.inputs.min(), record.inputs.max())
    new = curved(7, 12.0, count=2000)
    unseen = validate_chain(again, new)
    assert unseen.begins == "inferred from its first 20 s"
    assert unseen.fit > 93.0 > 40.0 + score_chain(again, [new], "other", "rest")[0].fit


def test_stages_in_series_keep_how_records_begin(tmp_path: Path) -> None:
    record = curved(1, 14.0)
    between = np.log(record.outputs / (8.05 - record.outputs)).clip(-4.0, 4.0)
    both = replace(record, outputs=np.hstack([between, record.outputs]), output_names=("heat", "position"))
    found = identify_stages(both, ["oe(1,1,1) | poly1 -> heat", "sigmoid3"], options=FEW)
    write_model(found.model, tmp_path / "model.json")
    last = both.with_outputs(record.outputs, ("position",))
    (score,) = score_chain(read_model(tmp_path / "model.json"), [last], "other")
    assert [score.fit] == pytest.approx(found.fit("estimation"))


def test_a_record_with_a_gap_is_as_good_as_one_split_by_hand(tmp_path: Path) -> None:
    record = curved(4, 3.0, 0.03, 1000)
    write_sampled(record, tmp_path / "whole.csv")
    lines = (tmp_path / "whole.csv").read_text("utf-8").splitlines(keepends=True)
    (tmp_path / "gap.csv").write_text("".join(lines[:401] + lines[451:]), "utf-8")
    pieces = read_pieces(tmp_path / "gap.csv", ["duty"], ["position"])
    assert [len(piece) for piece in pieces] == [400, 550]
    assert "in a gap; the record is split there into 2" in pieces[0].remarks[0]
    hand = [record.rows(0, 400), record.rows(450)]
    scored = [score_chain(estimate_chain(CURVED, r, FEW).chain, r, "estimation") for r in (pieces, hand)]
    fits = [np.mean([one.fit for one in scores]) for scores in scored]
    assert fits[0] == pytest.approx(fits[1], abs=2.0)
    assert fits[0] > 97.0


def test_a_few_missing_rows_and_irregular_times_split_nothing(tmp_path: Path) -> None:
    record = curved(4, 3.0, 0.03, 400)
    write_sampled(record, tmp_path / "whole.csv")
    lines = (tmp_path / "whole.csv").read_text("utf-8").splitlines(keepends=True)
    (tmp_path / "few.csv").write_text("".join(lines[:201] + lines[203:]), "utf-8")
    assert len(read_pieces(tmp_path / "few.csv", ["duty"], ["position"])) == 1
    kept = [lines[0], *(line for k, line in enumerate(lines[1:]) if k % 7 not in (1, 2, 3, 4, 5) or k % 3 == 0)]
    (tmp_path / "uneven.csv").write_text("".join(kept), "utf-8")
    assert len(read_pieces(tmp_path / "uneven.csv", ["duty"], ["position"])) >= 1


# ---------------------------------------------------------------- sentences


def remarks_on(record: Sampled, structure: str = "poly1 | oe(1,1,1)") -> str:
    return " ".join(estimate_chain(structure, record, replace(FEW, start="rest")).remarks)


def test_columns_that_were_mistaken_are_said() -> None:
    record = curved(5, 0.0, 0.02, held=50)
    copied = record.with_outputs(2.0 * record.inputs + 1.0)
    swapped = Sampled("log", 0.1, record.outputs, record.inputs, ("position",), ("duty",))
    assert "is input `duty` again" in remarks_on(copied)
    assert "are input and output exchanged?" in remarks_on(swapped)
    assert not remarks_on(record, CURVED)


def steep(seed: int, count: int, noise: float) -> Sampled:
    """A quick lag and a steep curve, from rest."""
    chance = np.random.default_rng(seed)
    u = np.repeat(chance.uniform(0.0, 10.0, count // 10 + 1), 10)[:count]
    u[:25] = 0.0
    x, y = 0.0, np.empty(count)
    for k, level in enumerate(u):
        y[k] = 8.0 / (1.0 + np.exp(5.0 - x))
        x += 0.08 * (level - x)
    return Sampled("log", 0.1, u, y + chance.normal(0.0, noise * y.std(), count), *NAMES)


@pytest.mark.slow
def test_a_short_record_is_said_and_a_pull_chosen() -> None:
    record, beside = steep(3, 300, 0.05), steep(99, 4000, 0.0)
    errors: dict[float | None, float] = {}
    for ridge in (0.0, None):
        found = estimate_chain("poly3 | oe(3,3,1) | sigmoid10", record, Options(starts=6, ridge=ridge))
        errors[ridge] = score_chain(found.chain, [beside], "other", "rest")[0].rms
        assert any("The records are short: 300" in one for one in found.remarks) == (ridge is None)
    assert errors[None] < 0.2 * errors[0.0]


def test_a_model_that_never_rested_gets_no_controller() -> None:
    record = curved(6, 7.0, 0.02)
    away = replace(record, inputs=8.0 + 0.3 * record.inputs)
    chain = estimate_chain("oe(1,1,1) | poly2", away, replace(FEW, start="estimate", anchor=0.0, starts=1)).chain
    task = ModelTuning(levels=((0.0, 2.0), (1.0, 10.0)), starts=((1.0, 0.1, 0.1),), evaluations=20)
    law = PidLaw(low=0.0, high=10.0)
    with pytest.raises(ParameterError, match="records hold duty from"):
        tune_model(ControlledModel(chain, law), task)
    tune_model(ControlledModel(chain, law), replace(task, beyond_data=True))
    curve = chain.with_records({}, {"duty": (0.0, 10.0), "position": (2.0, 3.0)})
    with pytest.raises(ParameterError, match="its static curve leaves what was measured"):
        tune_model(ControlledModel(curve, law), task)
    rested = estimate_chain(CURVED, curved(6, 0.0, 0.02, held=50), replace(FEW, starts=1)).chain
    tune_model(ControlledModel(rested, law), task)
    with pytest.raises(ParameterError, match="is to reach position"):
        tune_model(ControlledModel(rested, law), replace(task, levels=((0.0, 2.0), (30.0, 10.0))))


# ---------------------------------------------------------------- interruptions


@pytest.mark.parametrize("threads", [1, 2])
def test_a_search_that_is_interrupted_ends_within_a_second_with_its_best(threads: int) -> None:
    record = curved(1, 14.0, count=50_000)
    told: list[tuple[str, float]] = []

    def interrupt() -> None:
        told.append(("interrupt", time.process_time()))
        os.kill(os.getpid(), signal.SIGINT)

    def watch(text: str, share: float) -> None:
        told.append((text, 0.0))
        if len(told) == 1:
            threading.Timer(0.5, interrupt).start()

    options = replace(FEW, starts=40, threads=threads)
    found = estimate_chain("oe(1,1,1) | sigmoid10", record, options, watch)
    ended = time.process_time()  # as this machine may have other work
    (at,) = (when for text, when in told if text == "interrupt")
    assert ended - at < 1.0
    assert not found.complete
    assert np.isfinite(found.chain.simulate(record)).all()
