"""The paper about the package says nothing that the repository does not back.

Source of truth: the comments beside its claims. `evidence:` names files that must be there, `number:` a row of
`docs/reference/benchmarks/numbers.json`, whose ratio stands right before it.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
PAPER = (ROOT / "paper" / "paper.md").read_text("utf-8")
WORKS = (ROOT / "paper" / "paper.bib").read_text("utf-8")
NUMBERS = json.loads((ROOT / "docs" / "reference" / "benchmarks" / "numbers.json").read_text("utf-8"))
NUMBER = re.compile(r"([\d.]+) times\s+<!-- number: (.*?) -->")
MOST_WORDS = 1750
"""Of a paper of the journal."""


def find_ratio(place: str) -> float:
    """The ratio of `part, table, engine`; a semicolon stands for a comma in a name."""
    part, title, engine = (word.strip().replace(";", ",") for word in place.split(","))
    rows: list[Any] = next(t["rows"] for t in NUMBERS["parts"][part]["tables"] if t["title"] == title)
    return next(row["ratio"] for row in rows if row["engine"] == engine)


def list_wrong_numbers(text: str) -> list[str]:
    found = NUMBER.findall(text)
    return [place for said, place in found if f"{find_ratio(place):.3g}" != f"{float(said):.3g}"]


def test_numbers_are_those_of_the_benchmarks() -> None:
    assert len(NUMBER.findall(PAPER)) == PAPER.count("<!-- number:") > 0
    assert list_wrong_numbers(PAPER) == []


def test_a_wrong_number_is_found() -> None:
    assert list_wrong_numbers(PAPER.replace("15.2 times", "51.1 times")) != []


def test_evidence_is_there() -> None:
    named = [name.strip() for line in re.findall(r"<!-- evidence: (.*?) -->", PAPER) for name in line.split(",")]
    assert len(named) > 20
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_works_are_cited_and_known() -> None:
    cited = set(re.findall(r"@([a-z0-9-]+)", re.sub(r"<!--.*?-->", "", PAPER.partition("# Summary")[2], flags=re.S)))
    assert cited == set(re.findall(r"^@\w+\{([^,]+),", WORKS, re.M))


def test_it_has_the_form_of_the_journal() -> None:
    head = PAPER.split("---")[1]
    for key in ("title:", "tags:", "authors:", "affiliations:", "date:", "bibliography: paper.bib"):
        assert key in head
    for heading in ("# Summary", "# Statement of need", "# State of the field", "# References"):
        assert heading in PAPER
    assert len(re.sub(r"<!--.*?-->", "", PAPER, flags=re.S).split()) < MOST_WORDS
