"""Assignment of the columns of a raw table, by given names, by heading and unit, and by value."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from martensite.base.errors import DataError, UnitError, suggest_name
from martensite.logs.cells import Numbers
from martensite.logs.heading_guess import HEAT, Guess, find_listed, find_worded_unit, guess_heading
from martensite.logs.layout import CANONICAL, CLOCK, IGNORED, read_headings
from martensite.logs.raw_table import RawColumn, RawTable
from martensite.logs.table_times import is_part_of_clock
from martensite.logs.value_guess import ValueGuess, guess_columns, guess_unit, is_even_time, is_rising

HEAT_FLOW = "heat_flow"
"""Name of the first column of a calorimeter's signal."""
GIVEN, INFERRED, AMBIGUOUS = "given", "inferred", "ambiguous"
"""Certainty of a meaning."""
IMPLIED = {"x_value": "s", "millis": "ms", "micros": "us", "milliseconds": "ms", "microseconds": "us", "seconds": "s"}
"""Heading -> its unit of time."""
SECOND = re.compile(
    r"set|target|command|demand|soll|program|ambient|room|chamber|reference|cold|\b(?:max|min|average|mean)\b",
    re.IGNORECASE,
)
"""Words in headings of secondary columns."""
FASTEST_RAMP = 3.0
"""Fastest ramp of a calorimeter [K/s]; usual ramps are 1 to 100 K/min."""
COUNTER = re.compile(r"(?:#|no\.?|nr\.?|index|scan|sample|reading|point|row|record|sequence|x)", re.IGNORECASE)
"""Headings of row counters."""


_FLOAT = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_SCALE = re.compile(rf"(.*?[\])\w])\s*(?:\*\s*([+-]?{_FLOAT}))?\s*([+-]{_FLOAT})?")


@dataclass(frozen=True)
class Meaning:
    """Assigned meaning of a column; an empty name for an unknown column."""

    name: str
    unit: str
    source: str
    """Source of the meaning: `given` by the user, `heading`, `unit` alone, `values`, or `ambiguous`."""
    sure: bool = True
    factor: float = 1.0
    """Factor of the numbers in the file."""
    offset: float = 0.0
    """Offset [unit], added after the factor."""

    @property
    def certainty(self) -> str:
        """Return `given` by the file or the user, `inferred` with evidence, or `ambiguous`."""
        if not self.sure or self.source == AMBIGUOUS:
            return AMBIGUOUS
        return GIVEN if self.source in ("given", "heading") else INFERRED


def guess_meanings(raw: RawTable, new_headings: Mapping[str, str]) -> list[Meaning]:
    """Return the meanings of the columns of a table; the second of two equal columns keeps its heading as a name.

    Raises:
        DataError: `new_headings` refers to an unknown column, or assigns an unknown meaning.
    """
    given = _read_new_headings(raw, new_headings)
    meanings = [given.get(place) or _guess_column(raw, place) for place in range(len(raw.columns))]
    unknown = {
        place: raw.columns[place].numbers
        for place, one in enumerate(meanings)
        if not (one.name or one.unit or raw.columns[place].heading) and raw.columns[place].kind == "number"
    }
    timed = any(
        one.name == "time" or column.kind in ("clock", "stamp")
        for one, column in zip(meanings, raw.columns, strict=True)
    )
    for place, guess in guess_columns(unknown).items():
        if guess.name != "time" or not timed:
            meanings[place] = Meaning(guess.name, guess.unit, "values", guess.sure)
    if not any(one.name == "time" for one in meanings):
        meanings = _find_headed_time(raw, meanings)
    return _name_apart(raw, _judge_ramp(raw, meanings), given)


def _guess_column(raw: RawTable, place: int) -> Meaning:
    """Return the meaning of one column by heading and unit; a missing unit is guessed from the values."""
    column = raw.columns[place]
    listed = find_listed(column.unit.strip("()[] "))
    return _find_special(raw, column, listed) or _guess_quantity(raw, column, listed)


def _find_special(raw: RawTable, column: RawColumn, listed: str) -> Meaning | None:
    """Return the meaning of a column of text, of a clock, or of a counter of rows; otherwise None."""
    if column.kind in ("clock", "stamp"):
        return Meaning("time", CLOCK, "values" if not column.heading else "heading")
    if column.kind in ("text", "date"):
        return Meaning("", "", "")
    words = column.heading.lower().strip()
    if is_part_of_clock(raw, column):
        return Meaning(IGNORED, "", "")
    if words in IMPLIED:
        return Meaning("time", IMPLIED[words], "heading")
    if listed:
        return None
    counts = COUNTER.fullmatch(words) and is_even_time(column.numbers)
    if counts or (raw.has_headings and not words and _is_row_count(column.numbers)):
        return Meaning(IGNORED, "", "")
    return None


def _guess_quantity(raw: RawTable, column: RawColumn, listed: str) -> Meaning:
    """Return the quantity of a column; a missing unit is guessed from the values."""
    plain = guess_heading(column.heading)
    if listed and plain.has_words and plain.unit not in ("", listed):
        return Meaning(plain.name, plain.unit, "heading", False)
    guess = _add_unit(column, plain, listed or _find_scope_unit(raw, column, plain))
    if not guess.name and not guess.unit and column.heading and "emissivity" in raw.header_entries:
        return Meaning("temperature", "degC", "values")  # an infrared camera writes nothing else
    if not guess.name or (guess.name == "time" and not guess.has_words and not is_rising(column.numbers)):
        return Meaning("", guess.unit, "")
    if guess.unit:
        return Meaning(guess.name, guess.unit, _find_source(plain, guess))
    return _guess_unit(column, guess.name)


def _find_source(plain: Guess, guess: Guess) -> str:
    """Return whether the words of a heading or its unit gave a meaning."""
    return "heading" if plain.name == guess.name and (guess.has_words or plain.has_words) else "unit"


def _add_unit(column: RawColumn, plain: Guess, listed: str) -> Guess:
    """Return the guess from a heading with its unit, if there is one."""
    return guess_heading(f"{column.heading or 'column'} [{listed}]") if listed else plain


def _find_scope_unit(raw: RawTable, column: RawColumn, plain: Guess) -> str:
    """Return the unit that the head of a file of an oscilloscope gives to a column without a unit; otherwise empty."""
    if plain.unit or "vertical units" not in raw.header_entries:
        return ""
    timed = plain.name == "time" or (not column.heading and is_even_time(column.numbers))
    return find_listed(raw.header_entries.get("horizontal units" if timed else "vertical units", ""))


def _guess_unit(column: RawColumn, name: str) -> Meaning:
    """Return the meaning of a column of a known quantity without a unit."""
    quantity = name.rpartition(".")[2]
    worded = find_worded_unit(column.heading, quantity)
    if worded:
        return Meaning(name, worded, "heading")
    by_values: ValueGuess = guess_unit(quantity, column.numbers)
    if not by_values.unit:
        return Meaning(IGNORED, "", AMBIGUOUS)
    return Meaning(name, by_values.unit, "values", by_values.sure)


def _is_row_count(numbers: Numbers) -> bool:
    """Return whether a column counts the rows from 0 or 1."""
    return bool(numbers.size > 2 and numbers[0] in (0.0, 1.0) and np.all(np.diff(numbers) == 1.0))


def _judge_ramp(raw: RawTable, meanings: list[Meaning]) -> list[Meaning]:
    """Return a calorimeter's time without unit in minutes, if its ramp would be impossibly fast in seconds."""
    at = {one.name: k for k, one in enumerate(meanings) if one.name in ("time", "temperature")}
    if len(at) < 2 or meanings[at["time"]].source != "values" or not any(HEAT.search(c.heading) for c in raw.columns):
        return meanings
    times, heat = (raw.columns[at[name]].numbers for name in ("time", "temperature"))
    steps = np.abs(np.diff(heat)) / np.maximum(np.diff(times), 1e-12)
    unit = "min" if float(np.nanmedian(steps)) > FASTEST_RAMP else "s"
    return [replace(one, unit=unit, sure=unit == "s") if k == at["time"] else one for k, one in enumerate(meanings)]


def _find_headed_time(raw: RawTable, meanings: list[Meaning]) -> list[Meaning]:
    """Use a nameless first column with equal rising steps as time if there is no other time."""
    numeric = [k for k, column in enumerate(raw.columns) if column.kind == "number"]
    if len(numeric) < 2:
        return meanings
    first, column = numeric[0], raw.columns[numeric[0]]
    if meanings[first].name or column.heading or not is_even_time(column.numbers):
        return meanings
    guess = guess_unit("time", column.numbers)
    return [Meaning("time", guess.unit, "values", guess.sure) if k == first else one for k, one in enumerate(meanings)]


def _name_apart(raw: RawTable, meanings: list[Meaning], given: Mapping[int, Meaning]) -> list[Meaning]:
    """Return the columns with unique names; unknown columns with headings keep these."""
    order = sorted(range(len(meanings)), key=lambda k: (k not in given, bool(SECOND.search(raw.columns[k].heading)), k))
    taken: set[str] = set()
    named = list(meanings)
    for place in order:
        one, column = meanings[place], raw.columns[place]
        if one.name == "time" or one.name == IGNORED:
            continue
        if place in given and one.name in taken:
            raise DataError(f"`{raw.name}` has two columns `{one.name}`; name one of them differently.")
        if place in given and column.kind == "text":
            raise DataError(
                f"`{raw.name}`: column {place + 1} is to be `{one.name}`, but holds no numbers: `{column.sample}`."
            )
        usable = column.kind == "number" and bool(np.isfinite(column.numbers).any())
        if not usable or (not one.name and not column.heading):
            named[place] = replace(one, name="")
            continue
        if not one.name or one.name in taken:
            named[place] = one = _keep_heading(column, place, one, taken)
        taken.add(one.name)
    return named


def _keep_heading(column: RawColumn, place: int, one: Meaning, taken: set[str]) -> Meaning:
    slug = re.sub(r"\W+", "_", re.sub(r"[\[(].*", "", column.heading).lower()).strip("_") or f"column_{place + 1}"
    unit = one.unit if one.unit and one.unit != CLOCK else "1"
    if HEAT.search(column.heading) and HEAT_FLOW not in taken:
        slug = HEAT_FLOW
    if slug in taken or slug.rpartition(".")[2] in CANONICAL or not slug.isascii():
        slug = f"{one.name or 'column'}_{place + 1}"
    try:
        read_headings([f"{slug} [{unit}]"], "")
    except (DataError, UnitError):
        unit = "1"
    return Meaning(slug, unit, "values" if one.source == "values" else "heading", one.sure)


def find_places(headings: Sequence[str], new_headings: Mapping[str, str], where: str) -> dict[int, str]:
    """Return column index -> assigned meaning; columns are given by heading or number.

    Raises:
        DataError: the column does not exist, or is ambiguous.
    """
    places: dict[int, str] = {}
    for key, text in new_headings.items():
        same = [k for k, heading in enumerate(headings) if heading and heading.lower() == key.strip().lower()]
        if not same and key.strip().isdigit() and 0 < int(key) <= len(headings):
            same = [int(key) - 1]
        if len(same) != 1:
            valid = [h for h in headings if h] or [f"{k + 1}" for k in range(len(headings))]
            reason = "has several columns" if same else "has no column"
            raise DataError(
                f"{where} {reason} `{key}`; its columns are 1 to {len(headings)}. {suggest_name(key, valid)}"
            )
        places[same[0]] = text
    return places


def _read_new_headings(raw: RawTable, new_headings: Mapping[str, str]) -> dict[int, Meaning]:
    meanings: dict[int, Meaning] = {}
    for place, text in find_places([one.heading for one in raw.columns], new_headings, f"`{raw.name}`").items():
        column = raw.columns[place]
        if text.strip() == IGNORED:
            meanings[place] = Meaning(IGNORED, "", "given")
            continue
        text, factor, offset = _part_scale(text)
        written = find_listed(write_unit(column)) or guess_heading(column.heading).unit
        bare = "[" not in text and "(" not in text and written
        (head,) = read_headings([f"{text} [{written}]" if bare else text], f"`{raw.name}`")
        unit = CLOCK if column.kind in ("clock", "stamp") and head.name == "time" else head.spelling
        meanings[place] = Meaning(head.name, unit, "given", True, factor, offset)
    return meanings


def _part_scale(text: str) -> tuple[str, float, float]:
    """Return a meaning with its factor and offset: `force[N]*2.5-0.3`."""
    match = _SCALE.fullmatch(text.strip())
    return (text, 1.0, 0.0) if match is None else (match[1], float(match[2] or 1.0), float(match[3] or 0.0))


def write_unit(column: RawColumn) -> str:
    """Return the unit of a column as written in the file."""
    if column.unit:
        return column.unit
    match = re.search(r"[\[(]\s*([^\])]+?)\s*[\])]\s*$", column.heading)
    return match[1] if match else ""
