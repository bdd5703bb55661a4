"""Axes of a sweep: what their words mean.

Sources of truth: numpy's linspace and geomspace, units by hand, and numbers that are written as
words and read again.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from martensite.base.errors import InputError, ParameterError, UnitError
from martensite.design.sweep.axes import parse_axis
from martensite.search.free_numbers import FreeNumber, Target

TARGETS = {
    name: Target(name, name, unit, nominal)
    for name, unit, nominal in (
        ("wire.diameter", "m", 2e-4),
        ("wire.length", "m", 0.25),
        ("spring.length", "m", 0.1),
        ("cooling.h", "W/m^2/K", 60.0),
        ("law.A_s", "K", 341.15),
        ("drive.duty", "1", 0.3),
    )
}


def read(words: str) -> FreeNumber:
    return parse_axis(words, TARGETS)


@pytest.mark.parametrize(
    ("words", "levels"),
    [
        ("diameter=0.1..0.5 mm:5", np.linspace(1e-4, 5e-4, 5)),
        ("diameter = 0.1 .. 0.5 mm : 5", np.linspace(1e-4, 5e-4, 5)),
        ("wire.diameter=100..500 um:3", np.linspace(1e-4, 5e-4, 3)),
        ("cooling.h=20..200 W/m^2/K:4 log", np.geomspace(20.0, 200.0, 4)),
        ("duty=0.1..0.4:4", np.linspace(0.1, 0.4, 4)),
        ("duty=.1...4:2", [0.1, 0.4]),
        ("A_s=60..80 degC:3", [333.15, 343.15, 353.15]),
        ("A_s=60, 65, 80 degC", [333.15, 338.15, 353.15]),
        ("A_s=60 degC, 340 K", [333.15, 340.0]),
        ("A_s=-10..10 degC:2", [263.15, 283.15]),
        ("duty=0.2", [0.2]),
        ("duty=1e-1, 2E-1", [0.1, 0.2]),
    ],
)
def test_levels(words: str, levels: list[float]) -> None:
    assert read(words).levels() == pytest.approx(np.array(levels), rel=1e-14)


@pytest.mark.parametrize(
    ("words", "mean", "deviation"),
    [
        ("wire.length=250 mm +- 2 %", 0.25, 0.005),
        ("wire.length=+- 2 %", 0.25, 0.005),
        ("wire.length=+- 4 mm", 0.25, 0.004),
        ("wire.length=0.2 +- 0.01 m", 0.2, 0.01),
        ("wire.length=200 mm ± 10 mm", 0.2, 0.01),
        ("A_s=68 degC +- 2 K", 341.15, 2.0),
        ("A_s=+/- 1.5 K", 341.15, 1.5),
        ("duty=0.3 +- 0.01", 0.3, 0.01),
    ],
)
def test_distributions(words: str, mean: float, deviation: float) -> None:
    found = read(words)
    assert found.extremes() == ()
    assert (found.start, found.spread) == pytest.approx((mean, deviation), rel=1e-12)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("diameter", "is no free parameter"),
        ("diametr=0.1..0.5 mm", "Did you mean"),
        ("length=0.1..0.5 m", "ambiguous: wire.length, spring.length"),
        ("diameter=0.5..0.1 mm", "must rise"),
        ("diameter=0.1..0.1 mm", "must rise"),
        ("diameter=0.1..0.5 mm:1", "2 levels"),
        ("diameter=0.1..0.5 mm:99999999", "2 levels"),
        ("duty=-0.1..0.4:3 log", "above 0"),
        ("A_s=340 K +- 2 %", "must be a difference"),
        ("duty=0.3 +- 0", "above 0"),
        ("diameter=", "is no free parameter"),
        ("diameter=0.1, , 0.2 mm", "is no free parameter"),
    ],
)
def test_wrong_words_are_refused(words: str, sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        read(words)


@pytest.mark.parametrize(
    "words",
    [
        "diameter=0.1..0.5",
        "diameter=0.1..0.5 K",
        "diameter=a..b mm",
        "diameter=0.1.. mm",
        "diameter=nan..0.2 mm",
        "A_s=10 +- 1 s",
    ],
)
def test_what_is_no_quantity_is_refused_by_the_name_of_the_axis(words: str) -> None:
    with pytest.raises(UnitError, match=r"^Free parameter `(wire.diameter|law.A_s)`: "):
        read(words)


def test_levels_of_what_has_none_are_refused() -> None:
    for words in ("diameter=0.1..0.5 mm", "duty=0.3 +- 0.1"):
        with pytest.raises(ParameterError, match=r"no levels.*--sample"):
            read(words).levels()


NUMBERS = st.floats(-1e6, 1e6, allow_subnormal=False)


@given(NUMBERS, NUMBERS, st.integers(2, 50), st.booleans())
def test_a_range_reaches_both_ends_and_rises(a: float, b: float, count: int, log: bool) -> None:
    low, high = sorted((a, b))
    assume(high - low > 1e-9 * abs(high))
    assume(not log or low > 1e-6)
    found = read(f"duty={low!r}..{high!r}:{count}{' log' if log else ''}")
    levels = found.levels()
    assert (levels[0], levels[-1], len(levels)) == (pytest.approx(low, rel=1e-12), high, count)
    assert (np.diff(levels) >= 0.0).all()
    assert (low <= levels + 1e-9 * abs(low)).all()
    assert (levels <= high).all()


@given(st.lists(NUMBERS, min_size=1, max_size=8))
def test_levels_are_read_as_they_are_written(numbers: list[float]) -> None:
    assert read(f"duty={', '.join(map(repr, numbers))}").levels().tolist() == numbers


WORDS = st.text(alphabet="0123456789.-+eE±%,: mKlog/*()", max_size=20)


@settings(max_examples=40)
@given(WORDS)
def test_any_words_are_an_axis_or_a_sentence(words: str) -> None:
    try:
        read(f"duty={words}").extremes()
    except InputError as error:
        assert str(error).endswith((".", "?"))
