"""Writer of the bench as a static folder: `martensite app --static DIR`."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from gzip import compress
from importlib.metadata import version
from pathlib import Path

from martensite.app.documents import build_packaged, list_standalone
from martensite.app.messages import JsonTable, write_message
from martensite.app.site import NOTEBOOK, STATIC, WIDGET
from martensite.app.static_site.flat_inputs import list_waveforms
from martensite.app.static_site.input_map import measure_map
from martensite.app.static_site.packaged_modules import provide_module, provide_rounding
from martensite.app.static_site.run_module import RunSource, can_step, write_source
from martensite.app.static_site.scenario_table import describe_static
from martensite.app.static_site.study_pages import write_studies
from martensite.base.child_python import safe_children
from martensite.base.errors import DataError, MartensiteError

RUNS = "runs"
"""Folder of scenarios and modules in that of the page."""
MARK = '<meta name="martensite-runs" content="runs/manifest.json">'
"""Mark of a page without a server."""
FIRST = "dead_weight"
"""First scenario of the bench."""


@dataclass(frozen=True)
class FolderSize:
    """Number and size of the files of a folder."""

    files: int
    size: int
    """Bytes."""
    compressed: int
    """Compressed bytes."""

    def words(self) -> str:
        """Return the sizes as text."""
        return f"{self.files} files, {self.size / 1e6:.1f} MB, {self.compressed / 1e6:.1f} MB compressed"


Tell = Callable[[str], None]


def write_site(folder: Path, texts: Mapping[str, str], tell: Tell = lambda words: None) -> JsonTable:
    """Write the page with scenarios, texts by name; the first is displayed first."""
    with make_site_folder(folder):
        return _fill_folder(folder, texts, tell)


def _fill_folder(folder: Path, texts: Mapping[str, str], tell: Tell) -> JsonTable:
    listed = list[JsonTable]()
    with safe_children(), ProcessPoolExecutor(max(1, min(len(texts), os.cpu_count() or 1))) as pool:
        jobs = {name: pool.submit(describe_scenario_files, name, text) for name, text in texts.items()}
        for name, job in jobs.items():
            try:
                files, entry = job.result()
            except MartensiteError:
                pool.shutdown(cancel_futures=True)
                raise
            for file, content in files.items():
                (folder / RUNS / file).write_bytes(content)
            listed.append(entry)
            tell(f"{name}: {sum(map(len, files.values())) / 1e3:.0f} kB")
    copy_page(folder)
    write_studies(folder, folder / RUNS)
    return write_manifest(folder, listed)


def list_offered() -> dict[str, str]:
    """Return name and text of the packaged scenarios that the page can run, the default wire first."""
    offered = {name: text for name, text in list_standalone().items() if can_offer(text)}
    return {FIRST: offered[FIRST], **offered}


def can_offer(text: str) -> bool:
    """Return whether the page can run a scenario."""
    return can_step(build_packaged(text))


def describe_scenario_files(name: str, text: str) -> tuple[Mapping[str, bytes], JsonTable]:
    """Return the files of a scenario, and its entry in the manifest."""
    scenario = build_packaged(text)
    source = write_source(scenario, list_waveforms(scenario))
    module, binary = name_module(source), provide_module(source)  # the first, since it needs a compiler
    input_map = measure_map(text)
    magnified = provide_rounding(text, input_map.scenario, source)
    table = describe_static(name, text, input_map, source, module, magnified=magnified)
    files = {f"{name}.json": write_message(table), module: binary}
    entry = {"name": name, "title": input_map.scenario.title, "text": text, "file": f"{name}.json", "module": module}
    return files, entry


def name_module(source: RunSource) -> str:
    """Return the file name of a module, a digest, so that scenarios of one structure share it."""
    return f"{source.digest}.wasm"


def check_folder(folder: Path) -> None:
    """Raise `DataError` if a folder has other content, or cannot be read."""
    try:
        other = folder.exists() and (not folder.is_dir() or (any(folder.iterdir()) and not (folder / RUNS).is_dir()))
    except OSError as error:
        raise _describe_failure(folder, error) from None
    if other:
        raise DataError(f"`{folder}` holds something else than a static bench; name a new or empty folder.")


@contextmanager
def make_site_folder(folder: Path) -> Generator[None]:
    """Make the folder of a page; new folders are removed after an error."""
    check_folder(folder)
    runs = folder / RUNS
    new_folders = [one for one in (runs, *runs.parents) if not one.exists()]
    try:
        runs.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException as error:
        for one in new_folders[-1:]:
            shutil.rmtree(one, ignore_errors=True)
        if isinstance(error, OSError):
            raise _describe_failure(folder, error) from None
        raise


def _describe_failure(folder: Path, error: OSError) -> DataError:
    return DataError(f"The folder `{folder}` cannot be written: {error.strerror}; name another one.")


def write_manifest(folder: Path, scenarios: Sequence[JsonTable]) -> JsonTable:
    """Write the list of scenarios of the page."""
    manifest: JsonTable = {"version": version("martensite"), "scenarios": list(scenarios)}
    (folder / RUNS / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    return manifest


def copy_page(folder: Path) -> None:
    """Copy the page, marked as a page without a server."""
    for path in STATIC.iterdir():
        if path.name not in (WIDGET, NOTEBOOK):
            shutil.copyfile(path, folder / path.name)
    index = (folder / "index.html").read_text("utf-8")
    (folder / "index.html").write_text(index.replace("<title>", f"{MARK}\n    <title>", 1), encoding="utf-8")


def measure_folder(folder: Path) -> FolderSize:
    """Return the sizes of all files in a folder."""
    files = [path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()]
    return FolderSize(len(files), sum(map(len, files)), sum(len(compress(one, 9)) for one in files))
