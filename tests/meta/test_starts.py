"""Modules that a command may not import before its work needs them.

Source of truth: the modules of a process that ends where the work begins, at a missing input, or after a short work
that needs none of them. Each of the listed modules takes 0.1 to 1 s of CPU time.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
WIRE = str(EXAMPLES / "pwm_bias_spring.toml")
HEAVY = ("scipy", "matplotlib", "h5netcdf", "xarray", "pandas", "pint", "pydantic", "rich.console")
LOGS = ("martensite.logs.reader", "martensite.logs.container_files")
OTHER = ("martensite.fit", "martensite.identify", "martensite.export", "martensite.boards", "martensite.app")
COMMANDS: dict[str, tuple[str, ...]] = {
    f"check {WIRE}": (),
    f"run {WIRE} --set run.duration=1s --no-figure --runtime floats": ("h5netcdf",),
    "wire --diameter 0.25mm --length 200mm --supply 5V": (),
    "law brinson": LOGS,
    "data show log.csv": (*LOGS, "martensite.fit"),  # names the kind of experiment
    "fit missing.csv": (*LOGS, "martensite.fit", "martensite.boards"),
    f"fit missing.csv --scenario {WIRE} --free h=1..2": (*LOGS, "martensite.fit", "martensite.boards"),
    "identify missing.csv": (*LOGS, "martensite.fit", "martensite.identify"),
    "tune missing.toml": (),
    "sweep missing.toml": (),
    "design missing.toml": (),
    "size --pull 8N": (),
    "app --help": (),
}
"""Command -> modules among the listed ones that it may import."""


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_starts_without_heavy_modules(tmp_path: Path, command: str) -> None:
    (tmp_path / "log.csv").write_text("time [s],temperature [degC]\n" + "".join(f"{k},{20 + k}\n" for k in range(9)))
    watched = {*HEAVY, *LOGS, *OTHER} - {*COMMANDS[command]}
    code = (
        "import sys; from martensite.cli import main\n"
        f"sys.argv[1:] = {command.split(' ')!r}\n"
        "try: main()\n"
        f"finally: print('imported', sorted({watched!r} & sys.modules.keys()))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.stdout.endswith("imported []\n"), done.stdout[-300:] + done.stderr[-300:]
    assert (done.returncode == 2) == ("missing" in command or "size" in command), done.stderr


def test_an_import_is_noticed() -> None:
    """The test above would find a module that is imported by a command."""
    code = "import sys, martensite.fit.fit_task; print('martensite.fit' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"
