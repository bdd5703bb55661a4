"""The cells of a page, run in this process one after another, as a notebook runs them.

What a cell prints, displays and returns is kept as outputs of a notebook, in the order in which
it comes. A page that is built talks to nobody, so there is no Jupyter kernel.
"""

from __future__ import annotations

import base64
import os
import re
import subprocess
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from io import TextIOBase
from typing import Any

from IPython.core.displayhook import DisplayHook
from IPython.core.displaypub import DisplayPublisher
from IPython.core.interactiveshell import InteractiveShell
from traitlets import Type

Output = dict[str, Any]
"""An output of a notebook (nbformat 4)."""
_COLOUR = re.compile(r"\x1b\[[\d;]*m")


class Stream(TextIOBase):
    """Standard output or error of a cell, kept among its outputs."""

    def __init__(self, name: str, kept: list[Output]) -> None:
        self.stream, self.kept = name, kept

    def writable(self) -> bool:
        """Text can be written."""
        return True

    def write(self, text: str) -> int:
        """Keep some text, joined to what came just before."""
        last = self.kept[-1] if self.kept else {}
        if last.get("name") == self.stream:
            last["text"] += text
        elif text:
            self.kept.append({"output_type": "stream", "name": self.stream, "text": text})
        return len(text)


class _Displayed(DisplayPublisher):
    """Keeps what a cell displays."""

    shell: Any

    def publish(self, data: Any, metadata: Any = None, **_: Any) -> None:
        self.shell.keep("display_data", data, metadata)


class _Returned(DisplayHook):
    """Keeps the value of the last expression of a cell."""

    shell: Any

    def write_output_prompt(self) -> None:
        """Nothing: pages have no prompts."""

    def write_format_data(self, format_dict: Any, md_dict: Any = None) -> None:
        count = self.prompt_count
        self.shell.keep("execute_result", format_dict, md_dict, execution_count=count)


class Shell(InteractiveShell):
    """IPython without a terminal, whose outputs are kept.

    Attributes:
        kept: The outputs of the present cell.
        failures: What went wrong in it, as text.
        command: Runs a shell command: what it writes, or an error.
    """

    display_pub_class = Type(_Displayed)
    displayhook_class = Type(_Returned)
    kept: list[Output]
    failures: list[str]
    command: Callable[[str], str]

    def keep(self, kind: str, data: Any, metadata: Any, **more: Any) -> None:
        """Keep an output; bytes, as of images, as text."""
        coded = {
            name: base64.b64encode(value).decode() if isinstance(value, bytes) else value
            for name, value in data.items()
        }
        self.kept.append({"output_type": kind, "data": coded, "metadata": dict(metadata or {}), **more})

    def _showtraceback(self, etype: Any, evalue: Any, stb: Any) -> None:
        self.failures.append(_COLOUR.sub("", "\n".join(stb)))

    def enable_gui(self, gui: Any = None) -> None:
        """Nothing: figures have no windows."""

    def system(self, cmd: str) -> None:
        """Run a line `!…` and print what it writes; one that fails fails the cell."""
        print(self.command(cmd).rstrip())

    def run(self, source: str) -> tuple[list[Output], str]:
        """The outputs of a cell, and what went wrong in it (empty if nothing did)."""
        kept = self.kept = []
        self.failures = []
        with redirect_stdout(Stream("stdout", kept)), redirect_stderr(Stream("stderr", kept)):
            done = self.run_cell(source, store_history=True)
        if not done.success and not self.failures:
            self.failures.append(repr(done.error_before_exec or done.error_in_exec))
        return kept, "\n".join(self.failures)


def shell_for(command: Callable[[str], str]) -> Shell:
    """The shell of this process, which runs commands in the given way."""
    shell: Any = Shell.instance(colors="nocolor")  # type: ignore[no-untyped-call]
    shell.history_manager.enabled = False
    shell.command = command
    return shell


def ordinary(command: str) -> str:
    """What a shell command writes.

    Raises:
        RuntimeError: It fails.
    """
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{command} exited with {done.returncode}: {done.stderr}")
    return done.stdout


def without_colours() -> None:
    """No command that runs from here writes colours: its output is as in a file."""
    for name in ("FORCE_COLOR", "CLICOLOR_FORCE", "CLICOLOR"):
        os.environ.pop(name, None)
