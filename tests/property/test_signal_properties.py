"""What holds for every waveform: edges in order, levels within bounds, linear in between."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.ramp import Ramp
from martensite.signals.sine import Sine
from martensite.signals.staircase import Staircase
from martensite.signals.step import Step
from martensite.signals.table import Table
from martensite.signals.triangle import Triangle

LEVELS = st.floats(-1e3, 1e3)
PAIRS = st.tuples(LEVELS, LEVELS).map(sorted)
FREQUENCIES = st.floats(1e-3, 1e3)
DUTIES = st.floats(0.0, 1.0)
DISTINCT_DUTIES = st.floats(1e-6, 1.0 - 1e-6)
"""Shares whose edges do not coincide by rounding."""
TIMES = st.floats(0.0, 1e4)
PERIODS = st.floats(0.1, 300.0)
SHARES = st.lists(st.floats(0.0, 1.0, exclude_max=True), min_size=1, max_size=20)


@st.composite
def pwms(draw, duties=DUTIES):
    low, high = draw(PAIRS)
    frequency, duty = draw(FREQUENCIES), draw(duties)
    return PulseWidthModulation(low=low, high=high, frequency=frequency, duty=duty)


@st.composite
def triangles(draw):
    low, high = draw(PAIRS)
    return Triangle(low=low, high=high, frequency=draw(FREQUENCIES))


@st.composite
def sines(draw):
    low, high = draw(PAIRS)
    phase = draw(st.sampled_from(["low", "middle", "high"]))
    return Sine(low=low, high=high, frequency=draw(FREQUENCIES), phase=phase)


@st.composite
def staircases(draw):
    return Staircase(
        first=draw(LEVELS),
        increment=draw(LEVELS),
        hold=draw(st.floats(1e-3, 1e3)),
        count=draw(st.integers(1, 50)),
        direction=draw(st.sampled_from(["up", "up-down"])),
    )


@st.composite
def ramps(draw):
    start, length = draw(TIMES), draw(st.floats(1e-3, 1e3))
    return Ramp(low=draw(LEVELS), high=draw(LEVELS), start=start, end=start + length)


@st.composite
def steps(draw):
    at, length = draw(TIMES), draw(st.floats(1e-3, 1e3))
    return Step(low=draw(LEVELS), high=draw(LEVELS), at=at, until=at + length)


@st.composite
def tables(draw):
    times = sorted(draw(st.lists(TIMES, min_size=2, max_size=30, unique=True)))
    levels = draw(st.lists(LEVELS, min_size=len(times), max_size=len(times)))
    return Table(times=tuple(times), values=tuple(levels))


def duration_of(waveform, periods):
    """A run that holds a number of periods, so that the number of edges stays small."""
    if hasattr(waveform, "frequency"):
        return periods / waveform.frequency
    return periods * getattr(waveform, "hold", 10.0)


def levels_of(waveform):
    if isinstance(waveform, Staircase):
        last = waveform.first + (int(waveform.count) - 1) * waveform.increment
        return sorted((waveform.first, last))
    if isinstance(waveform, Table):
        return min(waveform.values), max(waveform.values)
    return sorted((waveform.low, waveform.high))


def between(a, b):
    """Times in [a, b): the edge itself, inner ones, and the last one before the next edge."""
    inner = [a + share * (b - a) for share in (0.1, 0.5, 0.9)]
    return [a, *(t for t in inner if a < t < b), math.nextafter(b, 0.0)]


EVERY = st.one_of(pwms(), triangles(), sines(), staircases(), ramps(), steps(), tables())


@settings(deadline=None)
@given(EVERY, PERIODS)
def test_edges_ascend_inside_the_run(waveform, periods):
    duration = duration_of(waveform, periods)
    edges = waveform.edges(duration)
    assert all(a < b for a, b in pairwise([0.0, *edges, duration]))


@settings(deadline=None)
@given(EVERY, PERIODS, SHARES)
def test_values_stay_within_the_levels(waveform, periods, shares):
    low, high = levels_of(waveform)
    duration = duration_of(waveform, periods)
    for share in shares:
        assert low <= waveform.value(share * duration) <= high


@settings(deadline=None)
@given(st.one_of(pwms(), staircases(), steps()), st.floats(0.1, 30.0))
def test_rectangular_signals_are_constant_between_edges(waveform, periods):
    duration = duration_of(waveform, periods)
    for a, b in pairwise([0.0, *waveform.edges(duration), duration]):
        assert len({waveform.value(t) for t in between(a, b)}) == 1


@settings(deadline=None)
@given(st.one_of(triangles(), ramps(), tables()), st.floats(0.1, 30.0))
def test_linear_signals_are_linear_between_edges(waveform, periods):
    duration = duration_of(waveform, periods)
    low, high = levels_of(waveform)
    for a, b in pairwise([0.0, *waveform.edges(duration), duration]):
        if b - a < 1e-6 * duration:
            continue
        first, last = waveform.value(a), waveform.value(math.nextafter(b, 0.0))
        for t in between(a, b):
            expected = first + (last - first) * (t - a) / (b - a)
            assert waveform.value(t) == pytest.approx(expected, abs=1e-6 * (high - low) + 1e-12)


@settings(deadline=None)
@given(pwms(DISTINCT_DUTIES), st.floats(0.1, 30.0))
def test_pwm_changes_level_at_every_edge(waveform, periods):
    edges = [0.0, *waveform.edges(duration_of(waveform, periods))]
    for number, edge in enumerate(edges):
        assert waveform.value(edge) == (waveform.low if number % 2 else waveform.high)


@settings(deadline=None)
@given(pwms(), st.integers(1, 200))
def test_pwm_is_on_for_its_duty(waveform, periods):
    duration = periods / waveform.frequency
    pieces = pairwise([0.0, *waveform.edges(duration), duration])
    mean = math.fsum((b - a) * waveform.value(0.5 * (a + b)) for a, b in pieces) / duration
    expected = waveform.low + waveform.duty * (waveform.high - waveform.low)
    assert mean == pytest.approx(expected, abs=1e-9 * max(1.0, abs(expected), waveform.high))
