"""A C core as WebAssembly: compiled by zig for no operating system, so that it imports nothing."""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from gzip import compress
from pathlib import Path

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import CompileError, InputError
from martensite.kernels.polynomials import ERFCX, ERFCX_CENTRE
from martensite_export.c_core import CCore, build_c_core
from martensite_export.fmu.binaries import find_zig
from martensite_export.wasm.wrapper import guide_text, script_text, types_text

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
            f"{name}.js": script_text(self.core, self.first),
            f"{name}.d.ts": types_text(self.core),
            "README.md": guide_text(self.core, self.title, self.first, len(self.binary), self.packed),
        }


def build_wasm(
    system: AbstractSystem, *, name: str | None = None, title: str = "", first: Sequence[float] = ()
) -> WasmModule:
    """A system or a bench as a WebAssembly module.

    Args:
        system: a `System`, a `Machine`, or a `Bench` with its loops.
        name: of the files, an identifier of C; by default made of the kinds of its parts.
        title: what its guide is called.
        first: signals at the start, in the order of its drives; by default 0.

    Raises:
        ParameterError: the name is no identifier.
        InputError: there is no compiler for it.
        CompileError: the compiler failed.
    """
    core = build_c_core(system, name=name)
    given = tuple(first) or (0.0,) * len(core.inputs)
    return WasmModule(core, title or core.description, given, _compile_core(core))


def find_wasm_compiler() -> list[str]:
    """The compiler; `InputError` if there is none."""
    zig = find_zig()
    if zig is None:
        raise InputError("WebAssembly is compiled by zig, which is not installed; run `pip install 'martensite[cc]'`.")
    return [*zig, "cc"]


def _compile_core(core: CCore) -> bytes:
    """The module. The environment variable `MARTENSITE_CFLAGS` has the last word on the flags."""
    more = os.environ.get("MARTENSITE_CFLAGS", "").split()
    command = [*find_wasm_compiler(), *FLAGS, *more, "-I.", "lanes.c", "-o", "made.wasm", *LINKED]
    with tempfile.TemporaryDirectory() as folder:
        for name, text in {**core.files, **list_sources(core)}.items():
            (Path(folder) / name).write_text(text, encoding="utf-8", newline="\n")
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            raise CompileError(f"The compiler of WebAssembly failed: {done.stderr.strip()[:500]}")
        return (Path(folder) / "made.wasm").read_bytes()


def list_sources(core: CCore) -> dict[str, str]:
    """What is compiled with a core: its lanes, and what stands for libm."""
    series = f"#define ERFCX_CENTRE {ERFCX_CENTRE}\n#define ERFCX_SERIES {', '.join(map(repr, ERFCX))}\n"
    begin = f'#include "{core.name}.c"\n#define CORE(name) {core.name}_##name\n'
    texts = {one: (FOLDER / one).read_text(encoding="utf-8") for one in ("math.h", "lanes.c")}
    return {"math.h": series + texts["math.h"], "lanes.c": begin + texts["lanes.c"]}
