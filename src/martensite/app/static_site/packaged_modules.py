"""WebAssembly modules that are part of the package, by the digest of their C.

They are the modules of the packaged and documented scenarios. `make modules` compiles missing modules, deletes modules
without a scenario, and measures the effect of rounding on each scenario. Other modules are compiled on this machine and
kept in the cache folder.
"""

from __future__ import annotations

import gzip
import hashlib
import json
import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from martensite.app.documents import build_packaged
from martensite.app.static_site.flat_inputs import list_waveforms
from martensite.app.static_site.rounding import measure_rounding
from martensite.app.static_site.run_module import RunSource, can_step, write_source
from martensite.base.caches import cache_folder, make_cache
from martensite.scenario.scenario import Scenario

MODULES = Path(__file__).parent / "modules"
SUFFIX = ".wasm.gz"
ROUNDING = "rounding.json"
"""File of the effect of rounding on each scenario."""
MOST_COMPILERS = 4
"""Largest number of compilers at a time."""


@dataclass(frozen=True)
class PackagedRun:
    """A scenario and the C of its runs."""

    text: str
    scenario: Scenario
    source: RunSource

    @property
    def file(self) -> str:
        """Return the file name of the module."""
        return self.source.digest + SUFFIX

    @property
    def key(self) -> str:
        """Return the digest of text and C."""
        return _digest_run(self.text, self.source)


def provide_module(source: RunSource) -> bytes:
    """Return the module of a source: packaged, cached, or compiled.

    Raises:
        InputError: the module is neither packaged nor cached, and the compiler is missing.
        CompileError: the compiler failed.
    """
    for path in _list_places(source):
        with suppress(FileNotFoundError):
            return gzip.decompress(path.read_bytes())
    module = source.compile()
    with suppress(OSError):
        (make_cache("wasm") / (source.digest + SUFFIX)).write_bytes(_compress(module))
    return module


def has_module(source: RunSource) -> bool:
    """Return whether a module needs no compilation."""
    return any(path.exists() for path in _list_places(source))


def _list_places(source: RunSource) -> list[Path]:
    return [folder / (source.digest + SUFFIX) for folder in (MODULES, cache_folder() / "wasm")]


def provide_rounding(text: str, scenario: Scenario, source: RunSource) -> float:
    """Return the effect of rounding on a run: of the package, or measured; see `measure_rounding`."""
    share = _read_rounding().get(_digest_run(text, source))
    return measure_rounding(scenario) if share is None else share


def list_runs(texts: Iterable[str]) -> list[PackagedRun]:
    """Return the scenarios that the page can run."""
    scenarios = {text: build_packaged(text) for text in texts}
    return [
        PackagedRun(text, one, write_source(one, list_waveforms(one)))
        for text, one in scenarios.items()
        if can_step(one)
    ]


def write_modules(texts: Iterable[str], folder: Path = MODULES) -> tuple[list[str], list[str]]:
    """Compile missing modules of scenarios and delete all others; return the names of both."""
    runs, old_shares = list_runs(texts), _read_rounding(folder)
    wanted, present = {one.file: one.source for one in runs}, {path.name for path in folder.glob("*" + SUFFIX)}
    missing, old = sorted(wanted.keys() - present), sorted(present - wanted.keys())
    with ThreadPoolExecutor(min(MOST_COMPILERS, os.cpu_count() or 1)) as pool:
        for name, module in zip(missing, pool.map(RunSource.compile, map(wanted.__getitem__, missing)), strict=True):
            (folder / name).write_bytes(_compress(module))
    for name in old:
        (folder / name).unlink()
    shares = {one.key: old_shares[one.key] if one.key in old_shares else measure_rounding(one.scenario) for one in runs}
    (folder / ROUNDING).write_text(json.dumps(shares, indent=0, sort_keys=True) + "\n", encoding="utf-8")
    _read_rounding.cache_clear()
    return missing, old


@lru_cache(1)
def _read_rounding(folder: Path = MODULES) -> dict[str, float]:
    try:
        return json.loads((folder / ROUNDING).read_text("utf-8"))
    except FileNotFoundError:
        return {}


def _digest_run(text: str, source: RunSource) -> str:
    return hashlib.sha256(f"{source.digest}\0{text}".encode()).hexdigest()[:16]


def _compress(module: bytes) -> bytes:
    return gzip.compress(module, 9, mtime=0)
