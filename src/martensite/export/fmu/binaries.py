"""Shared libraries of an FMU: for this machine, and for others where a compiler for them is here.

For another machine that is mingw-w64 (`x86_64-w64-mingw32-gcc`), `aarch64-linux-gnu-gcc`, or for
any of them zig, on the path or as the package ziglang. Zig is used only for platforms that are
named: for some of them it takes minutes when it is used first.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from martensite.base.child_python import python_command
from martensite.base.errors import InputError, MartensiteError, suggest_name
from martensite.kernels.compiler import find_compiler

FLAGS = ("-std=c99", "-O2", "-shared", "-fvisibility=hidden", "-ffp-contract=off", "-fno-math-errno")


@dataclass(frozen=True)
class BinaryTarget:
    """A kind of machine for which a library can be made."""

    folder: str
    """Name of the folder in FMI 2.0; FMI 3.0 uses the name of the target."""
    ending: str
    zig: str
    """Name of the target in zig."""
    cross: str | None = None
    """A compiler for it on other machines."""
    flags: tuple[str, ...] = ("-fPIC",)


TARGETS = {
    "x86_64-linux": BinaryTarget("linux64", ".so", "x86_64-linux-gnu.2.17", "x86_64-linux-gnu-gcc"),
    "aarch64-linux": BinaryTarget("aarch64-linux", ".so", "aarch64-linux-gnu.2.17", "aarch64-linux-gnu-gcc"),
    "x86_64-windows": BinaryTarget(
        "win64", ".dll", "x86_64-windows-gnu", "x86_64-w64-mingw32-gcc", ("-static-libgcc",)
    ),
    "x86_64-darwin": BinaryTarget("darwin64", ".dylib", "x86_64-macos"),
    "aarch64-darwin": BinaryTarget("aarch64-darwin", ".dylib", "aarch64-macos"),
}
"""By the names of FMI 3.0."""


def find_target() -> str:
    """Return the target that this machine is."""
    machine = platform.machine().lower()
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    return f"{machine}-{platform.system().lower()}"


def find_command(target: str) -> list[str] | None:
    """Return the compiler that makes a library for a target, or None."""
    found = _find_gcc(target)
    if found is not None:
        return [found]
    zig = find_zig()
    return None if zig is None else [*zig, "cc", "-target", TARGETS[target].zig]


def find_zig() -> list[str] | None:
    """Return the command of zig: on the path, or of the package ziglang; None without zig."""
    if shutil.which("zig"):
        return ["zig"]
    return python_command("-m", "ziglang") if find_spec("ziglang") else None


def _find_gcc(target: str) -> str | None:
    if target == find_target():
        return find_compiler()
    cross = TARGETS[target].cross
    return shutil.which(cross) if cross else None


def checked_targets(names: Sequence[str] | None) -> list[str]:
    """Return targets by name; by default all targets with the compiler of this machine, or with gcc.

    Raises:
        InputError: the target is unknown, or a compiler for it is missing.
    """
    if names is None:
        return [name for name in TARGETS if _find_gcc(name)]
    found = [name for name in TARGETS if find_command(name)]
    for name in names:
        if name not in TARGETS:
            raise InputError(f"No platform named `{name}`. {suggest_name(name, TARGETS)}")
        if name not in found:
            raise InputError(f"There is no compiler for `{name}` on this machine. {suggest_name(name, found)}")
    return list(dict.fromkeys(names))


def build_library(sources: Mapping[str, str], target: str) -> bytes:
    """Return the library that a compiler makes of all.c, with the other sources beside it.

    The environment variable `MARTENSITE_CFLAGS` has the last word on the flags of the compiler.

    Raises:
        MartensiteError: the compiler failed.
    """
    known, cc = TARGETS[target], find_command(target)
    if cc is None:
        raise MartensiteError(f"There is no compiler for `{target}` on this machine.")
    more = os.environ.get("MARTENSITE_CFLAGS", "").split()
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="utf-8", newline="\n")
        made = f"model{known.ending}"
        done = subprocess.run(
            [*cc, *FLAGS, *known.flags, *more, "all.c", "-o", made, "-lm"],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            raise MartensiteError(f"The C compiler `{' '.join(cc)}` failed: {done.stderr.strip()[:500]}")
        return (Path(folder) / made).read_bytes()
