"""What the calls about studies share: a study described, and its results kept in the folder.

Results are kept for one version of the package, and for the measured data that were there: they
are computed anew once either is another.
"""

from __future__ import annotations

import inspect
import json
from collections import Counter
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any, get_args

from martensite.app.drawer import Drawer
from martensite.app.messages import dumps, wanted
from martensite.base.errors import DataError
from martensite.base.files import replace_file
from martensite.scenario.citations import format_reference
from martensite.scenario.datasets import describe_dataset, is_here
from martensite.studies.base import AbstractStudy, Verdict, load_study


def named(request: Mapping[str, Any]) -> AbstractStudy:
    """The study of a request.

    Raises:
        UnknownNameError: there is none of that name.
    """
    return load_study(wanted(request, "name", str))


def about(study: AbstractStudy) -> dict[str, Any]:
    """What is known of a study without computing anything."""
    guide = [" ".join(paragraph.split()) for paragraph in study.guide.split("\n\n")]
    return {
        "name": study.key,
        "title": study.title,
        "guide": [paragraph for paragraph in guide if paragraph],
        "sources": [format_reference(key) for key in study.cites],
        "figure": study.caption or (inspect.getdoc(type(study).figure) or "").partition("\n")[0],
        "missing": missing(study),
    }


def missing(study: AbstractStudy) -> list[dict[str, str]]:
    """Data sets of a study that are not on this machine, wholly or in part."""
    absent = [name for name in study.data if not _whole(name)]
    return [
        {
            "name": name,
            "title": describe_dataset(name).title,
            "fetch": f"martensite data fetch {name}",
        }
        for name in absent
    ]


def _whole(name: str) -> bool:
    return all(is_here(f"{name}/{file}") for file in describe_dataset(name).files)


def tally(claims: list[dict[str, Any]]) -> dict[str, int]:
    """How many claims there are of each verdict."""
    counted = Counter(claim["verdict"] for claim in claims)
    return {verdict: counted[verdict] for verdict in get_args(Verdict)}


def _place(study: AbstractStudy, folder: Path) -> Path:
    return folder / "studies" / f"{study.key}-{version('martensite')}.json"


def kept(study: AbstractStudy, folder: Path) -> dict[str, Any] | None:
    """Results that were computed before and still hold; None without any."""
    try:
        found: dict[str, Any] = json.loads(_place(study, folder).read_text("utf-8"))
        Drawer(folder).path(found["figure"])
        same = found["missing"] == [one["name"] for one in missing(study)]
    except (OSError, ValueError, KeyError, TypeError, DataError):
        return None
    return found if same else None


def keep(study: AbstractStudy, folder: Path, results: Mapping[str, Any]) -> None:
    """Keep results until the version or the data are others."""
    place = _place(study, folder)
    place.parent.mkdir(exist_ok=True)
    with replace_file(place) as part:
        part.write_bytes(dumps(results))
