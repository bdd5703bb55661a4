"""Tables of studies: what is read from them, and what they are refused for.

Source of truth: the two files as their reader describes them; every refusal is one sentence.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pint
import pytest

from martensite.base.errors import DataError
from martensite.studies.base import load_study, study_names
from martensite_studies import tables
from martensite_studies.tables import Printed, TableStudy, find_number, read_claims, settle_claims

PRINTED = """
source = "tanaka1986"
["Table 1"]
force = { value = 2.0, unit = "N" }
lengths = { value = [1.0, 2.0], unit = "m" }
["Table 2".rows]
columns = ["load", "stroke"]
units = ["N", "m"]
rows = [[1.0, 0.1], [2.0, 0.3]]
"""
HEAD = """
title = "T"
cites = ["tanaka1986"]
guide = "G"
caption = "C"
absent = "no data"
parts = { one = "the only part" }
"""
CLAIMS = """
[[one]]
place = "Table 1"
unit = "N"
columns = ["id", "what", "published", "tolerance", "tolerance_reason", "why"]
rows = [
  ["force", "the force", "force", 0.5, "last digit", "as printed: {force:g}"],
  ["free", "another", "-", "-", "-", "for {words}"],
]
[[one]]
each = "found"
id = "stroke-{load:g}"
what = "stroke"
place = "Table 2"
published = "stroke"
computed = "twice"
scale = 10.0
unit = "dm"
tolerance = "wide"
tolerance_reason = "assumed"
why = "doubled"
"""


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "claims.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def printed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Printed:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "printed.toml").write_text(PRINTED, encoding="utf-8")
    monkeypatch.setattr(tables, "FOLDER", tmp_path)
    return tables.printed_numbers("mine")


def test_printed_numbers(printed: Printed) -> None:
    assert (printed.source, printed.force, printed.lengths) == ("tanaka1986", 2.0, (1.0, 2.0))
    assert printed.rows.column("stroke") == (0.1, 0.3)
    other = printed.with_numbers(force=3.0)
    assert (other.force, other == printed, hash(other) == hash(printed)) == (3.0, False, False)
    with pytest.raises(DataError, match="No printed number `forc`"):
        printed.with_numbers(forc=1.0)
    with pytest.raises(AttributeError, match="with_numbers"):
        printed.force = 1.0


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ('source = "a"\nforce = 2.0', "`force` .* must stand under a place"),
        ('source = "a"\n["T 1"]\nf = { value = 1.0 }', "must have `unit`"),
        ('source = "a"\n["T 1"]\nf = { value = 1.0, unit = "N", page = 3 }', "no key `page`"),
        ('source = "a"\n["T 1"]\nf = {value=1.0, unit="N"}\n["T 2"]\nf = {value=1.0, unit="N"}', "must have one place"),
    ],
)
def test_printed_numbers_that_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, sentence: str
) -> None:
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / "printed.toml").write_text(text, encoding="utf-8")
    monkeypatch.setattr(tables, "FOLDER", tmp_path)
    with pytest.raises(DataError, match=sentence):
        tables.printed_numbers("bad")


def test_claims(tmp_path: Path, printed: Printed) -> None:
    table = read_claims(written(tmp_path, HEAD + CLAIMS))
    rows = [vars(row) | {"twice": 2.0 * row.stroke} for row in printed.rows]
    numbers: dict[str, Any] = {"force": 2.4, "free": 7.0, "words": "good", "found": rows, "wide": 4}
    force, free, *strokes = settle_claims(table, "one", numbers, printed)
    assert (force.verdict, force.published, force.computed) == ("reproduced", 2.0, 2.4)
    assert (force.source, force.why) == ("tanaka1986, Table 1", "as printed: 2.4")
    assert (free.verdict, free.computed, free.why) == ("not checkable", 7.0, "for good")
    assert [one.id for one in strokes] == ["stroke-1", "stroke-2"]
    assert [(one.published, one.computed, one.tolerance) for one in strokes] == [(1.0, 2.0, 4), (3.0, 6.0, 4)]
    with pytest.raises(DataError, match="names no number: `free`"):
        list(settle_claims(table, "one", {"force": 2.4, "words": ""}, printed))


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('place = "Table 1"', "", "Claim `force` .* must have `place`"),
        ('tolerance_reason = "assumed"', "", "the reason for it, or neither"),
        ('published = "stroke"', "", "must have a published number"),
        ("scale = 10.0", "scales = 10.0", "no key `scales`. Did you mean `scale`"),
        ('caption = "C"', "", "must have `caption`"),
        ("{ one =", "{ two =", "no key `one`"),
    ],
)
def test_claims_that_are_refused(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    assert old in HEAD + CLAIMS
    with pytest.raises(DataError, match=sentence):
        read_claims(written(tmp_path, (HEAD + CLAIMS).replace(old, new, 1)))


def test_a_part_must_not_be_called_like_another_key(tmp_path: Path) -> None:
    text = HEAD.replace("{ one =", "{ data =") + CLAIMS.replace("[[one]]", "[[data]]")
    with pytest.raises(DataError, match="must not be called `data`"):
        read_claims(written(tmp_path, text))


def test_dotted_names() -> None:
    found = Printed(inner=Printed(rms=3.0))
    assert find_number("a.inner.rms", {"a": found}, "x") == 3.0
    assert find_number(1.5, {}, "x") == 1.5


def shipped() -> list[str]:
    studies = [type(load_study(name)) for name in study_names()]
    return [one.__module__.split(".")[1] for one in studies if issubclass(one, TableStudy)]


@pytest.mark.parametrize("study", shipped())
def test_units_of_shipped_numbers_are_units(study: str) -> None:
    import tomllib

    text = (tables.FOLDER / study / "printed.toml").read_text(encoding="utf-8")
    places = [entries for entries in tomllib.loads(text).values() if isinstance(entries, dict)]
    for entry in (entry for entries in places for entry in entries.values()):
        for unit in entry.get("units", [entry.get("unit")]):
            if unit not in ("", "SI"):
                pint.get_application_registry().parse_units(unit if unit != "1" else "")
