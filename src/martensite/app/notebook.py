"""The web bench in a notebook: a widget (anywidget) whose page uses the kernel instead of a server.

    from the page: {"id", "call": name, "request": {…}}, {"id", "file": key} or {"id", "asset": name}
    to the page:   {"id"} with the answer as bytes, or {"id", "refused": sentence, "kind"}

The functions of the server answer the calls.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import anywidget
import traitlets

from martensite.app.documents import check_files
from martensite.app.messages import Request, describe_refusal, require_choice, require_entry, write_message
from martensite.app.routes import find_call
from martensite.app.site import STATIC, WIDGET
from martensite.app.worker import Desk
from martensite.base.errors import InputError
from martensite.scenario.scenario import Scenario, read_scenario

CALLS = ("run", "form", "scenarios", "differences", "export", "model")
"""Calls of the bench; other pages are excluded."""
ASSETS = tuple(sorted(path.name for path in STATIC.iterdir()))
"""Files of the page."""


class BenchWidget(anywidget.AnyWidget):
    """The bench of a scenario: `scenario.show_bench()`.

    `scenario` has all changes of the page; `text` can be set to another document.

    Raises:
        InputError: the scenario continues another run, which no document stores.
        DataError: the scenario reads files, such as a log.
    """

    _esm = (STATIC / WIDGET).read_text("utf-8")
    text = traitlets.Unicode().tag(sync=True)
    """The scenario, TOML."""
    height = traitlets.Int(780, min=300).tag(sync=True)
    """Height of the page [px]."""

    def __init__(self, scenario: Scenario, **settings: Any) -> None:
        if scenario.start is not None:
            raise InputError("The bench starts at the beginning; this scenario goes on from another run.")
        check_files(scenario.text, {})
        super().__init__(text=scenario.text, **settings)
        self._path = scenario.path
        self._folder = tempfile.TemporaryDirectory(prefix="martensite-")
        self._desk = Desk(Path(self._folder.name))
        self.on_msg(self._hear)

    @property
    def scenario(self) -> Scenario:
        """Return the scenario of the page."""
        return read_scenario(self.text, self._path)

    def _hear(self, _: Any, content: Request, buffers: Any) -> None:
        try:
            answer = self.answer(content)
        except Exception as error:  # the page shows it; the kernel continues
            self.send({"id": content.get("id"), **describe_refusal(error)})
        else:
            self.send({"id": content.get("id")}, buffers=[answer])

    def answer(self, request: Request) -> bytes:
        """Return the answer to the page."""
        if "file" in request:
            return self._desk.files.path(require_entry(request, "file", str)).read_bytes()
        if "asset" in request:
            return (STATIC / _require_name(request, "asset", ASSETS)).read_bytes()
        call = _require_name(request, "call", CALLS)
        return write_message(find_call(call)(require_entry(request, "request", dict, {}), self._desk))


def _require_name(request: Request, entry: str, names: tuple[str, ...]) -> str:
    return require_choice(request, entry, entry, names)
