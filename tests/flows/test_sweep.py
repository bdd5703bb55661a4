"""A sweep from its words to its store: what is kept, where, and that it goes on as it began.

Sources of truth: single runs of the scenario with the same numbers, and the same sweep made in
another way.
"""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sweep_cases import OVER, WIRE, arrays, wanted, wire

from martensite.base.errors import DataError, InputError
from martensite.base.status import Status
from martensite.design.sweep import reading
from martensite.design.sweep import store as stores
from martensite.design.sweep.api import SweepExecution, begin_sweep, parse_share, run_sweep
from martensite.design.sweep.job import MEASURES, SweepJob, SweepRequest, build_spec, prepare_plan
from martensite.design.sweep.plan import SweepPiece, SweepPlan
from martensite.design.sweep.reading import open_sweep
from martensite.design.sweep.store import Store, create_store
from martensite.simulate.ensembles import Ensemble

SERIAL = SweepExecution("serial")
TRACES = (("position", 6), ("temperature", 3))


def plan(*over: str, text: str = WIRE, **more: Any) -> SweepPlan:
    return prepare_plan(wire(text), wanted(*over, **more))[0]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep with traces, made in one go."""
    path = tmp_path_factory.mktemp("sweep") / "whole.zarr"
    begin_sweep(wire(), wanted(traces=TRACES), path, SERIAL).run()
    return path


# ---------------------------------------------------------------- what is kept


def test_rows_are_single_runs(whole: Path) -> None:
    group = Store(whole).group
    for row in (0, 5, 11):
        diameter = float(group["element.diameter"][row])
        high = float(group["drive.waveform.high"][row])
        assert diameter == pytest.approx(0.12e-3 + 0.04e-3 * (row // 4), rel=1e-12)
        assert high == pytest.approx(2.0 + 2.0 / 3.0 * (row % 4), rel=1e-12)
        alone = wire(element__diameter=f"{diameter!r} m", drive__waveform__high=f"{high!r} V").run()
        assert group["max(temperature)"][row] == max(alone["temperature"])
        assert group["stroke"][row] == np.ptp(alone["position"])
        assert group["position"][row].tolist() == list(alone["position"])[::2]
        assert group["temperature"][row].tolist() == list(alone["temperature"])[::5]
    assert group["status"][:].tolist() == [0] * 12


def test_a_store_holds_all_that_is_needed(whole: Path) -> None:
    store = Store(whole)
    assert store.spec["scenario"] == WIRE
    assert SweepRequest.of_spec(store.spec) == replace(wanted(traces=TRACES), step=0.1)
    array: Any = store.group["element.diameter"]
    assert (array.attrs["units"], array.metadata.dimension_names) == ("m", ("run",))
    assert store.group["time of position"][:] == pytest.approx(np.linspace(0.0, 2.0, 6))
    assert "refused" in store.group["status"].attrs["flag_meanings"]
    assert set(store.group.array_keys()) == {
        "element.diameter",
        "drive.waveform.high",
        *MEASURES,
        "position",
        "temperature",
        "time of position",
        "time of temperature",
        "status",
        "ended",
        "accuracy",
        "made",
    }


def test_any_stretch_of_runs_is_that_of_the_whole() -> None:
    known = plan(chunk=12)
    every = known.compute(range(12))
    for rows in (range(0, 1), range(4, 9), range(11, 12)):
        part = known.compute(rows)
        for words in MEASURES:
            assert np.array_equal(part.scalars[words], every.scalars[words][rows])
        assert np.array_equal(part.values, every.values[rows])


@pytest.mark.parametrize("chunk", [1, 5, 100])
def test_the_size_of_chunks_does_not_matter(chunk: int, whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "other.zarr"
    begin_sweep(wire(), wanted(traces=TRACES, chunk=chunk), path, SERIAL).run()
    known = dict(arrays(path))
    assert all(known[name] == data for name, data in arrays(whole) if name != "made")


def test_another_seed_is_noticed(tmp_path: Path) -> None:
    paths = []
    for seed in (0, 1):
        paths.append(tmp_path / f"{seed}.zarr")
        sample = wanted("diameter=0.12..0.2 mm", sample="sobol:3", seed=seed)
        begin_sweep(wire(), sample, paths[-1], SERIAL).run()
    assert dict(arrays(paths[0])) != dict(arrays(paths[1]))


def test_failed_runs_keep_their_status_and_no_numbers() -> None:
    known = plan(traces=TRACES)
    good = known.compute(range(3))
    columns = {n: np.ones((3, 11)) for n in known.outputs}
    status = np.array([0, Status.UNSOLVED, 1], np.int8)
    kept = known._collect_results(
        good.values, Ensemble(columns, status, np.zeros(3), np.zeros(3), np.ones((len(known.measures), 3)))
    )
    for words in MEASURES:
        assert np.isfinite(kept.scalars[words]).tolist() == [True, False, True]
    lost = known.make_lost_piece(range(5, 7))
    assert lost.status.tolist() == [Status.LOST] * 2
    assert np.isnan(lost.traces["position"]).all()
    assert np.array_equal(lost.values, known.compute(range(5, 7)).values)


def test_refused_runs_are_rows_and_the_others_are_not_touched() -> None:
    axes = "A_s=68, 95, 68 degC", "high=2..4 V:4"  # 95 degC is above A_f
    scenario = wire()
    limit = scenario.system.value_of("element.law.A_f") - 273.15
    assert limit < 95.0
    known = plan(axes[0].replace("95", "70"), axes[1]).compute(range(12))
    found = plan(*axes).compute(range(12))
    assert found.status.tolist() == [0] * 4 + [Status.REFUSED] * 4 + [0] * 4
    for words in MEASURES:
        others = np.r_[0:4, 8:12]
        assert np.array_equal(found.scalars[words][others], known.scalars[words][others])
        assert np.isnan(found.scalars[words][4:8]).all()


# ---------------------------------------------------------------- going on


def test_a_sweep_in_parts_is_the_whole(whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "parts.zarr"
    for part in ("2/3", "1/3", "1/3", "3/3"):
        begun = begin_sweep(wire(), wanted(traces=TRACES), path, replace(SERIAL, part=part))
        assert begun.part == parse_share(4, part)
        begun.run()
    assert dict(arrays(path)) == dict(arrays(whole))


def test_a_store_that_was_moved_goes_on(whole: Path, tmp_path: Path) -> None:
    """Another folder is no other sweep."""
    first, second = tmp_path / "here.zarr", tmp_path / "there.zarr"
    begin_sweep(wire(), wanted(traces=TRACES), first, replace(SERIAL, part="1/2")).run()
    first.rename(second)
    moved = replace(wire(), path=tmp_path / "elsewhere" / "wire.toml")
    begun = begin_sweep(moved, wanted(traces=TRACES, runtime=None), second, SERIAL)
    assert begun.plan.course.runtime == "floats"
    assert begun.run().new_runs == 6
    assert dict(arrays(second)) == dict(arrays(whole))


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"seed": 3}, "seed `0` there, `3` here"),
        ({"chunk": 4}, "runs in a chunk `3` there, `4` here"),
        ({"step": 0.05}, "step `0.1` there, `0.05` here"),
        ({"measures": ("stroke",)}, r"measures.*`\[\"stroke\"\]` here"),
        ({"over": ("diameter=0.12..0.2 mm:2",)}, "axes"),
        ({"sample": "sobol:12"}, "sample `grid` there, `sobol:12` here"),
        ({"traces": (("position", 5),)}, "traces"),
    ],
)
def test_another_sweep_is_refused(changed: Any, sentence: str, whole: Path) -> None:
    with pytest.raises(DataError, match=f"another sweep: .*{sentence}.*--force"):
        begin_sweep(wire(), replace(wanted(traces=TRACES), **changed), whole, SERIAL)


def test_another_scenario_is_refused_with_its_first_line(whole: Path) -> None:
    other = wire(WIRE.replace("250 mm", "240 mm"))
    sentence = r"scenario `length = \"250 mm\"` there, `length = \"240 mm\"` here\. Choose"
    with pytest.raises(DataError, match=sentence):
        begin_sweep(other, wanted(traces=TRACES), whole, SERIAL)


def test_numbers_that_do_not_stand_in_the_scenario_are_watched(whole: Path) -> None:
    scenario = wire()
    same = replace(scenario, system=scenario.system.with_values({"element.law.E_A": 7e10}))
    with pytest.raises(DataError, match="numbers in files that the scenario names differ"):
        begin_sweep(same, wanted(traces=TRACES), whole, SERIAL)


def test_what_is_no_sweep_is_left_alone(tmp_path: Path) -> None:
    other = tmp_path / "precious"
    other.mkdir()
    (other / "thesis.tex").touch()
    for how in (SERIAL, replace(SERIAL, force=True)):
        with pytest.raises(DataError, match="holds no sweep"):
            begin_sweep(wire(), wanted(), other, how)
    assert (other / "thesis.tex").exists()


def test_force_replaces_a_sweep_once_all_is_right(tmp_path: Path) -> None:
    path = tmp_path / "s.zarr"
    begin_sweep(wire(), wanted(), path, SERIAL).run()
    before, force = dict(arrays(path)), replace(SERIAL, force=True)
    with pytest.raises(InputError):
        begin_sweep(wire(), wanted("diametr=0.1..0.2 mm:2"), path, force)
    with pytest.raises(InputError, match="other parts"):
        begin_sweep(wire(), wanted(), path, replace(force, part="1/2"))
    assert dict(arrays(path)) == before
    assert begin_sweep(wire(), wanted(seed=2), path, force).run().new_runs == 12


# ---------------------------------------------------------------- plans


@pytest.mark.parametrize(
    ("over", "more", "sentence"),
    [
        ((), {"over": ()}, "needs varied parameters"),
        (("diametr=0.1..0.2 mm:2",), {}, "Did you mean"),
        (("diameter=0.1..0.2 mm:2", "element.diameter=0.1, 0.2 mm"), {}, "varied twice"),
        (("diameter=0..0.2 mm:2",), {}, "diameter"),
        (OVER, {"measures": ("strok",)}, "Did you mean `stroke`"),
        (OVER, {"measures": ("max(stres)",)}, "Did you mean `stress`"),
        (OVER, {"measures": ("at(position, time=9 s)",)}, "the run ends at 2 s"),
        (OVER, {"measures": ()}, "at least one output"),
        (OVER, {"traces": (("strss", 3),)}, "Did you mean `stress`"),
        (OVER, {"sample": "sobl:8"}, "Did you mean `sobol`"),
        (OVER, {"sample": "sobol"}, "sobol:1024"),
        (OVER, {"sample": "grid:8"}, "levels"),
        (OVER, {"chunk": 0}, "at least one run"),
        (OVER, {"runtime": "floets"}, "Did you mean `floats`"),
        (OVER, {"precision": "float32"}, "float32 on CUDA"),
    ],
)
def test_wrong_plans_are_refused(over: Any, more: Any, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=sentence):
        begin_sweep(wire(), replace(wanted(*over), **more), tmp_path / "no.zarr", SERIAL)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("words", ["0/2", "3/2", "1", "a/b", "1/", "-1/2"])
def test_wrong_parts_are_refused_before_anything_is_made(words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"1/"):
        begin_sweep(wire(), wanted(), tmp_path / "no.zarr", replace(SERIAL, part=words))
    assert list(tmp_path.iterdir()) == []


def test_parts_share_all_chunks_once() -> None:
    shares = [parse_share(10, f"{i}/4") for i in (1, 2, 3, 4)]
    assert sorted(c for share in shares for c in share) == list(range(10))
    assert parse_share(10, None) == range(10)
    assert list(parse_share(2, "4/4")) == []


@pytest.mark.parametrize(
    ("backend", "sentence"),
    [
        (SweepExecution("proceses"), "Did you mean `processes`"),
        (SweepExecution("serial", workers=2), "`--workers` has no effect on the backend `serial`"),
        (SweepExecution("processes", scheduler="tcp://a:1"), "`--scheduler` has no effect"),
        (SweepExecution("dask", workers=2, scheduler="tcp://a:1"), "leave out"),
    ],
)
def test_wrong_backends_are_refused(backend: SweepExecution, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        backend.make_backend(9, "c")


FREE = WIRE.replace('step = "0.1 s"', "tolerance = 1e-3")


def test_energy_of_pulses_does_not_depend_on_the_samples(c_compiler: str) -> None:
    pulses = FREE.replace(
        '"step", high = "3 V", at = "0.1 s", until = "1.3 s"', '"pwm", high = "3 V", frequency = "10 Hz", duty = 0.4'
    )
    texts = pulses, pulses.replace("samples = 11", "samples = 201")
    few, many = (plan(text=text, measures=("energy", "max(power)"), runtime="c") for text in texts)
    assert few.cautions() == []
    for words in few.measures:
        columns = [one.compute(range(2)).scalars[words] for one in (few, many)]
        assert columns[0] == pytest.approx(columns[1], rel=5e-3)
        assert (columns[0] > 0.0).all()


def test_runs_to_a_tolerance_say_how_accurate_they_are(tmp_path: Path, c_compiler: str) -> None:
    begin_sweep(wire(FREE), wanted(runtime="c", traces=TRACES), tmp_path / "s.zarr", SERIAL).run()
    group = Store(tmp_path / "s.zarr").group
    assert group["status"][:].tolist() == [0] * 12
    assert group["ended"][:].tolist() == [2.0] * 12
    for row in (0, 5, 11):
        diameter = float(group["element.diameter"][row])
        high = float(group["drive.waveform.high"][row])
        changed = {"element__diameter": f"{diameter!r} m", "drive__waveform__high": f"{high!r} V"}
        alone = wire(FREE, run__tolerance=1e-6, **changed).run()
        for name, every in (("position", 2), ("temperature", 5)):
            off = np.abs(group[name][row] - alone[name][::every]).max()
            assert off <= (group["accuracy"][row] + 1e-6) * alone.range(name)
    assert (np.asarray(group["accuracy"][:]) <= 1e-3).all()


def test_runs_that_leave_the_envelope_are_rows(tmp_path: Path, c_compiler: str) -> None:
    path = tmp_path / "s.zarr"
    asked = wanted("high=2, 300 V", runtime="c", traces=TRACES, measures=("stroke",))
    begin_sweep(wire(FREE), asked, path, SERIAL).run()
    found = open_sweep(path).load()
    assert found["status"].values.tolist() == [Status.OK, Status.OUT_OF_ENVELOPE]
    assert np.isfinite(found["stroke"].values).tolist() == [True, False]
    assert 0.1 < found["ended"].values[1] < 0.2
    assert np.isfinite(found["position"].values[1]).tolist() == [True] + [False] * 5
    assert np.isfinite(found["position"].values[0]).all()


def test_sweeps_in_float32_need_a_step() -> None:
    with pytest.raises(InputError, match="`--step`"):
        plan(text=FREE, runtime="cuda", precision="float32")


# ---------------------------------------------------------------- jobs in other processes


def test_a_job_travels_and_refuses_to_make_another_sweep(tmp_path: Path) -> None:
    made, chosen = prepare_plan(wire(), wanted())
    spec = build_spec(wire(), chosen)
    create_store(tmp_path / "s.zarr", made, spec)
    job = pickle.loads(pickle.dumps(SweepJob(tmp_path / "s.zarr", json.dumps(spec))))
    assert job(2).status == {0: 3}
    assert Store(tmp_path / "s.zarr").list_finished_chunks() == {2}
    for wrong, sentence in (
        ({"version": "0.0.1"}, "version of martensite `0.0.1` there"),
        ({"numbers": "another"}, "numbers in files"),
        ({"modules": ["no_such_module"]}, "Cannot import `no_such_module`"),
        ({"runtime": "floets"}, "Did you mean"),
    ):
        other = SweepJob(tmp_path / "s.zarr", json.dumps({**spec, **wrong}))
        with pytest.raises(Exception, match=f"cannot make this sweep: .*{sentence}") as raised:
            other(0)
        assert str(pickle.loads(pickle.dumps(raised.value))) == str(raised.value)


# ---------------------------------------------------------------- summaries


def test_summaries_in_stretches_are_those_of_the_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made, chosen = prepare_plan(wire(), wanted("high=2..4 V:1000", chunk=41))
    store = create_store(tmp_path / "s.zarr", made, build_spec(wire(), chosen))
    rng, kept = np.random.default_rng(1), []
    for chunk in range(made.chunks):
        rows = made.rows(chunk)
        numbers = np.round(rng.standard_normal(len(rows)) ** 3, 3)
        numbers[rng.random(len(rows)) < 0.1] = np.nan
        status = np.where(np.isnan(numbers), 5, 0).astype(np.int8)
        if chunk == 10:
            continue  # missing
        scalars: dict[str, Any] = dict.fromkeys(made.measures, numbers)
        names = [one.target.name for one in made.axes]
        store.write(chunk, rows, SweepPiece(made.values(rows), scalars, {}, status), names)
        kept += numbers[np.isfinite(numbers)].tolist()
    expected = min(kept), float(np.median(kept)), max(kept)
    counts, first = reading.count_statuses(store, 2)
    monkeypatch.setattr(stores, "STRETCH", 90)
    assert len(list(store.stretches())) > 10
    assert reading.compute_spread(store, "stroke") == expected
    assert reading.count_statuses(store, 2) == (counts, first)
    assert (counts[0], counts[5]) == (len(kept), made.size - 41 - len(kept))
    assert len(first[5]) == 2


def test_many_runs_are_planned_without_holding_them() -> None:
    known = plan("diameter=0.12..0.2 mm", "high=2..4 V", sample="sobol:100000000")
    assert known.chunks == 33333334
    last = known.rows(known.chunks - 1)
    assert len(last) == 1


# ---------------------------------------------------------------- from Python


def test_the_function_is_the_command(whole: Path, tmp_path: Path) -> None:
    told: list[int] = []
    found = run_sweep(
        wire(),
        over=OVER,
        out=tmp_path / "s.zarr",
        traces=TRACES,
        backend="serial",
        chunk=3,
        runtime="floats",
        step="100 ms",
        tell=lambda now: told.append(now.done),
    )
    assert told == [0, 3, 6, 9, 12]
    assert dict(arrays(tmp_path / "s.zarr")) == dict(arrays(whole))
    assert found["stroke"].values.ravel().tolist() == Store(whole).group["stroke"][:].tolist()


@pytest.mark.parametrize(
    ("how", "chunks", "runtime", "name"),
    [
        (SweepExecution(), 2, "c", "serial"),
        (SweepExecution(), 3, "c", "processes"),
        (SweepExecution(), 9, "cuda", "serial"),
        (SweepExecution(workers=2), 1, "c", "processes"),
        (SweepExecution(scheduler="tcp://a:1"), 9, "c", "dask"),
    ],
)
def test_who_runs_chunks_by_itself(how: SweepExecution, chunks: int, runtime: str, name: str) -> None:
    assert how.make_backend(chunks, runtime).registered_name == name
