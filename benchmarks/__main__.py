"""`python -m benchmarks [SECTION ...]`: martensite beside other solvers, all in one run.

`python -m benchmarks peers` runs every section with the peers alone; `python -m benchmarks page`
writes the page of the documentation, and `python -m benchmarks conformance` that of all machines. Compare
ratios within one run, not times between runs: the machine's load is in all of them.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any

from rich.console import Console

from benchmarks import (  # noqa: F401  (enter theirs)
    app,
    conformance,
    page,
    sections_calls,
    sections_chains,
    sections_cuda,
    sections_elements,
    sections_fit,
    sections_laws,
    sections_machines,
    sections_mas,
    sections_process,
    sections_realtime,
    sections_records,
    sections_sweep,
    sections_throughput,
    sections_wasm,
)
from benchmarks.engines import PEERS, WHERE, available
from benchmarks.inputs import DRIVES
from benchmarks.report import machine, show
from benchmarks.sections import SECTIONS, Options


def parser() -> argparse.ArgumentParser:
    """The command line."""
    main = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    add = main.add_argument
    add("what", nargs="*", metavar="SECTION", help=f"{', '.join(SECTIONS)}; or peers; default all")
    add("--engines", help=f"comma-separated, of {', '.join(WHERE)}")
    add("--drive", default="sine", choices=[*DRIVES, "pulses"])
    add("--repeats", type=int, default=5, help="interleaved rounds")
    add("--base", help="engine that the ratios refer to (default: the first)")
    add("--sizes", default="1,256,4096", help="batch sizes")
    add("--most", type=int, default=10_000, help="runs of the largest sweep")
    add("--budget", type=float, default=60.0, help="time for the section `sweep` [s]")
    add("--json", type=Path, help="also write everything to this file")
    return main


def main() -> None:
    """Run the chosen sections and print their tables, or write the page."""
    if sys.argv[1:2] == ["page"]:
        page.main(sys.argv[2:])
        return
    if sys.argv[1:2] == ["conformance"]:
        conformance.main(sys.argv[2:])
        return
    chosen = parser().parse_args()
    names = [name for name in chosen.what if name != "peers"] or list(SECTIONS)
    unknown = [name for name in names if name not in SECTIONS]
    if unknown:
        parser().error(f"no section {unknown[0]!r}; there are {', '.join(SECTIONS)} and peers")
    everyone = list(PEERS if "peers" in chosen.what else WHERE)
    engines = available(chosen.engines.split(",") if chosen.engines else everyone)
    sizes = tuple(int(size) for size in chosen.sizes.split(","))
    options = Options(engines, chosen.drive, chosen.repeats, chosen.base, sizes, most=chosen.most, budget=chosen.budget)
    console, found = Console(), machine()
    console = console if console.is_terminal else Console(width=110)
    console.print(", ".join(f"{key} {value}" for key, value in found.items()))
    record: dict[str, Any] = {"machine": found, "tables": []}
    for name in names:
        for table in SECTIONS[name](options):
            show(console, table)
            rows = [{k: None if v != v else v for k, v in row.items()} for row in table.rows]
            record["tables"].append({"section": name, **table._asdict(), "rows": rows})
    if chosen.json:
        chosen.json.write_text(json.dumps(record, indent=1))


if __name__ == "__main__":
    os.environ.setdefault("MARTENSITE_QUICK_C", "off")  # what is timed is optimised
    main()
