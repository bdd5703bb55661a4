"""C compilation of kernels, with a cache of libraries.

All compiled programs use one folder of libraries, one message for a missing compiler, and one calling convention.
"""

from __future__ import annotations

import atexit
import ctypes
import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from martensite.base.caches import is_private_file, keep_private, make_cache
from martensite.base.child_python import python_command
from martensite.base.errors import CompileError
from martensite.base.files import tell_once
from martensite.base.lazy import write_install_line
from martensite.kernels.quick_compiler import find_tcc, is_within_reach, read_mode

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
GCC_ONLY = ("-fno-tree-pre", "-fno-if-conversion")
"""Flags that clang refuses; compilation is repeated without them."""
WIDE = ("-mprefer-vector-width=512",)
"""Flag for processors with AVX-512: by default compilers use half the width, which costs a batch a third."""


def find_compiler() -> str | None:
    """Return the C compiler, or None.

    It is the compiler named by `CC`, `cc` or `gcc`, or otherwise the compiler of the package `ziglang` (extra `cc`).
    """
    try:
        return _find_on_path(os.environ.get("CC", "cc"), os.environ.get("PATH"))
    except LookupError:
        return _find_zig()


@cache
def _find_on_path(name: str, folders: str | None) -> str:
    """Return the compiler of a name, or gcc, in the folders of the environment variable `PATH`.

    Raises:
        LookupError: there is none. Exceptions are not cached: a compiler may be installed while this process runs.
    """
    if command := shutil.which(name, path=folders) or shutil.which("gcc", path=folders):
        return command
    raise LookupError(name)


_ZIG = """#!/bin/sh
for word; do shift; case $word in {flags}) ;; *) set -- "$@" "$word" ;; esac; done
exec {python} cc "$@"
"""


@cache
def _find_zig() -> str | None:
    """Return a program that calls the C compiler of the package `ziglang`; None without it, or Windows."""
    if find_spec("ziglang") is None or os.name != "posix":
        return None
    text = _ZIG.format(python=shlex.join(python_command("-m", "ziglang")), flags="|".join(GCC_ONLY))
    name = f"zig-cc-{hashlib.sha256(text.encode()).hexdigest()[:12]}"
    for find_folder in (_locate_folder, _make_own_folder):
        with suppress(OSError):
            path = find_folder() / name
            if not is_private_file(path):
                draft = path.with_suffix(f".{os.getpid()}")
                draft.write_text(text)
                keep_private(draft, path, 0o700)
            return str(path)
    return None


def read_source(room: str, name: str, constants: Mapping[str, Any]) -> str:
    """Return the C source of a package file, below definitions of its constants."""
    text = (Path(__file__).parents[1] / room / name).read_text(encoding="utf-8")
    return "".join([*(f"#define {key} {value}\n" for key, value in constants.items()), text])


def load_library(source: str, more: tuple[str, ...] = (), *, soon: bool = False, later: bool = True) -> Any:
    """Compile C source to a shared library in the cache (by hash) and load it.

    A complete library built on this machine is reused. If the cache is not writable, a folder of this process is used.
    The environment variable `MARTENSITE_CFLAGS` is appended to the compiler flags.

    Args:
        source: C source.
        more: additional compiler flags.
        soon: True to accept a result of the quick compiler (`martensite.kernels.quick_compiler`) if the optimised
            library is missing.
        later: False to compile no optimised library in the background in this case.

    Raises:
        CompileError: no compiler was found, it failed, or no folder is writable for its output.
    """
    usual = _build_command(more)
    if command := _choose_quick(source, usual, soon):
        with suppress(CompileError, OSError):
            library = _load_quick(command, usual, source, more if later else None)
            if library is not None:
                return library
    name, reasons = _name_library(usual, source), list[str]()
    for find_folder in (_locate_folder, _make_own_folder):
        try:
            return _load_from(find_folder() / name, usual, source)
        except OSError as error:
            reasons.append(str(error.strerror or error))
            if find_folder is _locate_folder:
                tell_once(
                    f"Warning: what is compiled cannot be kept in the cache folder ({reasons[0]}); it is made anew in "
                    "every process. Name another folder in XDG_CACHE_HOME."
                )
    raise CompileError(
        f"The C runtime has no folder to compile in ({'; '.join(dict.fromkeys(reasons))}); name one in "
        "XDG_CACHE_HOME, or use the runtime `floats`."
    )


def is_compiled(source: str, more: tuple[str, ...] = (), *, soon: bool = False) -> bool:
    """Return whether `load_library` would find the library without compilation."""
    if find_compiler() is None:
        return False
    with suppress(OSError):
        folder, usual = _locate_folder(), _build_command(more)
        commands = (usual, _choose_quick(source, usual, soon))
        return any(_is_whole(folder / _name_library(command, source)) for command in commands if command)
    return False


def compile_library(path: Path, source: str, more: tuple[str, ...]) -> None:
    """Compile the optimised library of a source, unless it exists.

    Raises:
        CompileError: the compiler failed, or the library would not be accepted under this name.
    """
    command = _build_command(more)
    if path.name != _name_library(command, source):
        raise CompileError("The compiler or its flags have changed.")
    if not _is_whole(path):
        _compile_source(command, source, path)


def call_compiled(function: Any, *arguments: Any) -> None:
    """Call a function of a library, with whole numbers as `long` and others as C-contiguous arrays."""
    function(*(ctypes.c_long(one) if isinstance(one, int) else ctypes.c_void_p(one.ctypes.data) for one in arguments))


def _choose_quick(source: str, usual: tuple[str, ...], soon: bool) -> tuple[str, ...]:
    """Return the command of the quick compiler for a source; empty if it is not to be used."""
    mode = read_mode()
    if not is_within_reach(source) or not (mode == "only" or (soon and mode == "first")):
        return ()
    return find_tcc() or (() if mode == "only" else (*usual, "-O0"))


def _load_quick(command: tuple[str, ...], usual: tuple[str, ...], source: str, more: tuple[str, ...] | None) -> Any:
    """Return a library of the quick compiler, and order the optimised one with `more` flags; None if that exists."""
    path, first = _locate_folder() / _name_library(usual, source), read_mode() == "first"
    if first and _is_whole(path):
        return None
    quick = path.with_name(_name_library(command, source))
    library = _load_from(quick, command, source)
    if first and more is not None:
        from martensite.kernels.compile_jobs import order_library

        order_library(path, source, more, quick, __name__)
    return library


def _build_command(more: tuple[str, ...]) -> tuple[str, ...]:
    cc = find_compiler()
    if cc is None:
        raise CompileError(
            "The C runtime needs a C compiler and none was found; install gcc or clang, or "
            f"`{write_install_line('cc')}`, or use the runtime `floats`."
        )
    wide = WIDE if "avx512f" in _describe_machine() else ()
    return (cc, *FLAGS, *wide, *more, *os.environ.get("MARTENSITE_CFLAGS", "").split())


def _name_library(command: Sequence[str], source: str) -> str:
    text = " ".join((*command, _describe_machine(), source))
    return f"{hashlib.sha256(text.encode()).hexdigest()[:24]}.so"


def _locate_folder() -> Path:
    """Return the persistent folder for libraries; `OSError` if it is unusable or not trusted."""
    return make_cache("c")


@cache
def _make_own_folder() -> Path:
    """Return a folder of this process, removed at its end."""
    folder = tempfile.mkdtemp(prefix="martensite-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def _describe_machine() -> str:
    """Describe the features behind -march=native, so that several machines can use one cache folder."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        return platform.machine()
    flags = (line for line in text.splitlines() if line.startswith(("flags", "Features")))
    return f"{platform.machine()} {next(flags, '')}"


def _load_from(path: Path, command: Sequence[str], source: str) -> Any:
    """Return a library, compiled if it is missing, damaged, or of another machine."""
    if _is_whole(path):
        with suppress(OSError):
            return ctypes.CDLL(str(path))
    _compile_source(command, source, path)
    return ctypes.CDLL(str(path))


def _is_whole(path: Path) -> bool:
    """Return whether a library is complete and written by this user's compiler for this source.

    A truncated library would kill the process; a stranger's library would run the stranger's code.
    """
    if not (is_private_file(path) and is_private_file(_locate_digest(path))):
        return False
    try:
        raw = path.read_bytes()
        return _locate_digest(path).read_bytes() == _digest(raw) and _name_mark(path).encode() in raw
    except OSError:
        return False


def _locate_digest(path: Path) -> Path:
    return path.with_suffix(".sha256")


def _digest(raw: bytes) -> bytes:
    return hashlib.sha256(raw).hexdigest().encode()


def _name_mark(path: Path) -> str:
    """Return the symbol at the end of a library's source, which identifies the source."""
    return f"martensite_{path.stem}"


def _compile_source(command: Sequence[str], source: str, path: Path) -> None:
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        code, library = Path(folder) / "kernel.c", Path(folder) / "kernel.so"
        code.write_text(f'{source}\nconst char {_name_mark(path)}[] = "";\n')
        done = _call_compiler(command, code, library)
        if "unknown argument" in done.stderr:
            done = _call_compiler([word for word in command if word not in GCC_ONLY], code, library)
        if done.returncode != 0:
            raise CompileError(f"The C compiler `{command[0]}` failed: {done.stderr.strip()[:500]}")
        digest = _locate_digest(library)
        digest.write_bytes(_digest(library.read_bytes()))
        keep_private(digest, _locate_digest(path))  # before the library, which requires its digest
        keep_private(library, path)


def _call_compiler(command: Sequence[str], code: Path, library: Path) -> subprocess.CompletedProcess[str]:
    words = [*command, str(code), "-o", str(library), "-lm"]
    return subprocess.run(words, capture_output=True, text=True, check=False)


if __name__ == "__main__":
    from martensite.kernels.compile_jobs import do_jobs

    do_jobs(compile_library)
