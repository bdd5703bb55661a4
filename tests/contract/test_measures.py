"""Measures of curves whose extremes, crossings, means and integrals are known, and their words.

What every measure promises is in `martensite.testing.waveforms`.
"""

from __future__ import annotations

import numpy as np
import pytest
from builders import problem_a

from martensite.base.errors import InputError
from martensite.base.parameters import text
from martensite.simulate.measures.base import MEASURES, AbstractMeasure, list_needed, measure_samples, parse_measure
from martensite.simulate.measures.run_table import RunTable, tabulate_samples

SYSTEM = problem_a()

# ---------------------------------------------------------------- known curves

RAMP = np.linspace(0.0, 4.0, 9)
"""Times [s] of a ramp from 1 to 5, and back."""
WAY = np.concatenate([np.linspace(1.0, 5.0, 5), np.linspace(4.0, 1.0, 4)])


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("max", 5.0),
        ("min", 1.0),
        ("stroke", 4.0),
        ("final", 1.0),
        ("at(position, time=0.75 s)", 2.5),
        ("rise-time", 0.8 * 2.0),
        ("fall-time", 0.8 * 2.0),
        ("rise-time(position, low=0.25, high=0.75)", 1.0),
        ("reach-time", 0.9 * 2.0),
        ("reach-time(position, share=50 %)", 1.0),
        ("peak-time", 2.0),
        ("change", 4.0),
        ("integral", 12.0),
        ("mean", 3.0),
        ("energy(position)", 12.0),
        ("rms", np.sqrt(np.mean((WAY[:-1] ** 2 + WAY[1:] ** 2) / 2.0))),
    ],
)
def test_known_curves(words: str, expected: float) -> None:
    one = parse_measure(words)
    assert one.value(tabulate_samples(RAMP, WAY[None, :, None])) == pytest.approx([expected], rel=1e-12)
    if "time" in words and "at" not in words:
        down = one.value(tabulate_samples(RAMP, 3.0 - WAY[None, :, None]))
        assert down == pytest.approx([expected], rel=1e-12)


def test_a_change_has_its_sign_and_a_peak_lies_between_samples() -> None:
    assert parse_measure("change").value(tabulate_samples(RAMP, 3.0 - WAY[None, :, None])) == [-4.0]
    times = np.array([0.0, 0.7, 1.2, 2.0, 2.5])
    curve = -((times - 1.36) ** 2)
    assert parse_measure("peak-time").value(tabulate_samples(times, curve[None, :, None])) == pytest.approx([1.36])


def test_what_never_happens_takes_forever() -> None:
    there = np.linspace(0.0, 1.0, 9)[None, :, None]
    assert parse_measure("fall-time").value(tabulate_samples(RAMP, there)) == np.inf
    assert parse_measure("rise-time").value(tabulate_samples(RAMP, 0.0 * there)) == np.inf


def test_several_elements_are_looked_at_together() -> None:
    first, second = WAY, WAY[::-1] + 1.0
    both = np.stack([first, second])[:, :, None]
    assert parse_measure("max").value(tabulate_samples(RAMP, both)) == [6.0]
    assert parse_measure("integral").value(tabulate_samples(RAMP, both)) == pytest.approx([12.0 + 16.0])
    assert parse_measure("final").value(tabulate_samples(RAMP, both)) == [2.0]


def test_columns_and_what_is_needed() -> None:
    measures = [parse_measure(w) for w in ("stroke", "max(temperature)", "energy", "min(temperature)")]
    assert measures[0].columns(SYSTEM) == (next(iter(SYSTEM.mechanism.outputs())),)
    assert list_needed(measures, SYSTEM) == (*measures[0].columns(SYSTEM), "temperature", "power")
    columns = {"temperature": np.array([[1.0, 3.0], [2.0, 0.0]])}
    assert measure_samples(measures[1], SYSTEM, RAMP[:2], columns).tolist() == [3.0, 2.0]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("strok", "Did you mean `stroke`"),
        ("max(stress", "is no measure"),
        ("", "is no measure"),
        ("at(position, 2 s)", r"needs a name, such as `time=2 s`"),
        ("at(position, tme=2 s)", "Did you mean `time`"),
        ("at(position, time=2 m)", "time"),
        ("rise-time(position, low=0.9, high=0.1)", "must be below `high`"),
    ],
)
def test_wrong_words_are_refused(words: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        parse_measure(words)


def test_a_moment_after_the_end_is_refused() -> None:
    with pytest.raises(InputError, match=r"at 5 s, but the run ends at 4 s"):
        parse_measure("at(position, time=5 s)").value(tabulate_samples(RAMP, WAY[None, :, None]))


def test_a_measure_of_ones_own_is_found_by_its_words() -> None:
    @MEASURES.register("test-first")
    class First(AbstractMeasure):
        """The first sample."""

        of: str = text("output", default="")

        def unit(self, unit: str) -> str:
            return unit

        def value(self, table: RunTable) -> np.ndarray:
            return table.values[0, 0]

        def derivatives(self, table: RunTable) -> np.ndarray:
            found = np.zeros(table.values.shape)
            found[0, 0] = 1.0
            return found

    try:
        one = parse_measure("test-first(stress)")
        assert (type(one), one.unit_in(SYSTEM)) == (First, "Pa")
    finally:
        MEASURES._entries.pop("test-first")
