"""A page of files with the default wire, for tests: a module that is committed, and a map of a few controls.

The module is named by what it is compiled of. Where that has changed, `python tests/static_wire.py` makes it anew; it
needs zig (`pip install 'martensite[cc]'`), which the tests do not.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from martensite_app.documents import list_standalone
from martensite_app.messages import write_message
from martensite_app.static_site.flat_inputs import list_waveforms
from martensite_app.static_site.input_map import InputMap, measure_map
from martensite_app.static_site.run_module import RunSource, write_source
from martensite_app.static_site.scenario_table import describe_static
from martensite_app.static_site.site_writer import FIRST, RUNS, copy_page, name_module, write_manifest

MODULES = Path(__file__).parent / "app" / "modules"
CONTROLS = (
    "element.diameter",
    "element.law.A_s",
    "element.law.A_f",
    "drive.waveform.high",
    "mechanism.preload",
    "run.duration",
)
TEXT = list_standalone()[FIRST]


def measure_wire() -> tuple[InputMap, RunSource]:
    """The map of the default wire, and the C of its runs."""
    made = measure_map(TEXT, CONTROLS)
    return made, write_source(made.scenario, list_waveforms(made.scenario))


def write_wire(folder: Path, page: bool = False) -> dict[str, Any]:
    """Write what the page reads of the wire, and the page if it is asked for; what it reads."""
    made, source = measure_wire()
    module = name_module(source)
    table = describe_static(FIRST, TEXT, made, source, module)
    runs = folder / RUNS
    runs.mkdir(parents=True)
    (runs / f"{FIRST}.json").write_bytes(write_message(table))
    (runs / module).write_bytes((MODULES / module).read_bytes())
    entry = {"name": FIRST, "title": made.scenario.title, "text": TEXT, "file": f"{FIRST}.json", "module": module}
    write_manifest(folder, [entry])
    if page:
        copy_page(folder)
    return json.loads((runs / f"{FIRST}.json").read_text("utf-8"))


if __name__ == "__main__":
    MODULES.mkdir(exist_ok=True)
    for old in MODULES.glob("*.wasm"):
        old.unlink()
    _, wire = measure_wire()
    (MODULES / name_module(wire)).write_bytes(wire.compile())
