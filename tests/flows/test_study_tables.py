"""Tables of studies: what is read from them, and what they are refused for.

Source of truth: the two files as their reader describes them; every refusal is one sentence.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import pint
import pytest
from claim_checks import check_complete

from martensite.base.errors import DataError, ParameterError
from martensite.base.summary import PAGE_WIDTH
from martensite.cli.commands.study import summarise_answer
from martensite.studies import shipped_numbers, tables
from martensite.studies.base import WIDEST, Claim, load_study, study_names
from martensite.studies.claim_tables import find_number, read_claims, settle_part, write_digest
from martensite.studies.tables import Printed, TableStudy

PRINTED = """
source = "tanaka1986"
["Table 1"]
force = { value = 2.0, unit = "N" }
lengths = { value = [1.0, 2.0], unit = "m" }
["not printed: chosen here"]
own = { value = 7.0, unit = "N" }
["Table 2".rows]
columns = ["load", "stroke"]
units = ["N", "m"]
rows = [[1.0, 0.1], [2.0, 0.3]]
"""
HEAD = """
order = 0
title = "T"
cites = ["tanaka1986"]
guide = "G"
caption = "C"
absent = "no data"
parts = { one = "the only part" }
[digest]
holds = "a force of {claims[force].computed:.1f} N, printed {printed.force:g}"
misprinted = "nothing"
contradicts_itself = "nothing"
assumed = "nothing"
use_instead = "{reports[free].computed:.0f} and {reports[gone].computed:.0f}"
"""
CLAIMS = """
[[one]]
place = "Table 1"
unit = "N"
columns = ["id", "what", "published", "tolerance", "tolerance_reason", "why", "correction"]
rows = [
  ["force", "the force", "force", 0.4, "last digit", "as printed: {force:g}", "-"],
  ["wrong", "the same", "force", 0.4, "last digit", "typed", "{wrong:g} N"],
]
[[reports.one]]
place = "Table 1"
unit = "N"
id = "free"
what = "another"
why = "for {words}"
[[one]]
each = "found"
id = "stroke-{load:g}"
what = "stroke"
place = "Table 2"
published = "stroke"
computed = "twice"
scale = 10.0
unit = "dm"
differs = "twice the stroke"
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
        ('source = "a"\nforce = 2.0', "`force` .* needs a place"),
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
    numbers: dict[str, Any] = {"force": 2.4, "wrong": 3.0, "free": 7.0, "words": "good", "found": rows}
    found = settle_part(table, "one", numbers, printed)
    force, wrong, *strokes = found.claims
    assert (force.verdict, force.published, force.computed) == ("reproduced", 2.0, 2.4)
    assert (force.source, force.why) == ("tanaka1986, Table 1", "as printed: 2.4")
    assert (wrong.verdict, wrong.correction) == ("misprint", "3 N")
    (free,) = found.reports
    assert (free.computed, free.why) == (7.0, "for good")
    assert [(one.id, one.verdict) for one in strokes] == [(f"stroke-{load}", "not comparable") for load in (1, 2)]
    assert [(one.published, one.computed, one.tolerance) for one in strokes] == [(1.0, 2.0, None), (3.0, 6.0, None)]
    digest = write_digest(table, numbers, printed, [found])
    assert digest["holds"] == "a force of 2.4 N, printed 2"
    assert digest["use_instead"] == "7 and …"
    del numbers["free"]
    with pytest.raises(DataError, match="names no number: `free`"):
        settle_part(table, "one", numbers, printed)


def test_a_misprint_that_is_none_is_reproduced(tmp_path: Path, printed: Printed) -> None:
    """The verdict follows from the numbers, whatever the table calls it."""
    table = read_claims(written(tmp_path, HEAD + CLAIMS))
    numbers: dict[str, Any] = {"force": 2.4, "wrong": 2.1, "free": 7.0, "words": "good", "found": []}
    wrong = settle_part(table, "one", numbers, printed).claims[1]
    assert (wrong.verdict, wrong.correction) == ("reproduced", "")


def test_nothing_is_published_that_is_not_printed(tmp_path: Path, printed: Printed) -> None:
    numbers: dict[str, Any] = {"force": 2.4, "wrong": 2.1, "free": 7.0, "words": "good", "found": []}
    for name in ("own", "free", "8.5"):
        old, new = '"force", 0.4, "last digit", "typed"', f'{name if name == "8.5" else repr(name)}, 0.4, "l", "typed"'
        table = read_claims(written(tmp_path, HEAD + CLAIMS.replace(old, new.replace("'", '"'))))
        with pytest.raises(DataError, match="but the source prints none like it"):
            settle_part(table, "one", numbers, printed)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('place = "Table 1"', "", "Claim `force` .* must have `place`"),
        ('differs = "twice the stroke"', "", "must have a tolerance, unless"),
        ('differs = "twice the stroke"', "tolerance = 1.0", "the reason for it, or neither"),
        ('differs = "twice the stroke"', 'against = "x"', "must have a tolerance, unless"),
        ('differs = "twice the stroke"', 'differs = "x"\ncorrection = "x"', "must have one of `correction`, `differs`"),
        ('differs = "twice the stroke"', 'kind = "fitted"', "must be `recovery` if there is any"),
        ("scale = 10.0", "scales = 10.0", "no key `scales`. Did you mean `scale`"),
        ('caption = "C"', "", "must have `caption`"),
        ('assumed = "nothing"', "", "digest .* must have `assumed`"),
        ("{ one =", "{ two =", "no key `one`"),
        ('id = "free"', 'id = "free"\ntolerance = 1.0', "Report `free` .* has no key `tolerance`"),
    ],
)
def test_claims_that_are_refused(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    assert old in HEAD + CLAIMS
    with pytest.raises(DataError, match=sentence):
        read_claims(written(tmp_path, (HEAD + CLAIMS).replace(old, new, 1)))


FIELDS: dict[str, Any] = {
    **{"id": "a", "statement": "b", "source": "c", "published": 2.0, "computed": 3.0, "unit": "m", "tolerance": 0.4},
    **{"verdict": "disagrees", "why": "d", "tolerance_reason": "e"},
}


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"verdict": "reproduced"}, "disagrees by its numbers and cannot be reproduced"),
        ({"computed": 2.1}, "reproduced by its numbers and cannot be disagrees"),
        ({"computed": 2.1, "verdict": "misprint", "correction": "x"}, "cannot be misprint"),
        ({"computed": 2.1, "verdict": "self-contradictory", "against": "x"}, "cannot be self-contradictory"),
        ({"verdict": "misprint"}, "must have a `correction`"),
        ({"verdict": "self-contradictory"}, "must have a `against`"),
        ({"verdict": "not comparable", "tolerance": None}, "must have a `differs`"),
        ({"verdict": "not comparable", "differs": "x"}, "must have no tolerance"),
        ({"verdict": "recovery"}, "must have no tolerance"),
        ({"correction": "x"}, "must have no `correction`"),
        ({"published": None}, "must have a published number"),
        ({"published": None, "as_printed": 2.0}, "must have a published number"),
        ({"tolerance_reason": ""}, "must have a published number"),
        ({"tolerance": 0.41}, "must have a tolerance up to 0.4"),
        ({"tolerance": math.nan}, "must have a tolerance up to 0.4"),
    ],
)
def test_a_verdict_against_its_numbers_cannot_be_made(fields: dict[str, Any], sentence: str) -> None:
    assert Claim(**FIELDS).verdict == "disagrees"
    with pytest.raises(ParameterError, match=sentence):
        Claim(**FIELDS | fields)


def test_a_part_must_not_be_called_like_another_key(tmp_path: Path) -> None:
    text = HEAD.replace("{ one =", "{ data =") + CLAIMS.replace("one]]", "data]]")
    with pytest.raises(DataError, match="must not be called `data`"):
        read_claims(written(tmp_path, text))


def test_dotted_names() -> None:
    found = Printed(inner=Printed(rms=3.0))
    assert find_number("a.inner.rms", {"a": found}, "x") == 3.0
    assert find_number(1.5, {}, "x") == 1.5


# ---------------------------------------------------------------- what ships


def table_studies() -> list[TableStudy]:
    return [one for one in map(load_study, study_names()) if isinstance(one, TableStudy)]


each_study = pytest.mark.parametrize("study", table_studies(), ids=lambda one: one.key)


@each_study
def test_units_of_shipped_numbers_are_units(study: TableStudy) -> None:
    import tomllib

    text = (study.folder() / "printed.toml").read_text(encoding="utf-8")
    places = [entries for entries in tomllib.loads(text).values() if isinstance(entries, dict)]
    for entry in (entry for entries in places for entry in entries.values()):
        for unit in entry.get("units", [entry.get("unit")]):
            if unit not in ("", "SI"):
                pint.get_application_registry().parse_units(unit if unit != "1" else "")


@each_study
def test_what_ships_is_complete_and_of_this_program(study: TableStudy) -> None:
    """Numbers are those of the files beside them, verdicts rest on narrow tolerances, and the digest fits a screen."""
    found = study.load_shipped_answer()
    assert found is not None and shipped_numbers.fingerprint_study(study.folder()) in found.made_by, (
        f"`python -m martensite.studies.shipped_numbers {study.key}` computes what ships anew"
    )
    check_complete(found)
    for claim in found.claims:
        printed = claim.published if claim.published is not None else claim.as_printed
        if claim.tolerance is not None:
            assert printed is not None and claim.tolerance <= WIDEST * abs(printed)
        assert not claim.against or re.search(r"Table|section|equation|Figure", claim.against), claim.id
    summary = summarise_answer(study, found, claims=False)
    lines = list(summary.format_lines(PAGE_WIDTH))
    assert len(lines) <= 24 and max(map(len, lines)) <= PAGE_WIDTH, "\n".join(lines)
    assert "…" not in " ".join(found.digest.values())


PLACES = r"(Table|Tables|section|equation|Equation|equations|Equations|Figure|run|chapter|step|T_)s? ?[(\d][\d.()]*"


@each_study
def test_no_figure_of_a_digest_is_typed(study: TableStudy) -> None:
    for sentence in study.table["digest"].values():
        bare = re.sub(r"\{.*?\}|" + PLACES + r"( (to|and) \(?[\d.]+\)?)?", "", " ".join(sentence.split()))
        assert not re.search(r"\d", bare), bare


def test_a_number_that_is_another_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    study = load_study("platform")
    assert isinstance(study, TableStudy)
    monkeypatch.setitem(study.table, "parts", {"equation": "equations"})
    right = shipped_numbers.read_results(study.folder())
    assert right is not None
    study._numbers["equation"] = right["numbers"]["equation"] | {"eq8_finish": 0.7}
    assert shipped_numbers.find_changes(study) == ["`eq8, as printed` was shipped as 0.75 and is 0.7."]
    study._numbers["equation"] = right["numbers"]["equation"] | {"resistivity_hot": 1e-6}
    assert shipped_numbers.find_changes(study) == ["`resistivity-hot` was shipped as 9.70446e-07 and is 1e-06."]


def test_a_figure_of_another_program_is_not_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    study = load_study("hammerstein-wiener")
    assert isinstance(study, TableStudy)
    assert shipped_numbers.find_figure(study) == study.folder() / "figure.svg"
    monkeypatch.setattr(shipped_numbers, "fingerprint_study", lambda folder: "another")
    assert shipped_numbers.find_figure(study) is None


def test_objects_are_shipped_with_what_can_be_written() -> None:
    class Fit:
        def __init__(self) -> None:
            self.h, self.errors, self.path = 1.23456789012345, (1.0, 2.0), Path("x")

        @property
        def rms(self) -> float:
            return 0.5

    simple = shipped_numbers.simplify_numbers({"a": Fit(), "rows": [{"k": 1, "fit": Fit()}]})
    assert simple["a"] == {"h": 1.23456789012, "errors": [1.0, 2.0], "rms": 0.5}
    assert simple["rows"][0]["fit"]["rms"] == 0.5
