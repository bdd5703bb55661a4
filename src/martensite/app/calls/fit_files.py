"""What a finished fit leaves behind.

{"key": of the fit, "what": "material"} -> {"key": …, "name": …}

`material` is a material file (TOML) with numbers, intervals, and hashes of the data; `report` a
page of HTML with figures. The fit is computed again at the numbers that were found, without a
search.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from threading import Event
from typing import Any

from martensite.app.calls.fit import ENDED, searched
from martensite.app.drawer import Drawer
from martensite.app.identify.asked import task_of_request
from martensite.app.identify.watching import Watching
from martensite.app.messages import BadMessageError, wanted
from martensite.app.worker import Desk
from martensite.base.errors import DataError
from martensite.fit.material_files import write_material
from martensite.fit.task import LogFit

ENDINGS = {"material": "toml", "report": "html"}


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, str]:
    """Write the file that is asked for."""
    what = wanted(request, "what", str)
    if what not in ENDINGS:
        raise BadMessageError(f"`what` must be one of {', '.join(ENDINGS)}, but is {what!r}.")
    drawer = Drawer(desk.folder)
    kept = _kept(drawer, wanted(request, "key", str))
    fit = _again(kept, desk)
    source = fit.problem.experiments[0].record.source
    name = source.stem if source is not None else "fit"
    key, path = drawer.place(f"{name}.{ENDINGS[what]}")
    desk.tell({"stage": "writing"})
    _write(fit, what, path)
    return {"key": key, "name": path.name}


def _write(fit: LogFit, what: str, path: Path) -> None:
    if what == "material":
        write_material(fit, path, scenario=fit.scenario)
        return
    from martensite.show.reports.fit_report import write_report

    write_report(fit, path, scenario=fit.scenario)


def _again(kept: Mapping[str, Any], desk: Desk) -> LogFit:
    """The fit, at the numbers that were found."""
    arranged = task_of_request(wanted(kept, "request", dict), desk).arranged()
    ended = Event()
    ended.set()
    watching = Watching(arranged.problem.training, desk.tell, ended)
    state = Drawer(desk.folder).path(wanted(kept, "state", str))
    found = searched(arranged, watching, state)
    known = {name: wanted(kept, "ended", dict)[name] for name in ENDED}
    history = tuple((int(runs), float(cost)) for runs, cost in known.pop("history"))
    return replace(found, **known, history=history)


def _kept(drawer: Drawer, key: str) -> dict[str, Any]:
    try:
        found = json.loads(drawer.path(key).read_text(encoding="utf-8"))
        if isinstance(found, dict) and {"request", "state", "ended"} <= found.keys():
            return found
    except ValueError:
        pass
    raise DataError("This file is not that of a fit.")
