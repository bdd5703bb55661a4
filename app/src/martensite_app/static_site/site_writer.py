"""Writes the bench as a folder that any file server hands out: `martensite app --static DIR`."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from importlib.metadata import version
from pathlib import Path

from martensite.base.errors import DataError
from martensite_app.documents import build_packaged, list_standalone
from martensite_app.messages import JsonTable, write_message
from martensite_app.site import STATIC
from martensite_app.static_site.flat_inputs import waveforms_of
from martensite_app.static_site.input_map import measure_map
from martensite_app.static_site.run_module import RunSource, write_source
from martensite_app.static_site.scenario_table import describe_static
from martensite_export.wasm.module import find_wasm_compiler

RUNS = "runs"
"""Folder of scenarios and modules in that of the page."""
MARK = '<meta name="martensite-runs" content="runs/manifest.json">'
"""Says to the page that there is no server."""
Tell = Callable[[str], None]


def write_site(folder: Path, names: list[str] | None = None, tell: Tell = lambda words: None) -> JsonTable:
    """Write the page with scenarios of the package, all that run without files of their own by default.

    Raises:
        DataError: the folder is there and holds something else.
        InputError: there is no compiler of WebAssembly.
        CompileError: the compiler failed.
    """
    find_wasm_compiler()
    _prepare_folder(folder)
    texts = list_standalone()
    chosen = {name: texts[name] for name in names or texts if can_offer(texts[name])}
    listed = list[JsonTable]()
    with ProcessPoolExecutor(max(1, min(len(chosen), os.cpu_count() or 1))) as pool:
        jobs = {name: pool.submit(describe_scenario_files, name, text) for name, text in chosen.items()}
        for name, job in jobs.items():
            files, entry = job.result()
            for file, content in files.items():
                (folder / RUNS / file).write_bytes(content)
            listed.append(entry)
            tell(f"{name}: {sum(map(len, files.values())) / 1e3:.0f} kB")
    manifest = {"version": version("martensite"), "scenarios": listed}
    (folder / RUNS / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    _write_page(folder)
    return manifest


def can_offer(text: str) -> bool:
    """Whether the page can run a scenario: it starts at home, and no controller runs outside of the C."""
    scenario = build_packaged(text)
    return not (scenario.outside or scenario.initial or scenario.restart_at)


def describe_scenario_files(name: str, text: str) -> tuple[Mapping[str, bytes], JsonTable]:
    """The files of a scenario, and its entry in the manifest."""
    made = measure_map(text)
    source = write_source(made.scenario, waveforms_of(made.scenario))
    module = name_module(source)
    table = describe_static(name, text, made, source, module)
    files = {f"{name}.json": write_message(table), module: source.compile()}
    entry = {"name": name, "title": made.scenario.title, "text": text, "file": f"{name}.json", "module": module}
    return files, entry


def name_module(source: RunSource) -> str:
    """The file of a module: by what is compiled, so that scenarios of one structure share it."""
    return f"{source.digest}.wasm"


def _prepare_folder(folder: Path) -> None:
    if folder.exists() and (not folder.is_dir() or (any(folder.iterdir()) and not (folder / RUNS).is_dir())):
        raise DataError(f"`{folder}` holds something else than a static bench; name a new or empty folder.")
    (folder / RUNS).mkdir(parents=True, exist_ok=True)


def _write_page(folder: Path) -> None:
    for path in STATIC.iterdir():
        shutil.copyfile(path, folder / path.name)
    index = (folder / "index.html").read_text("utf-8")
    (folder / "index.html").write_text(index.replace("<title>", f"{MARK}\n    <title>", 1), encoding="utf-8")
