"""A fit of the page as a command, with records and scenario."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path
from shlex import quote

from martensite.app.identify.fit_request import read_ranges
from martensite.app.messages import Request
from martensite.app.uploads import clean_name
from martensite.fit.experiment import Experiment
from martensite.fit.experiment_kinds.base import Proposal
from martensite.fit.fit import Fit
from martensite.logs.record_text import format_record

SCENARIO = "scenario.toml"


def list_experiments(fit: Fit) -> list[Experiment]:
    """Return the fitted experiments, and the experiments held out as a whole."""
    return [*fit.problem.experiments, *(one.experiment for one in fit.held_out_records)]


def _name_files(fit: Fit) -> list[str]:
    return [f"{clean_name(one.name)}.csv" for one in list_experiments(fit)]


def write_command(request: Request, fit: Fit, proposal: Proposal | None) -> str:
    """Return the command that repeats the fit on the same records."""
    words = ["martensite", "fit", *_name_files(fit), "--scenario", SCENARIO]
    units = {free.name.partition("@")[0]: free.unit for free in fit.problem.free}
    words += ["--free", ",".join(one.write(units.get(one.name, "1")) for one in read_ranges(request, "free"))]
    own = {text.partition("=")[0].strip(): text for text in proposal.each} if proposal else {}
    for one in request.get("each", []):
        words += ["--each", own.get(one["name"], one["name"])]
    compared = request.get("compare") or (list(proposal.columns) if proposal else [])
    words += [word for one in compared for word in ("--column", str(one))]
    hold_out = request.get("hold_out", "auto")
    names = [one.experiment.name for one in fit.held_out_records]
    words += ["--hold-out", ",".join(names)] if names else [] if hold_out == "auto" else ["--hold-out", str(hold_out)]
    for name, usual in (("method", "trf"), ("loss", "linear"), ("starts", 0)):
        words += [] if request.get(name, usual) == usual else [f"--{name}", str(request[name])]
    return " ".join(map(quote, words))


def write_terminal_files(
    request: Request, fit: Fit, proposal: Proposal | None, steps: Sequence[str], path: Path
) -> None:
    """Write an archive with records, scenario and command."""
    command = write_command(request, fit, proposal)
    done = "".join(f"- {one}\n" for one in steps) or "- Nothing: the records are as they were recorded.\n"
    text = f"This repeats the fit:\n\n    {command}\n\nWhat was done to the logs:\n\n{done}"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("README.md", text)
        packed.writestr(SCENARIO, str(request["text"]))
        for name, one in zip(_name_files(fit), list_experiments(fit), strict=True):
            packed.writestr(name, format_record(one.record, list(one.record.columns)))
