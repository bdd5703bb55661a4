"""Stages in series, and scores.

Source of truth: the system that the records were computed with (`first_order`); its noise sets
the fit that a right structure reaches.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from first_order import AMBIENT, LINE, STRUCTURE, TAU, log, pulses, ramps

from martensite.base.errors import DataError, InputError
from martensite.identify.chains.decimation import coarsen_records
from martensite.identify.chains.estimate import Options, estimate_chain
from martensite.identify.chains.goals import at_rest
from martensite.identify.chains.scores import free_run, score_chain
from martensite.identify.chains.stages import IdentifiedStages, ModelStage, identify_stages
from martensite.signals.sampling.resampling import resample_record, select_signals
from martensite.signals.sampling.sampled import Sampled

FEW = Options(starts=3, refined=3)


def stage_one(record: Sampled) -> Sampled:
    return select_signals(record, ["duty"], ["temperature"])


FITTED, SLOW = log("pulses", pulses(1)), log("ramps", ramps(), seed=2)


@pytest.fixture(scope="module")
def found() -> IdentifiedStages:
    return identify_stages(FITTED, [STRUCTURE, LINE], SLOW, options=replace(FEW, anchor=0.1))


# ---------------------------------------------------------------- stages


def test_stages_and_their_series(found: IdentifiedStages) -> None:
    assert [s.output for s in found.stages] == ["temperature", "position"]
    assert found.model.text() == "poly(2) | oe(1,1,1) | poly(1)"
    assert (found.model.input_names, found.model.output_names) == (("duty",), ("position",))
    rows = {(s.model, s.role): s for s in found.scores}
    assert len(rows) == 6
    assert min(found.fit()) > 98.0
    first = found.estimates[0].chain
    tau = dict(zip(first.names(), first.theta, strict=True))["2.log_tau"]
    assert np.exp(tau) == pytest.approx(TAU, rel=0.02)
    assert rows["stage 1", "validation"].rms == pytest.approx(0.1, rel=0.15)  # the noise
    assert rows["series", "validation"].rms == pytest.approx(0.01, rel=0.2)
    assert rows["stage 1", "validation"].unit == "degC"
    run = found.model.simulate(select_signals(SLOW, ["duty"], ["position"]))
    assert rows["series", "validation"].worst == pytest.approx(np.max(np.abs(run - SLOW.outputs[:, 1:])))


def test_rest_is_anchored(found: IdentifiedStages) -> None:
    still = np.zeros((50, 1))
    assert found.estimates[0].chain.simulate(still)[-1, 0] == pytest.approx(AMBIENT, abs=0.05)
    level = at_rest(stage_one(FITTED)).outputs[0, 0]
    assert level == pytest.approx(FITTED.outputs[:20, 0].mean())


def test_a_stage_may_give_several_outputs() -> None:
    made = identify_stages(FITTED, "ss(1,1,2,1) -> temperature, position", options=replace(FEW, starts=1))
    assert made.model.output_names == ("temperature", "position")
    assert [s.output for s in made.scores] == ["temperature", "position"]


def test_what_stages_need() -> None:
    assert ModelStage.read("poly2 -> temperature") == ModelStage("poly2", "temperature")
    assert ModelStage.read("poly2", "y") == ModelStage("poly2", "y")
    assert ModelStage.read("unit -> T, y").outputs == ("T", "y")
    with pytest.raises(InputError, match="names no output"):
        identify_stages(FITTED, ["poly1", "poly1"])
    with pytest.raises(DataError, match="no signal `temprature`"):
        identify_stages(FITTED, ["poly1 -> temprature", "poly1"])
    with pytest.raises(InputError, match="at least one stage"):
        identify_stages(FITTED, [])


# ---------------------------------------------------------------- scores and records


def test_free_runs_begin_as_is_said(found: IdentifiedStages) -> None:
    chain = found.estimates[0].chain
    late = stage_one(log("late", ramps()[120:], noise=0.0))
    late = late.rows(5)  # in motion, neither at rest nor at zero
    fits = {start: score_chain(chain, [late], "other", start)[0].fit for start in ("rest", "estimate")}
    assert fits["estimate"] > 99.0 > fits["rest"] + 1.0
    assert free_run(chain, late, "zero")[0, 0] == 0.0
    assert free_run(chain, late, "rest")[0, 0] > 20.0


def test_a_record_of_another_sample_time_is_brought_to_that_of_the_model(found: IdentifiedStages) -> None:
    fine = resample_record(stage_one(SLOW), ratio=0.5)
    (score,) = score_chain(found.estimates[0].chain, [fine], "other")
    assert (score.role, score.fit > 98.0) == ("other", True)


def test_records_thinned_together_have_one_sample_time() -> None:
    long, short = log("long", ramps(1200)), log("short", ramps(900), seed=5)
    thin = coarsen_records([long, short], most=100)
    assert thin[0].interval == pytest.approx(thin[1].interval, rel=1e-12)
    assert thin[0].interval > long.interval
    pair = [stage_one(long), stage_one(short)]
    made = estimate_chain("poly2 | oe(1,1,1)", pair, replace(FEW, starts=1))
    assert score_chain(made.chain, [stage_one(SLOW)], "other")[0].fit > 98.0


def test_records_that_say_nothing_are_refused() -> None:
    one = stage_one(FITTED)
    still = replace(one, inputs=np.full((len(one), 1), 7.0))
    empty = one.with_outputs(np.full((len(one), 1), np.nan))
    level = one.with_outputs(np.full((len(one), 1), 3.0))
    short = one.rows(19, 22)
    cases = (
        (still, "`duty` is 7 throughout"),
        (empty, "no known samples"),
        (level, "is 3 throughout"),
        (short, "4 free numbers, but the records hold 3"),
    )
    for record, words in cases:
        with pytest.raises(InputError, match=words):
            estimate_chain("poly2 | oe(1,1,1)", record, Options(starts=1))


def test_missing_outputs_do_not_hurt() -> None:
    one = stage_one(FITTED)
    outputs = one.outputs.copy()
    outputs[::3] = np.nan
    made = estimate_chain("poly2 | oe(1,1,1)", one.with_outputs(outputs), replace(FEW, starts=1))
    assert score_chain(made.chain, [stage_one(SLOW)], "other")[0].fit > 98.0
