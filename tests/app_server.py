"""A running bench for tests, and a way to ask it."""

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import httpx

TAB = "tab-of-tests"


@dataclass(frozen=True)
class Bench:
    """A server in a process of its own."""

    port: int
    token: str
    folder: Path
    pid: int

    @property
    def origin(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def address(self) -> str:
        return f"{self.origin}/?token={self.token}"

    def client(self, tab: str = TAB, **headers: str) -> httpx.Client:
        """Somebody who holds the token."""
        known = {"Authorization": f"Bearer {self.token}", "X-Tab": tab}
        return httpx.Client(base_url=self.origin, headers={**known, **headers}, timeout=60.0)

    def call(self, name: str, request: dict[str, Any], tab: str = TAB) -> Any:
        """The answer to a quick call; whatever its status."""
        with self.client(tab) as client:
            return client.post(f"/api/call/{name}", json=request).json()


@contextmanager
def running(folder: Path, port: int = 0, environment: Mapping[str, str] = MappingProxyType({})) -> Iterator[Bench]:
    """A bench that keeps its files in `folder`."""
    command = [sys.executable, "-m", "martensite", "app", "--no-browser", "--json"]
    process = subprocess.Popen(
        [*command, "--folder", str(folder), "--port", str(port)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1", **environment},
    )
    errors: list[str] = []
    assert process.stdout and process.stderr
    reader = threading.Thread(target=lambda: errors.extend(process.stderr or ()), daemon=True)
    reader.start()
    try:
        at = _announced(process, errors)
        yield Bench(at["port"], at["token"], folder, process.pid)
    finally:
        process.terminate()
        process.wait(20)
        reader.join(5)
        process.stdout.close()
        process.stderr.close()
    assert not [line for line in errors if "Traceback" in line], "".join(errors)


def _announced(process: "subprocess.Popen[str]", errors: list[str]) -> dict[str, Any]:
    """What the server prints about itself when it is ready."""
    text = ""
    assert process.stdout
    while line := process.stdout.readline():
        text += line
        if line.startswith("}"):
            return json.loads(text)
    time.sleep(0.2)
    raise AssertionError(f"the bench did not start: {text}{''.join(errors)}")
