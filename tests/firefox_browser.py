"""A headless Firefox, driven by WebDriver BiDi: commands and events as JSON over a socket."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

NAMES = ("firefox-esr", "firefox")
PATIENCE = 60.0
"""For a process that starts on a busy machine [s]."""


class Firefox:
    """One window of a Firefox."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket, self._count = socket, 0
        self.said: list[str] = []
        """Errors and warnings of the console, and uncaught exceptions."""
        self.ask("session.new", capabilities={})
        self.ask("session.subscribe", events=["log.entryAdded"])
        self._context: str = self.ask("browsingContext.getTree")["contexts"][0]["context"]

    def ask(self, method: str, **params: Any) -> Any:
        """Return the answer to a command; events before it are kept."""
        self._count += 1
        self._socket.send(json.dumps({"id": self._count, "method": method, "params": params}))
        while True:
            message = json.loads(self._socket.recv(timeout=PATIENCE))
            if message.get("method") == "log.entryAdded" and message["params"]["level"] in ("error", "warn"):
                self.said.append(message["params"]["text"])
            if message.get("id") == self._count:
                assert message["type"] == "success", message
                return message["result"]

    def resize(self, width: int, height: int) -> None:
        """Give the page a size [px]."""
        viewport = {"width": width, "height": height}
        self.ask("browsingContext.setViewport", context=self._context, viewport=viewport)

    def open(self, address: str) -> None:
        """Go to an address; a page that replaces its address at once aborts no wait."""
        self.ask("browsingContext.navigate", context=self._context, url="about:blank", wait="complete")
        self.ask("browsingContext.navigate", context=self._context, url=address, wait="none")

    def evaluate(self, script: str) -> Any:
        """Return the text, number or flag that a script, or its promise, gives."""
        target = {"context": self._context}
        found = self.ask("script.evaluate", expression=script, target=target, awaitPromise=True)
        assert found["type"] == "success", found["exceptionDetails"]["text"]
        return found["result"].get("value")

    def wait_for(self, condition: str) -> Any:
        """Return the first true value of an expression."""
        ask = f"""new Promise((done, failed) => {{
          const begun = Date.now();
          const look = () => {{
            const found = {condition};
            if (found) done(found);
            else if (Date.now() - begun > {1000 * (PATIENCE - 5)}) failed(new Error("it never came"));
            else setTimeout(look, 50);
          }};
          look();
        }})"""
        return self.evaluate(ask)


def find_firefox() -> str | None:
    """Return the path of Firefox, or None."""
    return next(filter(None, map(shutil.which, NAMES)), None)


@contextmanager
def run_firefox(program: str, profile: Path) -> Iterator[Firefox]:
    """Provide a Firefox that ends with the block."""
    command = [program, "--headless", "--no-remote", "--profile", profile, "--remote-debugging-port", "0"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) as process:
        try:
            assert process.stderr is not None
            lines = iter(process.stderr.readline, "")
            found = next(filter(None, (re.search(r"ws://[\d.:]+", line) for line in lines)))
            with connect(f"{found[0]}/session", max_size=2**26) as socket:
                yield Firefox(socket)
        finally:
            process.terminate()
