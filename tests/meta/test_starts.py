"""Modules that a command may not import before its work needs them.

Source of truth: the modules of a process that ends where the work begins, at a missing input, or after a short work
that needs none of them. Each of the listed modules takes 0.1 to 1 s of CPU time.
"""

from __future__ import annotations

import json
import os
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


FORKED = """
import json, os, sys, martensite.cli.app, martensite.scenario.scenario, martensite.simulate.api
found, watched = {}, set(json.loads(sys.argv[1]))
for command in json.loads(sys.argv[2]):
    assert not watched & sys.modules.keys()
    near, far = os.pipe()
    if (child := os.fork()) == 0:
        from martensite.cli import main
        status, sys.argv[1:] = 0, command.split(" ")
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        try:
            main()
        except SystemExit as end:
            status = end.code or 0
        os.write(far, json.dumps([status, sorted(watched & sys.modules.keys())]).encode())
        os._exit(0)
    os.waitpid(child, 0)
    os.close(far)
    found[command] = json.loads(os.read(near, 1 << 16) or b"[1, []]")
print(json.dumps(found))
"""
"""Forks a process for each command: what all of them need is imported once."""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_commands_start_without_heavy_modules(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time [s],temperature [degC]\n" + "".join(f"{k},{20 + k}\n" for k in range(9)))
    every = json.dumps([*HEAVY, *LOGS, *OTHER])
    words = [sys.executable, "-c", FORKED, every, json.dumps([*COMMANDS, "fit dsc log.csv"])]
    done = subprocess.run(words, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert set(found.pop("fit dsc log.csv")[1]) & {*LOGS}  # an import is noticed
    for command, (status, imported) in found.items():
        assert set(imported) <= {*COMMANDS[command]}, command
        assert (status == 2) == ("missing" in command or command.startswith("size")), (command, done.stderr)
