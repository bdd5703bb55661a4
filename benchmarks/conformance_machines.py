"""Every machine that the kernels are printed for, playing the same random programs of whole steps.

What: a `Program` is a system and random signals of its drives, held for a few steps each. A machine answers with the
outputs at the start and after every step, (steps + 1, outputs), and with the CPU time of a step of another program.
Plain floats are the reference. CUDA C is made by the C compiler of this machine for its processor, one thread after
another (`tests/cuda_on_host.py`), so it says something of the program, and nothing of a GPU.
"""

from __future__ import annotations

import ctypes
import gzip
import tempfile
import time
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.wasm_runs import play_module, say_missing, write_module
from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import SolveError
from martensite.export.c_core import build_c_core
from martensite.export.c_kernels import precision_of
from martensite.export.fmu import to_fmu
from martensite.export.fmu.binaries import find_target
from martensite.export.wasm import build_wasm
from martensite.kernels.c99 import c_source
from martensite.kernels.c99_lanes import BLOCK, lanes_source
from martensite.kernels.compiler import load_library
from martensite.simulate.compiled import CompiledSystem, bind_system, compile_system
from martensite.simulate.lanes import Lanes

ROUNDS = 5


class Program(NamedTuple):
    """A system under signals that are held over steps."""

    name: str
    system: AbstractSystem
    signals: Any
    """At the start, and of every step, (steps + 1, drives)."""
    dt: float
    """Length of a step [s]."""

    @property
    def compiled(self) -> CompiledSystem:
        """Traced."""
        return compile_system(self.system)

    @property
    def values(self) -> list[float]:
        """Numbers of the system."""
        return self.compiled.values(self.system)


class Machine(NamedTuple):
    """What runs programs."""

    name: str
    what: str
    """What it is handed, whose size is told."""
    play: Callable[[Program], Any]
    """Outputs (steps + 1, outputs)."""
    size: Callable[[Program], int]
    """Bytes that it is handed, compressed."""
    step: Callable[[Program], float] | None = None
    """CPU time of a step [s]."""
    missing: Callable[[], str] = str
    """What is not there to run it."""
    precision: str = "float64"
    only: tuple[str, ...] | None = None
    """Programs that it plays; all if None."""


def pack_text(*texts: str) -> int:
    """Bytes of texts, compressed by gzip."""
    return len(gzip.compress("".join(texts).encode(), 9, mtime=0))


def time_steps(run: Callable[[], Any], steps: int) -> float:
    """CPU time of a step [s], the best of some rounds."""
    run()
    found: list[float] = []
    for _ in range(ROUNDS):
        begin = time.process_time()
        run()
        found.append((time.process_time() - begin) / steps)
    return min(found)


# ---------------------------------------------------------------- Python


def play_floats(program: Program) -> Any:
    """Init, step and observe on floats, one after the other: the reference."""
    functions, size = bind_system(program.system)
    (first, *rest), rows = program.signals.tolist(), []
    state = functions["init"](*first)
    rows.append(functions["observe"](*state, *first))
    for signals in rest:
        state = functions["step"](*state, *signals, program.dt)[:size]
        rows.append(functions["observe"](*state, *signals))
    return np.array(rows)


def step_floats(program: Program) -> float:
    """Nothing observed."""
    functions, size = bind_system(program.system)
    (first, *rest), step = program.signals.tolist(), functions["step"]

    def run() -> None:
        state = functions["init"](*first)
        for signals in rest:
            state = step(*state, *signals, program.dt)[:size]

    return time_steps(run, len(rest))


# ---------------------------------------------------------------- C


def play_lanes(program: Program, count: int) -> Any:
    """In C as runs are; of all lanes the one that is farthest from the first is not hidden."""
    lanes = Lanes(program.system, count, native=True)
    first, rest = program.signals[0][:, None], np.repeat(program.signals[1:, :, None], count, axis=2)
    lanes.reset(first)
    start = lanes.observe(first)
    rows = np.concatenate([start[None], lanes.advance(rest, program.dt)])
    worst = np.abs(rows - rows[..., :1]).max(axis=(0, 1)).argmax()
    return rows[..., worst]


def step_lanes(program: Program, count: int) -> float:
    """A step of one lane."""
    lanes = Lanes(program.system, count, native=True)
    rest = np.repeat(program.signals[1:, :, None], count, axis=2)

    def run() -> None:
        lanes.reset(program.signals[0][:, None])
        lanes.advance(rest, program.dt, shown=False)

    return time_steps(run, count * len(rest))


PLAY = """
int play(const {real} *u, long n, {real} dt, {real} *y) {{
    static {name}_model m;
    long k;
    int worst = 0, found;
    {name}_defaults(&m);
    worst = {name}_start(&m, u);
    if (y) {name}_observe(&m, u, y);
    for (k = 1; k <= n; k++) {{
        found = {name}_step(&m, u + k * {name}_INPUTS, dt);
        worst = found > worst ? found : worst;
        if (y) {name}_observe(&m, u + k * {name}_INPUTS, y + k * {name}_OUTPUTS);
    }}
    return worst;
}}
"""


def load_core(program: Program, precision: str) -> Callable[[bool], Any]:
    """The export in C, with a loop around it; a call plays it, and answers with the outputs if they are wanted."""
    core = build_c_core(program.system, name="core", precision=precision)
    real = precision_of(precision).number
    text = core.header + core.source.replace('#include "core.h"', "") + PLAY.format(real=real, name="core")
    library, kind = load_library(text), np.dtype(precision)
    signals = np.ascontiguousarray(program.signals, kind)
    rows = np.zeros((len(signals), len(core.outputs)), kind)
    number = ctypes.c_double if precision == "float64" else ctypes.c_float

    def call(shown: bool) -> Any:
        places = [ctypes.c_void_p(one.ctypes.data) for one in (signals, rows)]
        worst = library.play(
            places[0], ctypes.c_long(len(signals) - 1), number(program.dt), places[1] if shown else None
        )
        if worst > 1:
            raise SolveError(f"A step of `{program.name}` was not solved in {precision}.")
        return rows.astype(float)

    return call


def step_core(program: Program, precision: str) -> float:
    """Nothing observed."""
    call = load_core(program, precision)
    return time_steps(lambda: call(False), len(program.signals) - 1)


def size_core(program: Program, precision: str) -> int:
    """Header and source."""
    return pack_text(*build_c_core(program.system, name="core", precision=precision).files.values())


# ---------------------------------------------------------------- WebAssembly, FMU, CUDA


def play_wasm(program: Program, rounds: int = 0) -> tuple[Any, float]:
    """In Node.js, with the script of the export; outputs, and time of a step [s]."""
    first, *rest = program.signals.tolist()
    made = build_wasm(program.system, name="model", first=first)
    with tempfile.TemporaryDirectory() as folder:
        write_module(made, Path(folder))
        rows, said = play_module(made, Path(folder), [(program.dt, tuple(row)) for row in rest], rounds)
    return rows, (said["seconds"] or 0.0) / len(rest)


class PlayedFmu:
    """An FMU of FMI 2.0 through the calls of its interface, as a master makes them."""

    def __init__(self, program: Program) -> None:
        self.program, self.outputs = program, program.compiled.outputs

    @cached_property
    def archive(self) -> bytes:
        """What is written."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "model.fmu"
            to_fmu(self.program.system, path, step=self.program.dt, platforms=[find_target()])
            return path.read_bytes()

    def play(self) -> tuple[Any, float]:
        """Outputs, and CPU time of a step with its calls from Python [s]."""
        from fmu_instance import Instance

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "model.fmu"
            path.write_bytes(self.archive)
            one, names = Instance(path), [drive.name for drive in self.program.system.drives()]
            given: list[Any] = [dict(zip(names, row, strict=True)) for row in self.program.signals.tolist()]
            one.begin(given[0])
            dt = self.program.dt
            rows, begin = [one.get(*self.outputs)], time.process_time()
            for k, signals in enumerate(given[1:]):
                assert one.set(signals) == 0
                assert one.step(k * dt, dt) <= 1
                rows.append(one.get(*self.outputs))
            spent = (time.process_time() - begin) / (len(given) - 1)
            one.close()
        return np.array(rows), spent


def play_cuda(program: Program, precision: str = "float64") -> Any:
    """CUDA C on the processor: its march on given steps, which shows what depends on the state alone."""
    from cuda_on_host import HostMemory, HostProgram

    from martensite.signals.held import Held
    from martensite.simulate.cuda import device, march, to_ends
    from martensite.simulate.variants import VariantSetup

    kept = device.open_device, device.DeviceProgram, device.DeviceMemory
    replace: Any = device
    replace.open_device, replace.DeviceProgram, replace.DeviceMemory = (lambda: None), HostProgram, HostMemory
    try:
        steps, names = len(program.signals) - 1, list(program.system.convergence_scales())
        drives = [one.name for one in program.system.drives()]
        waves = {
            name: Held(values=tuple(column), frequency=1.0 / program.dt)
            for name, column in zip(drives, program.signals[1:].T.tolist(), strict=True)
        }
        setup = VariantSetup(
            program.system, waves, steps * program.dt, steps + 1, program.dt, tuple(names), "cuda", precision=precision
        )
        found = setup.run({program.compiled.paths[0]: np.array(program.values[:1])})
        rows = np.full((steps + 1, len(program.compiled.outputs)), np.nan)
        for name in names:
            rows[:, program.compiled.outputs.index(name)] = found.columns[name][0]
        return rows
    finally:
        replace.open_device, replace.DeviceProgram, replace.DeviceMemory = kept
        for one in (march.load_march, to_ends.load_program):
            one.cache_clear()


def size_cuda(program: Program, precision: str) -> int:
    """The text of its march."""
    from martensite.simulate.compiled import compile_march
    from martensite.simulate.cuda.source import MarchSource

    compiled = compile_march(program.system)
    wanted = tuple(range(len(compiled.convergence_scales)))
    return pack_text(MarchSource(compiled, wanted, (0,), precision).text)


def print_c(program: Program, write: Callable[..., str]) -> str:
    """What is compiled for runs."""
    traced = program.compiled.program
    return write(traced, [traced.functions[name] for name in ("init", "step", "observe")])


WIDE = 256
QUICK = ("wire of README.md", "pwm_bias_spring", "finger", "migaone")
"""What compiles in seconds everywhere."""
SINGLE = (*QUICK, "finger, mas", "platform_spring", "torsion_wire", "r_phase", "antagonistic_wires")
"""All but the long ones."""
MACHINES = [
    Machine(
        "Python floats", "Python", play_floats, lambda one: pack_text(one.compiled.program.float_source), step_floats
    ),
    Machine(
        "C",
        "C source",
        lambda one: play_lanes(one, 1),
        lambda one: pack_text(print_c(one, c_source)),
        lambda one: step_lanes(one, 1),
    ),
    Machine(
        "C lanes",
        "C source",
        lambda one: play_lanes(one, BLOCK),
        lambda one: pack_text(print_c(one, lanes_source)),
        lambda one: step_lanes(one, WIDE),
    ),
    Machine(
        "exported C core",
        "C source and header",
        lambda one: load_core(one, "float64")(True),
        lambda one: size_core(one, "float64"),
        lambda one: step_core(one, "float64"),
        only=SINGLE,
    ),
    Machine(
        "exported C core, float32",
        "C source and header",
        lambda one: load_core(one, "float32")(True),
        lambda one: size_core(one, "float32"),
        lambda one: step_core(one, "float32"),
        only=SINGLE,
        precision="float32",
    ),
    Machine(
        "WebAssembly",
        "module",
        lambda one: play_wasm(one)[0],
        lambda one: build_wasm(one.system, name="model").packed,
        lambda one: play_wasm(one, 20)[1],
        say_missing,
        only=QUICK,
    ),
    Machine(
        "FMU (FMI 2.0)",
        "archive with sources and the library for one platform",
        lambda one: PlayedFmu(one).play()[0],
        lambda one: len(PlayedFmu(one).archive),
        lambda one: PlayedFmu(one).play()[1],
        only=QUICK,
    ),
    Machine("CUDA C, on the processor", "CUDA source", play_cuda, lambda one: size_cuda(one, "float64"), only=SINGLE),
    Machine(
        "CUDA C, float32, on the processor",
        "CUDA source",
        lambda one: play_cuda(one, "float32"),
        lambda one: size_cuda(one, "float32"),
        precision="float32",
        only=SINGLE,
    ),
]
"""In the order of the page; the first is the reference."""
