"""`python -m benchmarks conformance`: every machine on the same random programs, and the page that says so.

What: `kernels` are those of the contract tests (`tests/kernels.py`), of the first form of laws, elements, mechanisms,
heat losses and resistances, on 256 random inputs; `steps` are whole steps of systems under random signals. A
difference is the largest of an output, as a share of the largest value that plain floats give it. Speed is CPU time of
a step of the wire of README.md. Numbers go to `machines.json`, from which alone the page is written (`--from`).
"""

from __future__ import annotations

import argparse
import ctypes
import datetime
import json
import os
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.conformance_machines import MACHINES, Machine, Program
from benchmarks.conformance_page import NUMBERS, PAGE, render_page
from benchmarks.page_machine import compiled_by, processor
from benchmarks.process import ROOT
from benchmarks.throughput_runs import readme_scenario
from martensite.base.errors import SolveError
from martensite.export.c_kernels import CKernel, kernels_text, precision_of
from martensite.kernels.compiler import load_library
from martensite.scenario.scenario import Scenario, load

WIRE = "wire of README.md"
EXAMPLES = {
    "pwm_bias_spring": {},
    "finger": {},
    "finger, mas": {"element.law": "mas"},
    "clamped_wire": {},
    "antagonistic_wires": {},
    "platform_spring": {},
    "torsion_wire": {},
    "r_phase": {},
    "migaone": {},
    "hand": {},
}
STEPS, HELD, TIMED, LONGEST = 300, 20, 3000, 0.5
LEFT_OUT = {"axial-wire", "ribbon", "hand", "lagoudas", "mas-polycrystal"}
"""Kernels that take minutes to compile several times."""
KINDS = ("law", "element", "mechanism", "cooling", "resistance")


def draw_program(name: str, scenario: Scenario, steps: int = STEPS) -> Program:
    """A system under signals of the range of its waveforms, held for some steps, often at an end of the range."""
    rng, drives = np.random.default_rng(len(name)), [one.name for one in scenario.system.drives()]
    waves: Any = scenario.waveform
    each = [waves.get(name) for name in drives] if isinstance(waves, dict) else [waves]
    times, columns = np.linspace(0.0, scenario.duration, 2001), list[Any]()
    for wave in each:
        values = np.array([0.0 if wave is None else wave.value(float(time)) for time in times])
        share = np.clip(rng.uniform(-0.5, 1.5, steps // HELD + 1), 0.0, 1.0)
        levels = values.min() + share * (values.max() - values.min())
        columns.append([values.min(), *np.repeat(levels, HELD)[:steps]])
    return Program(name, scenario.system, np.transpose(columns), min(scenario.duration / steps, LONGEST))


def list_programs() -> Iterator[Program]:
    """All of them."""
    yield draw_program(WIRE, readme_scenario())
    for name, changes in EXAMPLES.items():
        yield draw_program(name, load(ROOT / f"examples/{name.partition(',')[0]}.toml", changes))


def compare_rows(rows: Any, meant: Any) -> float:
    """Largest difference as a share of the largest of its output; what a machine does not show is left out."""
    largest = np.maximum(np.abs(meant).max(axis=0), 1e-300)
    shares = np.abs(rows - meant).max(axis=0) / largest
    return float(np.nanmax(shares))


# ---------------------------------------------------------------- kernels


def run_core_kernel(thing: Any, kernel: Any, inputs: Any, precision: str) -> Any:
    """A kernel as the exported C has it, one lane after the other."""
    from kernels import traced, values

    program, kind = traced(thing, kernel), precision_of(precision)
    made = CKernel.of(program.functions["kernel"], len(inputs), 0)
    text = kernels_text(program, list(range(len(program.parameters))), [made], "one_", kind)
    outputs = len(program.functions["kernel"].outputs)
    play = (
        f"void play(long n, const {kind.number} *p, const {kind.number} *x, {kind.number} *y) {{ long k; "
        f"{kind.number} c[{program.constants + 1}]; one_kernel_prepare(p, c); for (k = 0; k < n; k++) "
        f"one_kernel_kernel(c, x + k * {len(inputs)}, 0, 0, y + k * {outputs}); }}"
    )
    library = load_library("\n".join(["#include <float.h>", "#include <math.h>", text, play]))
    dtype = np.dtype(precision)
    arrays = [np.ascontiguousarray(one, dtype) for one in (values(thing) or [0.0], inputs.T)]
    found = np.zeros((inputs.shape[1], outputs), dtype)
    library.play(ctypes.c_long(inputs.shape[1]), *(ctypes.c_void_p(a.ctypes.data) for a in (*arrays, found)))
    return found.T.astype(float)


def list_kernel_machines() -> dict[str, Callable[..., Any]]:
    """Ways to run a kernel, by the name of the machine."""
    from kernels import on_c, on_lanes

    return {
        "C": on_c,
        "C lanes": on_lanes,
        "exported C core": partial(run_core_kernel, precision="float64"),
        "exported C core, float32": partial(run_core_kernel, precision="float32"),
    }


def compare_kernels() -> dict[str, dict[str, float]]:
    """Differences by machine and kernel, compiled with `-O1`."""
    import builders
    from kernels import KERNELS, disagreement, on_kernel_itself

    os.environ["MARTENSITE_CFLAGS"] = "-O1"
    found: dict[str, dict[str, float]] = {}
    for kind in KINDS:
        for cls in builders.registered(kind):
            if cls.registered_name in LEFT_OUT:
                continue
            thing = builders.variants(cls)[0]
            for part, kernel in KERNELS[kind].items():
                inputs = kernel.inputs()
                meant = on_kernel_itself(thing, kernel, inputs)
                for name, run in list_kernel_machines().items():
                    label = f"{kind} {cls.registered_name}, {part}"
                    found.setdefault(name, {})[label] = disagreement(meant, run(thing, kernel, inputs))
            print(kind, cls.registered_name, {name: f"{max(r.values()):.1e}" for name, r in found.items()}, flush=True)
    return found


# ---------------------------------------------------------------- the table


def measure_machine(machine: Machine, programs: list[Program], meant: list[Any], timed: Program) -> dict[str, Any]:
    """A row: differences of steps, size, and speed, or what is missing."""
    row: dict[str, Any] = {"machine": machine.name, "precision": machine.precision, "handed": machine.what}
    missing = machine.missing()
    if missing:
        return row | {"missing": missing}
    shares: dict[str, float] = {}
    for one, exact in zip(programs, meant, strict=True):
        if machine.only is None or one.name in machine.only:
            try:
                shares[one.name] = compare_rows(machine.play(one), exact)
            except SolveError:
                row.setdefault("unsolved", []).append(one.name)
    print(machine.name, {name: f"{share:.1e}" for name, share in shares.items()}, flush=True)
    row |= {"steps": shares, "bytes": machine.size(programs[0])}
    return row | {"step_us": None if machine.step is None else 1e6 * machine.step(timed)}


def measure_some(names: list[str], known: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """What the page says, after every machine; rows of those that are not named stay, if they were made here today."""
    programs = list(list_programs())
    timed = draw_program(WIRE, readme_scenario(), TIMED)
    meant = [MACHINES[0].play(one) for one in programs]
    head = {
        "made": datetime.date.today().isoformat(),
        "processor": processor()[0],
        "python": sys.version.split()[0],
        "compiler": compiled_by(),
        "steps": STEPS,
        "programs": [one.name for one in programs],
    }
    same = all(known.get(name) == value for name, value in head.items())
    rows = {row["machine"]: row for row in known["machines"]} if same else {}
    for machine in MACHINES:
        if machine.name in names or machine.name not in rows:
            kept = {"kernels": rows[machine.name]["kernels"]} if "kernels" in rows.get(machine.name, {}) else {}
            rows[machine.name] = measure_machine(machine, programs, meant, timed) | kept
            yield head | {"machines": list(rows.values())}
    if "kernels" in names:
        for name, shares in compare_kernels().items():
            worst = max(shares, key=lambda label: shares[label])
            rows[name]["kernels"] = {"count": len(shares), "largest": shares[worst], "where": worst}
        yield head | {"machines": list(rows.values())}


def main(arguments: list[str]) -> None:
    """Measure, or only write the page from the numbers."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks conformance", description=__doc__)
    parser.add_argument("--from", dest="source", type=Path, help="write the page from these numbers, run nothing")
    parser.add_argument("--only", help="machines to run, with `;` between them, and `kernels`; other rows stay")
    chosen = parser.parse_args(arguments)
    sys.path.append(str(ROOT / "tests"))
    known = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() and chosen.only else {}
    names = chosen.only.split(";") if chosen.only else [*(one.name for one in MACHINES), "kernels"]
    for found in [] if chosen.source else measure_some(names, known):
        NUMBERS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    numbers = json.loads((chosen.source or NUMBERS).read_text(encoding="utf-8"))
    PAGE.write_text(render_page(numbers), encoding="utf-8")
