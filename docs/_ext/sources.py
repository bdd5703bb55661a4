"""Markdown of the pages about a source: its entry, the claims of its studies, and numbers within the text.

`{{STUDY: NAME:FORMAT}}` in a page stands for a number of a study: `printed.NAME`, `claims[ID].computed`,
`reports[ID].computed`, or a computed number by its name. A page that names none such does not build.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import bibtex
import yaml
from parts import cited, figure, plain, table, unbroken

from martensite.scenario.citations import list_entries
from martensite.studies.base import AbstractStudy, Answer, Claim, load_study
from martensite.studies.shipped_numbers import read_results
from martensite.studies.tables import TableStudy

CITATION = Path(__file__).parents[2] / "CITATION.cff"
COMPARABLE = {
    "reproduced": "",
    "misprint": "misprinted",
    "self-contradictory": "contradicted by another statement of the source",
    "disagrees": "different without a printed reason",
}
"""Verdicts on printed numbers that can be compared, with words for those that are not reproduced."""
_FIELD = re.compile(r"\{\{([a-z-]+): (.+?)\}\}")
_POWER = re.compile(r"(\d)e([+-])0*(\d+)")
_RAISED = str.maketrans("+-0123456789", "\N{SUPERSCRIPT PLUS SIGN}⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_UNITS = {"1": "", "%": "%", "deg": "°", "degC": "°C", "ohm": "Ω", "um": "µm", "W/m^2/K": "W/(m² K)"}
"""Units as a page writes them; others by the rules of `_write_unit`."""


def entry(key: str) -> str:
    """A work in a sentence, with a link to the bibliography."""
    return f"> {bibtex.describe_work(key)} {cited(key)}\n"


def both_entries(key: str) -> str:
    """A work and this program, in BibTeX."""
    about = yaml.safe_load(CITATION.read_text("utf-8"))
    authors = " and ".join(f"{{{one['name']}}}" for one in about["authors"])
    own = {"author": authors, "title": about["title"], "version": version("martensite")}
    program = "".join(f"  {name:<7} = {{{words}}},\n" for name, words in own.items())
    return "\n".join(["```bibtex", *list_entries([key]), "", f"@software{{martensite-program,\n{program}}}", "```\n"])


def drawing(name: str) -> str:
    """Return the figure of a study, for a page in a folder; on a narrow screen it scrolls."""
    return _contained("drawing", figure(name).replace("(_figures", "(../_figures"))


def count_reproduced(studies: Sequence[str]) -> str:
    """Return a sentence with the counts of the verdicts on a source."""
    count: Counter[str] = sum((Counter(find_answer(name)[1].count_all()) for name in studies), Counter[str]())
    comparable = sum(count[verdict] for verdict in COMPARABLE)
    if not comparable:
        return f"**No printed number is comparable** ({count['not comparable']} were examined)."
    others = ", ".join(f"{count[one]} {words}" for one, words in COMPARABLE.items() if words and count[one])
    reproduced = f"**{count['reproduced']} of the {comparable} comparable printed numbers are reproduced**"
    return f"{reproduced}; the others: {others}."


# -- what a study found ------------------------------------------------------------------
@cache
def find_answer(name: str) -> tuple[AbstractStudy, Answer]:
    """A study with all that it found."""
    study = load_study(name)
    return study, study.find_answer()


def claims(name: str) -> str:
    """The claims of a study with their verdicts; what these rest on is folded away."""
    _, answer = find_answer(name)
    counted = ", ".join(f"{count} {words}" for words, count in answer.count_all().items() if count)
    reasons = (f"- *{plain(one.statement)}* ({one.verdict}): {_reason(one)}" for one in answer.claims)
    return "\n".join(
        [
            f"{counted}.\n",
            _contained("claims", table(("claim", "printed", "computed", "verdict"), map(_row, answer.claims))),
            "\n<details><summary>What each verdict rests on</summary>\n",
            *reasons,
            "\n</details>\n",
        ]
    )


def _contained(style: str, text: str) -> str:
    return f":::{{container}} {style}\n{text}\n:::\n"


def _row(one: Claim) -> tuple[str, ...]:
    printed = _write(one.published, one.unit) if one.as_printed is None else f"({_write(one.as_printed, one.unit)})"
    place = one.source.partition(", ")[2]
    return (
        f"{plain(one.statement)} ({place})",
        printed,
        _write(one.computed, one.unit),
        unbroken(one.verdict.replace("-", "\N{NON-BREAKING HYPHEN}")),
    )


def _reason(one: Claim) -> str:
    return plain(one.describe_reason().partition(", ")[2])


def _write(number: float | None, unit: str) -> str:
    if number is None:
        return ""
    words, name = _typeset(f"{number:.4g}"), _write_unit(unit)
    return words + name if name in ("", "°") else unbroken(f"{words} {name}")


def _write_unit(unit: str) -> str:
    return _UNITS[unit] if unit in _UNITS else unit.replace("^2", "²").replace("^3", "³").replace("*", " ")


def _typeset(words: str) -> str:
    """A number as one writes it: with a minus sign, and a power of ten."""
    words = re.sub(r"^-(?=\d)", "\N{MINUS SIGN}", words)
    return _POWER.sub(lambda found: f"{found[1]}·10{(found[2] + found[3]).lstrip('+').translate(_RAISED)}", words)


# -- numbers within the text -------------------------------------------------------------
def with_numbers(text: str) -> str:
    """The text with the number of a study in the place of each field."""
    return _FIELD.sub(lambda found: _typeset(f"{{{found[2]}}}".format_map(known_numbers(found[1]))), text)


@cache
def known_numbers(name: str) -> Mapping[str, Any]:
    """All that a field may name."""
    study, answer = find_answer(name)
    numbers = dict(_list_numbers(study)) if isinstance(study, TableStudy) else {}
    told = {kind: {one.id: one for one in getattr(answer, kind)} for kind in ("claims", "reports")}
    return {**numbers, "printed": getattr(study, "printed", None), **told}


def _list_numbers(study: TableStudy) -> Iterator[tuple[str, Any]]:
    """Computed numbers: those that the study came with, or was found to have."""
    shipped = read_results(study.folder())
    parts = shipped["numbers"] if shipped else {part: study.part_numbers(part) for part in study.table["parts"]}
    for numbers in parts.values():
        yield from numbers.items()
