"""The grammar of free parameters is one, whatever a text is for.

Source of truth: texts that are written and read again, and the same text given to a fit, a design, a tuning, a sweep
and a curve of steady states.
"""

from __future__ import annotations

from typing import Any

import builders
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tuning_cases import linear_bench

from martensite.base.errors import InputError, ParameterError
from martensite.control.tuning.gain_search import build_free_gains
from martensite.design.optimise.targets import read_design_number
from martensite.design.sweep.axes import parse_axis
from martensite.fit.free_parameters import read_ranges
from martensite.search.free_numbers import SearchRange, Target
from martensite.search.free_text import FORMS, parse_free

KNOWN = [Target("element.length", "element.length", "m", 0.1)]
NUMBERS = st.none() | st.floats(-1e6, 1e6).map(lambda x: float(f"{x:.10g}"))


@given(NUMBERS, NUMBERS, NUMBERS, st.sampled_from([None, "linear", "log", "whole"]), st.sampled_from(["1", "m", "K"]))
def test_ranges_are_read_as_they_are_written(low: Any, high: Any, start: Any, scale: Any, unit: str) -> None:
    wanted = SearchRange("x", low, high, start, scale)
    assert SearchRange.read(wanted.write(unit), unit) == wanted


def test_every_use_refuses_a_malformed_text_with_the_same_sentence() -> None:
    system: Any = builders.plain_system()
    uses: list[Any] = [
        lambda text: read_ranges([text], [system]),
        lambda text: read_design_number(text, KNOWN, system),
        lambda text: build_free_gains(linear_bench(), [text], []),
        lambda text: parse_axis(text, {one.name: one for one in KNOWN}),
        lambda text: parse_free(text, complete=True),
    ]
    for use in uses:
        with pytest.raises(ParameterError, match=r"^`=1\.\.2 m` is no free parameter; write .*`NAME=LOW\.\.HIGH UNIT`"):
            use("=1..2 m")


@pytest.mark.parametrize("form", FORMS)
def test_a_form_that_is_not_allowed_is_refused(form: str) -> None:
    text = {"range": "x=1..2 m", "levels": "x=1, 2 m", "spread": "x=1 m ± 2 mm"}[form]
    assert parse_free(text, form).form == form
    others = [one for one in FORMS if one != form]
    with pytest.raises(InputError, match="is no free parameter"):
        parse_free(text, *others)
