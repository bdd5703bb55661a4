"""Claims, reports and the digest of a study from its table `claims.toml`.

It holds title, guide and, by part, tables of claims; reports are in tables under `reports`. Keys of a table hold for
all its rows; `-` in a row omits a column.

    [[beam]]
    place = "Table 5"
    unit = "N/m"
    columns = ["id", "what", "published", "tolerance", "tolerance_reason", "why"]
    rows = [
      ["stiffness", "stiffness of the beam", "computed_stiffness", 0.1, "last digit", "3 E I/l³"],
    ]

key                 meaning
id, what, why       name of the claim, its statement, the basis of its verdict
place, source       place in the source; the source, if it differs from that of the printed numbers
published           name of a number of `printed.toml`, or of such a column of the rows of `each`
as_printed          for a misprint, instead of `published`: computed result of a printed equation
computed            name of a computed number, such as `a.rms`; by default the id
scale, unit         factor on both numbers, and their unit afterwards
tolerance           largest allowed difference: a number or the name of one
tolerance_reason    reason of the tolerance
correction          the correct text or number of a misprint
against             the other printed statement of a contradiction, with its place
differs             the difference or omitted data of an incomparable number; `computed` is then optional
kind                `recovery` for a number chosen or fitted with published numbers
each                name of a list of computed rows; the table is repeated for each, with its columns as names
needs               name in `files` of the required files of measured data; `absent` is the reason without them

Verdicts are those of `martensite.studies.base`. Reports have the keys without published numbers. The table `digest` has
a sentence or two for each of its keys. Words in braces in all texts are replaced by numbers, as in `str.format`. A
digest can also use `claims[ID]` and `reports[ID]`, as in `{claims[stiffness].published:.1f}`, and `printed.NAME`.
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
"""Keys of `claims.toml` in addition to the parts; `wanders` lists parts whose searches depend on the machine."""
REQUIRED = ("order", "title", "cites", "guide", "caption", "digest")
NEEDED = ("id", "what", "place", "unit", "why")
REPORTED = (*NEEDED, "computed", "scale", "source", "each", "needs")
CLAIMED = (*REPORTED, *("published", "as_printed", "tolerance", "tolerance_reason", "kind"), *GROUNDS.values())
OMITTED = "-"
ABSENT = "measured data that this machine lacks"


class _Unknown:
    """A missing number in a sentence."""

    def __format__(self, _: str) -> str:
        return "…"

    def __getattr__(self, _: str) -> _Unknown:
        return self


class _Told(dict[str, Any]):
    """Claims or reports by id; a missing one has no numbers."""

    def __missing__(self, _: str) -> _Unknown:
        return _Unknown()


def read_claims(path: Path) -> dict[str, Any]:
    """Return the checked content of a file of claims."""
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
        for tables, check in ((table, _check_claim), (reports, _check_report)):
            tables[part] = [list(_expand_block(block)) for block in tables.get(part, ())]
            for row in (row for block in tables[part] for row in block):
                check(row, f"`{row.get('id', '')}` of {path}")
    return table


def _expand_block(block: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the claims of a table: common keys, and the keys of each row."""
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
    tested = "tolerance" in claim
    if tested != ("tolerance_reason" in claim):
        raise DataError(f"Claim {where} must have a tolerance and the reason for it, or neither.")
    if tested == bool(grounds and grounds[0] in ("kind", "differs")):
        raise DataError(
            f"Claim {where} must have a tolerance, unless it is a recovery or not comparable; "
            "a number that is not published is a report."
        )
    if tested and ("published" in claim) == ("as_printed" in claim):
        raise DataError(f"Claim {where} has a tolerance and must have a published number.")


def _check_report(report: Mapping[str, Any], where: str) -> None:
    check_keys(report, REPORTED, NEEDED, f"Report {where}")


def check_keys(table: Mapping[str, Any], valid: tuple[str, ...], needed: tuple[str, ...], where: str) -> None:
    """Raise `DataError` for unknown and missing keys."""
    for key in table:
        if key not in valid:
            raise DataError(f"{where} has no key `{key}`. {suggest_name(key, valid)}")
    for key in needed:
        if key not in table:
            raise DataError(f"{where} must have `{key}`.")


def settle_part(table: Mapping[str, Any], part: str, numbers: Mapping[str, Any], printed: Any) -> Answer:
    """Return the claims and reports of a part, with computed numbers and verdicts.

    Args:
        table: the result of `read_claims`.
        part: key of the part.
        numbers: computed numbers by name; lists of rows for tables with `each`.
        printed: the printed numbers.
    """
    claims = [_settle_claim(*row) for row in _list_rows(table, table[part], numbers, printed)]
    reports = [_settle_report(*row) for row in _list_rows(table, table["reports"][part], numbers, printed)]
    return Answer(claims, reports)


Row = tuple[Mapping[str, Any], Mapping[str, Any], Any, str]


def _list_rows(
    table: Mapping[str, Any], blocks: list[list[dict[str, Any]]], numbers: Mapping[str, Any], printed: Any
) -> Iterator[Row]:
    """Yield the table, names, printed numbers and reason of absence of each claim or report."""
    from martensite.logs.datasets import is_here

    for block in (block for block in blocks if block):
        for row in numbers[block[0]["each"]] if "each" in block[0] else ({},):
            names = {**table.get("texts", {}), **vars(printed), **numbers, **row}
            for row_claim in block:
                files = table["files"][row_claim["needs"]] if "needs" in row_claim else ()
                available = numbers.get("shipped") or all(map(is_here, files))
                yield row_claim, names, printed, "" if available else table["absent"]


def _settle_report(report: Mapping[str, Any], names: Mapping[str, Any], printed: Any, absent: str) -> StudyReport:
    id, what, unit = (report[key].format_map(names) for key in ("id", "what", "unit"))
    computed = None if absent else _computed_number(report, names, id)
    why = absent or report["why"].format_map(names)
    return StudyReport(id, what, _name_source(report, printed), computed, unit, why)


def _settle_claim(claim: Mapping[str, Any], names: Mapping[str, Any], printed: Any, absent: str) -> Claim:
    """Return a claim with its number and verdict; without them if `absent` has a reason."""
    id, what, unit = (claim[key].format_map(names) for key in ("id", "what", "unit"))
    words = id, what, _name_source(claim, printed)
    published = _published_number(claim, names, printed, id)
    if absent:
        return Claim(*words, published, None, unit, None, "not comparable", absent, differs=ABSENT)
    why = claim["why"].format_map(names)
    bare = "differs" in claim and "computed" not in claim
    computed = None if bare else _computed_number(claim, names, id)
    grounds = {verdict: name for verdict, name in GROUNDS.items() if name in claim}
    named: dict[str, Any] = {name: claim[name].format_map(names) for name in grounds.values()}
    if "tolerance" not in claim:
        verdict: Verdict = "recovery" if "kind" in claim else "not comparable"
        return Claim(*words, published, computed, unit, None, verdict, why, **named)
    if "as_printed" in claim:
        named["as_printed"] = claim.get("scale", 1.0) * find_number(claim["as_printed"], names, id)
    tolerance = find_number(claim["tolerance"], names, id)
    verdict = judge_number(named.get("as_printed", published), computed or 0.0, tolerance)
    if verdict == "reproduced":
        named = {}  # with other numbers than the printed ones, a misprint cannot be tested
    elif grounds:
        (verdict,) = grounds  # type: ignore[assignment]
    reason = claim["tolerance_reason"].format_map(names)
    return Claim(*words, published, computed, unit, tolerance, verdict, why, reason, **named)


def _name_source(claim: Mapping[str, Any], printed: Any) -> str:
    return f"{claim.get('source', printed.source)}, {claim['place']}"


def _computed_number(claim: Mapping[str, Any], names: Mapping[str, Any], id: str) -> float:
    return claim.get("scale", 1.0) * find_number(claim.get("computed", id.replace("-", "_")), names, id)


def _published_number(claim: Mapping[str, Any], names: Mapping[str, Any], printed: Any, id: str) -> Any:
    """Return the published number; a printed one has priority over a computed one of the same name."""
    if "published" not in claim:
        return None
    own = vars(printed) if "each" not in claim else {}
    number = find_number(claim["published"], {**names, **own}, id)
    if number not in _list_printed(printed):
        raise DataError(f"Claim `{id}` has a published number of {number}, but the source prints none like it.")
    return claim.get("scale", 1.0) * number


def _list_printed(printed: Any) -> Iterator[Any]:
    """Yield each printed number, including those in tables."""
    for name, value in vars(printed).items():
        for one in value if isinstance(value, tuple) else (value,):
            if name not in printed.unprinted:
                yield from vars(one).values() if hasattr(one, "__dict__") else (one,)


def find_number(name: str | float, names: Mapping[str, Any], claim: str) -> Any:
    """Return a number by its dotted name, such as `a.rms`; a number stands for itself."""
    if not isinstance(name, str):
        return name
    if name in names:
        return names[name]
    first, *rest = name.split(".")
    if first not in names:
        raise DataError(f"Claim `{claim}` names no number: `{name}`. {suggest_name(first, names)}")
    return reduce(getattr, rest, names[first])


def write_digest(
    table: Mapping[str, Any], numbers: Mapping[str, Any], printed: Any, answers: list[Answer]
) -> dict[str, str]:
    """Return the digest with its numbers, for the numbers and answers of all parts."""
    tables = {kind: _Told({one.id: _blank_unknown(one) for a in answers for one in getattr(a, kind)}) for kind in KINDS}
    names = {**table.get("texts", {}), **vars(printed), **numbers, "printed": printed, **tables}
    return {key: " ".join(table["digest"][key].format_map(names).split()) for key in DIGEST}


KINDS = "claims", "reports"


def _blank_unknown(one: Claim | StudyReport) -> SimpleNamespace:
    return SimpleNamespace(**{key: _Unknown() if value is None else value for key, value in vars(one).items()})
