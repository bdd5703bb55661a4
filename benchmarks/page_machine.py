"""The machine of a benchmark page in words, and what could not take part; no names, no paths."""

from __future__ import annotations

import importlib.util
import os
import platform
import re
import subprocess
from importlib.metadata import version
from pathlib import Path
from typing import Any

from benchmarks.engines import available
from benchmarks.peers import simcoon_path, sma_react_path
from martensite.kernels.compiler import FLAGS, WIDE, find_compiler

PACKAGES = ("martensite", "numpy", "scipy", "diffrax", "scikit-sundae", "zarr")
VERSION = "from importlib.metadata import version; print(version('simcoon'))"


def processor() -> tuple[str, bool]:
    """Its name, and whether it has AVX-512."""
    file = Path("/proc/cpuinfo")
    told = file.read_text() if file.exists() else ""
    name = re.search(r"^model name\s*:\s*(.*)$", told, re.MULTILINE)
    return (name[1] if name else platform.machine()), "avx512f" in told


def compiled_by() -> str:
    """Name and version of the C compiler."""
    command = find_compiler()
    if command is None:
        return "none"
    told = subprocess.run([command, "--version"], capture_output=True, text=True, check=True)
    words = told.stdout.splitlines()[0]
    name = "clang" if "clang" in words else "gcc"
    found = re.search(r"\d+\.\d+(\.\d+)?", words)
    return f"{name} {found[0]}" if found else name


def packages() -> dict[str, str]:
    """Versions of what took part."""
    found = {"Python": platform.python_version()}
    for name in PACKAGES:
        if importlib.util.find_spec({"scikit-sundae": "sksundae"}.get(name, name)):
            found[name] = version(name)
    if simcoon_path.available():
        command = [simcoon_path.interpreter(), "-c", VERSION]
        told = subprocess.run(command, capture_output=True, text=True, check=True)
        found["simcoon"] = told.stdout.strip()
    if sma_react_path.checkout():
        found["SMA_REACT"] = str(sma_react_path.version())
    return found


def machine() -> dict[str, Any]:
    """What numbers depend on."""
    name, wide = processor()
    more = os.environ.get("MARTENSITE_CFLAGS", "").split()
    return {
        "processor": name,
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "compiler": compiled_by(),
        "flags": " ".join([*FLAGS, *(WIDE if wide else ()), *more]),
        "packages": packages(),
    }


def missing() -> list[str]:
    """Sentences on what could not take part."""
    found: list[str] = []
    if not available(["cvode"]):
        found.append("SUNDIALS: scikit-sundae was not installed.")
    if not available(["diffrax"]):
        found.append("diffrax: it was not installed.")
    if not simcoon_path.available():
        found.append("simcoon: no interpreter that has it was named.")
    if not sma_react_path.checkout():
        found.append("SMA_REACT: no checkout of it was named.")
    return found
