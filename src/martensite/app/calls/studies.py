"""Calls about studies: list, describe and compute them, and cache results.

Shipped numbers and figures are displayed at once. Computed results are cached for one version of the package and the
present measured data.
"""

from __future__ import annotations

import inspect
import json
import time
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

from martensite.app.messages import JsonTable, Request, require_entry, write_message
from martensite.app.uploads import UploadFolder
from martensite.app.worker import Desk
from martensite.base.errors import DataError
from martensite.base.files import write_file
from martensite.logs.datasets import describe_dataset, is_here
from martensite.scenario.citations import list_entries, read_fields
from martensite.studies.base import DIGEST, AbstractStudy, Answer, load_studies, load_study

SHIPPED = "shipped"
"""Name of the figure of shipped results, in place of the key of a file."""


def load_named_study(request: Request) -> AbstractStudy:
    """Return the study of a request."""
    return load_study(require_entry(request, "name", str))


def describe_study(study: AbstractStudy) -> JsonTable:
    """Return the description of a study, without a computation."""
    guide = [" ".join(paragraph.split()) for paragraph in study.guide.split("\n\n")]
    return {
        "name": study.key,
        "title": study.title,
        "guide": [paragraph for paragraph in guide if paragraph],
        "sources": [format_reference(key) for key in study.cites],
        "figure": study.caption or (inspect.getdoc(type(study).figure) or "").partition("\n")[0],
        "missing": list_missing_data(study),
    }


def format_reference(key: str) -> dict[str, str]:
    """Return a work of the bibliography: `text` in a line, its `note`, and a `link` or an empty text."""
    fields = read_fields(list_entries([key])[0])
    authors = fields.get("author", "").replace(" and others", " et al.").replace(" and ", "; ")
    places = ("journal", "booktitle", "school", "organization", "volume")
    place = " ".join(fields[name] for name in places if name in fields)
    year = f"({fields['year']})" if "year" in fields else ""
    pieces = (authors, fields.get("title", key), f"{place} {year}".strip())
    text = ". ".join(piece.rstrip(".") for piece in pieces if piece) + "."
    link = f"https://doi.org/{fields['doi']}" if "doi" in fields else fields.get("url", "")
    return {"key": key, "text": text, "note": fields.get("note", ""), "link": link}


def list_missing_data(study: AbstractStudy) -> list[dict[str, str]]:
    """Return the data sets of a study that are missing on this machine."""
    absent = [
        name for name in study.data if not all(is_here(f"{name}/{file}") for file in describe_dataset(name).files)
    ]
    return [
        {"name": name, "title": describe_dataset(name).title, "fetch": f"martensite data fetch {name}"}
        for name in absent
    ]


def describe_answer(study: AbstractStudy, answer: Answer) -> JsonTable:
    """Return the answer of a study without a figure: digest, claims, reports, tally."""
    entries = [{"heading": key.replace("_", " "), "text": answer.digest[key]} for key in DIGEST if key in answer.digest]
    return {
        "name": study.key,
        "digest": entries,
        "claims": [asdict(claim) for claim in answer.claims],
        "reports": [asdict(report) for report in answer.reports],
        "tally": {name: count for name, count in answer.count_all().items() if name != "reports"},
        "made_by": answer.made_by,
        "figure": "",
        "seconds": 0.0,
    }


def find_results(study: AbstractStudy, folder: Path) -> JsonTable | None:
    """Return cached results, else shipped results, else None."""
    if (results := read_results(study, folder)) is not None:
        return results
    shipped = study.load_shipped_answer()
    if shipped is None:
        return None
    return describe_answer(study, shipped) | {"figure": "" if study.shipped_figure() is None else SHIPPED}


def read_figure(request: Request, desk: Desk) -> JsonTable:
    """Return the figure of a study: of its cached results, else the shipped figure.

    {"name": …} -> {"svg": text}
    """
    study = load_named_study(request)
    results = read_results(study, desk.folder)
    path = desk.files.path(results["figure"]) if results else study.shipped_figure()
    if path is None:
        raise DataError(f"The study `{study.key}` has no stored figure; compute it first.")
    return {"svg": path.read_text("utf-8")}


def _locate_results(study: AbstractStudy, folder: Path) -> Path:
    return folder / "studies" / f"{study.key}-{version('martensite')}.json"


def read_results(study: AbstractStudy, folder: Path) -> JsonTable | None:
    """Return valid cached results, or None."""
    try:
        results: JsonTable = json.loads(_locate_results(study, folder).read_text("utf-8"))
        UploadFolder(folder).path(results["figure"])
        same = results["missing"] == [one["name"] for one in list_missing_data(study)]
    except (OSError, ValueError, KeyError, TypeError, DataError):
        return None
    return results if same else None


def write_results(study: AbstractStudy, folder: Path, results: Request) -> None:
    """Cache results until the version or the data change."""
    place = _locate_results(study, folder)
    place.parent.mkdir(exist_ok=True)
    write_file(place, write_message(results))


def list_studies(request: Request, desk: Desk) -> JsonTable:
    """Return all studies, with the tally of their verdicts if known.

    {} -> {"studies": [{"name": …, "title": …, "sources": […], "tally": {…} or null, "drawn": key or empty, …}]}
    """
    rows: list[JsonTable] = []
    for study in load_studies()[0]:
        results = find_results(study, desk.folder)
        outcome = {"tally": results["tally"], "drawn": results["figure"]} if results else {"tally": None, "drawn": ""}
        rows.append(describe_study(study) | outcome)
    return {"studies": rows}


def describe_study_page(request: Request, desk: Desk) -> JsonTable:
    """Return a study with its scenarios, and its results if known.

    {"name": …}
    -> {"name": …, "guide": […], "scenarios": [{title, text}], "results": {…} or null, …}
    """
    study = load_named_study(request)
    scenarios = [{"title": title, "text": text} for title, text in study.scenarios().items()]
    return describe_study(study) | {
        "parts": list(study.parts()),
        "scenarios": scenarios,
        "results": find_results(study, desk.folder),
    }


def compute_study(request: Request, desk: Desk) -> JsonTable:
    """Compute a study part by part, and its figure. Long work.

    {"name": …} -> {"name": …, "digest": […], "claims": […], "reports": […], "tally": {…}, "figure": key of a file, …}

    Notes: {"doing": words, "done": parts, "of": parts and the figure, "claims": of the last part}. The results are
    cached.
    """
    study, start = load_named_study(request), time.perf_counter()
    answers: list[Answer] = []
    parts = study.parts()
    new: list[JsonTable] = []
    for done, (words, part) in enumerate(parts.items()):
        desk.tell({"doing": words, "done": done, "of": len(parts) + 1, "claims": new})
        answers.append(part())
        new = [asdict(claim) for claim in answers[-1].claims]
    desk.tell({"doing": "the figure", "done": len(parts), "of": len(parts) + 1, "claims": new})
    key, path = desk.files.place(f"{study.key}.svg")
    study.figure(path)
    claims, reports = ([one for part in answers for one in getattr(part, kind)] for kind in ("claims", "reports"))
    results = describe_answer(study, Answer(claims, reports, study.digest())) | {
        "figure": key,
        "missing": [one["name"] for one in list_missing_data(study)],
        "seconds": time.perf_counter() - start,
    }
    write_results(study, desk.folder, results)
    return results
