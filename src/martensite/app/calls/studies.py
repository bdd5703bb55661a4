"""Calls about studies: list and describe them, compute one, keep its results.

A study comes with computed numbers, which are shown at once, without a figure. Results that are computed here are kept
for one version of the package, and for the measured data that were there: they are computed anew once either is
another.
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


def load_named_study(request: Request) -> AbstractStudy:
    """The study of a request.

    Raises:
        UnknownNameError: there is none of that name.
    """
    return load_study(require_entry(request, "name", str))


def describe_study(study: AbstractStudy) -> JsonTable:
    """Return the description of a study without computing."""
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
    """A work as a reader wants it: `text` in a line, its `note`, and a `link` if there is one.

    Raises:
        UnknownNameError: it is not in the bibliography.
    """
    found = read_fields(list_entries([key])[0])
    authors = found.get("author", "").replace(" and others", " et al.").replace(" and ", "; ")
    places = ("journal", "booktitle", "school", "organization", "volume")
    place = " ".join(found[name] for name in places if name in found)
    year = f"({found['year']})" if "year" in found else ""
    pieces = (authors, found.get("title", key), f"{place} {year}".strip())
    text = ". ".join(piece.rstrip(".") for piece in pieces if piece) + "."
    link = f"https://doi.org/{found['doi']}" if "doi" in found else found.get("url", "")
    return {"key": key, "text": text, "note": found.get("note", ""), "link": link}


def list_missing_data(study: AbstractStudy) -> list[dict[str, str]]:
    """Data sets of a study that are not on this machine, wholly or in part."""
    absent = [
        name for name in study.data if not all(is_here(f"{name}/{file}") for file in describe_dataset(name).files)
    ]
    return [
        {"name": name, "title": describe_dataset(name).title, "fetch": f"martensite data fetch {name}"}
        for name in absent
    ]


def describe_answer(study: AbstractStudy, answer: Answer) -> JsonTable:
    """Return the answer of a study without a figure: digest with headings, claims, reports, tally."""
    told = [{"heading": key.replace("_", " "), "text": answer.digest[key]} for key in DIGEST if key in answer.digest]
    return {
        "name": study.key,
        "digest": told,
        "claims": [asdict(claim) for claim in answer.claims],
        "reports": [asdict(report) for report in answer.reports],
        "tally": {name: count for name, count in answer.count_all().items() if name != "reports"},
        "made_by": answer.made_by,
        "figure": "",
        "seconds": 0.0,
    }


def find_results(study: AbstractStudy, folder: Path) -> JsonTable | None:
    """Results that were computed here, else those that came with the study; None without any."""
    if (kept := read_results(study, folder)) is not None:
        return kept
    shipped = study.shipped()
    return None if shipped is None else describe_answer(study, shipped)


def _locate_results(study: AbstractStudy, folder: Path) -> Path:
    return folder / "studies" / f"{study.key}-{version('martensite')}.json"


def read_results(study: AbstractStudy, folder: Path) -> JsonTable | None:
    """Results that were computed before and still hold; None without any."""
    try:
        found: JsonTable = json.loads(_locate_results(study, folder).read_text("utf-8"))
        UploadFolder(folder).path(found["figure"])
        same = found["missing"] == [one["name"] for one in list_missing_data(study)]
    except (OSError, ValueError, KeyError, TypeError, DataError):
        return None
    return found if same else None


def write_results(study: AbstractStudy, folder: Path, results: Request) -> None:
    """Keep results until the version or the data are others."""
    place = _locate_results(study, folder)
    place.parent.mkdir(exist_ok=True)
    write_file(place, write_message(results))


def list_studies(request: Request, desk: Desk) -> JsonTable:
    """All studies, each with the tally of its verdicts if its numbers are known.

    {} -> {"studies": [{"name": …, "title": …, "sources": […], "tally": {…} or null, …}]}
    """
    found: list[JsonTable] = []
    for study in load_studies()[0]:
        results = find_results(study, desk.folder)
        found.append(describe_study(study) | {"tally": results["tally"] if results else None})
    return {"studies": found}


def describe_study_page(request: Request, desk: Desk) -> JsonTable:
    """One study: what it is, the scenarios to open, and its results if they are known.

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
    """Compute a study: its claims and reports, part by part, and its figure. Long work.

    {"name": …} -> {"name": …, "digest": […], "claims": […], "reports": […], "tally": {…}, "figure": key of a file, …}

    Notes: {"doing": words, "done": parts, "of": parts and the figure, "claims": those of the part
    that is over}. The results are kept in the folder.
    """
    study, begun = load_named_study(request), time.perf_counter()
    found: list[Answer] = []
    parts = study.parts()
    new: list[JsonTable] = []
    for done, (words, part) in enumerate(parts.items()):
        desk.tell({"doing": words, "done": done, "of": len(parts) + 1, "claims": new})
        found.append(part())
        new = [asdict(claim) for claim in found[-1].claims]
    desk.tell({"doing": "the figure", "done": len(parts), "of": len(parts) + 1, "claims": new})
    key, path = UploadFolder(desk.folder).place(f"{study.key}.svg")
    study.figure(path)
    claims, reports = ([one for part in found for one in getattr(part, kind)] for kind in ("claims", "reports"))
    results = describe_answer(study, Answer(claims, reports, study.digest())) | {
        "figure": key,
        "missing": [one["name"] for one in list_missing_data(study)],
        "seconds": time.perf_counter() - begun,
    }
    write_results(study, desk.folder, results)
    return results
