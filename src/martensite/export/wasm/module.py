"""A C core as WebAssembly: compiled by zig for no operating system, so that it imports nothing."""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from gzip import compress
from pathlib import Path

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import CompileError, InputError
from martensite.base.lazy import write_install_line
from martensite.export.c_core import CCore, build_c_core
from martensite.export.fmu.binaries import find_zig
from martensite.export.wasm.slopes import CoreSlopes, choose_slopes
from martensite.export.wasm.wrapper import guide_text, script_text, types_text
from martensite.kernels.polynomials import ERFCX, ERFCX_CENTRE

FLAGS = (
    "-target",
    "wasm32-freestanding",
    "-std=c99",
    "-O2",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-sanitize=undefined",
)
VECTORS = ("-msimd128",)
"""With slopes: instructions on two numbers, which browsers have since 2023."""
LINKED = ("-Wl,--no-entry", "-Wl,-z,stack-size=262144", "-Wl,--export=__heap_base", "-Wl,--strip-all")
"""The stack lies below all data: one that overflows ends the call, and spoils no number."""
FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class WasmModule:
    """A model for the web: what is in it, and the files that bring it there."""

    core: CCore
    title: str
    first: tuple[float, ...]
    """Signals at the start."""
    binary: bytes
    slopes: CoreSlopes | None = None
    """Derivatives of the module; None without."""

    @cached_property
    def packed(self) -> int:
        """Size of the module [bytes] as a server sends it, compressed by gzip."""
        return len(compress(self.binary, 9, mtime=0))

    @property
    def files(self) -> dict[str, str | bytes]:
        """Contents by the name of their file."""
        name = self.core.name
        return {
            f"{name}.wasm": self.binary,
            f"{name}.js": script_text(self.core, self.first, self.slopes),
            f"{name}.d.ts": types_text(self.core, self.slopes),
            "README.md": guide_text(self.core, self.title, self.first, len(self.binary), self.packed, self.slopes),
        }


def build_wasm(
    system: AbstractSystem,
    *,
    name: str | None = None,
    title: str = "",
    first: Sequence[float] = (),
    slopes: Sequence[str] = (),
) -> WasmModule:
    """Build a WebAssembly module of a system or a bench.

    Args:
        system: a `System`, a `Machine`, or a `Bench` with its loops.
        name: of the files, an identifier of C; by default made of the kinds of its parts.
        title: what its guide is called.
        first: signals at the start, in the order of its drives; by default 0.
        slopes: parameters (paths or unique endings) and signals by which outputs have derivatives.

    Raises:
        ParameterError: the name is not an identifier; or a derivative of `slopes` is missing.
        InputError: a compiler for it is missing.
        CompileError: the compiler failed.
    """
    core = build_c_core(system, name=name)
    given = tuple(first) or (0.0,) * len(core.inputs)
    chosen = choose_slopes(system, core, slopes) if slopes else None
    return WasmModule(core, title or core.description, given, _compile_core(core, chosen), chosen)


def find_wasm_compiler() -> list[str]:
    """Return the compiler; `InputError` if there is none."""
    zig = find_zig()
    if zig is None:
        raise InputError(f"WebAssembly is compiled by zig, which is not installed; run `{write_install_line('cc')}`.")
    return [*zig, "cc"]


def _compile_core(core: CCore, slopes: CoreSlopes | None) -> bytes:
    vectors = VECTORS if slopes and slopes.width > 1 else ()
    return compile_sources({**core.files, **list_sources(core, slopes)}, ["lanes.c"], vectors)


def compile_sources(sources: Mapping[str, str], compiled: Sequence[str], more: Sequence[str] = ()) -> bytes:
    """Compile a module of C sources, by the names of their files; some get more flags.

    The environment variable `MARTENSITE_CFLAGS` has the last word on the flags.

    Raises:
        InputError: a compiler for it is missing.
        CompileError: the compiler failed.
    """
    last = os.environ.get("MARTENSITE_CFLAGS", "").split()
    command = [*find_wasm_compiler(), *FLAGS, *more, *last, "-I.", *compiled, "-o", "made.wasm", *LINKED]
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="utf-8", newline="\n")
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            raise CompileError(f"The compiler of WebAssembly failed: {done.stderr.strip()[:500]}")
        return (Path(folder) / "made.wasm").read_bytes()


def write_math() -> str:
    """Return the replacement of math.h for targets without libm."""
    series = f"#define ERFCX_CENTRE {ERFCX_CENTRE}\n#define ERFCX_SERIES {', '.join(map(repr, ERFCX))}\n"
    return series + _read_text("math.h")


def list_sources(core: CCore, slopes: CoreSlopes | None = None) -> dict[str, str]:
    """Return the sources for a core: its lanes, with derivatives if it has any, and the replacement of libm."""
    begin = f'#include "{core.name}.c"\n#define CORE(name) {core.name}_##name\n'
    lanes = begin + _read_text("lanes.c")
    if slopes:
        lanes += f"\n{slopes.source}\n{_read_text('slopes.c')}{slopes.step_source}"
    return {"math.h": write_math(), "lanes.c": lanes}


def _read_text(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")
