"""The C compiler of the machine: C in, functions out, kept in a cache.

Every compiled program of this package comes from here: one folder of libraries, one sentence where
there is no compiler, one way to hand over numbers and arrays.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from martensite.base.errors import MartensiteError
from martensite.base.files import cache_folder

FLAGS = (
    "-std=c99",
    "-O3",
    "-march=native",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-ffp-contract=off",
    "-fno-tree-pre",
    "-fopenmp-simd",
    "-fPIC",
    "-shared",
)
WIDE = ("-mprefer-vector-width=512",)
"""For processors with AVX-512: compilers prefer half the width, which costs a batch a third."""


def find_compiler() -> str | None:
    """The C compiler that would be used, or None.

    That of the machine: the one that `CC` names, `cc` or `gcc`; else the one of the package
    `ziglang`, which the extra `cc` installs.
    """
    return shutil.which(os.environ.get("CC", "cc")) or shutil.which("gcc") or _find_zig()


_ZIG = """#!/bin/sh
for word; do shift; [ "$word" = -fno-tree-pre ] || set -- "$@" "$word"; done
exec "{python}" -m ziglang cc "$@"
"""


@cache
def _find_zig() -> str | None:
    """A program that calls the C compiler of the package `ziglang`; None without it, or Windows."""
    if find_spec("ziglang") is None or os.name != "posix":
        return None
    text = _ZIG.format(python=sys.executable)
    path = cache_folder() / "c" / f"zig-cc-{hashlib.sha256(text.encode()).hexdigest()[:12]}"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)
    return str(path)


def load_library(source: str, more: tuple[str, ...] = ()) -> Any:
    """Compile C source to a shared library in the cache (by hash) and load it.

    The environment variable `MARTENSITE_CFLAGS` has the last word on the flags of the compiler.

    Args:
        source: the C.
        more: further flags of the compiler.

    Raises:
        MartensiteError: there is no compiler, or it failed.
    """
    command = _build_command(more)
    path = _kept_as(command, source)
    if not path.exists():
        _compile_source(command, source, path)
    return ctypes.CDLL(str(path))


def is_compiled(source: str, more: tuple[str, ...] = ()) -> bool:
    """Whether `load_library` would find what it needs, so that nothing is compiled."""
    return find_compiler() is not None and _kept_as(_build_command(more), source).exists()


def call_compiled(function: Any, *arguments: Any) -> None:
    """Call a function of a library: a whole number is a `long`, all else arrays of C's order."""
    function(*(ctypes.c_long(one) if isinstance(one, int) else ctypes.c_void_p(one.ctypes.data) for one in arguments))


def _build_command(more: tuple[str, ...]) -> tuple[str, ...]:
    cc = find_compiler()
    if cc is None:
        raise MartensiteError(
            "The C runtime needs a C compiler and none was found; install gcc or clang, or "
            "`pip install 'martensite[cc]'`, or use the runtime `floats`."
        )
    wide = WIDE if "avx512f" in _describe_machine() else ()
    return (cc, *FLAGS, *wide, *more, *os.environ.get("MARTENSITE_CFLAGS", "").split())


def _kept_as(command: Sequence[str], source: str) -> Path:
    text = " ".join((*command, _describe_machine(), source))
    return cache_folder() / "c" / f"{hashlib.sha256(text.encode()).hexdigest()[:24]}.so"


def _describe_machine() -> str:
    """What -march=native depends on, so that a shared cache folder never misleads."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        return ""
    return next((line for line in text.splitlines() if line.startswith("flags")), "")


def _compile_source(command: Sequence[str], source: str, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        code, library = Path(folder) / "kernel.c", Path(folder) / "kernel.so"
        code.write_text(source)
        done = subprocess.run(
            [*command, str(code), "-o", str(library), "-lm"], capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            raise MartensiteError(f"The C compiler `{command[0]}` failed: {done.stderr.strip()[:500]}")
        library.replace(path)
