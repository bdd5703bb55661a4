"""What runs in the process of a page, and in that of a `martensite …` command of a page.

It imports little: a process imports this module before it begins.
"""

from __future__ import annotations

import os
import shlex
import sys
from multiprocessing.connection import Connection
from pathlib import Path

import cells

_OPERATORS = frozenset("();<>|&")
MAY_FAIL = " || true"
"""Behind a command that is shown as it fails, with exit code 1."""


def run_cells(ways: Connection, folder: str, sources: list[str]) -> None:
    """Run the cells of a page; send the outputs of each, and ask for commands."""
    os.chdir(folder)

    def command(line: str) -> str:
        line, may_fail = line.removesuffix(MAY_FAIL), line.endswith(MAY_FAIL)
        if not _plain(line):
            return cells.ordinary(line)
        ways.send(("command", (line, str(Path.cwd()), dict(os.environ))))
        code, out, err = ways.recv()
        if code != 0 and not (may_fail and code in (1, 2)):
            raise RuntimeError(f"{line} exited with {code}: {err}")
        return out

    cells.without_colours()
    shell = cells.shell_for(command)
    for source in sources:
        ways.send(("cell", shell.run(source)))


def run_command(line: str, folder: str, variables: dict[str, str], kept: str) -> None:
    """Run a `martensite …` command; what it writes goes to the files `1` and `2` of a folder."""
    for number in (1, 2):
        os.dup2(os.open(f"{kept}/{number}", os.O_WRONLY | os.O_CREAT, 0o600), number)
    os.chdir(folder)
    os.environ.update(variables)
    from martensite.cli import main

    sys.argv = shlex.split(line)
    main()


def _plain(line: str) -> bool:
    """Whether a shell would pass the line on, word by word, to `martensite`."""
    words = list(shlex.shlex(line, posix=True, punctuation_chars=True))
    return words[0] == "martensite" and not set("$`") & set(line) and not _OPERATORS & set(words)
