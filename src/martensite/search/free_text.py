"""The grammar of free parameters, for command line, Python, files and the web page.

    A_s                                  within bounds chosen from its declaration
    A_s=40..90 degC                      within bounds; either may be left out
    A_s=40..90 degC@60 degC              from a start
    element.diameter=0.05..0.5 mm log    on a scale: linear, log, or whole
    diameter=0.1..0.5 mm:9               in a sweep: nine values
    A_s=68, 70, 72 degC                  in a sweep: these values
    length=250 mm ± 2 %                  normal about a centre, or about the present value; `+-` is `±`
    h:by=specimen=± 20 %                 in a fit: each specimen has a separate value
    A_f-A_s=2..60 degC                   in a fit: the difference of two parameters

A unit behind the last value holds for all values without a unit. An error is one sentence: the text, what is allowed,
and for an unknown name the nearest valid one.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from martensite.base.errors import ParameterError

FORMS = {"range": "NAME=LOW..HIGH UNIT", "levels": "NAME=A, B, C UNIT", "spread": "NAME=CENTRE ± SPREAD UNIT"}
"""Form of the values of a free parameter -> its text."""
EXAMPLE = "element.diameter=0.05..0.5 mm"
_FREE = re.compile(
    r"\s*(?P<name>[^=@:\s]+)\s*(?::by=(?P<by>[^=@\s]+)\s*)?(?:=\s*(?P<values>[^@]+?))?\s*(?:@\s*(?P<start>.+?))?"
    r"(?:\s+(?P<scale>linear|log|whole))?\s*"
)
_RANGE = re.compile(r"(.*?)\s*\.\.\s*(.*?)\s*(?::\s*(\d+))?")
_SPREAD = re.compile(r"(.*?)\s*(?:±|\+/?-)\s*(.+)")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


@dataclass(frozen=True)
class FreeText:
    """Parts of the text of a free parameter; None for an omitted part."""

    text: str
    name: str
    by: str = ""
    """Kind of group whose members have separate values."""
    form: str = ""
    """Key of `FORMS`; empty for a name alone."""
    values: tuple[str | None, ...] = ()
    """Both ends, all levels, or centre and spread."""
    count: int | None = None
    start: str | None = None
    scale: str | None = None


def parse_free(text: str, *forms: str, complete: bool = False) -> FreeText:
    """Parse the text of a free parameter.

    Args:
        text: as above.
        forms: allowed forms, keys of `FORMS`, a range by default.
        complete: True if values are required, a range with both ends.

    Raises:
        ParameterError: the text is malformed, or of another form.
    """
    allowed = forms or ("range",)
    match = _FREE.fullmatch(text)
    parts = match.groupdict() if match else {}
    form, values, count = _parse_values(parts.get("values") or "")
    fits = form in allowed if form else not complete
    if match is None or ".." in parts["name"] or not fits or (complete and form == "range" and None in values):
        usual = [f"`{FORMS[one]}`" for one in allowed]
        if not complete:
            usual = ["`NAME`", *usual, "`NAME@START UNIT`"]
        listed = " or ".join(filter(None, [", ".join(usual[:-1]), usual[-1]]))
        raise ParameterError(f"`{text}` is no free parameter; write {listed}, such as `{EXAMPLE}`.")
    return FreeText(text, parts["name"], parts["by"] or "", form, values, count, parts["start"], parts["scale"])


def _parse_values(text: str) -> tuple[str, tuple[str | None, ...], int | None]:
    """Return the form of values, their texts, and the number of levels of a range."""
    if not text:
        return "", (), None
    if (match := _RANGE.fullmatch(text)) is not None:
        ends = _share_unit(match[1], match[2])
        return ("range", ends, int(match[3]) if match[3] else None) if any(ends) else ("none", (), None)
    if (match := _SPREAD.fullmatch(text)) is not None:
        relative = match[2].endswith("%")
        return "spread", ((match[1] or None, match[2]) if relative else _share_unit(match[1], match[2])), None
    levels = _share_unit(*text.split(","))
    return ("levels" if all(levels) else "none"), levels, None


def _share_unit(*texts: str) -> tuple[str | None, ...]:
    """Return values with the last unit added to values without a unit; None for an empty text."""
    number = _NUMBER.match(texts[-1].strip())
    unit = texts[-1].strip()[number.end() :].strip() if number else ""
    pieces = (one.strip() for one in texts)
    return tuple((f"{one} {unit}".strip() if is_bare(one) else one) or None for one in pieces)


def is_bare(text: str) -> bool:
    """Return whether a text is a number without a unit."""
    return _NUMBER.fullmatch(text) is not None
