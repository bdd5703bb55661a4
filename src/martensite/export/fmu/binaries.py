"""Shared libraries of an FMU, for this machine and by cross compilers for others.

Cross compilers are mingw-w64 (`x86_64-w64-mingw32-gcc`), `aarch64-linux-gnu-gcc`, and zig, on the path or as the
package ziglang. Zig is used only for requested platforms, since its first use can take minutes.
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
from martensite.base.errors import MartensiteError, require_known
from martensite.kernels.compiler import find_compiler

FLAGS = ("-std=c99", "-O2", "-shared", "-fvisibility=hidden", "-ffp-contract=off", "-fno-math-errno")


@dataclass(frozen=True)
class BinaryTarget:
    """A platform with a library."""

    folder: str
    """Folder in FMI 2.0; FMI 3.0 uses the name of the target."""
    ending: str
    zig: str
    """Target name of zig."""
    cross: str | None = None
    """Cross compiler."""
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
"""Targets by the names of FMI 3.0."""


def find_target() -> str:
    """Return the target of this machine."""
    machine = platform.machine().lower()
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    return f"{machine}-{platform.system().lower()}"


def find_command(target: str) -> list[str] | None:
    """Return the compiler command for a target, or None."""
    gcc = _find_gcc(target)
    if gcc is not None:
        return [gcc]
    zig = find_zig()
    return None if zig is None else [*zig, "cc", "-target", TARGETS[target].zig]


def find_zig() -> list[str] | None:
    """Return the command of zig, on the path or of the package ziglang, or None."""
    if shutil.which("zig"):
        return ["zig"]
    return python_command("-m", "ziglang") if find_spec("ziglang") else None


def _find_gcc(target: str) -> str | None:
    if target == find_target():
        return find_compiler()
    cross = TARGETS[target].cross
    return shutil.which(cross) if cross else None


def checked_targets(names: Sequence[str] | None) -> list[str]:
    """Return the requested targets; by default all with this machine's compiler or gcc."""
    if names is None:
        return [name for name in TARGETS if _find_gcc(name)]
    compiled = [name for name in TARGETS if find_command(name)]
    for name in names:
        require_known("platform", name, TARGETS)
        require_known("platform with a compiler on this machine", name, compiled)
    return list(dict.fromkeys(names))


def build_library(sources: Mapping[str, str], target: str) -> bytes:
    """Compile all.c, with the other sources next to it, and return the library.

    The environment variable `MARTENSITE_CFLAGS` adds the last compiler flags.
    """
    properties, cc = TARGETS[target], find_command(target)
    if cc is None:
        raise MartensiteError(f"There is no compiler for `{target}` on this machine.")
    more = os.environ.get("MARTENSITE_CFLAGS", "").split()
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="utf-8", newline="\n")
        library = f"model{properties.ending}"
        run = subprocess.run(
            [*cc, *FLAGS, *properties.flags, *more, "all.c", "-o", library, "-lm"],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )
        if run.returncode != 0:
            raise MartensiteError(f"The C compiler `{' '.join(cc)}` failed: {run.stderr.strip()[:500]}")
        return (Path(folder) / library).read_bytes()
