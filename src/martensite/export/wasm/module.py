"""A C core as WebAssembly, compiled by zig without an operating system, so that it imports nothing."""

from __future__ import annotations

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
from martensite.export.wasm.wrapper import guide_text, read_text, script_text, types_text
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
LINKED = ("-Wl,--no-entry", "-Wl,-z,stack-size=262144", "-Wl,--export=__heap_base", "-Wl,--strip-all")
"""The stack is below all data: an overflow ends the call and overwrites no number."""


@dataclass(frozen=True)
class WasmModule:
    """A model for the web, and its files."""

    core: CCore
    title: str
    first: tuple[float, ...]
    """Signals at the start."""
    binary: bytes

    @cached_property
    def packed(self) -> int:
        """Return the size of the module [bytes], compressed by gzip."""
        return len(compress(self.binary, 9, mtime=0))

    @property
    def files(self) -> dict[str, str | bytes]:
        """Return the contents by file name."""
        name = self.core.name
        return {
            f"{name}.wasm": self.binary,
            f"{name}.js": script_text(self.core, self.first),
            f"{name}.d.ts": types_text(self.core),
            "README.md": guide_text(self.core, self.title, self.first, len(self.binary), self.packed),
        }


def build_wasm(
    system: AbstractSystem, *, name: str | None = None, title: str = "", first: Sequence[float] = ()
) -> WasmModule:
    """Build a WebAssembly module of a system or a bench.

    Args:
        system: a `System`, a `Machine`, or a `Bench` with its loops.
        name: C identifier for the files; by default made of the kinds of its parts.
        title: title of its guide.
        first: signals at the start, in the order of its drives; by default 0.

    Raises:
        ParameterError: the name is not an identifier.
        InputError: the compiler is missing.
        CompileError: the compiler failed.
    """
    core = build_c_core(system, name=name)
    given = tuple(first) or (0.0,) * len(core.inputs)
    binary = compile_sources({**core.files, **list_sources(core)}, ["lanes.c"])
    return WasmModule(core, title or core.description, given, binary)


def find_wasm_compiler() -> list[str]:
    """Return the compiler command."""
    zig = find_zig()
    if zig is None:
        raise InputError(f"WebAssembly is compiled by zig, which is not installed; run `{write_install_line('cc')}`.")
    return [*zig, "cc"]


def compile_sources(sources: Mapping[str, str], compiled: Sequence[str], linked: Sequence[str] = ()) -> bytes:
    """Compile C sources, given by file name, to an optimised module; `linked` are further options of the linker."""
    command = [*find_wasm_compiler(), *FLAGS, "-I.", *compiled, "-o", "made.wasm", *LINKED, *linked]
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
    return series + read_text("math.h")


def list_sources(core: CCore) -> dict[str, str]:
    """Return the sources on a core: its batch functions and the replacement of libm."""
    begin = f'#include "{core.name}.c"\n#define CORE(name) {core.name}_##name\n'
    return {"math.h": write_math(), "lanes.c": begin + read_text("lanes.c")}
