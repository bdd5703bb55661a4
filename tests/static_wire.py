"""A page of files with the default wire, for tests: the module of the package, and a map of a few controls.

`TABLE` and `PULSE` are the same wire with other drives, a table and one short pulse in a long run, for which the
module holds as well.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from martensite.app.documents import list_standalone
from martensite.app.messages import write_message
from martensite.app.static_site.control_map import InputMap
from martensite.app.static_site.flat_inputs import list_waveforms
from martensite.app.static_site.input_map import measure_map
from martensite.app.static_site.packaged_modules import provide_module
from martensite.app.static_site.run_module import RunSource, write_source
from martensite.app.static_site.scenario_table import describe_static
from martensite.app.static_site.site_writer import RUNS, copy_page, name_module, write_manifest
from martensite.app.static_site.study_pages import write_studies

CONTROLS = (
    "element.diameter",
    "element.law.A_s",
    "element.law.A_f",
    "drive.waveform.high",
    "mechanism.preload",
    "run.duration",
)
WIRE = "constant_power"
TEXT = list_standalone()[WIRE]
ROW = "drive.waveform.values"
_ROWS = 'kind = "table", times = ["0 s", "1 s", "2 s", "5 s"], values = ["0 W", "0.5 W", "0.5 W", "0 W"]'
TABLE = re.sub("title = .*", 'title = "Power of a table"', re.sub("waveform = .*", f"waveform = {{ {_ROWS} }}", TEXT))

_PULSE = 'kind = "step", high = "9 W", at = "30.1 s", until = "30.2 s"'
PULSE = re.sub("waveform = .*", f"waveform = {{ {_PULSE} }}", TEXT).replace('"10 s"', '"3600 s"')


def measure_wire(text: str = TEXT, controls: Sequence[str] = CONTROLS) -> tuple[InputMap, RunSource]:
    """The map of the default wire, and the C of its runs."""
    made = measure_map(text, controls)
    return made, write_source(made.scenario, list_waveforms(made.scenario))


def write_wire(folder: Path, page: bool = False, table: bool = False) -> None:
    """Write what the page reads of the wire, with the other drives as well, and the page if it is asked for."""
    (folder / RUNS).mkdir(parents=True)
    entries = [_write_runs(folder / RUNS, WIRE, TEXT, CONTROLS)]
    if table:
        entries.append(_write_runs(folder / RUNS, "table", TABLE, (ROW, "drive.waveform.times")))
        entries.append(_write_runs(folder / RUNS, "pulse", PULSE, ("mechanism.preload",)))
    write_manifest(folder, entries)
    if page:
        copy_page(folder)
        write_studies(folder, folder / RUNS)


def _write_runs(runs: Path, name: str, text: str, controls: Sequence[str]) -> dict[str, Any]:
    made, source = measure_wire(text, controls)
    module = name_module(source)
    told = describe_static(name, text, made, source, module)
    (runs / f"{name}.json").write_bytes(write_message(told))
    (runs / module).write_bytes(provide_module(source))
    return {"name": name, "title": made.scenario.title, "text": text, "file": f"{name}.json", "module": module}
