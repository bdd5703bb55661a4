"""Moments over many intervals in arrays are those of the intervals one by one, to the last bit."""

import pytest

from martensite.signals.base import AbstractWaveform
from martensite.signals.moments import MANY
from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.table import Table

TABLE = Table(times=(0.3, 0.9, 2.0), values=(1.0, -2.5, 0.7))


@pytest.mark.parametrize("wave", [TABLE, PulseWidthModulation(high=3.0, frequency=1.7, duty=0.3)])
def test_arrays_are_the_intervals_one_by_one(wave: AbstractWaveform) -> None:
    begins = [0.013 * k for k in range(5 * MANY)]
    ends = [*begins[1:], begins[-1] + 0.5]  # within a segment and across
    shape = wave.shape(0.0, ends[-1])
    assert shape.many(begins, ends) == [shape.moments(a, b) for a, b in zip(begins, ends, strict=True)]
