"""Staircases: counters mended, plateaus averaged, offsets found; what is refused.

Source of truth: staircases made here from known levels, offsets and resistances.
"""

from __future__ import annotations

import math
import random
from statistics import mean, stdev

import pytest
from hypothesis import given
from hypothesis import strategies as st

from martensite.base.errors import DataError, ParameterError
from martensite.signals.records import Record
from martensite.studies.electrothermal.staircase import reduce_to_plateaus, supply_offset, unwrap_counter

STEPS = st.lists(st.integers(0, 100), min_size=1, max_size=60)
UNITS = {"time": "s", "level": "V", "current": "A"}


def staircase(levels, rows=10, resistance=1.5, offset=0.23, scatter=0.0) -> Record:
    """A record of `rows` seconds on each level; the current settles over the first half."""
    noise = random.Random(1)
    level = [v for v in levels for _ in range(rows)]
    current = [
        (v - offset) / resistance + (0.1 if i % rows < rows // 2 else noise.gauss(0.0, scatter))
        for i, v in enumerate(level)
    ]
    times = [float(i) for i in range(len(level))]
    return Record("made", {"time": times, "level": level, "current": current}, UNITS)


# ---------------------------------------------------------------- counter


@given(STEPS, st.sets(st.integers(1, 59), max_size=4))
def test_a_mended_counter_is_the_staircase_it_was(steps, places) -> None:
    true = [float(sum(steps[: i + 1])) for i in range(len(steps))]
    jumps = sorted(i for i in places if i < len(true))
    shown = [v - 300.0 * sum(i >= j for j in jumps) for i, v in enumerate(true)]
    found = unwrap_counter(shown, 300.0)
    assert found.values == true
    assert found.jumps == jumps


def test_only_falls_by_about_the_drop_are_mended() -> None:
    small, large, rise = [5.0, 3.6, 5.0], [9.0, 4.0, 9.0], [1.0, 4.0, 4.5]
    for values in (small, large, rise, [2.0], []):
        found = unwrap_counter(values, 3.0)
        assert (found.values, found.jumps) == (values, [])
    found = unwrap_counter([3.9, 3.9, 1.0, 1.1], 3.0)
    assert found.values == pytest.approx([3.9, 3.9, 4.0, 4.1])
    assert found.jumps == [2]


@pytest.mark.parametrize("drop", [0.0, -3.0, math.inf, math.nan])
def test_a_drop_must_be_a_number_above_zero(drop) -> None:
    with pytest.raises(ParameterError, match="`drop` must be above 0"):
        unwrap_counter([1.0], drop)


# ---------------------------------------------------------------- plateaus


def test_one_row_per_plateau_from_its_settled_half() -> None:
    record = staircase([1.0, 1.1, 1.2], scatter=0.01)
    table = reduce_to_plateaus(record, "level")
    assert table["level"].tolist() == [1.0, 1.1, 1.2]
    assert table["count"].tolist() == [5.0, 5.0, 5.0]
    assert table.times.tolist() == [7.0, 17.0, 27.0]
    for k in range(3):
        settled = record["current"][10 * k + 5 : 10 * k + 10]
        assert table["current"][k] == pytest.approx(mean(settled), rel=1e-14)
        assert table["current_deviation"][k] == pytest.approx(stdev(settled), rel=1e-12)
    assert table.units["current_deviation"] == "A"
    assert table.units["count"] == "1"
    assert table.dropped == 0


def test_the_whole_plateau_differs_where_it_has_not_settled() -> None:
    record = staircase([1.0, 1.1])
    half, whole = (reduce_to_plateaus(record, "level"), reduce_to_plateaus(record, "level", settled=1.0))
    assert half["current"][0] == pytest.approx((1.0 - 0.23) / 1.5, rel=1e-14)
    assert whole["current"][0] == pytest.approx(half["current"][0] + 0.05, rel=1e-12)
    assert max(half["current_deviation"]) < 1e-15 < min(whole["current_deviation"])


def test_a_level_that_returns_is_another_plateau() -> None:
    assert reduce_to_plateaus(staircase([1.0, 2.0, 1.0]), "level")["level"].tolist() == [1.0, 2.0, 1.0]


def test_a_noisy_level_needs_a_tolerance() -> None:
    record = staircase([1.0, 1.1])
    noisy = [v + 0.002 * (i % 2) for i, v in enumerate(record["level"])]
    record = Record("noisy", record.columns | {"level": noisy}, UNITS)
    with pytest.raises(DataError, match="`level` of record `noisy` has no plateau of at least 2"):
        reduce_to_plateaus(record, "level")
    assert reduce_to_plateaus(record, "level", tolerance=0.01)["level"].tolist() == [1.0, 1.1]


def test_short_plateaus_are_left_out_and_counted() -> None:
    record = staircase([1.0, 1.1])
    columns = {name: values[:13] for name, values in record.columns.items()}
    table = reduce_to_plateaus(Record("cut", columns, UNITS), "level", shortest=5)
    assert table["level"].tolist() == [1.0]
    assert table.dropped == 3


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"settled": 0.0}, "`settled` must be above 0 to 1"),
        ({"settled": 1.1}, "`settled` must be above 0 to 1"),
        ({"tolerance": -1.0}, "`tolerance` must be at least 0"),
        ({"shortest": 1}, "`shortest` must be at least 2"),
    ],
)
def test_bad_arguments_are_refused(arguments, sentence) -> None:
    with pytest.raises(ParameterError, match=sentence):
        reduce_to_plateaus(staircase([1.0]), "level", **arguments)


def test_a_missing_column_and_a_taken_name_are_refused() -> None:
    with pytest.raises(DataError, match=r"no column `levl`. Did you mean `level`"):
        reduce_to_plateaus(staircase([1.0]), "levl")
    record = staircase([1.0])
    record = Record("twice", record.columns | {"count": record.times}, UNITS | {"count": "1"})
    with pytest.raises(DataError, match="has a column `count` already"):
        reduce_to_plateaus(record, "level")


# ---------------------------------------------------------------- offset


def test_offset_and_resistance_are_found_again() -> None:
    levels = [1.0 + 0.1 * k for k in range(13)]
    exact = supply_offset(reduce_to_plateaus(staircase(levels), "level"), "level", "current", 1.0, 2.2)
    assert exact.offset == pytest.approx(0.23, abs=1e-12)
    assert exact.resistance == pytest.approx(1.5, rel=1e-12)
    assert exact.offset_error < 1e-12
    assert exact.count == 13


def test_errors_are_those_of_numpy() -> None:
    np = pytest.importorskip("numpy")
    levels = [1.0 + 0.1 * k for k in range(13)]
    table = reduce_to_plateaus(staircase(levels, scatter=0.02), "level")
    found = supply_offset(table, "level", "current", 1.0, 2.2)
    (slope, offset), cov = np.polyfit(table["current"], table["level"], 1, cov=True)
    assert (found.resistance, found.offset) == pytest.approx((slope, offset), rel=1e-9)
    errors = found.resistance_error, found.offset_error
    assert errors == pytest.approx(tuple(np.sqrt(np.diag(cov))), rel=1e-9)
    assert abs(found.offset - 0.23) < 4.0 * found.offset_error


def test_a_wire_that_resists_more_when_warm_lowers_the_offset() -> None:
    levels = [1.0 + 0.1 * k for k in range(13)]
    record = staircase(levels)
    warm = [i / (1.0 + 0.05 * i * i) for i in record["current"]]
    record = Record("warm", record.columns | {"current": warm}, UNITS)
    table = reduce_to_plateaus(record, "level")
    low = supply_offset(table, "level", "current", 1.0, 1.5).offset
    assert supply_offset(table, "level", "current", 1.0, 2.2).offset < low < 0.23


def test_too_few_plateaus_are_refused() -> None:
    table = reduce_to_plateaus(staircase([1.0, 1.1, 1.2]), "level")
    with pytest.raises(DataError, match=r"has 2 plateaus from 1.1 to 1.2 V; an offset needs"):
        supply_offset(table, "level", "current", 1.1, 1.2)
