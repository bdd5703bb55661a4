"""Records at equal intervals: from tables and back, at other intervals, in parts, averaged.

Source of truth: closed forms of the signals that are sampled; a first-order system, whose
averages obey the same equation; the noise that was added.
"""

from __future__ import annotations

import numpy as np
import pytest

from martensite.base.errors import DataError
from martensite.signals.records import Record
from martensite.signals.sampling.regular_grid import from_record
from martensite.signals.sampling.resampling import collect_experiments, resample_record, select_signals, split_record
from martensite.signals.sampling.sampled import Sampled
from martensite.signals.sampling.trends import find_trend, remove_trend

DT = 0.1


def record(u: object, y: object, interval: float = DT, name: str = "log", start: float = 0.0):
    return Sampled(
        name, interval, np.asarray(u, float), np.asarray(y, float), ("u",), ("y",), {"u": "1", "y": "mm"}, start
    )


def table(times: list[float], **columns: list[float]) -> Record:
    units = {"time": "s", "duty": "1", "temperature": "K", "position": "m"}
    named = {"time": times, **columns}
    return Record("log", named, {name: units[name] for name in named})


def ramp(count: int = 100) -> Sampled:
    t = DT * np.arange(count)
    return record(np.sin(t), 2.0 + 3.0 * t, start=5.0)


# ---------------------------------------------------------------- from tables


def test_a_regular_table_is_taken_as_it_is() -> None:
    times = [10.0 + 0.02 * k for k in range(50)]
    found = from_record(
        table(times, duty=[0.1 * k for k in range(50)], temperature=[300.0 + k for k in range(50)]),
        ["duty"],
        ["temperature"],
    )
    assert (found.interval, found.start, len(found), found.remarks) == (0.02, 10.0, 50, ())
    assert found.units == {"duty": "1", "temperature": "degC"}
    assert found.outputs[:, 0] == pytest.approx(np.arange(50) + 26.85)
    assert found.inputs[:, 0] == pytest.approx(0.1 * np.arange(50))


def test_printed_times_may_be_rounded() -> None:
    """1/30 s printed to a millisecond: no drift of the grid over a long table."""
    times = [round(k / 30.0, 3) for k in range(5000)]
    found = from_record(table(times, duty=times, position=times), ["duty"], ["position"])
    assert len(found) == 5000
    assert found.remarks == ()
    assert found.interval == pytest.approx(1.0 / 30.0, rel=1e-5)
    again = from_record(table(times, duty=times, position=times), ["duty"], ["position"], 1 / 30)
    assert again.interval == 1 / 30
    assert len(again) == 5000


def test_rows_missing_on_the_grid_are_samples_without_outputs() -> None:
    kept = [k for k in range(40) if not (10 <= k < 14 or k == 30)]
    times = [0.5 * k for k in kept]
    found = from_record(
        table(times, duty=[float(k) for k in kept], position=[1e-3 * k for k in kept]), ["duty"], ["position"]
    )
    assert len(found) == 40
    missing = np.flatnonzero(np.isnan(found.outputs[:, 0]))
    assert missing.tolist() == [10, 11, 12, 13, 30]
    assert found.inputs[10:15, 0].tolist() == [9.0, 9.0, 9.0, 9.0, 14.0]
    assert "5 rows in 2 gaps" in found.remarks[0]


def test_irregular_times_are_brought_onto_a_grid() -> None:
    rng = np.random.default_rng(1)
    times = np.cumsum(rng.uniform(0.05, 0.15, 400))
    found = from_record(table(list(times), duty=list(times), position=list(2e-3 * times)), ["duty"], ["position"])
    assert "irregular" in found.remarks[0]
    assert found.outputs[:, 0] == pytest.approx(2.0 * found.times)  # mm, a straight line
    behind = found.times - found.inputs[:, 0]  # held from the row before
    assert behind.min() >= -1e-9
    assert behind.max() < 0.15


def test_missing_cells() -> None:
    nan = float("nan")
    times = [0.0, 1.0, 2.0, 3.0, 4.0]
    found = from_record(
        table(times, duty=[nan, 0.1, nan, nan, 0.4], position=[0.0, nan, 2e-3, 3e-3, 4e-3]), ["duty"], ["position"]
    )
    assert found.start == 1.0
    assert found.inputs[:, 0].tolist() == [0.1, 0.1, 0.1, 0.4]
    assert np.isnan(found.outputs[:, 0]).tolist() == [True, False, False, False]
    assert len(found.remarks) == 2
    nothing = table(times, duty=times, position=[nan] * 5)
    with pytest.raises(DataError, match=r"Output `position` .* missing throughout"):
        from_record(nothing, ["duty"], ["position"])


def test_what_a_table_must_hold() -> None:
    good = table([0.0, 1.0, 2.0], duty=[0.0, 1.0, 0.0], position=[0.0, 1.0, 2.0])
    with pytest.raises(DataError, match="Did you mean `duty`"):
        from_record(good, ["dutty"], ["position"])
    with pytest.raises(DataError, match="A unit is given for `positon`"):
        from_record(good, ["duty"], ["position"], units={"positon": "mm"})
    with pytest.raises(DataError, match="must increase"):
        from_record(table([0.0, 2.0, 1.0], duty=[0.0] * 3, position=[0.0] * 3), ["duty"], ["position"])


# ---------------------------------------------------------------- other intervals


def test_averages_obey_the_equation_of_the_record() -> None:
    """The mean of a first-order response is the response to the mean: no delay, no aliases."""
    rng = np.random.default_rng(2)
    u = np.repeat(rng.uniform(0.0, 1.0, 200), 10)
    y = np.zeros(len(u))
    for k in range(1, len(u)):
        y[k] = y[k - 1] + 0.05 * (u[k - 1] - y[k - 1])
    slow = resample_record(record(u, y), ratio=10.0)
    assert (slow.interval, len(slow)) == (10 * DT, 200)
    assert slow.inputs[:, 0] == pytest.approx(u[::10])
    assert slow.outputs[:, 0] == pytest.approx(y.reshape(-1, 10).mean(axis=1))
    fast = resample_record(record(np.tile([0.0, 1.0], 500), y[:1000]), ratio=4.0)
    assert fast.inputs[:, 0] == pytest.approx(np.full(250, 0.5))  # a carrier becomes its mean


def test_any_ratio_keeps_the_mean() -> None:
    given = ramp(1000)
    found = resample_record(given, interval=0.37)
    assert found.interval == pytest.approx(0.37)
    held = 2.0 + 3.0 * DT * np.floor(found.times[3] / DT - 50.0 + 1e-9)
    assert abs(found.outputs[3, 0] - held) < 3.0 * 0.37
    covered = len(found) * 0.37
    integral = found.inputs[:, 0].sum() * 0.37
    assert integral == pytest.approx(1.0 - np.cos(covered), abs=0.06)


def test_going_up_holds_inputs_and_joins_outputs() -> None:
    found = resample_record(record([0.0, 1.0, 0.5], [0.0, 4.0, 2.0]), ratio=0.25)
    assert found.inputs[:, 0].tolist() == [0.0] * 4 + [1.0] * 4 + [0.5]
    assert found.outputs[:, 0] == pytest.approx([0.0, 1.0, 2.0, 3.0, 4.0, 3.5, 3.0, 2.5, 2.0])


def test_missing_outputs_are_not_averaged_in() -> None:
    y = np.arange(12.0)
    y[[0, 4, 5, 6]] = np.nan
    found = resample_record(record(np.zeros(12), y), ratio=4.0)
    assert found.outputs[0, 0] == pytest.approx(2.0)
    assert np.isnan(found.outputs[1, 0])
    assert found.outputs[2, 0] == pytest.approx(9.5)


@pytest.mark.parametrize("given", [{}, {"interval": 0.2, "ratio": 2.0}, {"ratio": -1.0}, {"interval": 1e3}])
def test_a_wrong_interval_is_refused(given: dict[str, float]) -> None:
    with pytest.raises(DataError):
        resample_record(ramp(), **given)


# ---------------------------------------------------------------- parts


def test_split() -> None:
    first, second = split_record(ramp(), share=0.7)
    assert (len(first), len(second)) == (70, 30)
    assert second.start == pytest.approx(12.0)
    assert np.vstack([first.outputs, second.outputs]) == pytest.approx(ramp().outputs)
    first, second = split_record(ramp(), time=6.0)
    assert len(first) == 10
    with pytest.raises(DataError, match="would be empty"):
        split_record(ramp(), time=4.0)
    with pytest.raises(DataError, match="either"):
        split_record(ramp())


def test_experiments_have_names_and_fit_together() -> None:
    named = collect_experiments(ramp(), ramp(50), ramp(60).rows(0, 20, "else"))
    assert [r.name for r in named] == ["log (1)", "log (2)", "else"]
    with pytest.raises(DataError, match="sampled every"):
        collect_experiments(ramp(), resample_record(ramp(), ratio=2.0))
    other = ramp()
    other.units["y"] = "m"  # type: ignore[index]
    with pytest.raises(DataError, match="`y` is in mm and in m"):
        collect_experiments(ramp(), other)


def test_an_output_becomes_an_input() -> None:
    y = np.stack([np.arange(6.0), np.arange(6.0) ** 2], axis=1)
    y[2, 0] = np.nan
    whole = Sampled("log", DT, np.zeros(6), y, ("u",), ("T", "y"))
    stage = select_signals(whole, ["T"], ["y"])
    assert stage.inputs[:, 0] == pytest.approx(np.arange(6.0))
    assert "1 missing samples of `T`" in stage.remarks[0]
    with pytest.raises(DataError, match="has no signal `z`"):
        select_signals(whole, ["z"], ["y"])


# ---------------------------------------------------------------- levels and periods


def test_trends() -> None:
    given = ramp()
    flat, found = remove_trend(given, "line")
    assert flat.outputs == pytest.approx(np.zeros((100, 1)), abs=1e-12)
    assert (found.outputs[0], found.output_slopes[0]) == pytest.approx((2.0, 3.0))
    assert found.restore_to(flat).outputs == pytest.approx(given.outputs)
    assert found.restore_to(flat).inputs == pytest.approx(given.inputs)
    centred, _ = remove_trend(given)
    assert centred.outputs.mean() == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(DataError, match="Did you mean `mean`"):
        find_trend(given, "means")


def test_the_level_at_rest_is_that_before_the_input_moves() -> None:
    rng = np.random.default_rng(3)
    u, y = np.zeros(100), np.full(100, 23.0) + 0.01 * rng.standard_normal(100)
    u[40:], y[40:] = 1.0, 80.0
    assert find_trend(record(u, y), "rest").outputs[0] == pytest.approx(23.0, abs=0.01)
    assert find_trend(record(u, y), "rest", rest=6.0).outputs[0] > 30.0
