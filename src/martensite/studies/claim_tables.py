"""Claims, reports and the digest of a study from its table `claims.toml`.

It holds title, guide and, part by part, tables of claims; reports stand apart, part by part under `reports`.
Keys of a table hold for all its rows; `-` in a row leaves a column out.

    [[beam]]
    place = "Table 5"
    unit = "N/m"
    columns = ["id", "what", "published", "tolerance", "tolerance_reason", "why"]
    rows = [
      ["stiffness", "stiffness of the beam", "computed_stiffness", 0.1, "last digit", "3 E I/l³"],
    ]

key                 meaning
id, what, why       name of the claim, its statement, the basis of its verdict
place, source       place in the source; the source, if it differs from the source of the printed numbers
published           a number of `printed.toml` by its name, or a column of the rows of `each` that comes from there
as_printed          of a misprint, instead of `published`: a computed number, the result of a printed equation
computed            a computed number by its name, such as `a.rms`; the id if left out
scale, unit         factor on both numbers, and the unit that they then have
tolerance           largest difference that counts as agreement: a number or the name of one
tolerance_reason    why so large
correction          makes it a misprint: the correct text or number
against             makes it a contradiction: the other printed statement, with its place
differs             makes it not comparable: the difference or omitted data; `computed` is then optional
kind                `recovery` for a number chosen or fitted with published numbers
each                a list of computed rows, for each of which there are the claims of the table;
                    their columns come before all other names
needs               files of measured data that the number requires, by their name in
                    `files`; `absent` says why

Verdicts are those of `martensite.studies.base`. Reports have the first lines of keys, without published numbers. The
table `digest` has a sentence or two for each of its keys. Words in braces in all texts are replaced by numbers, as in
`str.format`. A digest may also use `claims[ID]` and `reports[ID]`, as in `{claims[stiffness].published:.1f}`, and
`printed.NAME`.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from functools import reduce
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from martensite.base.errors import DataError, suggest_name
from martensite.studies.base import DIGEST, GROUNDS, Answer, Claim, StudyReport, Verdict, judge_number

HEADER = (
    *("order", "title", "cites", "guide", "caption", "scenarios", "parts", "digest", "reports"),
    *("data", "absent", "files", "texts", "compiler", "wanders"),
)
"""Keys of `claims.toml` beside the parts; `wanders` lists parts whose searches may end elsewhere on another machine."""
REQUIRED = ("order", "title", "cites", "guide", "caption", "digest")
NEEDED = ("id", "what", "place", "unit", "why")
REPORTED = (*NEEDED, "computed", "scale", "source", "each", "needs")
CLAIMED = (*REPORTED, *("published", "as_printed", "tolerance", "tolerance_reason", "kind"), *GROUNDS.values())
OMITTED = "-"
ABSENT = "measured data that this machine lacks"


class _Unknown:
    """A number that there is not, in a sentence."""

    def __format__(self, _: str) -> str:
        return "…"

    def __getattr__(self, _: str) -> _Unknown:
        return self


class _Told(dict[str, Any]):
    """Claims or reports by their ids; of one that is not among them no number is known."""

    def __missing__(self, _: str) -> _Unknown:
        return _Unknown()


def read_claims(path: Path) -> dict[str, Any]:
    """Return a file of claims, checked.

    Raises:
        DataError: a key is unknown, missing or taken, or a tolerance has no reason.
    """
    table = tomllib.loads(path.read_text("utf-8"))
    parts = table.get("parts", {})
    check_keys(table, (*HEADER, *parts), (*REQUIRED,), str(path))
    check_keys(table["digest"], DIGEST, DIGEST, f"The digest of {path}")
    reports = table.setdefault("reports", {})
    check_keys(reports, tuple(parts), (), f"Table `reports` of {path}")
    for part in parts:
        if part in HEADER:
            raise DataError(f"A part of {path} must not be called `{part}`: the word is taken.")
        if part not in table and part not in reports:
            raise DataError(f"{path} must have `{part}`.")
        for held, check in ((table, _check_claim), (reports, _check_report)):
            held[part] = [list(_expand_block(block)) for block in held.get(part, ())]
            for row in (row for block in held[part] for row in block):
                check(row, f"`{row.get('id', '')}` of {path}")
    return table


def _expand_block(block: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the claims of a table: keys for all, and those of each row."""
    shared = {key: value for key, value in block.items() if key not in ("columns", "rows")}
    columns = block.get("columns", ())
    for row in block.get("rows", ((),)):
        cells = zip(columns, row, strict=True)
        yield shared | {key: value for key, value in cells if value != OMITTED}


def _check_claim(claim: Mapping[str, Any], where: str) -> None:
    check_keys(claim, CLAIMED, NEEDED, f"Claim {where}")
    grounds = [key for key in ("kind", *GROUNDS.values()) if key in claim]
    if len(grounds) > 1:
        raise DataError(f"Claim {where} must have one of {', '.join(f'`{key}`' for key in grounds)}.")
    if claim.get("kind", "recovery") != "recovery":
        raise DataError(f"The kind of claim {where} must be `recovery` if there is any, but is `{claim['kind']}`.")
    judged = "tolerance" in claim
    if judged != ("tolerance_reason" in claim):
        raise DataError(f"Claim {where} must have a tolerance and the reason for it, or neither.")
    if judged == bool(grounds and grounds[0] in ("kind", "differs")):
        raise DataError(
            f"Claim {where} must have a tolerance, unless it is a recovery or not comparable; "
            "a number that is not published is a report."
        )
    if judged and ("published" in claim) == ("as_printed" in claim):
        raise DataError(f"Claim {where} has a tolerance and must have a published number.")


def _check_report(report: Mapping[str, Any], where: str) -> None:
    check_keys(report, REPORTED, NEEDED, f"Report {where}")


def check_keys(table: Mapping[str, Any], known: tuple[str, ...], needed: tuple[str, ...], where: str) -> None:
    """Raise `DataError` for a key that is not known, and for one that is missing."""
    for key in table:
        if key not in known:
            raise DataError(f"{where} has no key `{key}`. {suggest_name(key, known)}")
    for key in needed:
        if key not in table:
            raise DataError(f"{where} must have `{key}`.")


def settle_part(table: Mapping[str, Any], part: str, numbers: Mapping[str, Any], printed: Any) -> Answer:
    """Return the claims and reports of a part, with computed numbers and verdicts.

    Args:
        table: what `read_claims` gave.
        part: key of the part.
        numbers: computed numbers by their names; lists of rows for tables with `each`.
        printed: the printed numbers.
    """
    claims = [_settle_claim(*row) for row in _list_rows(table, table[part], numbers, printed)]
    reports = [_settle_report(*row) for row in _list_rows(table, table["reports"][part], numbers, printed)]
    return Answer(claims, reports)


Row = tuple[Mapping[str, Any], Mapping[str, Any], Any, str]


def _list_rows(
    table: Mapping[str, Any], blocks: list[list[dict[str, Any]]], numbers: Mapping[str, Any], printed: Any
) -> Iterator[Row]:
    """Yield every claim or report: what the table says, words and numbers by name, printed ones, why there is none."""
    from martensite.logs.datasets import is_here

    for block in (block for block in blocks if block):
        for row in numbers[block[0]["each"]] if "each" in block[0] else ({},):
            names = {**table.get("texts", {}), **vars(printed), **numbers, **row}
            for said in block:
                files = table["files"][said["needs"]] if "needs" in said else ()
                known = numbers.get("shipped") or all(map(is_here, files))
                yield said, names, printed, "" if known else table["absent"]


def _settle_report(said: Mapping[str, Any], names: Mapping[str, Any], printed: Any, absent: str) -> StudyReport:
    id, what, unit = (said[key].format_map(names) for key in ("id", "what", "unit"))
    computed = None if absent else _computed_number(said, names, id)
    why = absent or said["why"].format_map(names)
    return StudyReport(id, what, _name_source(said, printed), computed, unit, why)


def _settle_claim(said: Mapping[str, Any], names: Mapping[str, Any], printed: Any, absent: str) -> Claim:
    """Return a claim with its number and its verdict; without them for the reason `absent`, if any."""
    id, what, unit = (said[key].format_map(names) for key in ("id", "what", "unit"))
    words = id, what, _name_source(said, printed)
    published = _published_number(said, names, printed, id)
    if absent:
        return Claim(*words, published, None, unit, None, "not comparable", absent, differs=ABSENT)
    why = said["why"].format_map(names)
    bare = "differs" in said and "computed" not in said
    computed = None if bare else _computed_number(said, names, id)
    grounds = {verdict: name for verdict, name in GROUNDS.items() if name in said}
    named: dict[str, Any] = {name: said[name].format_map(names) for name in grounds.values()}
    if "tolerance" not in said:
        verdict: Verdict = "recovery" if "kind" in said else "not comparable"
        return Claim(*words, published, computed, unit, None, verdict, why, **named)
    if "as_printed" in said:
        named["as_printed"] = said.get("scale", 1.0) * find_number(said["as_printed"], names, id)
    tolerance = find_number(said["tolerance"], names, id)
    verdict = judge_number(named.get("as_printed", published), computed or 0.0, tolerance)
    if verdict == "reproduced":
        named = {}  # with different numbers than the printed ones, a misprint cannot be judged
    elif grounds:
        (verdict,) = grounds  # type: ignore[assignment]
    reason = said["tolerance_reason"].format_map(names)
    return Claim(*words, published, computed, unit, tolerance, verdict, why, reason, **named)


def _name_source(said: Mapping[str, Any], printed: Any) -> str:
    return f"{said.get('source', printed.source)}, {said['place']}"


def _computed_number(said: Mapping[str, Any], names: Mapping[str, Any], id: str) -> float:
    return said.get("scale", 1.0) * find_number(said.get("computed", id.replace("-", "_")), names, id)


def _published_number(said: Mapping[str, Any], names: Mapping[str, Any], printed: Any, id: str) -> Any:
    """Return the published number; a printed one comes before a computed one of the same name.

    Raises:
        DataError: no such number is printed.
    """
    if "published" not in said:
        return None
    own = vars(printed) if "each" not in said else {}
    found = find_number(said["published"], {**names, **own}, id)
    if found not in _list_printed(printed):
        raise DataError(f"Claim `{id}` has a published number of {found}, but the source prints none like it.")
    return said.get("scale", 1.0) * found


def _list_printed(printed: Any) -> Iterator[Any]:
    """Yield every printed number, those of tables too."""
    for name, value in vars(printed).items():
        for one in value if isinstance(value, tuple) else (value,):
            if name not in printed.unprinted:
                yield from vars(one).values() if hasattr(one, "__dict__") else (one,)


def find_number(name: str | float, known: Mapping[str, Any], claim: str) -> Any:
    """Return a number by its dotted name, such as `a.rms`; a number stands for itself.

    Raises:
        DataError: there is none of that name.
    """
    if not isinstance(name, str):
        return name
    if name in known:
        return known[name]
    first, *rest = name.split(".")
    if first not in known:
        raise DataError(f"Claim `{claim}` names no number: `{name}`. {suggest_name(first, known)}")
    return reduce(getattr, rest, known[first])


def write_digest(
    table: Mapping[str, Any], numbers: Mapping[str, Any], printed: Any, answers: list[Answer]
) -> dict[str, str]:
    """Return the digest with its numbers; `numbers` are those of all parts, `answers` their claims and reports."""
    told = {kind: _Told({one.id: _blank_unknown(one) for a in answers for one in getattr(a, kind)}) for kind in KINDS}
    names = {**table.get("texts", {}), **vars(printed), **numbers, "printed": printed, **told}
    return {key: " ".join(table["digest"][key].format_map(names).split()) for key in DIGEST}


KINDS = "claims", "reports"


def _blank_unknown(one: Claim | StudyReport) -> SimpleNamespace:
    """Return the fields of a claim or report, to be written into a sentence."""
    return SimpleNamespace(**{key: _Unknown() if value is None else value for key, value in vars(one).items()})
