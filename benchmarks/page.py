"""`python -m benchmarks page`: run the parts of the benchmark page and write it.

What: numbers go to `numbers.json` in a folder beside the page, and the page and its drawings are
written from that file alone (`page_text.render`); `--from` does only the second. `--only` runs some
parts and keeps the others that are there, if they come from the same machine and versions.
"""

from __future__ import annotations

import argparse
import datetime
import json
import math
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.page_text import FOLDER, FORMAT, render
from benchmarks.peers.simcoon_path import ONE_THREAD
from benchmarks.process import ROOT

PAGE = ROOT / "docs/reference" / f"{FOLDER}.md"
NUMBERS = "numbers.json"
SIZES, QUICK_SIZES = "1,64,1024,4096", "1,64"


def parser() -> argparse.ArgumentParser:
    """The command line."""
    main = argparse.ArgumentParser(prog="python -m benchmarks page", description=__doc__)
    add = main.add_argument
    add("--out", type=Path, default=PAGE, help="the page")
    add("--quick", action="store_true", help="fewer engines, smaller batches")
    add("--only", default="", help="comma-separated parts to run; others are kept")
    add("--repeats", type=int, default=5, help="interleaved rounds")
    add("--sizes", default="", help=f"batch sizes (default {SIZES}; quick {QUICK_SIZES})")
    add("--most", type=int, default=1_000_000, help="runs of the largest sweep")
    add("--budget", type=float, default=240.0, help="time for the sweeps [s]")
    add("--from", dest="source", type=Path, help="write the page from these numbers, run nothing")
    return main


def finite(value: Any) -> Any:
    """As JSON has it: no NaN, no NumPy."""
    if isinstance(value, str) or value is None:
        return value
    if isinstance(value, int):
        return int(value)
    number = float(value)
    return float(f"{number:.6g}") if math.isfinite(number) else None


def cleaned(table: Any) -> dict[str, Any]:
    """A table for JSON."""
    rows = [{name: finite(value) for name, value in row.items()} for row in table.rows]
    return {"title": table.title, "note": table.note, "rows": rows}


def ran(name: str, choice: Any) -> dict[str, Any]:
    """One part: its tables, the day, and how busy the machine was when it began."""
    from benchmarks.page_parts import PARTS

    busy = round(busy_cores(), 2)
    tables = [cleaned(table) for table in PARTS[name](choice)]
    made = datetime.datetime.now(datetime.UTC).date().isoformat()
    return {"made": made, "load": busy, "tables": tables}


def busy_cores(seconds: float = 1.0) -> float:
    """How many cores other processes keep busy just now."""
    import psutil

    return (os.cpu_count() or 1) * psutil.cpu_percent(seconds) / 100.0


def settings(chosen: argparse.Namespace) -> dict[str, Any]:
    """What was asked for and is not as usual, for the page."""
    usual, found = parser(), dict[str, Any]()
    for name in ("quick", "repeats", "sizes", "most", "budget"):
        value = getattr(chosen, name)
        if value != usual.get_default(name):
            found[name] = value
    return found


def measured(chosen: argparse.Namespace, before: dict[str, Any] | None) -> dict[str, Any]:
    """Numbers of a run.

    Raises:
        SystemExit: there is no such part, or what is kept comes from elsewhere.
    """
    from benchmarks import page_laws  # noqa: F401  (enters its part)
    from benchmarks.page_machine import machine, missing
    from benchmarks.page_parts import PARTS, Choice

    sizes = chosen.sizes or (QUICK_SIZES if chosen.quick else SIZES)
    choice = Choice(chosen.quick, chosen.repeats, [int(n) for n in sizes.split(",")], chosen.most, chosen.budget)
    names = chosen.only.split(",") if chosen.only else list(PARTS)
    unknown = [name for name in names if name not in PARTS]
    if unknown:
        raise SystemExit(f"There is no part {unknown[0]!r}; there are {', '.join(PARTS)}.")
    found = {"format": FORMAT, "options": settings(chosen), "machine": machine()}
    parts = kept(before, found) if chosen.only and before else {}
    for name in names:
        print(f"{name} ...", file=sys.stderr, flush=True)
        parts[name] = ran(name, choice)
    ordered = {name: parts[name] for name in PARTS if name in parts}
    return {**found, "missing": missing(), "parts": ordered}


def kept(before: dict[str, Any], now: dict[str, Any]) -> dict[str, Any]:
    """Parts of an older run, if they may stand beside those of this one."""
    for name in ("format", "options", "machine"):
        if before.get(name) != now[name]:
            raise SystemExit(f"The numbers that are there were made with another {name}; run all parts.")
    return dict(before["parts"])


def write(numbers: dict[str, Any], out: Path) -> None:
    """The numbers, and the page and drawings from them."""
    folder = out.parent / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    (folder / NUMBERS).write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    for name, text in render(numbers).items():
        place = out if name == f"{FOLDER}.md" else out.parent / name
        place.write_text(text, encoding="utf-8")


def one_thread(arguments: Sequence[str]) -> None:
    """Begin again with linear algebra in one thread, which is settled when NumPy is imported."""
    if not ONE_THREAD.items() <= os.environ.items():
        command = [sys.executable, "-m", "benchmarks", "page", *arguments]
        os.execve(sys.executable, command, {**os.environ, **ONE_THREAD})


def main(arguments: Sequence[str]) -> None:
    """Run and write, or only write."""
    chosen = parser().parse_args(arguments)
    there = chosen.source or chosen.out.parent / FOLDER / NUMBERS
    before = json.loads(there.read_text(encoding="utf-8")) if there.exists() else None
    if not chosen.source:
        one_thread(arguments)
        before = measured(chosen, before)
    if before is None:
        raise SystemExit(f"There are no numbers in {there}.")
    write(before, chosen.out)


if __name__ == "__main__":
    main(sys.argv[1:])
