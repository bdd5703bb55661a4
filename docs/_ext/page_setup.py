"""What the hidden first cell of an executed page imports: figures, and commands as in a pipe.

A command written as `!martensite …` runs without a terminal, so that its output is what it
would write to a file, and one that fails stops the build.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from IPython import get_ipython

from martensite.plot.style import STYLE

EXAMPLES = Path(__file__).parents[2] / "examples"
"""The example scenarios of the repository; a page runs in a folder of its own."""
_COLOURED = ("FORCE_COLOR", "CLICOLOR_FORCE", "CLICOLOR")


def system(command: str) -> None:
    """Run a shell command and print what it writes."""
    environment = {k: v for k, v in os.environ.items() if k not in _COLOURED}
    done = subprocess.run(
        command, shell=True, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise RuntimeError(f"{command} exited with {done.returncode}: {done.stderr}")
    print(done.stdout.rstrip())


shell: Any = get_ipython()  # type: ignore[no-untyped-call]
shell.run_line_magic("matplotlib", "inline")
shell.run_line_magic("config", 'InlineBackend.figure_formats = ["svg"]')
shell.system = system
plt.rcParams.update(STYLE)
